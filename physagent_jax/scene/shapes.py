"""Parametric surfaces sampled as flat Gaussians: what the procedural objects are built of."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.scene.surfels import bake_light, make_surfels, place_evenly

DISC_RADIUS = 0.68  # standard deviation over the mean spacing
_CANDIDATES = 10  # random parameter pairs per wanted sample
_STEP = 1e-4  # of the finite differences, in parameter units

Surface = Callable[[np.ndarray, np.ndarray], np.ndarray]  # (u, v), each (n,), in [0, 1] -> points (n, 3)
Paint = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]  # (points, u, v) -> rgb (n, 3)


@dataclasses.dataclass(frozen=True)
class Patch:
    """A surface over the unit square, and its paint.

    Attributes:
        surface: Maps parameters in [0, 1] to points [m]; d/du x d/dv points outwards.
        paint: Albedo in [0, 1] at the points.
        two_sided: Whether it is a thin sheet that light shines through.
        detail: Samples per area relative to other patches.
        shade: Factor on the light, for parts that lie in others' shadow.
    """

    surface: Surface
    paint: Paint
    two_sided: bool = False
    detail: float = 1.0
    shade: float = 1.0


def build(
    patches: list[Patch], count: int, seed: int, *, opacity: float = 0.98, gloss: float = 0.0
) -> GaussianCloud:
    """Samples the patches evenly, paints them and bakes light in.

    Args:
        patches: The parts.
        count: Gaussians in all (met up to rounding).
        seed: Seed of the sampling.
        opacity: Opacity of every Gaussian.
        gloss: Strength of a white highlight.
    """
    rng = np.random.default_rng(seed)
    u, v = (rng.uniform(size=4096) for _ in range(2))
    areas = [_compute_area_vectors(p.surface, u, v)[1].mean() * p.detail for p in patches]
    parts = [_sample(p, max(round(count * a / sum(areas)), 8), rng, gloss) for p, a in zip(patches, areas)]
    points, normals, radius, rgb = (np.concatenate(field) for field in zip(*parts))
    return make_surfels(points, normals, radius, rgb, opacity=opacity)


def _compute_area_vectors(surface: Surface, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals, shape (n, 3), and area elements [m^2], shape (n,), by central differences."""
    along_u = surface(u + _STEP, v) - surface(u - _STEP, v)
    along_v = surface(u, v + _STEP) - surface(u, v - _STEP)
    cross = np.cross(along_u, along_v) / (2 * _STEP) ** 2
    area = np.linalg.norm(cross, axis=1)
    return cross / np.maximum(area, 1e-12)[:, None], area


def _sample(patch: Patch, count: int, rng: np.random.Generator, gloss: float):
    u, v = (rng.uniform(_STEP, 1 - _STEP, _CANDIDATES * count) for _ in range(2))
    area = _compute_area_vectors(patch.surface, u, v)[1]
    # The top ``3 count`` of Gumbel-perturbed log weights: draws proportional to area, without replacement.
    keys = np.log(np.maximum(area, 1e-12)) + rng.gumbel(size=len(area))
    chosen = np.sort(np.argpartition(-keys, 3 * count)[: 3 * count])
    u, v = u[chosen], v[chosen]
    keep = place_evenly(patch.surface(u, v), count)
    u, v = u[keep], v[keep]
    points = patch.surface(u, v)
    normals = _compute_area_vectors(patch.surface, u, v)[0]
    light = patch.shade * bake_light(normals, two_sided=patch.two_sided)
    rgb = patch.paint(points, u, v) * light[:, None] + gloss * _paint_highlight(normals)[:, None]
    radius = np.full(count, DISC_RADIUS * np.sqrt(area.mean() / count))
    return points, normals, radius, rgb


def _paint_highlight(normals: np.ndarray) -> np.ndarray:
    """The highlight where a viewer in front sees the key light mirrored, shape (n,)."""
    halfway = np.array([-0.35, -0.75, 0.56])
    return np.maximum(normals @ (halfway / np.linalg.norm(halfway)), 0) ** 40


def make_lathe(radius: Callable, height: Callable) -> Surface:
    """Surface of revolution about z: ``u`` turns, ``v`` runs up; ``radius(angle, v)``, ``height(v)`` [m]."""

    def surface(u, v):
        angle = 2 * np.pi * u
        r = radius(angle, v)
        return np.stack([r * np.cos(angle), r * np.sin(angle), height(v) + 0 * r], axis=1)

    return surface


def make_tube(controls: np.ndarray, radius: Callable) -> Surface:
    """Tube of ``radius(v)`` [m] around a cubic Bezier curve with ``controls``, shape (4, 3)."""
    controls = np.asarray(controls, np.float64)
    axis = controls[3] - controls[0]
    side = np.cross(axis, [0.31, 0.85, 0.43])
    side /= np.linalg.norm(side)

    def surface(u, v):
        along = bezier_tangent(controls, v)
        first = side - (along @ side)[:, None] * along
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        second = np.cross(along, first)
        angle = 2 * np.pi * u
        around = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second
        return bezier(controls, v) + radius(v)[:, None] * around

    return surface


def make_leaf(base, direction, *, length: float, width: float, droop: float, roll: float) -> Surface:
    """A pointed, slightly folded blade; ``u`` runs across, ``v`` from the base to the tip.

    Args:
        base: Where it is attached [m], shape (3,).
        direction: Where it points at first, shape (3,).
        length: [m].
        width: [m].
        droop: How far the tip sinks below the straight line, over the length.
        roll: Angle about its own axis [rad].
    """
    along = np.asarray(direction, np.float64) / np.linalg.norm(direction)
    side = np.cross(along, [0.0, 0.0, 1.0]) + 1e-6
    side /= np.linalg.norm(side)
    up = np.cross(side, along)
    side, up = np.cos(roll) * side + np.sin(roll) * up, np.cos(roll) * up - np.sin(roll) * side

    def surface(u, v):
        across = 2 * u - 1
        half = 0.5 * width * np.sin(np.pi * np.clip(v, 0, 1) ** 0.8) ** 0.75 * (1 - 0.15 * v)
        fold = 0.35 * half * across**2
        sink = droop * length * v**2
        return (
            np.asarray(base)
            + (length * v)[:, None] * along
            + (half * across)[:, None] * side
            + fold[:, None] * up
            - sink[:, None] * np.array([0.0, 0.0, 1.0])
        )

    return surface


def bezier(controls: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Points of a cubic Bezier curve, shape (n, 3)."""
    s = 1 - t
    weights = np.stack([s**3, 3 * s**2 * t, 3 * s * t**2, t**3], axis=1)
    return weights @ controls


def bezier_tangent(controls: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Unit tangents of a cubic Bezier curve, shape (n, 3)."""
    s = 1 - t
    weights = np.stack([s**2, 2 * s * t, t**2], axis=1)
    tangent = weights @ np.diff(controls, axis=0)
    return tangent / np.linalg.norm(tangent, axis=1, keepdims=True)
