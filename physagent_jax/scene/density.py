"""The density of the Gaussians on a grid, and the cells that they enclose."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy import ndimage
from scipy.spatial.transform import Rotation

from physagent_jax.gaussians.cloud import GaussianCloud

REACH = 2.0  # standard deviations out to which a Gaussian counts
THINNEST = 0.35  # least standard deviation in cells: REACH * THINNEST = 0.7 cells to each side of a flat disc
WIDEST = 0.125  # largest standard deviation over the grid's longest side
EVALUATIONS = 50_000_000  # of the exponential, in all; the widest Gaussians are clamped until it is met
_BATCH = 2_000_000  # evaluations at once, for memory

_NEIGHBOURS = ndimage.generate_binary_structure(3, 1).astype(np.uint8)
_NEIGHBOURS[1, 1, 1] = 0  # the six face neighbours


@dataclasses.dataclass(frozen=True)
class CellGrid:
    """Cubic cells in a box.

    Attributes:
        low: The low corner [m], shape (3,).
        spacing: Side of a cell [m].
        shape: Cells along the axes.
    """

    low: np.ndarray
    spacing: float
    shape: tuple[int, int, int]

    @classmethod
    def around(cls, points: np.ndarray, spacing: float, *, margin: int = 2) -> CellGrid:
        """The grid that covers ``points`` with ``margin`` empty cells to spare on each side."""
        low, high = points.min(axis=0), points.max(axis=0)
        shape = np.ceil((high - low) / spacing).astype(int) + 1 + 2 * margin
        slack = 0.5 * (shape * spacing - (high - low))
        return cls(low - slack, spacing, (int(shape[0]), int(shape[1]), int(shape[2])))

    def cells(self, points: np.ndarray) -> np.ndarray:
        """Cell indices of points, shape (n, 3)."""
        return np.floor((points - self.low) / self.spacing).astype(np.int64)

    def centers(self, cells: np.ndarray) -> np.ndarray:
        """Centres of cells [m], shape (n, 3)."""
        return self.low + (cells + 0.5) * self.spacing


def overlap_density(cloud: GaussianCloud, grid: CellGrid) -> np.ndarray:
    """Sums opacity * exp(-d^T Sigma^-1 d / 2) over the Gaussians at the cell centres (PhysGaussian).

    A Gaussian counts out to `REACH` standard deviations. These are clamped from below, so that a flat disc
    still meets the centres of the cells that it passes through, and from above, so that a runaway Gaussian
    costs no more than others (in PhysGaussian an unbounded radius makes the filling hang).

    Returns:
        Dimensionless overlap, float64, the grid's shape.
    """
    means = np.asarray(cloud.means, np.float64)
    opacities = np.asarray(cloud.opacities, np.float64)
    axes = Rotation.from_quat(np.asarray(cloud.quats, np.float64), scalar_first=True).as_matrix()
    sigmas, radii = _clamp(np.asarray(cloud.scales, np.float64), axes, grid)
    whiten = axes / sigmas[:, None, :]  # d^T whiten = the offset in standard deviations
    base = grid.cells(means)
    density = np.zeros(np.prod(grid.shape))
    for radius in np.unique(radii, axis=0):
        members = np.flatnonzero((radii == radius).all(axis=1))
        offsets = np.stack(np.meshgrid(*[np.arange(-r, r + 1) for r in radius], indexing="ij"), -1).reshape(
            -1, 3
        )
        for part in np.array_split(members, len(members) * len(offsets) // _BATCH + 1):
            cells = base[part][:, None] + offsets
            offset = grid.centers(cells) - means[part][:, None]
            q = ((offset @ whiten[part]) ** 2).sum(axis=-1)
            counts = (q <= REACH**2) & ((cells >= 0) & (cells < grid.shape)).all(axis=-1)
            weight = (opacities[part][:, None] * np.exp(-0.5 * q))[counts]
            flat = np.ravel_multi_index(tuple(cells[counts].T), grid.shape)
            if flat.size < density.size // 8:  # few Gaussians have this footprint: leave the grid alone
                np.add.at(density, flat, weight)
            else:
                density += np.bincount(flat, weight, len(density))
    return density.reshape(grid.shape)


def _clamp(scales: np.ndarray, axes: np.ndarray, grid: CellGrid) -> tuple[np.ndarray, np.ndarray]:
    """Standard deviations in bounds [m] and footprints in cells along the grid's axes, each shape (n, 3)."""
    low = THINNEST * grid.spacing
    high = max(WIDEST * max(grid.shape) * grid.spacing, low)
    scales = np.nan_to_num(scales, nan=0.0, posinf=high)
    while True:
        sigmas = np.clip(scales, low, high)
        reach = REACH * np.sqrt(np.einsum("nij,nj->ni", axes**2, sigmas**2))
        radii = np.floor(reach / grid.spacing + 0.5).astype(np.int64)
        if np.prod(2 * radii + 1, axis=1).sum() <= EVALUATIONS or high <= low:
            return sigmas, radii
        high = max(0.8 * high, low)


def find_interior(
    wall: np.ndarray, *, exclude: int | None, cast: int, search: np.ndarray | None = None
) -> np.ndarray:
    """Empty cells that are inside the walls.

    A cell is inside if the walls enclose it (no path of face neighbours leads out), or, since captured
    walls have holes, by PhysGaussian's test: along the axes a wall is hit, and the walls ahead along
    ``cast`` are an odd number. Rays that slip through a hole leave thin unfilled columns: cells most of
    whose face neighbours are solid are therefore filled as well.

    Args:
        wall: Cells that hold matter, bool.
        exclude: Direction (0..5 = +x, -x, +y, -y, +z, -z) along which no wall need be hit; None = all six.
        cast: Direction along which walls are counted.
        search: Cells that count as walls for the test; None = ``wall``.

    Returns:
        Bool, disjoint from ``wall``.
    """
    search = wall if search is None else search
    ahead = [_find_wall_ahead(search, direction) for direction in range(6)]
    required = [a for direction, a in enumerate(ahead) if direction != exclude]
    inside = ~search & _find_odd_ahead(search, cast) & np.logical_and.reduce(required)
    inside |= search & ~wall & np.logical_and.reduce(ahead)  # thin matter with walls all around
    solid = np.asarray(ndimage.binary_fill_holes(wall | inside))
    for _ in range(2):
        solid |= ndimage.convolve(solid.view(np.uint8), _NEIGHBOURS, mode="constant") >= 4
    return solid & ~wall


def _march_forward(cells: np.ndarray, direction: int) -> np.ndarray:
    """View whose first axis runs along ``direction``."""
    moved = np.moveaxis(cells, direction // 2, 0)
    return moved if direction % 2 == 0 else moved[::-1]


def _find_wall_ahead(wall: np.ndarray, direction: int) -> np.ndarray:
    """Return whether a wall lies strictly ahead of each cell."""
    ahead = np.zeros_like(wall)
    backwards = _march_forward(wall, direction)[::-1]
    _march_forward(ahead, direction)[::-1][1:] = np.logical_or.accumulate(backwards, axis=0)[:-1]
    return ahead


def _find_odd_ahead(wall: np.ndarray, direction: int) -> np.ndarray:
    """Return whether the number of walls entered from each cell onwards is odd."""
    view = _march_forward(wall, direction)
    entered = view.copy()
    entered[1:] &= ~view[:-1]
    odd = np.empty_like(wall)
    _march_forward(odd, direction)[::-1] = np.logical_xor.accumulate(entered[::-1], axis=0)
    return odd
