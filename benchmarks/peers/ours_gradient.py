"""Our own gradient of a scene: `jax.value_and_grad` through `replay` of what `simulate` did."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.peers.ours import build
from benchmarks.peers.scene import PeerScene
from physagent_jax.mpm import Model, Schedule, State, cell_order, replay, simulate


class Ours:
    """The product's simulation, with its window and kernels, differentiated."""

    name = "ours"

    def version(self) -> str:
        """JAX's version and device."""
        return f"jax {jax.__version__} on {jax.default_backend()}"

    def load(self, scene: PeerScene, dt: float, steps: int, weight: np.ndarray) -> None:
        """Simulate once, for the schedule."""
        order = cell_order(scene.x, scene.dx)
        model, state = build(scene.take(order))
        schedule = make_schedule(model, state, 1, steps, dt)
        loss = find_loss(model, state, schedule, weight[order], 2e9)
        self._gradient, self._at = jax.value_and_grad(loss), jnp.ones(3, state.x.dtype)

    def compute_gradient(self) -> tuple[float, np.ndarray]:
        """The loss, and its derivatives by gravity, initial velocity and stiffness, shape (3,)."""
        value, gradient = jax.block_until_ready(self._gradient(self._at))
        return float(value), np.asarray(gradient, float)


def make_schedule(model: Model, state: State, frames: int, steps: int, dt: float) -> Schedule:
    """Schedule of ``frames`` frames of ``steps`` substeps of ``dt`` [s]."""
    made = simulate(model, state, frame_count=frames + 1, frame_dt=steps * dt, substep_dt=dt)
    return Schedule.of(model, made)


def find_loss(model: Model, state: State, schedule: Schedule, weight: np.ndarray, memory: float):
    """The loss of `benchmarks.peers.gradient` as a function of three factors: of gravity, velocity and stiffness."""
    direction = jnp.asarray(weight, state.x.dtype)
    law: Any = model.materials[0]
    moduli = [name for name in ("mu", "lam", "bulk_modulus") if hasattr(law, name)]

    def loss(scales):
        stiff = dataclasses.replace(law, **{name: scales[2] * getattr(law, name) for name in moduli})
        changed = model.replace(gravity=scales[0] * model.gravity, materials=(stiff,))
        begun = dataclasses.replace(state, v=scales[1] * state.v)
        end = replay(changed, begun, schedule, memory=memory)[-1]
        return (end.x[:, 2] ** 2).mean() + 0.1 * (direction * end.x).mean()

    return loss
