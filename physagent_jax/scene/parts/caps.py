"""The caps of a solid: what sits on a narrower place, like a lid on its seam or a head on a neck."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from physagent_jax.scene.parts.lattice import Lattice

_NARROW = 0.8  # area of the seam over the largest above and below, at most
_WHOLE = 0.98  # share of what is above a seam that has to be in one piece


def find_caps(lattice: Lattice) -> list[np.ndarray]:
    """The nodes above each seam, each of shape (k,), smaller ones first."""
    area = lattice.fill_vessels().sum((0, 1)).astype(float)
    below, above = np.maximum.accumulate(area), np.maximum.accumulate(area[::-1])[::-1]
    narrow = (area > 0) & (area < _NARROW * np.minimum(below, above))
    labels, count = ndimage.label(narrow)
    seams = [min(np.flatnonzero(labels == k + 1), key=lambda level: area[level]) for k in range(count)]
    found = []
    for seam in sorted(seams, reverse=True):
        top = lattice.solid.copy()
        top[:, :, :seam] = False
        pieces = ndimage.label(top, np.ones((3, 3, 3)))[0]
        sizes = np.bincount(pieces[top])
        if sizes.max() >= _WHOLE * sizes.sum():
            found.append(lattice.pick(pieces == sizes.argmax()))
    return found
