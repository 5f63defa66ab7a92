"""The caps of a solid: what sits on a narrower place, like a lid on its seam or a head on a neck."""

from __future__ import annotations

import numpy as np

from physagent_jax.scene.parts.lattice import Lattice, find_pieces

_NARROW = 0.8  # area of the seam over the largest above and below, at most
_WHOLE = 0.98  # share of what is above a seam that has to be in one piece


def find_caps(lattice: Lattice) -> list[np.ndarray]:
    """The nodes above each seam, each of shape (k,), smaller ones first."""
    area = lattice.fill_vessels().sum((0, 1)).astype(float)
    below, above = np.maximum.accumulate(area), np.maximum.accumulate(area[::-1])[::-1]
    narrow = (area > 0) & (area < _NARROW * np.minimum(below, above))
    seams = [run[area[run].argmin()] for run in _find_runs(narrow)]
    found = []
    for seam in sorted(seams, reverse=True):
        top = lattice.solid.copy()
        top[:, :, :seam] = False
        pieces = find_pieces(top)
        sizes = np.bincount(pieces[top])
        if sizes.max() >= _WHOLE * sizes.sum():
            found.append(lattice.pick(pieces == sizes.argmax()))
    return found


def _find_runs(mask: np.ndarray) -> list[np.ndarray]:
    """The indices of each run of a mask, shape (n,)."""
    index = np.flatnonzero(mask)
    return [run for run in np.split(index, np.flatnonzero(np.diff(index) > 1) + 1) if len(run)]
