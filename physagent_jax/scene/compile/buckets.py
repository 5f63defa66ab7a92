"""Array sizes rounded up, so that objects of nearly the same size run the same compiled program.

Particles are filled up with copies that share the mass and volume of their originals. A copy starts where its original
does and nothing ever tells them apart, so they stay together and deposit on the grid what one particle would: the
motion is the same to round-off, and no part of the simulator has to know. Gaussians are filled up with invisible ones.
"""

from __future__ import annotations

import dataclasses

import jax
import numpy as np

from physagent_jax.core.arrays import to_device
from physagent_jax.gaussians.binding import Binding
from physagent_jax.gaussians.cloud import GaussianCloud


def round_up(count: int) -> int:
    """``count`` rounded up to one of eight sizes per octave: by 12.5 % at most, and not at all below 16."""
    step = 2 ** max(0, int(count).bit_length() - 4)
    return -(-count // step) * step


def add_copies(order: np.ndarray, block: np.ndarray) -> np.ndarray:
    """``order`` with some of its entries twice, one after the other, so that each block fills its bucket.

    Args:
        order: Particles in the simulator's order, shape (n,).
        block: A number per entry of ``order``, equal within a block, ascending; shape (n,).
    """
    times = []
    for count in np.unique(block, return_counts=True)[1]:
        missing, repeats = round_up(count) - count, np.ones(count, int)
        repeats[np.arange(missing) * count // max(missing, 1)] = 2
        times.append(repeats)
    return np.repeat(order, np.concatenate(times))


def split_mass(order: np.ndarray) -> np.ndarray:
    """The share of its particle's mass and volume that each entry of ``order`` has, shape (n,)."""
    return 1 / np.bincount(order)[order]


def find_places(mask: np.ndarray) -> jax.Array:
    """The indices at which ``mask``, shape (n,), is true; n fills the rest of the bucket."""
    return pad_indices(np.flatnonzero(mask), len(mask))


def pad_indices(held: np.ndarray, count: int) -> jax.Array:
    """Indices of ``held`` particles and, to fill the bucket, their ``count``: no particle, which nothing is done to."""
    return to_device(np.pad(held, (0, round_up(len(held)) - len(held)), constant_values=count), np.int32)


def pad_gaussians(cloud: GaussianCloud, binding: Binding) -> tuple[GaussianCloud, Binding]:
    """The Gaussians of a bucket: after the given ones, copies of the last that nobody sees."""
    missing = round_up(cloud.count) - cloud.count
    return pad_cloud(cloud), jax.tree.map(lambda leaf: _repeat_last(leaf, missing), binding)


def pad_cloud(cloud: GaussianCloud) -> GaussianCloud:
    """The same without a binding, for Gaussians that only stand."""
    missing = round_up(cloud.count) - cloud.count
    filled = jax.tree.map(lambda leaf: _repeat_last(leaf, missing), cloud)
    opacities = to_device(np.pad(np.asarray(cloud.opacities), (0, missing)))
    return dataclasses.replace(filled, opacities=opacities)


def _repeat_last(leaf: jax.Array, times: int) -> jax.Array:
    rows = np.asarray(leaf)
    return to_device(np.concatenate([rows, np.repeat(rows[-1:], times, axis=0)]))
