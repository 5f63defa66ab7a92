"""`python -m benchmarks.limits [--parts PART ...] [--json OUT] [--markdown OUT] [--quick]`: what the method does badly.

"thin": matter is thrown at a plate of few cells. "touching": two bodies that touch are given velocities apart.
"liquid": a jar of liquid at rest or stirred loses depth. "tool": slopes of a result by the speed of a moving obstacle.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Literal

import jax
import jax.numpy as jnp
import numpy as np
import trimesh
import tyro

from benchmarks import harness
from benchmarks.cases.bodies import half_space
from benchmarks.harness import RAW, Job, Page, number, provenance, table
from physagent_jax.mpm import (
    Box,
    Contact,
    DomainBox,
    DruckerPrager,
    Fluid,
    Grid,
    Model,
    NeoHookean,
    SignedDistance,
    Sphere,
    State,
    lame_parameters,
    rollout,
    simulate,
)
from physagent_jax.mpm.materials import Material
from physagent_jax.scene.signed_distance import sample

Part = Literal["thin", "touching", "liquid", "tool"]
PARTS: tuple[Part, ...] = ("thin", "touching", "liquid", "tool")

CELLS = 24
THICKNESSES = (1.0, 1.5, 2.0, 3.0, 4.0)  # [cells]
OFFSETS = (0.1, 0.6, 0.95)  # of the plate's upper face above a node [cells]
SPEEDS = (3.0, 6.0)  # [m/s]
THROW = 0.8  # time after which matter has passed or not [s]
APART, UNTIL = 0.3, 0.48  # speed of the upper body [m/s], time [s]
STEPS = {"1e-6": 1e-6, "0.1": 0.1}  # of the differences of speed [m/s]
SPEED = 0.93  # of the tool [m/s]
EVER = (0.0, 1e9)  # [s]


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Measure the limits that docs/limits.md states."""

    json: Path = RAW / "limits.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Part, ...] = PARTS
    """Parts to measure; none = only write the tables."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    return harness.main(command, list_parts(command.quick), PAGE)


def list_parts(quick: bool) -> dict[str, Callable[[], list[Job]]]:
    """Makers of the jobs of each part; quick ones take seconds."""
    thicknesses, offsets, seconds = ((1.0,), (0.1, 0.95), 0.3) if quick else (THICKNESSES, OFFSETS, 3.0)
    plates = [(kind, cells) for kind in PLATES for cells in thicknesses]
    jars = [(2, False), (2, True), (1, False)][-1 if quick else 0 :]
    gaps = (0.0,) if quick else (0.0, 1.0, 2.0)
    return {
        "thin": lambda: [
            Job(f"{kind} of {cells:g} cells", partial(measure_plate, kind, cells, offsets))
            for kind, cells in plates
        ],
        "touching": lambda: [Job(f"{gap:g} cells apart", partial(measure_parting, gap)) for gap in gaps],
        "liquid": lambda: [
            Job(
                f"{side}^3, {'stirred' if stirred else 'at rest'}",
                partial(measure_jar, side, stirred, seconds),
            )
            for side, stirred in jars
        ],
        "tool": lambda: [Job("ball that pushes a block", measure_slopes)],
    }


def write_tables(result: harness.Result) -> harness.Tables:
    """The tables of docs/limits.md."""
    rows = {part: result[part]["rows"] if part in result else [] for part in PARTS}
    plates: dict[tuple, dict[str, str]] = {}
    for row in rows["thin"]:
        cells = plates.setdefault((row["obstacle"], number(row["cells"]), number(row["speed"])), {})
        cells[row["matter"]] = _format_range(row["passed"])
    return {
        "thin": table(
            ("obstacle", "thickness [cells]", "speed [m/s]", *MATTER),
            [[*key, *(cells.get(name, "") for name in MATTER)] for key, cells in plates.items()],
        ),
        "touching": table(
            ("gap at first [cells]", f"after {UNTIL:g} s", "of free bodies"),
            [[number(row["gap"]), number(row["opened"]), number(row["free"])] for row in rows["touching"]],
        ),
        "liquid": table(
            ("particles a cell", "liquid", "depth over initial depth", "mean det F"),
            [
                [row["per_axis"] ** 3, row["motion"], f"{row['depth']:.3f}", f"{row['det_F']:.3f}"]
                for row in rows["liquid"]
            ],
        ),
        "tool": table(
            ("slope by", "m per m/s"), [[row["method"], f"{row['slope']:.4f}"] for row in rows["tool"]]
        ),
        "runs": provenance(result, PARTS),
    }


PAGE = Page(
    "limits",
    "python -m benchmarks.limits",
    write_tables,
    ("physagent_jax/mpm", "physagent_jax/kernels", "physagent_jax/scene/signed_distance.py"),
)


def _format_range(shares: Sequence[float]) -> str:
    texts = [f"{100 * share:.3g}" for share in (min(shares), max(shares))]
    return f"{' to '.join(dict.fromkeys(texts))} %"


def measure_plate(kind: str, cells: float, offsets: Sequence[float]) -> list[dict]:
    """Shares of mass that pass a plate at each offset of its upper face, for every matter and speed."""
    x, volume = fill((1 / 3, 1 / 3, 0.55), (2 / 3, 2 / 3, 0.8), 1 / CELLS / 2)
    rows = []
    for speed in SPEEDS:
        for name, make in MATTER.items():
            passed = []
            for offset in offsets:
                top, bottom = (CELLS // 2 + offset) / CELLS, (CELLS // 2 + offset - cells) / CELLS
                obstacles = DomainBox(3), PLATES[kind](bottom, top)
                v = np.broadcast_to([0, 0, -speed], x.shape)
                end = _simulate(x, v, volume, [make(len(x))], THROW, 8, boundaries=obstacles).state
                passed.append(float((np.asarray(end.x[:, 2]) < bottom - 0.5 / CELLS).mean()))
            rows.append({"obstacle": kind, "cells": cells, "matter": name, "speed": speed, "passed": passed})
            harness.say(str(rows[-1]))
    return rows


def measure_parting(gap: float) -> list[dict]:
    """Gap of two soft blocks, the upper of which is given a velocity upwards [cells]."""
    dx = 1 / 32
    lower, volume = fill((0.375, 0.375, 0.25), (0.625, 0.625, 0.5), dx / 2)
    x, count = np.concatenate([lower, lower + [0, 0, 0.25 + gap * dx]]), len(lower)
    v = np.repeat([[0, 0, 0], [0, 0, APART]], count, axis=0)
    end = _simulate(x, v, volume, [soft(count), soft(count)], UNTIL, 24, cells=32, gravity=None).state
    z = np.asarray(end.x[:, 2])
    opened = float((z[count:].min() - z[:count].max()) / dx - 0.5)  # particles are half a cell apart
    return [{"gap": gap, "opened": opened, "free": gap + APART * UNTIL / dx}]


def measure_jar(per_axis: int, stirred: bool, seconds: float) -> list[dict]:
    """Depth of a liquid over its first depth, by the height of its centre, and mean determinant of F."""
    x, volume = fill((0.25, 0.25, 0.25), (0.75, 0.75, 0.5), 1 / CELLS / per_axis)
    v = np.zeros_like(x)
    v[:, 0] = stirred * np.sign(x[:, 2] - 0.375)
    walls = [
        half_space(0.5 - 0.25 * np.array(normal), normal, Contact.SEPARATE, jnp.float32)
        for normal in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1))
    ]
    end = _simulate(x, v, volume, [liquid(len(x))], seconds, 30, boundaries=tuple(walls)).state
    depth = float(jnp.mean(end.x[:, 2]) - 0.25) / 0.125
    mean = float(jnp.linalg.det(end.F).mean())
    motion = "stirred" if stirred else "at rest"
    return [{"per_axis": per_axis, "motion": motion, "seconds": seconds, "depth": depth, "det_F": mean}]


def measure_slopes() -> list[dict]:
    """Slopes of a block's place by the speed of the ball that pushes it, in float64 [m per m/s]."""
    with jax.enable_x64(True):
        x, volume = fill((0.35, 0.35, 0.2), (0.6, 0.6, 0.4), 1 / 40)
        floor = half_space((0.5, 0.5, 0.2), (0, 0, 1), Contact.SEPARATE, jnp.float64, friction=0.3)

        def push(speed):
            point, velocity = jnp.array([0.2, 0.475, 0.3]), speed * jnp.array([1.0, 0, 0])
            ball = Sphere(point, jnp.array(0.12), jnp.array(0.3), *EVER, velocity=velocity)
            material = [soft(len(x))]
            model = make_model(len(x), 500 * volume, volume, material, cells=20, boundaries=(floor, ball))
            end, _ = rollout(model, State.at_rest(jnp.asarray(x)), frame_count=5, substeps=50)
            return end.x[:, 0].mean()

        slopes = {"automatic differentiation": jax.grad(push)(SPEED)}
        for label, step in STEPS.items():
            slopes[f"difference over {label} m/s"] = (push(SPEED + step) - push(SPEED - step)) / (2 * step)
        return [{"method": name, "slope": float(slope)} for name, slope in slopes.items()]


def fill(low: Sequence[float], high: Sequence[float], spacing: float) -> tuple[np.ndarray, float]:
    """Centres of cubes that fill a box [m], shape (n, 3), and the volume of one [m^3]."""
    axes = [np.arange(a + spacing / 2, b, spacing) for a, b in zip(low, high)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3), spacing**3


def sand(count: int) -> Material:
    """Sand with a friction angle of 30 degrees."""
    mu, lam = lame_parameters(1e5, 0.3)
    return DruckerPrager(*(jnp.full(count, value) for value in (mu, lam, np.deg2rad(30.0), 0.0)))


def liquid(count: int) -> Material:
    """Liquid with the bulk modulus 2e5 Pa."""
    return Fluid(jnp.full(count, 2e5))


def soft(count: int) -> Material:
    """Neo-Hookean solid with Young's modulus 2e4 Pa."""
    mu, lam = lame_parameters(2e4, 0.3)
    return NeoHookean(jnp.full(count, mu), jnp.full(count, lam))


def _make_box(bottom: float, top: float) -> Box:
    point, half = [0.5, 0.5, (bottom + top) / 2], [0.6, 0.6, (top - bottom) / 2]
    return Box(jnp.array(point), jnp.array(half), jnp.array(0.3), *EVER)


def _make_mesh(bottom: float, top: float) -> SignedDistance:
    """The same plate from its triangles, as a scene's mesh is sampled."""
    triangles = trimesh.creation.box(bounds=[[-0.1, -0.1, bottom], [1.1, 1.1, top]]).triangles
    values, origin = sample(np.asarray(triangles), 1 / CELLS, 0.0, 1.0, "plate")
    values, origin = (jnp.asarray(value, jnp.float32) for value in (values, origin))
    return SignedDistance(values, origin, jnp.array(0.3), *EVER, spacing=1 / CELLS)


def _simulate(x, v, volume: float, materials, seconds: float, frames: int, *, rho: float = 1000.0, **model):
    """The last frame."""
    made = make_model(len(x), rho * volume, volume, materials, **model)
    x, v = (jnp.asarray(value, jnp.float32) for value in (x, v))
    state = State.at_rest(x, v, materials=made.materials)
    *_, last = simulate(made, state, frame_count=frames + 1, frame_dt=seconds / frames, tell_limits=False)
    return last


def make_model(
    count: int,
    mass: float,
    volume: float,
    materials,
    *,
    cells: int = CELLS,
    gravity=(0, 0, -9.8),
    boundaries=(),
) -> Model:
    """A model in a domain of 1 m."""
    return Model(
        Grid.whole(1.0, cells),
        dt=jnp.array(1e-3),
        gravity=None if gravity is None else jnp.array(gravity),
        mass=jnp.full(count, mass),
        volume=jnp.full(count, volume),
        materials=tuple(materials),
        boundaries=boundaries,
    )


MATTER: dict[str, Callable[[int], Material]] = {"sand": sand, "fluid": liquid, "soft solid": soft}
PLATES: dict[str, Callable] = {"box": _make_box, "mesh": _make_mesh}


if __name__ == "__main__":
    sys.exit(main())
