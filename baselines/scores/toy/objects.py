"""Objects to learn from: a ball, a vase, a ring, a bar and a drum. None of them is in a task."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.scene.shapes import Patch, build, make_lathe, make_tube
from physagent_jax.scene.surfels import value_noise

GAUSSIANS = 1200  # enough for pictures of 64 pixels


def make_ball(rng: np.random.Generator) -> list[Patch]:
    """A ball, sometimes flattened."""
    height = rng.uniform(0.7, 1.0)
    return [_lathe([(np.cos(a), height * np.sin(a)) for a in np.linspace(-1.57, 1.57, 25)], rng)]


def make_vase(rng: np.random.Generator) -> list[Patch]:
    """A closed vase with a belly and a neck."""
    belly, neck = rng.uniform(0.5, 0.7), rng.uniform(0.22, 0.35)
    profile = [(0, -1), (0.35, -1), (belly, -0.4), (neck, 0.4), (neck + 0.1, 1), (0, 1)]
    return [_lathe(profile, rng)]


def make_ring(rng: np.random.Generator) -> list[Patch]:
    """A ring that lies flat."""
    thick = rng.uniform(0.24, 0.34)
    turn = np.linspace(0, 2 * np.pi, 25)
    return [_lathe([(0.7 + thick * np.sin(a), thick * np.cos(a)) for a in turn], rng)]


def make_bar(rng: np.random.Generator) -> list[Patch]:
    """A round bar, upright or lying."""
    radius = rng.uniform(0.22, 0.3)
    ends = np.array([[0, 0, -1.0], [0, 0, -0.3], [0, 0, 0.3], [0, 0, 1.0]])
    if rng.random() < 0.5:
        ends = ends[:, [2, 0, 1]]
    rounded = make_tube(ends, lambda v: radius * np.sqrt(np.clip(1.02 - (2 * v - 1) ** 8, 0, 1)))
    return [Patch(rounded, _paint(rng))]


def make_drum(rng: np.random.Generator) -> list[Patch]:
    """A low cylinder."""
    height = rng.uniform(0.3, 0.6)
    return [_lathe([(0, -height), (0.8, -height), (0.8, height), (0, height)], rng)]


OBJECTS: dict[str, Callable[[np.random.Generator], list[Patch]]] = {
    "ball": make_ball,
    "vase": make_vase,
    "ring": make_ring,
    "bar": make_bar,
    "drum": make_drum,
}


def write_object(name: str, seed: int, folder: Path) -> Path:
    """Write an object of a kind, its proportions and colours drawn by the seed, as a 3DGS PLY."""
    rng = np.random.default_rng([seed, list(OBJECTS).index(name)])
    cloud: GaussianCloud = build(OBJECTS[name](rng), GAUSSIANS, seed)
    path = folder / f"{name}_{seed}.ply"
    write_ply(path, cloud)
    return path


def _lathe(profile: list[tuple[float, float]], rng: np.random.Generator) -> Patch:
    """A surface of revolution through (radius, height) points."""
    radius, height = np.array(profile, float).T
    at = np.linspace(0, 1, len(profile))
    surface = make_lathe(
        lambda angle, v: np.interp(v, at, np.maximum(radius, 1e-4)), lambda v: np.interp(v, at, height)
    )
    return Patch(surface, _paint(rng))


def _paint(rng: np.random.Generator):
    """Stripes or blotches of two colours: without texture a turning solid of revolution looks still."""
    light, dark = rng.uniform(0.4, 1.0, 3), rng.uniform(0.0, 0.5, 3)
    seed, scale, striped = int(rng.integers(1 << 30)), rng.uniform(2, 5), rng.random() < 0.5
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)

    def paint(points, u, v):
        if striped:
            share = 0.5 + 0.5 * np.sign(np.sin(2.5 * scale * (points @ direction)))
        else:
            share = np.clip((value_noise(points, scale, seed) - 0.5) / 0.1, 0, 1)
        return dark + share[:, None] * (light - dark)

    return paint
