"""From Gaussians to matter: particles on the surface and inside, and the volume that each stands for."""

from __future__ import annotations

import dataclasses
import math
import warnings

import numpy as np
from scipy import ndimage

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.scene.config import Filling
from physagent_jax.scene.density import CellGrid, find_interior, overlap_density
from physagent_jax.scene.one_sided import find_behind

SURFACE_SHARE = 0.5  # of the cap that surface particles may take if the inside needs the rest
OUTSIDE, OUTER, INNER = 0, 1, 2  # layers of cells; outer ones are solid and at most two cells from outside
INSIDE_JITTER = 0.35  # half width of the random offset, in strata
WALL_JITTER = 0.15  # less near the surface, so that particles do not stick out
MAX_CELLS = 512  # along the longest side
MOST_CELLS = 64_000_000  # in all: about 2 GB where most are solid
MOST_PLACES = 100_000_000  # of which particles take theirs at random: seconds, no memory
_AT_ONCE = 1_000_000  # random numbers


@dataclasses.dataclass(frozen=True)
class Particles:
    """Material points at rest: first the Gaussians' particles in order of their index, then the filled ones.

    Attributes:
        x: Positions [m], shape (n, 3), float32.
        volume: [m^3], shape (n,), float32.
        gaussian_index: The Gaussian whose centre it is; -1 = filled, shape (n,), int32.
        enclosed: Whether it lies inside, in a cell without surface and away from the outside, shape (n,); None = none.
    """

    x: np.ndarray
    volume: np.ndarray
    gaussian_index: np.ndarray
    enclosed: np.ndarray | None = None

    @property
    def count(self) -> int:
        """Number of particles."""
        return len(self.x)


def fill(cloud: GaussianCloud, config: Filling, *, dx: float) -> Particles:
    """Make particles of the Gaussians' centres and fill what they enclose.

    On a grid of ``config.cells`` along the object's longest side, cells whose density exceeds
    ``density_threshold``, or that hold a Gaussian's centre, are walls; `density.find_interior` finds the inside, and
    `one_sided.find_behind` what is behind walls that show one side only.
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
    grid = CellGrid.around(means, _choose_spacing(means, config, dx))
    _check_cells(grid, config)
    cells = grid.cells(means)
    wall, search = _find_walls(cloud, config, grid, cells)
    inside = np.zeros_like(wall)
    if config.enabled:
        inside = find_interior(
            wall, exclude=config.exclude_direction, cast=config.ray_cast_direction, search=search
        )
        if (found := find_behind(wall, inside)) is not None:
            inside |= found[1]
            warnings.warn(
                f"the Gaussians show one side of the object, towards {found[0]}: it is filled behind them for the "
                "simulation, up to their rim; pictures from behind show that nothing is there",
                UserWarning,
                stacklevel=2,
            )
    layer = _make_layers(wall | inside)
    hollow, lack = _find_lacking(layer, cells, config)
    lacking = int(lack.sum())
    room = config.max_particles - lacking  # for the surface
    surface = select_evenly(cells, max(room, int(SURFACE_SHARE * config.max_particles)))
    kept = _even_out(hollow, lack, config.max_particles - len(surface))
    added = _place_stratified(grid, hollow, lack, kept, layer[tuple(hollow.T)] == INNER, config)
    x = np.concatenate([means[surface], added])
    index = np.concatenate([surface, np.full(len(added), -1)])
    cells = grid.cells(x)
    if config.volumes == "cells":
        volume = _compute_cell_shares(x, dx)
    else:
        volume = _compute_volumes(cells, wall, layer, grid.spacing)
    enclosed = (~wall & (layer == INNER))[tuple(cells.T)]
    return Particles(x.astype(np.float32), volume.astype(np.float32), index.astype(np.int32), enclosed)


def _choose_spacing(means: np.ndarray, config: Filling, dx: float) -> float:
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
    """Refuse a grid that takes too much memory, before any is taken.

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


def _find_walls(cloud, config: Filling, grid: CellGrid, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cells that hold matter, and cells that stop a search ray."""
    density = overlap_density(cloud, grid)
    if config.smooth:
        density = ndimage.gaussian_filter(density, 1.0, mode="constant")
    if config.density_unit == "coverage":
        density = np.expm1(np.negative(density, out=density), out=density)
        density *= -10.0
    wall, search = density > config.density_threshold, density > config.search_threshold
    wall[tuple(cells.T)] = True
    return wall, search | wall


def _make_layers(solid: np.ndarray) -> np.ndarray:
    """`OUTSIDE`, `OUTER` or `INNER` for each cell, uint8."""
    outside = ~solid
    diamond, cube = ndimage.generate_binary_structure(3, 1), np.ones((3, 3, 3), bool)
    near = np.logical_or(  # all within two cells' length
        ndimage.binary_dilation(outside, diamond, iterations=2), ndimage.binary_dilation(outside, cube)
    )
    return np.where(solid, np.where(near, OUTER, INNER), OUTSIDE).astype(np.uint8)


def _find_lacking(layer: np.ndarray, cells: np.ndarray, config: Filling) -> tuple[np.ndarray, np.ndarray]:
    """Solid cells that hold fewer particles than wanted, shape (n, 3), and how many they lack, shape (n,).

    Args:
        layer: Layer of each cell.
        cells: Those of the Gaussians, shape (g, 3).
        config: How to fill.
    """
    if not config.enabled:
        return np.zeros((0, 3), np.int16), np.zeros(0, np.int8)
    lack = np.where(layer == OUTSIDE, 0, config.particles_per_cell).astype(np.int8).ravel()
    occupied, count = np.unique(np.ravel_multi_index(tuple(cells.T), layer.shape), return_counts=True)
    lack[occupied] = np.maximum(lack[occupied] - count, 0)
    where = np.flatnonzero(lack).astype(np.int32)
    places = len(where) * _choose_strata(config) ** 3
    if places > MOST_PLACES:
        raise UserError(
            "filling the object takes too many places for particles",
            got=f"{len(where):,} cells of {_choose_strata(config) ** 3}, at most {MOST_PLACES:,} in all",
            do="Use fewer `filling.particles_per_cell` or `filling.cells`",
        )
    hollow = np.empty((len(where), 3), np.int16)
    column, hollow[:, 2] = np.divmod(where, layer.shape[2])
    hollow[:, 0], hollow[:, 1] = np.divmod(column, layer.shape[1])
    return hollow, lack[where]


def _choose_strata(config: Filling) -> int:
    """Along an edge of a cell."""
    return int(np.ceil(config.particles_per_cell ** (1 / 3) - 1e-9))


def _place_stratified(grid: CellGrid, cells, lack, kept, inner, config: Filling) -> np.ndarray:
    """The first ``kept`` of the ``lack`` stratified positions in each of ``cells`` [m], shape (kept.sum(), 3).

    The rest are drawn too, and dropped: a point is where it is whatever the cap.
    """
    rng = np.random.default_rng(config.seed)
    strata = _choose_strata(config)
    step = max(_AT_ONCE // strata**3, 1)
    parts = [slice(first, first + step) for first in range(0, len(cells), step)]
    corners = []
    for part in parts:  # each cell's strata in a random order of its own
        order = np.argsort(rng.random((len(lack[part]), strata**3)), axis=1, kind="stable")
        chosen = order[np.arange(strata**3) < kept[part][:, None]]
        corners.append(np.stack(np.unravel_index(chosen, (strata,) * 3), axis=1))
    points = [np.zeros((0, 3))]
    for part, corner in zip(parts, corners):
        jitter = rng.uniform(-1, 1, (lack[part].sum(), 3))[
            _rank(lack[part]) < np.repeat(kept[part], lack[part])
        ]
        row = np.repeat(np.arange(len(lack[part])), kept[part])
        jitter *= np.where(inner[part][row], INSIDE_JITTER, WALL_JITTER)[:, None]
        points.append(grid.low + (cells[part][row] + (corner + 0.5 + jitter) / strata) * grid.spacing)
    return np.concatenate(points)


def _rank(counts: np.ndarray) -> np.ndarray:
    """0, 1, ... within each group, for groups of ``counts`` in a row; shape (counts.sum(),)."""
    return np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)


def _even_out(cells: np.ndarray, available: np.ndarray, count: int) -> np.ndarray:
    """The number of each cell's ``available`` points to keep, spread as by `select_evenly`; ``count`` in all."""
    if available.sum() <= count:
        return available
    layers = np.cumsum([(available > taken).sum() for taken in range(available.max())])
    whole = int(np.searchsorted(layers, count, side="right"))
    kept = np.minimum(available, whole)
    last = np.flatnonzero(available > whole)
    last = last[np.argsort(_encode_morton(cells[last]), kind="stable")]
    kept[_choose_evenly(last, count - int(kept.sum()))] += 1
    return kept


def select_evenly(cells: np.ndarray, count: int) -> np.ndarray:
    """Increasing indices of ``count`` points, spread evenly in space.

    Every occupied cell gives one point before any gives a second; a layer that does not fit whole is thinned
    at equal steps along a Morton curve.

    Args:
        cells: Non-negative cell indices, shape (n, 3).
        count: At most n.
    """
    if count >= len(cells):
        return np.arange(len(cells))
    code = _encode_morton(cells)
    order = np.argsort(code, kind="stable")
    sorted_code = code[order]
    starts = np.flatnonzero(np.concatenate([[True], sorted_code[1:] != sorted_code[:-1]]))
    rank = _rank(np.diff(np.append(starts, len(order))))
    layers = np.cumsum(np.bincount(rank))
    whole = int(np.searchsorted(layers, count, side="right"))  # layers that fit
    kept = order[rank < whole]
    return np.sort(np.concatenate([kept, _choose_evenly(order[rank == whole], count - len(kept))]))


def _choose_evenly(values: np.ndarray, count: int) -> np.ndarray:
    """``count`` of ``values``, at equal steps."""
    return values[(np.arange(count) * 2 + 1) * len(values) // max(2 * count, 1)]


def _encode_morton(cells: np.ndarray) -> np.ndarray:
    """Interleave the low ten bits of the indices, so that near codes are near cells; uint32, shape (n,)."""
    code = np.zeros(len(cells), np.uint32)
    for axis in range(3):
        bits = cells[:, axis].astype(np.uint32)
        for shift, mask in ((16, 0x030000FF), (8, 0x0300F00F), (4, 0x030C30C3), (2, 0x09249249)):
            bits |= bits << shift  # halves move apart, until two empty bits follow each
            bits &= mask
        code |= bits << axis
    return code


def _compute_volumes(cells: np.ndarray, wall: np.ndarray, layer: np.ndarray, spacing: float) -> np.ndarray:
    """Volume of each particle [m^3], shape (n,).

    A solid cell is matter; of an outer wall cell half is, because the surface runs through it, on average midway.
    Cells' matter is shared within blocks of 1, 2, 4, ... cells, the smallest for which nearly all matter lies
    in blocks that hold particles (1 unless the cap thinned them); the rest is spread over all.
    """
    half_cells = np.where(layer == OUTSIDE, 0, np.where(wall & (layer == OUTER), 1, 2)).astype(np.uint8)
    total = half_cells.sum(dtype=np.int64)
    block = 1
    while True:
        sums = _sum_blocks(half_cells, block)
        key = np.ravel_multi_index(tuple((cells // block).T), sums.shape)
        occupied, where, count = np.unique(key, return_inverse=True, return_counts=True)
        contents = sums.ravel()[occupied]
        covered = contents.sum(dtype=np.int64)
        if covered >= 0.98 * total or max(sums.shape) == 1:
            return (contents / count * (total / covered * 0.5 * spacing**3))[where]
        block *= 2


def _compute_cell_shares(x: np.ndarray, dx: float) -> np.ndarray:
    """PhysGaussian's volumes [m^3]: the simulation cell's over the number of particles in it, shape (n,)."""
    _, cell, count = np.unique(np.floor(x / dx), axis=0, return_inverse=True, return_counts=True)
    return dx**3 / count[cell.ravel()]


def _sum_blocks(values: np.ndarray, block: int) -> np.ndarray:
    """Sums of ``values`` over cubes of ``block`` cells along each side, from the low corner on."""
    if block == 1:
        return values
    shape = [-(-side // block) for side in values.shape]
    padded = np.pad(values, [(0, n * block - side) for n, side in zip(shape, values.shape)])
    split = padded.reshape(shape[0], block, shape[1], block, shape[2], block)
    return split.sum(axis=(1, 3, 5), dtype=np.int64)
