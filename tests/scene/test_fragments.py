"""Fragments: weak only where two of them meet."""

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from physagent_jax.scene.fragments import count_fragments, find_seams

SPACING = 0.04
GRID = np.stack(np.meshgrid(*[np.arange(0, 1, SPACING)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)


def test_what_is_left_without_the_seams_is_that_many_pieces():
    weak = find_seams(GRID, 8, 3.5 * SPACING)
    pairs = KDTree(GRID[~weak]).query_pairs(1.1 * SPACING, output_type="ndarray")
    size = (~weak).sum()
    joined = csr_matrix((np.ones(len(pairs)), pairs.T), shape=(size, size))
    count, labels = connected_components(joined, directed=False)
    assert count == 8 and np.bincount(labels).min() > 0.02 * size


def test_wider_seams_contain_narrower_ones_and_one_piece_has_none():
    narrow, wide = (find_seams(GRID, 8, width) for width in (0.05, 0.1))
    assert 0 < narrow.sum() < wide.sum() and not (narrow & ~wide).any()
    assert not find_seams(GRID, 1, 0.1).any()


def test_a_slender_thing_breaks_into_few_pieces_that_stay_whole():
    """A bottle that was to break into thirty was nothing but seams, and became a heap as of sand."""
    dx = 2 * SPACING
    bar = GRID[(GRID[:, 0] < 6 * dx) & (GRID[:, 1] < 6 * dx)]
    volume = len(bar) * SPACING**3
    count = count_fragments(30, volume, dx)
    firm = [1 - find_seams(bar, each, 2 * dx).mean() for each in (count, 30)]
    assert 4 <= count < 10 and firm[0] > 0.5 and firm[1] < 0.2
    assert count_fragments(30, 1.0, 0.04) == 30 and count_fragments(30, 1e-6, 0.04) == 4
