"""Frames as a pure function with static counts, made for `jax.grad` and `jax.vmap`; `mpm.simulate` adapts instead."""

from __future__ import annotations

import dataclasses
import math
from functools import partial

import jax
import jax.numpy as jnp

from physagent_jax.kernels import programs
from physagent_jax.mpm import kernels, reductions
from physagent_jax.mpm.conform import conform
from physagent_jax.mpm.health import count_outside
from physagent_jax.mpm.state import Model, State
from physagent_jax.mpm.step import NODES, kirchhoff_stress, substep
from physagent_jax.mpm.transfer import STOPPED

PARTICLE_NUMBERS = 24  # x, v, C and F


def rollout(model: Model, state: State, *, frame_count: int, substeps: int) -> tuple[State, State]:
    """``frame_count`` frames of ``substeps`` steps of ``model.dt`` each; differentiable in reverse.

    Nothing adapts: ``model.grid`` must cover the whole motion (`Grid.whole` always does) and ``model.dt``
    must be stable throughout. If a particle leaves the window, all positions become NaN: a pure function
    cannot raise, and going on would answer wrongly in silence.

    Each frame is checkpointed, and each step within it: the reverse pass stores one state per frame and,
    for one frame at a time, one per step; the nodes of each step too where they are fewer numbers than the
    particles, else they are computed again. `mpm.replay` goes through what `simulate` has done.

    Returns:
        The final state, and the states at the end of every frame stacked along a new first axis.

    Raises:
        UserError: ``model`` and ``state`` do not fit each other (`conform`).
    """
    programs.release_programs()
    with kernels.use_device_of(state.x):
        return _rollout(*conform(model, state), frame_count, substeps)


@partial(jax.jit, static_argnums=(2, 3))
def _rollout(model: Model, state: State, frame_count: int, substeps: int) -> tuple[State, State]:
    few = model.inertia.node_numbers * math.prod(model.grid.shape) < PARTICLE_NUMBERS * len(state.x)
    kept = jax.checkpoint_policies.save_only_these_names(STOPPED, *([NODES] if few else []))

    @partial(jax.checkpoint, policy=kept)
    def one(carry, _):
        state, tau, _ = substep(model, *carry)
        left = reductions.sum_devices(count_outside(state.x, model.grid), model.axis)
        poison = jnp.where(left > 0, jnp.nan, 0.0).astype(state.x.dtype)
        return (dataclasses.replace(state, x=state.x + poison), tau), None

    @jax.checkpoint
    def frame(carry, _):
        carry, _ = jax.lax.scan(one, carry, None, length=substeps)
        return carry, carry[0]

    (end, _), states = jax.lax.scan(frame, (state, kirchhoff_stress(model, state)), None, length=frame_count)
    return end, states
