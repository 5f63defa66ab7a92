"""Seeded objects made on the spot: a potted plant, a loaf of bread, a jelly. z-up, standing on z = 0, about 1 m.

They need no download and have what the closed loop needs: parts thick enough to be simulated, and texture
that can be tracked.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from physagent_jax.core.arrays import to_device
from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.scene.shapes import Patch, bezier, build, make_lathe, make_leaf, make_tube
from physagent_jax.scene.surfels import value_noise

_TAU = 2 * np.pi


def make_plant(seed: int = 0, *, count: int = 8000) -> GaussianCloud:
    """A small tree in a terracotta pot, 1 m tall.

    The trunk is 0.12 m thick, 2.8 cells when the plant is 24 cells tall: a thinner one has no bending
    stiffness of its own on such a grid.
    """
    rng = np.random.default_rng(seed)
    trunk = np.array([[0, 0, 0.24], [0.05, 0.02, 0.36], [-0.07, -0.02, 0.48], [0.0, 0.0, 0.66]])
    trunk[1:3, :2] *= rng.choice([-1, 1])
    patches = [
        *_make_pot(seed),
        Patch(make_tube(trunk, lambda v: 0.062 - 0.008 * v), _paint_bark(seed), detail=1.3, shade=0.92),
    ]
    branches = [_make_branch(trunk, k, rng) for k in range(9)]
    patches += [
        Patch(make_tube(b, lambda v: 0.026 - 0.012 * v), _paint_bark(seed), detail=1.3, shade=0.9)
        for b in branches
    ]
    for b, branch in enumerate(branches):
        patches += _make_foliage(branch, 8, rng, seed + 17 * b)
    return _stand_up(build(patches, count, seed), height=1.0)


def _make_branch(trunk: np.ndarray, k: int, rng: np.random.Generator) -> np.ndarray:
    """A Bezier curve from the upper trunk outwards and up; the golden angle spreads them."""
    angle = 2.39996 * k + rng.uniform(-0.3, 0.3)
    out = np.array([np.cos(angle), np.sin(angle), 0.0])
    base = bezier(trunk, np.array([0.62 + 0.042 * k]))[0]
    reach, rise = rng.uniform(0.13, 0.2), 0.05 + 0.022 * k + rng.uniform(0, 0.03)
    up = np.array([0.0, 0.0, 1.0])
    return np.stack(
        [
            base,
            base + 0.4 * reach * out + 0.2 * rise * up,
            base + 0.8 * reach * out + 0.6 * rise * up,
            base + reach * out + rise * up,
        ]
    )


def _make_foliage(branch: np.ndarray, count: int, rng: np.random.Generator, seed: int) -> list[Patch]:
    """Leave around the outer half of a branch, spreading and drooping a little."""
    patches = []
    for k in range(count):
        base = bezier(branch, np.array([0.45 + 0.55 * (k + 1) / count]))[0]
        angle = 2.39996 * k + rng.uniform(0, 0.8)
        outward = branch[3] - branch[0]
        direction = np.array([np.cos(angle), np.sin(angle), rng.uniform(-0.05, 0.75)])
        direction += 0.9 * outward / np.linalg.norm(outward)
        surface = make_leaf(
            base,
            direction,
            length=rng.uniform(0.15, 0.22),
            width=rng.uniform(0.095, 0.135),
            droop=rng.uniform(0.15, 0.4),
            roll=rng.uniform(-0.5, 0.5),
        )
        patches.append(
            Patch(surface, _paint_leaf(rng, seed + k), two_sided=True, shade=rng.uniform(0.85, 1.12))
        )
    return patches


def _paint_leaf(rng: np.random.Generator, seed: int):
    green = np.array([0.24, 0.58, 0.16]) + rng.uniform(-1, 1) * np.array([0.10, 0.07, 0.02])

    def paint(points, u, v):
        across = np.abs(2 * u - 1)
        rib = np.exp(-((across / 0.10) ** 2))
        veins = 0.5 + 0.5 * np.cos(_TAU * (5.5 * v - 1.6 * across))
        tone = 0.78 + 0.24 * veins + 0.22 * (value_noise(points, 30, seed) - 0.5)
        base = green * tone[:, None] * (1.12 - 0.35 * (1 - v)[:, None])
        pale = np.array([0.62, 0.76, 0.34])
        return base + 0.75 * rib[:, None] * (pale - base)

    return paint


def _paint_bark(seed: int):
    def paint(points, u, v):
        rings = value_noise(points * [1.0, 1.0, 3.0], 14, seed + 3)
        grain = value_noise(points, 45, seed + 4)
        tone = 0.55 + 0.5 * rings + 0.45 * (grain - 0.5)
        return np.array([0.50, 0.36, 0.23]) * tone[:, None]

    return paint


def _make_pot(seed: int) -> list[Patch]:
    """Tapered body, rim, soil and foot; the wall below the soil is a closed vessel, so that it fills."""

    def clay(points, u, v):
        stain = value_noise(points * [1, 1, 0.4], 9, seed + 5)
        grain = value_noise(points, 50, seed + 6, octaves=2)
        tone = 0.80 + 0.34 * stain + 0.22 * (grain - 0.5)
        base = np.array([0.74, 0.38, 0.24]) * tone[:, None]
        lime = np.clip((value_noise(points, 7, seed + 7) - 0.66) / 0.1, 0, 1)[:, None]
        return base + 0.35 * lime * (np.array([0.88, 0.80, 0.72]) - base)

    def soil(points, u, v):
        crumbs = value_noise(points, 55, seed + 8, octaves=2)
        return np.array([0.30, 0.20, 0.13]) * (0.45 + 1.1 * crumbs[:, None])

    def ring(profile):  # a lathe through (radius, height) points
        at = np.linspace(0, 1, len(profile))
        r, z = np.asarray(profile).T
        return make_lathe(lambda angle, v: np.interp(v, at, r), lambda v: np.interp(v, at, z))

    return [
        Patch(ring([(0.001, 0.0), (0.105, 0.0)]), clay, shade=0.9, detail=0.5),
        Patch(ring([(0.115, 0.0), (0.165, 0.225)]), clay),
        Patch(ring([(0.165, 0.225), (0.186, 0.228)]), clay, shade=0.6),
        Patch(ring([(0.186, 0.228), (0.190, 0.300)]), clay, detail=1.2),
        Patch(ring([(0.190, 0.300), (0.166, 0.302)]), clay, detail=1.2),
        Patch(ring([(0.166, 0.302), (0.160, 0.270)]), clay, shade=0.65),
        Patch(ring([(0.160, 0.270), (0.001, 0.278)]), soil, detail=1.2),
    ]


def make_loaf(seed: int = 0, *, count: int = 6000) -> GaussianCloud:
    """A crusty loaf, 1 m long, slashed on top, with the crumb showing at the cut end."""
    half, cut = 0.5, 0.36  # half length; where the cut plane crosses the axis
    slant = -0.75  # of the cut over the loaf's width: a viewer in front sees the crumb
    outline = _compute_loaf_outline()

    def crust(u, v):
        y, z = outline(u)
        x = -half + (cut + slant * y + half) * (1 - np.cos(0.5 * np.pi * np.clip(v, -1, 1)))
        taper = np.sqrt(np.clip(1 - (np.clip(0.28 - (x + half), 0, None) / 0.28) ** 2.4, 0, 1))
        taper = taper * (1 + 0.05 * (value_noise(np.stack([x, y, z], 1), 5, seed + 1, octaves=1) - 0.5))
        return np.stack([-x, -y * taper, 0.15 + (z - 0.15) * taper], axis=1)

    def crumb(u, v):
        y, z = outline(u)
        return np.stack([-cut - slant * y * (1 - v), -y * (1 - v), 0.15 + (z - 0.15) * (1 - v)], axis=1)

    patches = [Patch(crust, _paint_crust(seed)), Patch(crumb, _paint_crumb(seed), detail=1.8)]
    return _stand_up(build(patches, count, seed), length=1.0)


def _compute_loaf_outline():
    """The cross-section (y, z) [m] over turns, by arc length: a high arch on a flat, rounded sole."""
    angle = np.linspace(0, _TAU, 2001)
    sine = np.sin(angle)
    y = 0.26 * np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** 0.8
    z = 0.13 + np.where(sine > 0, 0.30 * np.abs(sine) ** 0.9, -0.13 * np.abs(sine) ** 0.45)
    length = np.concatenate([[0], np.cumsum(np.hypot(np.diff(y), np.diff(z)))])
    return lambda t: tuple(np.interp(t % 1.0 * length[-1], length, c) for c in (y, z))


def _paint_crust(seed: int):
    def paint(points, u, v):
        x, y, z = points.T
        bake = np.clip(z / 0.43, 0, 1) + 0.5 * (value_noise(points, 6, seed + 2) - 0.5)
        pale, golden, dark = np.array([[0.86, 0.66, 0.40], [0.78, 0.47, 0.19], [0.46, 0.23, 0.09]])
        low = np.clip(bake / 0.5, 0, 1)[:, None]
        high = np.clip((bake - 0.5) / 0.55, 0, 1)[:, None]
        base = pale + low * (golden - pale) + high * (dark - golden)
        along = (x + 0.55 * y + 0.02 * np.sin(40 * y)) / 0.20  # slashes run diagonally
        gap = np.abs(along - np.round(along))
        slash = np.exp(-((gap / 0.13) ** 2)) * np.clip((z - 0.27) / 0.05, 0, 1)
        edge = np.exp(-(((gap - 0.24) / 0.06) ** 2)) * np.clip((z - 0.27) / 0.05, 0, 1)
        base = base + 0.9 * slash[:, None] * (np.array([0.95, 0.82, 0.58]) - base)
        flour = np.clip((value_noise(points, 26, seed + 3) - 0.62) / 0.12, 0, 1) * np.clip(
            (z - 0.2) / 0.1, 0, 1
        )
        base = base + 0.4 * (flour * (1 - slash))[:, None] * (np.array([0.97, 0.93, 0.86]) - base)
        return base * (1 - 0.45 * edge[:, None]) * (0.88 + 0.24 * value_noise(points, 60, seed + 4)[:, None])

    return paint


def _paint_crumb(seed: int):
    def paint(points, u, v):
        rim = np.clip((0.09 - v) / 0.04, 0, 1)[:, None]  # v = 0 at the crust
        holes = np.clip((value_noise(points, 22, seed + 5, octaves=2) - 0.60) / 0.10, 0, 1)[:, None]
        fine = value_noise(points, 60, seed + 6, octaves=2)[:, None]
        crumb = np.array([0.95, 0.87, 0.70]) * (0.88 + 0.22 * fine)
        crumb = crumb + 0.55 * holes * (np.array([0.66, 0.50, 0.30]) - crumb)
        return crumb + rim * (np.array([0.60, 0.34, 0.14]) - crumb)

    return paint


def make_jelly(seed: int = 0, *, count: int = 8000) -> GaussianCloud:
    """A fluted jelly turned out of its mould, 0.7 m tall and 1 m wide, with fruit inside."""
    flutes = 14

    def fluted(base, depth):
        return lambda angle, v: base(v) * (1 + depth(v) * (np.abs(np.cos(0.5 * flutes * angle)) - 0.6))

    side = make_lathe(
        fluted(lambda v: 0.50 - 0.13 * np.maximum(v, 0) ** 1.4, lambda v: 0.13 + 0 * v), lambda v: 0.56 * v
    )
    # A dome that closes the top: the radius falls from the side's to nothing as the height levels out.
    dome = make_lathe(
        fluted(lambda v: 0.37 * np.cos(0.5 * np.pi * np.clip(v, 0, 0.9999)), lambda v: 0.13 * (1 - v)),
        lambda v: 0.56 + 0.14 * np.sin(0.5 * np.pi * v),
    )
    foot = make_lathe(fluted(lambda v: 0.475 * v + 1e-4, lambda v: 0.13 * v), lambda v: 0.0 * v)
    paint = _paint_jelly(seed)
    patches = [Patch(side, paint), Patch(dome, paint), Patch(foot, paint, shade=0.85, detail=0.6)]
    return _stand_up(build(patches, count, seed, opacity=0.95, gloss=0.75), height=0.7)


def _paint_jelly(seed: int):
    def paint(points, u, v):
        x, y, z = points.T
        depth = np.clip(z / 0.7, 0, 1)
        deep, bright = np.array([0.62, 0.05, 0.13]), np.array([1.0, 0.36, 0.30])
        # Light that entered above leaves near the foot and at thin flutes: brighter there, as gels look.
        radius = np.hypot(x, y)
        thin = np.clip(value_noise(points, 3, seed + 1, octaves=2), 0, 1)
        glow = np.clip(0.75 * (1 - depth) ** 1.5 + 0.35 * thin + 0.25 * (radius - 0.3), 0, 1)[:, None]
        base = deep + glow * (bright - deep)
        fruit = np.clip((value_noise(points, 10, seed + 2, octaves=1) - 0.76) / 0.04, 0, 1)[:, None]
        base = base + 0.7 * fruit * (np.array([1.0, 0.72, 0.30]) - base)
        bubbles = np.clip((value_noise(points, 34, seed + 3, octaves=1) - 0.74) / 0.08, 0, 1)[:, None]
        return base + 0.45 * bubbles * (np.array([1.0, 0.80, 0.78]) - base)

    return paint


def _stand_up(
    cloud: GaussianCloud, *, height: float | None = None, length: float | None = None
) -> GaussianCloud:
    """Shift the lowest centre to z = 0 and scale to a height, or to a length along x [m]."""
    means = np.asarray(cloud.means, np.float64)
    low, high = means.min(axis=0), means.max(axis=0)
    scale = height / (high - low)[2] if height else length / (high - low)[0]
    center = 0.5 * (low + high)
    means = scale * (means - [center[0], center[1], low[2]])
    return dataclasses.replace(cloud, means=to_device(means, np.float32), scales=cloud.scales * scale)


PROCEDURAL: dict[str, Callable[..., GaussianCloud]] = {
    "plant": make_plant,
    "loaf": make_loaf,
    "jelly": make_jelly,
}
