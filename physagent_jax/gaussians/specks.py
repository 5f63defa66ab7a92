"""Gaussians that people take for dirt: far needles of a capture, and specks that fly about alone. For pictures only."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.ndimage import uniform_filter

from physagent_jax.core.arrays import to_device
from physagent_jax.gaussians.cloud import GaussianCloud, Splats

CELL = 0.04  # [sizes] of the boxes in which Gaussians are counted; a neighbourhood is three of them wide
MOST_CELLS = 160  # a side; what is farther out counts as in the outermost
LONELY = 0.15  # of the usual number in a neighbourhood, below which a Gaussian is alone
LEFT = 0.5  # of the number at rest that must be there for it to have stayed with its own
LONGEST, MOST_RATIO = 0.06, 5.0  # [sizes] that a needle may be long; times its middle axis, if that is longer


def shorten_needles(cloud: GaussianCloud, size: float) -> GaussianCloud:
    """The cloud with the longest axes of needles shortened: those of `LONGEST` and `MOST_RATIO` together.

    Args:
        cloud: At rest.
        size: The object's longest side [m].
    """
    scales = np.asarray(cloud.scales)
    middle = np.sort(scales, axis=1)[:, 1:2]
    most = np.maximum(LONGEST * size, MOST_RATIO * middle)
    return (
        cloud
        if (scales <= most).all()
        else dataclasses.replace(cloud, scales=to_device(np.minimum(scales, most)))
    )


def count_neighbours(means: np.ndarray, size: float) -> np.ndarray:
    """The number of points around each, itself included, shape (n,).

    Args:
        means: Points [m], shape (n, 3).
        size: The object's longest side [m].
    """
    safe = np.where(np.isfinite(means).all(axis=1, keepdims=True), means, 0.0)
    cells = np.floor((safe - np.median(safe, axis=0)) / (CELL * size)).astype(np.int64)
    cells = np.clip(cells, -MOST_CELLS // 2, MOST_CELLS // 2)
    cells = cells - cells.min(0) + 1
    shape = tuple(cells.max(0) + 2)
    flat = np.ravel_multi_index(tuple(cells.T), shape)
    counts = np.bincount(flat, minlength=int(np.prod(shape))).reshape(shape).astype(np.float32)
    around = 27 * uniform_filter(counts, 3, mode="constant")
    return np.rint(around.ravel()[flat]).astype(np.int64)


def hide_specks(splats: Splats, rest: np.ndarray, size: float) -> Splats:
    """The Gaussians, those invisible that have left all others.

    Args:
        splats: Deformed.
        rest: Numbers of neighbours at rest (`count_neighbours`), shape (n,).
        size: The object's longest side [m].
    """
    now = count_neighbours(np.asarray(splats.means)[: len(rest)], size)
    alone = (now < LONELY * np.median(rest)) & (now < LEFT * rest)
    if not alone.any():
        return splats
    opacities = np.asarray(splats.opacities).copy()
    opacities[: len(rest)][alone] = 0
    return dataclasses.replace(splats, opacities=to_device(opacities))
