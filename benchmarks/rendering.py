"""`python -m benchmarks.rendering [--json OUT] [--markdown OUT] [--quick]`: milliseconds per image and gradient.

A sphere covered with overlapping Gaussians fills most of the picture, as an object does. Medians of warm images with
the range; compilation apart. "gradient" is the forward image and the derivative of a mean squared difference with
respect to centres, covariances, opacities and colours. "together" is the time per image where one thread per core
renders images of its own.
"""

from __future__ import annotations

import dataclasses
import os
import sys
import time
from functools import partial
from pathlib import Path
from typing import Literal

import jax
import jax.numpy as jnp
import numpy as np
import tyro

from benchmarks import harness
from benchmarks.cases.splats import sphere
from benchmarks.harness import RAW, Job, Page, number, provenance, table
from physagent_jax.gaussians.cloud import Splats
from physagent_jax.render import (
    Camera,
    choose_batch_size,
    choose_pair_capacity,
    look_at,
    rasterize,
    render,
    render_all,
)

CASES = ((20_000, 256, 40.0), (100_000, 512, 200.0))  # Gaussians, side of the picture [px], aim [ms]
RATIO = 3.5  # aimed at: time with gradient over time of the image
COLUMNS = {
    "Gaussians": lambda row: f"{row['gaussians']:,}",
    "pixels": lambda row: f"{row['pixels']:,}",
    "image [ms]": lambda row: f"{number(row['forward_ms'])} ({_format_range(row['forward_range_ms'])})",
    "aim [ms]": lambda row: number(row["aims"]["forward_ms"]),
    "gradient [ms]": lambda row: f"{number(row['gradient_ms'])} ({_format_range(row['gradient_range_ms'])})",
    "over image": lambda row: number(row["gradient_over_forward"]),
    "aim": lambda row: number(row["aims"]["gradient_over_forward"]),
    "together [ms]": lambda row: number(row["together_ms"]),
    "first calls [s]": lambda row: ", ".join(map(number, row["first_seconds"])),
}


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Measure what a picture costs."""

    json: Path = RAW / "rendering.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Literal["images"], ...] = ("images",)
    """There is one."""
    repeats: int = 15
    """Timed images; quick: three."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    return harness.main(command, {"images": lambda: _list_jobs(command)}, PAGE)


def write_tables(result: harness.Result) -> harness.Tables:
    """The tables of docs/rendering.md."""
    rows = result["images"]["rows"] if "images" in result else []
    return {
        "images": table(tuple(COLUMNS), [[show(row) for show in COLUMNS.values()] for row in rows]),
        "runs": provenance(result, ("images",)),
    }


PAGE = Page(
    "rendering",
    "python -m benchmarks.rendering",
    write_tables,
    ("physagent_jax/render", "physagent_jax/gaussians", "physagent_jax/kernels"),
)


def _list_jobs(command: Command) -> list[Job]:
    cases = ((2_000, 64, 40.0),) if command.quick else CASES
    repeats = 3 if command.quick else command.repeats
    return [Job(f"{case[0]} Gaussians", partial(_measure_and_tell, *case, repeats)) for case in cases]


def _measure_and_tell(*case) -> list[dict]:
    row = measured(*case)
    harness.say(str(row))
    return [row]


def _format_range(values: list[float]) -> str:
    return " to ".join(map(number, values))


def measured(count: int, side: int, aim: float, repeats: int) -> dict:
    """The row of one case."""
    splats = sphere(count)
    camera = look_at((0, -3.2, 0.4), (0, 0, 0), (0, 0, 1), fov_degrees=40, width=side, height=side)
    white = jnp.ones(3, jnp.float32)
    capacity = choose_pair_capacity(splats, camera)

    def loss(splats):
        image, _ = rasterize(splats, camera, white, capacity=capacity)
        return ((image.rgb - 0.5) ** 2).mean() + (image.depth**2).mean()

    gradient = jax.jit(jax.value_and_grad(loss, allow_int=True))
    forward, first = _time_calls(lambda: render(splats, camera), repeats)
    backward, first_gradient = _time_calls(lambda: gradient(splats), repeats)
    median, both = float(np.median(forward)), float(np.median(backward))
    return {
        "gaussians": count,
        "pixels": side * side,
        "pairs": capacity,
        "forward_ms": round(median, 2),
        "forward_range_ms": [round(min(forward), 2), round(max(forward), 2)],
        "gradient_ms": round(both, 2),
        "gradient_range_ms": [round(min(backward), 2), round(max(backward), 2)],
        "gradient_over_forward": round(both / median, 2),
        "together_ms": round(_time_together(splats, camera, repeats), 2),
        "first_seconds": [round(first, 2), round(first_gradient, 2)],
        "aims": {"forward_ms": aim, "gradient_over_forward": RATIO},
        "load_average": round(os.getloadavg()[0], 2),
    }


def _time_calls(function, repeats: int) -> tuple[list[float], float]:
    """Milliseconds of each warm call, and seconds of the first one."""
    begun = time.perf_counter()
    jax.block_until_ready(function())
    first, samples = time.perf_counter() - begun, []
    for _ in range(repeats):
        begun = time.perf_counter()
        jax.block_until_ready(function())
        samples.append(1e3 * (time.perf_counter() - begun))
    return samples, first


def _time_together(splats: Splats, camera: Camera, repeats: int) -> float:
    """Milliseconds per frame where as many are rendered at the same time as is best."""
    frames = [splats] * (choose_batch_size() * repeats)
    begun = time.perf_counter()
    render_all(frames, camera)
    return 1e3 * (time.perf_counter() - begun) / len(frames)


if __name__ == "__main__":
    sys.exit(main())
