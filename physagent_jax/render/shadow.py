"""The soft shadow that Gaussians cast straight down: dark and sharp at contact, pale and wide from high above."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.ndimage import gaussian_filter

from physagent_jax.gaussians.cloud import Splats

CELLS_PER_SIZE = 48
MOST_CELLS = 384  # a side: what has flown off farther casts none
GRAIN = 0.02  # [sizes] over which single Gaussians blend into a surface
COARSE = 1.5 * GRAIN  # standard deviation from which on a Gaussian is cast as several points [sizes]
NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(
    7
)  # where these are, in standard deviations, and their shares
NEAREST = 0.03  # [sizes]; of a column of matter the lowest part counts, averaged over about that height
# Heights of matter above the ground [sizes]; of each, how wide its shadow is blurred [sizes], and how much of the light
# it takes where it covers all of the ground. Between two heights both are mixed.
HEIGHTS = (0.0, 0.07, 0.2, 0.5, 1.0, 2.0)
BLURS = (0.012, 0.035, 0.09, 0.18, 0.3, 0.4)
STRENGTHS = (0.74, 0.58, 0.45, 0.32, 0.2, 0.0)
LEAST_SEEN = 0.004  # darkness; less is no level of 8 bits
DEEPEST = 0.1  # [sizes] below the ground; what is deeper is out of the light


@dataclasses.dataclass(frozen=True)
class ShadowMap:
    """The share of light that is missing on the ground.

    Attributes:
        low: Position of the first sample (x, y) [m], shape (2,).
        cell: Between samples [m].
        darkness: 0 = lit, 1 = dark, shape (nx, ny); its rim is 0.
    """

    low: np.ndarray
    cell: float
    darkness: np.ndarray

    def sample(self, points: np.ndarray) -> np.ndarray:
        """Darkness at ground points (x, y) [m], shape (..., 2), between samples bilinear; 0 off the map, and at nan."""
        places = (points - self.low.astype(np.float32)) / np.float32(self.cell)
        rows, columns = self.darkness.shape
        u, v = np.clip(np.nan_to_num(places[..., 0]), 0, rows - 1.001), places[..., 1]
        v = np.clip(np.nan_to_num(v), 0, columns - 1.001)
        i, j = u.astype(np.int32), v.astype(np.int32)
        a, b = u - i, v - j
        flat, at = self.darkness.ravel(), i * columns + j
        near = flat[at] + b * (flat[at + 1] - flat[at])
        far = flat[at + columns] + b * (flat[at + columns + 1] - flat[at + columns])
        return near + a * (far - near)


def cast_shadow(splats: Splats, ground: float, size: float) -> ShadowMap | None:
    """The shadow of Gaussians on a ground under a wide, even sky.

    Args:
        splats: In world space.
        ground: Its height [m].
        size: Size of the object [m].

    Returns:
        None if nothing is above the ground and near enough to darken it.
    """
    means = np.asarray(splats.means, np.float64)
    heights = (means[:, 2] - ground) / size
    opacities = np.asarray(splats.opacities, np.float64)
    casts = np.isfinite(means).all(axis=1) & (heights > -DEEPEST) & (heights < HEIGHTS[-1]) & (opacities > 0)
    if not casts.any():
        return None
    cell = size / CELLS_PER_SIZE
    covariances = np.asarray(splats.covariances, np.float64)[casts][:, [0, 1, 3]] / cell**2
    area = 2 * np.pi * np.sqrt(np.maximum(covariances[:, 0] * covariances[:, 2] - covariances[:, 1] ** 2, 0))
    thickness, heights = opacities[casts] * area, np.maximum(heights[casts], 0)
    places, thickness, heights = _spread_coarse(means[casts, :2] / cell, covariances, thickness, heights)
    # A lattice that stands still in the world, so that a shadow does not shimmer as it moves.
    cells = np.floor(places).astype(np.int64)
    middle = np.median(cells, axis=0).astype(np.int64)
    margin = int(3 * BLURS[-2] * CELLS_PER_SIZE)
    reach = MOST_CELLS // 2 - margin - 2
    low = np.maximum(cells.min(0), middle - reach) - margin
    high = np.minimum(cells.max(0), middle + reach) + margin + 2
    shape = tuple((high - low).tolist())
    column, near = (
        gaussian_filter(each, GRAIN * CELLS_PER_SIZE, truncate=3, mode="constant")
        for each in _scatter(places - low, (thickness, thickness * np.exp(-heights / NEAREST)), shape)
    )
    lowest = -NEAREST * np.log(np.clip(near / np.maximum(column, 1e-12), 1e-30, 1))
    cover, layer = 1 - np.exp(-column), np.interp(lowest, HEIGHTS, np.arange(len(HEIGHTS)))
    dark = np.zeros(shape, np.float32)
    for index, (blur, strength) in enumerate(zip(BLURS, STRENGTHS)):
        share = np.clip(1 - np.abs(layer - index), 0, None) * cover
        if strength and share.any():
            dark += strength * gaussian_filter(share, blur * CELLS_PER_SIZE, truncate=3, mode="constant")
    dark[[0, -1], :] = dark[:, [0, -1]] = 0
    rows, columns = (np.flatnonzero((dark > LEAST_SEEN).any(axis=axis)) for axis in (1, 0))
    if len(rows) == 0:
        return None
    first = np.array([rows[0], columns[0]]) - 1  # the rim is 0, so there is a row and a column more
    return ShadowMap((low + first) * cell, cell, dark[first[0] : rows[-1] + 2, first[1] : columns[-1] + 2])


def _spread_coarse(
    places: np.ndarray, covariances: np.ndarray, thickness: np.ndarray, heights: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Large Gaussians as several points; places and covariances (xx, xy, yy) in cells."""
    coarse = covariances[:, 0] + covariances[:, 2] > (COARSE * CELLS_PER_SIZE) ** 2
    if not coarse.any():
        return places, thickness, heights
    xx, xy, yy = covariances[coarse].T
    a = np.sqrt(np.maximum(xx, 1e-12))
    b = xy / a
    c = np.sqrt(np.maximum(yy - b * b, 0))
    u, v = (each.ravel() for each in np.meshgrid(NODES, NODES))
    share = np.outer(WEIGHTS, WEIGHTS).ravel() / WEIGHTS.sum() ** 2
    offsets = np.stack([np.outer(a, u), np.outer(b, u) + np.outer(c, v)], axis=2)
    points = (places[coarse][:, None] + offsets).reshape(-1, 2)
    return (
        np.concatenate([places[~coarse], points]),
        np.concatenate([thickness[~coarse], np.outer(thickness[coarse], share).ravel()]),
        np.concatenate([heights[~coarse], np.repeat(heights[coarse], len(share))]),
    )


def _scatter(places: np.ndarray, values: tuple[np.ndarray, ...], shape: tuple[int, ...]) -> list[np.ndarray]:
    """Sums of each of ``values`` on a lattice, shared among the four samples around a place."""
    corner = np.floor(places).astype(np.int64)
    inside = ((corner >= 0) & (corner + 1 < shape)).all(axis=1)
    corner, part = corner[inside], (places - corner)[inside]
    totals = [np.zeros(shape[0] * shape[1]) for _ in values]
    for i in (0, 1):
        for j in (0, 1):
            share = np.abs(1 - i - part[:, 0]) * np.abs(1 - j - part[:, 1])
            at = (corner[:, 0] + i) * shape[1] + corner[:, 1] + j
            for total, value in zip(totals, values):
                total += np.bincount(at, share * value[inside], len(total))
    return [total.reshape(shape).astype(np.float32) for total in totals]
