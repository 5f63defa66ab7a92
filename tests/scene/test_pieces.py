"""Loose pieces of a capture."""

import numpy as np
import pytest

from physagent_jax.scene.filling import Particles
from physagent_jax.scene.pieces import explain_loose, join_pieces, label_pieces

DX = 0.05


def blocks(*places, size=0.3):
    """Cubes of particles two per cell and axis, with their low corners there."""
    axis = np.arange(DX / 4, size, DX / 2)
    cube = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    x = np.concatenate([cube + place for place in places]).astype(np.float32)
    return Particles(x, np.full(len(x), 1e-5, np.float32), np.full(len(x), -1, np.int32))


def test_a_gap_is_bridged_as_wide_as_the_faces():
    apart = blocks((1, 1, 1), (1.36, 1, 1))
    assert label_pieces(apart.x, DX).max() == 1
    joined, loose = join_pieces(apart, DX)
    assert not loose and not label_pieces(joined.x, DX).any()
    added = joined.x[apart.count :]
    assert (added[:, 0] > 1.28).all() and (added[:, 0] < 1.38).all()
    assert np.ptp(added[:, 1]) > 0.24 and np.ptp(added[:, 2]) > 0.24
    np.testing.assert_array_equal(joined.x[: apart.count], apart.x)


def test_pieces_are_joined_by_way_of_others():
    joined, loose = join_pieces(blocks((1, 1, 1), (1.4, 1, 1), (1.8, 1, 1)), DX)
    assert not loose and not label_pieces(joined.x, DX).any()


def test_what_is_far_stays_loose_and_is_reported():
    apart = blocks((1, 1, 1), (2, 1, 1))
    joined, loose = join_pieces(apart, DX)
    assert joined is apart and len(loose) == 1
    assert loose[0].share == pytest.approx(0.5) and loose[0].distance == pytest.approx(
        0.725 / 1.275, abs=0.02
    )
    assert "50.0%" in (explain_loose(loose) or "")


def test_one_piece_is_left_as_it_is():
    whole = blocks((1, 1, 1))
    assert join_pieces(whole, DX) == (whole, ()) and explain_loose(()) is None
