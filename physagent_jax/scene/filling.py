"""From Gaussians to matter: particles on the surface and inside, and the volume that each stands for."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from scipy import ndimage

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.scene.config import Filling
from physagent_jax.scene.density import CellGrid, interior, overlap_density

SURFACE_SHARE = 0.5  # of the cap that surface particles may take if the inside needs the rest
WALL_WEIGHT = (
    0.5  # share of an outer wall cell that is matter: the surface runs through it, on average midway
)
WALL_DEPTH = 2.0  # cells from outside up to which cells are outer ones
INSIDE_JITTER = 0.35  # half width of the random offset, in strata
WALL_JITTER = 0.15  # less near the surface, so that particles do not stick out
MAX_CELLS = 512  # along the longest side
MOST_CELLS = 64_000_000  # in all: about 4 GB
MOST_PLACES = 100_000_000  # about 2 GB


@dataclasses.dataclass(frozen=True)
class Particles:
    """Matter at rest: first the Gaussians' particles in order of their index, then the filled ones.

    Attributes:
        x: Positions [m], shape (n, 3), float32.
        volume: [m^3], shape (n,), float32.
        gaussian_index: The Gaussian whose centre it is; -1 = filled, shape (n,), int32.
    """

    x: np.ndarray
    volume: np.ndarray
    gaussian_index: np.ndarray

    @property
    def count(self) -> int:
        """Number of particles."""
        return len(self.x)

    @property
    def filled_count(self) -> int:
        """Number of particles that are no Gaussian's centre."""
        return int((self.gaussian_index < 0).sum())


def fill(cloud: GaussianCloud, config: Filling, *, dx: float) -> Particles:
    """Makes particles of the Gaussians' centres and fills what they enclose.

    On a grid of ``config.cells`` along the object's longest side, cells whose density exceeds
    ``density_threshold``, or that hold a Gaussian's centre, are walls; `density.interior` finds the inside.
    Walls are topped up to ``particles_per_cell``, counting the Gaussians in them, and inside cells get as
    many, stratified and jittered.

    **Density.** PhysGaussian thresholds the plain overlap sum D at 5 and 3. That number grows with how many
    Gaussians the trainer spent per cell and with the cell's size, so these values suit its own scenes only:
    with cells of 1/48 of the longest side, the median D where Gaussians are is 1.4 for the bundled robot, 2.2
    for a cow sampled at 20,000 points, and 28 for a captured guitar. The default unit is therefore the coverage
    10 (1 - exp(-D)), by Beer-Lambert the share of light, in tenths, that the cell's matter stops: half opaque
    (5) is matter, a third opaque (3) stops a search ray, whatever the sampling. ``density_unit="overlap"`` is
    PhysGaussian's.

    **Volume.** PhysGaussian gives each particle its simulation cell's volume over the number of particles
    in it; since a cell that the surface merely touches counts in full, this overestimates by half a cell
    all around, e.g. by 27 % for a cube of 12 cells. Here a solid cell's volume (half of it for an outer
    wall, which straddles the surface) is shared among the particles in it: the sum is the object's volume, up
    to 0.3 filling cells on a face that runs along the grid. ``volumes="cells"`` is PhysGaussian's.

    **Cap.** At most ``max_particles``. If that is too few, the surface gets what the inside leaves, but at
    least half: the surface is what is seen and what Gaussians are bound to, while the inside must keep
    about a particle per simulation cell or it tears numerically. Both are thinned evenly in space.

    Args:
        cloud: In the world [m].
        config: How to fill.
        dx: The simulation's grid spacing [m].

    Returns:
        The particles. Same input and seed, same bytes.

    Raises:
        UserError: There are no Gaussians, or centres that are not finite, or all coincide; or the grid is too large.
    """
    means = np.asarray(cloud.means, np.float64)
    grid = CellGrid.around(means, _spacing(means, config, dx))
    _check_cells(grid, config)
    cells = grid.cells(means)
    wall, search = _walls(cloud, config, grid, cells)
    inside = np.zeros_like(wall)
    if config.enabled:
        inside = interior(
            wall, exclude=config.exclude_direction, cast=config.ray_cast_direction, search=search
        )
    depth = np.asarray(ndimage.distance_transform_edt(wall | inside))  # cells to the outside
    present = np.zeros(grid.shape, np.int32)
    np.add.at(present, tuple(cells.T), 1)
    added = _added_points(grid, depth, present, config) if config.enabled else np.zeros((0, 3))
    surface, filled = _capped(means, added, grid, config.max_particles)
    x = np.concatenate([means[surface], added[filled]])
    index = np.concatenate([surface, np.full(len(filled), -1)])
    if config.volumes == "cells":
        volume = _cell_shares(x, dx)
    else:
        volume = _volumes(grid.cells(x), wall, depth, grid.spacing)
    return Particles(x.astype(np.float32), volume.astype(np.float32), index.astype(np.int32))


def _spacing(means: np.ndarray, config: Filling, dx: float) -> float:
    """Side of a filling cell [m]."""
    if len(means) == 0 or not np.isfinite(means).all():
        got = f"{len(means)} Gaussians, {int(np.isfinite(means).all(axis=-1).sum())} of them finite"
        raise UserError("filling needs Gaussians with finite centres", got=got, do="Check the file")
    longest = float(np.ptp(means, axis=0).max())
    if not longest > 0:
        raise UserError("all Gaussians share one centre", do="Choose another file")
    if config.cells is not None:
        return longest / config.cells
    return float(np.clip(0.5 * dx, longest / MAX_CELLS, longest / 4))


def _check_cells(grid: CellGrid, config: Filling) -> None:
    """Refuses a grid that takes too much memory, before any is taken.

    Raises:
        UserError: There are too many cells, or places for particles in them.
    """
    cells = math.prod(grid.shape)
    fewer = "Use fewer `filling.cells`" if config.cells is not None else "Set `filling.cells`, e.g. to 128"
    if cells > MOST_CELLS:
        shape = " x ".join(map(str, grid.shape))
        raise UserError(
            "filling the object takes too many cells", got=f"{shape}, at most {MOST_CELLS:,} in all", do=fewer
        )


def _walls(cloud, config: Filling, grid: CellGrid, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cells that hold matter, and cells that stop a search ray."""
    density = overlap_density(cloud, grid)
    if config.smooth:
        density = ndimage.gaussian_filter(density, 1.0, mode="constant")
    if config.density_unit == "coverage":
        density = -10.0 * np.expm1(-density)
    wall, search = density > config.density_threshold, density > config.search_threshold
    wall[tuple(cells.T)] = True
    return wall, search | wall


def _added_points(grid: CellGrid, depth, present, config: Filling) -> np.ndarray:
    """Stratified positions [m] that top cells up to ``particles_per_cell``, shape (n, 3)."""
    rng = np.random.default_rng(config.seed)
    wanted = config.particles_per_cell
    lack = np.where(depth > 0, np.maximum(wanted - present, 0), 0)
    cells = np.argwhere(lack > 0)
    strata = int(np.ceil(wanted ** (1 / 3) - 1e-9))
    if len(cells) * strata**3 > MOST_PLACES:
        raise UserError(
            "filling the object takes too many places for particles",
            got=f"{len(cells):,} cells of {strata**3}, at most {MOST_PLACES:,} in all",
            do="Use fewer `filling.particles_per_cell` or `filling.cells`",
        )
    # Each cell's first ``lack`` strata in a random order of its own.
    order = np.argsort(rng.random((len(cells), strata**3)), axis=1, kind="stable")
    taken = np.arange(strata**3) < lack[tuple(cells.T)][:, None]
    row = np.nonzero(taken)[0]
    corner = np.stack(np.unravel_index(order[taken], (strata,) * 3), axis=1)
    width = np.where(depth[tuple(cells[row].T)] > WALL_DEPTH, INSIDE_JITTER, WALL_JITTER)[:, None]
    jitter = width * rng.uniform(-1, 1, (len(row), 3))
    return grid.low + (cells[row] + (corner + 0.5 + jitter) / strata) * grid.spacing


def _capped(means, added, grid: CellGrid, cap: int) -> tuple[np.ndarray, np.ndarray]:
    """Indices of the Gaussians and of the added points that are kept, increasing."""
    total = len(means) + len(added)
    if total <= cap:
        return np.arange(len(means)), np.arange(len(added))
    surface = min(len(means), max(cap - len(added), int(SURFACE_SHARE * cap)))
    return (
        even_subset(grid.cells(means), surface),
        even_subset(grid.cells(added), min(len(added), cap - surface)),
    )


def even_subset(cells: np.ndarray, count: int) -> np.ndarray:
    """Increasing indices of ``count`` points, spread evenly in space.

    Every occupied cell gives one point before any gives a second; a layer that does not fit whole is thinned
    at equal steps along a Morton curve.

    Args:
        cells: Non-negative cell indices, shape (n, 3).
        count: At most n.
    """
    if count >= len(cells):
        return np.arange(len(cells))
    code = _morton(cells)
    order = np.argsort(code, kind="stable")
    sorted_code = code[order]
    starts = np.flatnonzero(np.concatenate([[True], sorted_code[1:] != sorted_code[:-1]]))
    rank = np.arange(len(order)) - np.repeat(starts, np.diff(np.append(starts, len(order))))
    layers = np.cumsum(np.bincount(rank))
    whole = int(np.searchsorted(layers, count, side="right"))  # layers that fit
    kept = order[rank < whole]
    layer = order[rank == whole]
    rest = count - len(kept)
    return np.sort(np.concatenate([kept, layer[(np.arange(rest) * 2 + 1) * len(layer) // max(2 * rest, 1)]]))


def _morton(cells: np.ndarray) -> np.ndarray:
    """Interleaves the low ten bits of the indices, so that near codes are near cells; shape (n,)."""
    code = np.zeros(len(cells), np.int64)
    for bit in range(10):
        for axis in range(3):
            code |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return code


def _volumes(cells: np.ndarray, wall: np.ndarray, depth: np.ndarray, spacing: float) -> np.ndarray:
    """Volume of each particle [m^3], shape (n,).

    Cells' matter is shared within blocks of 1, 2, 4, ... cells, the smallest for which nearly all matter lies
    in blocks that hold particles (1 unless the cap thinned them); the rest is spread over all.
    """
    matter = np.where(wall & (depth <= WALL_DEPTH), WALL_WEIGHT, depth > 0) * spacing**3
    total = matter.sum()
    block = 1
    while True:
        shape = tuple(-(-s // block) for s in wall.shape)
        key = np.ravel_multi_index(tuple((cells // block).T), shape)
        count = np.bincount(key, minlength=np.prod(shape))
        held = _block_sums(matter, block, shape).ravel()
        covered = held[count > 0].sum()
        if covered >= 0.98 * total or max(shape) == 1:
            return held[key] / count[key] * (total / covered)
        block *= 2


def _cell_shares(x: np.ndarray, dx: float) -> np.ndarray:
    """PhysGaussian's volumes [m^3]: the simulation cell's over the number of particles in it, shape (n,)."""
    _, cell, count = np.unique(np.floor(x / dx), axis=0, return_inverse=True, return_counts=True)
    return dx**3 / count[cell.ravel()]


def _block_sums(values: np.ndarray, block: int, shape: tuple[int, ...]) -> np.ndarray:
    padded = np.pad(values, [(0, n * block - s) for n, s in zip(shape, values.shape)])
    split = padded.reshape(shape[0], block, shape[1], block, shape[2], block)
    return split.sum(axis=(1, 3, 5))
