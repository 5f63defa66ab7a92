"""Gradients by the kernels in single precision beside the reference path's in double, and that beside differences."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks import harness
from benchmarks.gradients.cube import NEO_HOOKEAN, make_cube
from benchmarks.harness import Row
from benchmarks.peers.gradient import draw_weight
from benchmarks.peers.ours_gradient import find_loss
from physagent_jax.mpm import Schedule, simulate

HORIZONS = (10, 100, 1000)  # substeps


def measure_precision(count: int, material: str = NEO_HOOKEAN) -> list[Row]:
    """The row of ``count`` substeps."""
    particles = 1000
    with jax.enable_x64(True):
        model, state = make_cube(particles, np.float64, "reference", material)
        run = dict(frame_count=2, frame_dt=count * 2e-4, substep_dt=2e-4)
        schedule = Schedule.of(model, simulate(model, state, **run))
        loss = find_loss(model, state, schedule, draw_weight(particles), 2e9)
        at, h = jnp.ones(3), 1e-5
        exact = np.asarray(jax.grad(loss)(at))
        step = h * np.eye(3)
        differences = np.array([(loss(at + e) - loss(at - e)) / (2 * h) for e in step])
    single, begun = make_cube(particles, np.float32, material=material)
    got = np.asarray(
        jax.grad(find_loss(single, begun, schedule, draw_weight(particles), 2e9))(jnp.ones(3, jnp.float32)),
        np.float64,
    )
    norm = float(np.linalg.norm(exact))
    row = {
        "material": material,
        "particles": particles,
        "substeps": schedule.substeps,
        "cosine": float(got @ exact / (np.linalg.norm(got) * norm)),
        "error": float(np.linalg.norm(got - exact) / norm),
        "norm": norm,
        "difference_error": float(np.linalg.norm(differences - exact) / norm),
    }
    harness.say(str(row))
    return [row]
