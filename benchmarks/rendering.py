"""`python -m benchmarks.rendering --json OUT [--quick]`: milliseconds per image, forward and with the gradient.

A sphere covered with overlapping Gaussians fills most of the picture, as an object does. Medians of warm images with
the range; compilation apart. "gradient" is the forward image and the derivative of a mean squared difference with
respect to centres, covariances, opacities and colours. "together" is the time per image where one thread per core
renders images of its own.
"""

from __future__ import annotations

import dataclasses
import json
import os
import sys
import time
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import tyro
from rich.console import Console

from benchmarks.cases.splats import sphere
from benchmarks.machine import circumstances
from physagent_jax.core.files import write_text
from physagent_jax.gaussians.cloud import Splats
from physagent_jax.render import Camera, frames_at_once, look_at, pair_capacity, rasterize, render, render_all

CASES = ((20_000, 256, 40.0), (100_000, 512, 200.0))  # Gaussians, side of the picture [px], aim [ms]
RATIO = 3.5  # aimed at: time with gradient over time of the image
console = Console(stderr=True)


@dataclasses.dataclass(frozen=True)
class Command:
    """Measure what a picture costs."""

    json: Path
    """File to write."""
    repeats: int = 15
    """Timed images."""
    quick: bool = False
    """One small case, few repeats."""


def main() -> int:
    """Runs the command line."""
    command = tyro.cli(Command)
    cases = ((2_000, 64, 40.0),) if command.quick else CASES
    rows = [measured(*case, 3 if command.quick else command.repeats) for case in cases]
    for row in rows:
        console.print(row, highlight=False)
    write_text(
        command.json, json.dumps({**circumstances(), "quick": command.quick, "rows": rows}, indent=1) + "\n"
    )
    print(command.json)
    return 0


def measured(count: int, side: int, aim: float, repeats: int) -> dict:
    """The row of one case."""
    splats = sphere(count)
    camera = look_at((0, -3.2, 0.4), (0, 0, 0), (0, 0, 1), fov_degrees=40, width=side, height=side)
    white = jnp.ones(3, jnp.float32)
    capacity = pair_capacity(splats, camera)

    def loss(splats):
        image, _ = rasterize(splats, camera, white, capacity=capacity)
        return ((image.rgb - 0.5) ** 2).mean() + (image.depth**2).mean()

    gradient = jax.jit(jax.value_and_grad(loss, allow_int=True))
    forward, first = _timed(lambda: render(splats, camera), repeats)
    backward, first_gradient = _timed(lambda: gradient(splats), repeats)
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
        "together_ms": round(_together(splats, camera, repeats), 2),
        "first_seconds": [round(first, 2), round(first_gradient, 2)],
        "aims": {"forward_ms": aim, "gradient_over_forward": RATIO},
        "load_average": round(os.getloadavg()[0], 2),
    }


def _timed(function, repeats: int) -> tuple[list[float], float]:
    """Milliseconds of each warm call, and seconds of the first one."""
    begun = time.perf_counter()
    jax.block_until_ready(function())
    first, samples = time.perf_counter() - begun, []
    for _ in range(repeats):
        begun = time.perf_counter()
        jax.block_until_ready(function())
        samples.append(1e3 * (time.perf_counter() - begun))
    return samples, first


def _together(splats: Splats, camera: Camera, repeats: int) -> float:
    """Milliseconds per frame where as many are rendered at the same time as is best."""
    frames = [splats] * (frames_at_once() * repeats)
    begun = time.perf_counter()
    render_all(frames, camera)
    return 1e3 * (time.perf_counter() - begun) / len(frames)


if __name__ == "__main__":
    sys.exit(main())
