"""A tiny z-buffered point renderer and textured shapes under exactly known motions: the oracle of these tests.

It shares nothing with the product's renderer but the camera. Everything is drawn at twice the
resolution and averaged down, so that edges and texture move by fractions of a pixel as in a real picture.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from physagent_jax.render.camera import Camera, look_at

Motion = Callable[[np.ndarray, float], np.ndarray]
"""Maps rest points (n, 3) and the clip's phase in [0, 1] to moved points (n, 3)."""

SIZE = 256
FRAMES = 24


@dataclasses.dataclass(frozen=True)
class Shape:
    """Surface points with colours to be drawn, and volume points that stand for the particles."""

    surface: np.ndarray
    colours: np.ndarray
    volume: np.ndarray


@dataclasses.dataclass(frozen=True)
class Clip:
    """A camera's pictures, and the particles' true path (T, n, 3)."""

    rgb: np.ndarray
    depth: np.ndarray
    camera: Camera
    particles: np.ndarray


def camera(eye=(0.0, -3.0, 0.5), size: int = SIZE) -> Camera:
    return look_at(eye, (0, 0, 0), (0, 0, 1), fov_degrees=36.0, width=size, height=size)


def texture(points: np.ndarray, seed: int, *, waves: int = 40) -> np.ndarray:
    """Smooth coloured marble with features of 0.06 to 0.3 m, (n, 3) in 40..255."""
    rng = np.random.default_rng(seed)
    k = rng.normal(size=(waves, 3))
    k *= (2 * np.pi / rng.uniform(0.06, 0.3, waves) / np.linalg.norm(k, axis=1))[:, None]
    signal = np.sin(points @ k.T + rng.uniform(0, 2 * np.pi, waves)) @ rng.normal(size=(waves, 3))
    return 147 + 107 * np.tanh(signal / np.sqrt(waves))


def _sample_sphere(count: int) -> np.ndarray:
    i = np.arange(count) + 0.5
    z, angle = 1 - 2 * i / count, np.pi * (1 + 5**0.5) * i
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(angle), r * np.sin(angle), z], 1)


def blob(seed: int = 0, axes=(0.5, 0.4, 0.4), count: int = 40_000) -> Shape:
    """An ellipsoid with dents; the filling follows the same dents."""

    def dented(directions):
        lumps = 0.06 * np.sin(3 * directions[:, :1] + 1) + 0.06 * np.sin(4 * directions[:, 2:] + 2)
        return directions * (1 + lumps) * np.asarray(axes)

    surface = dented(_sample_sphere(count))
    rng = np.random.default_rng(seed)
    directions = _sample_sphere(6000)
    volume = dented(directions) * rng.uniform(0, 1, (6000, 1)) ** (1 / 3)
    return Shape(surface, texture(surface, seed), volume)


def plant(seed: int = 1) -> Shape:
    """A stalk with three leafy balls, standing on z = -0.5 and 1 m tall."""
    rng = np.random.default_rng(seed)
    height, angle = rng.uniform(-0.5, 0.4, 12_000), rng.uniform(0, 2 * np.pi, 12_000)
    stalk = np.stack([0.04 * np.cos(angle), 0.04 * np.sin(angle), height], 1)
    radii = (0.16, 0.15, 0.12)
    centers = ((0.12, 0, 0.3), (-0.14, 0.05, 0.1), (0.08, -0.05, -0.1))
    parts = [stalk, *(_sample_sphere(12_000) * r + c for r, c in zip(radii, centers))]
    areas = np.array([2 * np.pi * 0.04 * 0.9, *(4 * np.pi * r**2 for r in radii)])
    counts = (4800 * areas / areas.sum()).astype(int)  # particles are as dense on the stalk as on the balls
    volume = [p[np.linspace(0, len(p) - 1, n).astype(int)] for p, n in zip(parts, counts)]
    surface = np.concatenate(parts)
    return Shape(surface, texture(surface, seed), np.concatenate(volume))


def film(
    shape: Shape,
    motion: Motion,
    view: Camera | None = None,
    *,
    frames: int = FRAMES,
    background=(255, 255, 255),
) -> Clip:
    """Draw ``shape`` under ``motion`` at ``frames`` evenly spaced phases."""
    view = camera() if view is None else view
    phases = np.linspace(0, 1, frames) if frames > 1 else [0.0]
    drawn = [_draw(motion(shape.surface, s), shape.colours, view, background) for s in phases]
    rgb, depth = (np.stack(a) for a in zip(*drawn))
    return Clip(rgb, depth, view, np.stack([motion(shape.volume, s) for s in phases]))


def _draw(points, colours, view: Camera, background):
    """One frame: rgb uint8 (H, W, 3) and z-depth float32 (H, W), nan where nothing is."""
    scale, width, height = 2, view.width, view.height
    seen = points @ view.viewmat[:3, :3].T + view.viewmat[:3, 3]
    order = np.argsort(-seen[:, 2])  # far to near: the nearest writes last
    seen = seen[order]
    pixel = np.floor(scale * (seen @ view.K.T)[:, :2] / seen[:, 2:]).astype(np.int32)
    steps = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)], np.int32)
    x, y = (pixel[:, None, k] + steps[:, k] for k in (0, 1))
    inside = (x >= 0) & (x < scale * width) & (y >= 0) & (y < scale * height)
    source = np.broadcast_to(np.arange(len(seen), dtype=np.int32)[:, None], x.shape)
    owner = np.full(scale * height * scale * width, -1, np.int32)
    if inside.all():
        owner[(y * (scale * width) + x).ravel()] = source.ravel()
    else:
        owner[(y * (scale * width) + x)[inside]] = source[inside]
    owner = owner.reshape(height, scale, width, scale).transpose(0, 2, 1, 3).reshape(height, width, -1)
    rgb = np.broadcast_to(np.asarray(background, float).round().astype(np.uint8), (height, width, 3)).copy()
    depth = np.full((height, width), np.nan, np.float32)
    touched = (owner >= 0).any(-1)  # all else is background
    tiles = owner[touched]
    hit = tiles >= 0
    fine = np.where(hit[..., None], colours[order][tiles], np.asarray(background, float))
    rgb[touched] = fine.mean(1).round().astype(np.uint8)
    count = hit.sum(1)
    mean = np.where(hit, seen[tiles, 2], 0.0).sum(1) / count
    depth[touched] = np.where(count >= 2, mean, np.nan)
    return rgb, depth


def translated(offset, path: Callable[[float], float] = lambda s: s) -> Motion:
    """Move by ``offset`` times ``path(phase)``."""
    return lambda x, s: x + np.asarray(offset) * path(s)


def rotated(axis, degrees: float) -> Motion:
    """Turns about an axis through the origin, right-hand rule."""
    unit = np.asarray(axis, float) / np.linalg.norm(axis)
    return lambda x, s: Rotation.from_rotvec(np.radians(degrees * s) * unit).apply(x)


def stretched(factors) -> Motion:
    """Scales along world x, y, z about the origin."""
    return lambda x, s: x * (1 + (np.asarray(factors) - 1) * s)


def bent(angle_degrees: float, path: Callable[[float], float] = lambda s: s, *, foot: float = -0.5) -> Motion:
    """Bends towards -x as a clamped beam of height 1 m: a circular arc, the foot stays."""

    def motion(x, s):
        kappa = np.radians(angle_degrees) * path(s) + 1e-9
        up = x[:, 2] - foot
        return np.stack(
            [
                x[:, 0] * np.cos(kappa * up) - (1 - np.cos(kappa * up)) / kappa,
                x[:, 1],
                foot + np.sin(kappa * up) / kappa + x[:, 0] * np.sin(kappa * up),
            ],
            1,
        )

    return motion
