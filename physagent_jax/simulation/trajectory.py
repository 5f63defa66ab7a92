"""A scene's clip as a differentiable function of its numbers: forces, materials, and how it starts.

`simulate_scene` adapts its step and its grid window to the motion and leaves forces out of frames in which they do not
act; none of that can be traced. With the schedule of a recording it is done again as it was (`mpm.replay`), called from
Python. Without one, all of it is fixed, and the whole is one function for `jax.jit` and `jax.vmap`: the grid is the
whole domain, the step a fraction of the bound at rest, and every force is evaluated in every step. The law of motion is
the same, so these two differ by what their time steps differ. Wheels do not turn here: that is of the pictures
(`rolling`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
from jax.core import Tracer

from physagent_jax.core.arrays import to_device
from physagent_jax.core.errors import UserError
from physagent_jax.core.pytree import register_dataclass
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.mpm import Grid, Schedule, State, replay, rollout, stable_dt
from physagent_jax.mpm.schedule import MEMORY, check_horizon, check_truncation
from physagent_jax.mpm.timestep import divide_frame
from physagent_jax.scene.compile import CompiledScene
from physagent_jax.scene.parameters import SceneParameters

SAFETY = 0.5  # of the bound at rest; a step that never adapts must also bear the squeeze on landing


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Trajectory:
    """The particles at every frame; they are the model's, of which `CompiledScene.back` picks the body's.

    Attributes:
        x: Positions [m], shape (frames, n, 3); the first frame is the rest pose.
        F: Deformation gradients, shape (frames, n, 3, 3).
        time: [s], shape (frames,).
    """

    x: jax.Array
    F: jax.Array
    time: jax.Array

    def centroid(self, mass: jax.Array) -> jax.Array:
        """Mass centre per frame [m], shape (frames, 3); ``mass`` [kg], shape (n,), is `Model.mass`."""
        return (self.x * mass[:, None]).sum(1) / mass.sum()


def trajectory(
    scene: CompiledScene,
    parameters: SceneParameters | ForceFieldParameters | None = None,
    schedule: Schedule | None = None,
    *,
    substeps: int | None = None,
    memory: float = MEMORY,
    horizon: int | None = None,
    truncate: int | None = None,
    edge: float = 0.0,
) -> Trajectory:
    """Simulate all frames of ``scene``; differentiable in reverse with respect to ``parameters``, model and state.

    If a particle leaves the domain, or the window that the schedule has for a frame, all positions from then on are
    NaN: a traced function cannot raise.

    Derivatives by the speed, place or size of a moving obstacle are exact at a point and too small at large, because
    contact takes nodes one after the other (`mpm.boundaries.contact`).

    Args:
        scene: What to simulate; its model and state may be traced.
        parameters: Numbers in place of the scene's own, or of its force field's, traced or not; None = its own.
        schedule: `Recording.schedule` of this scene, or of one with numbers close to these: the same steps and windows
            are taken, and with the same numbers the recording's positions come out. None = everything is fixed.
        substeps: Steps per frame where there is no schedule; None = `find_static_substeps`, which needs a model and
            state that are not traced.
        memory: What a reverse pass along a schedule may keep [bytes].
        horizon: Frames after the first that are simulated; None = all.
        truncate: Frames after which the gradient is cut, as in `mpm.replay`; None = never.
        edge: Width of the smooth edges that windows of forces and constraints are given [s] (`mpm.edges`): with some,
            also those of what is held or blown at have a derivative. It should span several substeps. It may shrink
            from one evaluation to the next; with 0 windows are hard, as they are simulated.

    Raises:
        UserError: ``substeps`` is below 1 or given beside a schedule, the schedule has other frames than the scene,
            ``horizon``, ``truncate`` or ``edge`` is out of range, or the parameters do not fit the scene.
    """
    frames = scene.config.timing.frame_count - 1
    count = check_horizon(horizon, frames)
    check_truncation(truncate)
    if schedule is None:
        scene = with_static_step(scene, substeps)
    elif substeps is not None:
        raise UserError("a schedule says how many substeps there are", do="Leave out `substeps`")
    elif len(schedule.frames) != frames:
        raise UserError(
            f"the schedule must have the scene's frames after the first, {frames}", got=len(schedule.frames)
        )
    soft, width = isinstance(edge, Tracer) or edge != 0, None
    if soft:
        width = _check_edge(edge, schedule, scene.state.x.dtype)
        schedule = schedule and schedule.covering(scene.with_edges(width).model)
    if parameters is not None:
        scene = scene.with_parameters(parameters)
    if soft:
        scene = scene.with_edges(width)
    if schedule is None:
        states = _roll_out(scene, count, truncate)
    else:
        limits = dict(horizon=horizon, truncate=truncate)
        states = _join(replay(scene.model, scene.state, schedule, memory=memory, **limits), jnp.stack)
    return Trajectory(
        *(_prepend_first(getattr(scene.state, name), getattr(states, name)) for name in ("x", "F", "time"))
    )


def _check_edge(edge: Any, schedule: Schedule | None, dtype: Any) -> jax.Array:
    """``edge`` as an array.

    Raises:
        UserError: It is negative, or traced where it must be known.
    """
    if isinstance(edge, Tracer):
        if schedule is not None:
            raise UserError(
                "`edge` must be known along a schedule: it decides what acts in which frame",
                do="Give a number, or leave out the schedule",
            )
        return edge.astype(dtype)
    if not edge >= 0:
        raise UserError("`edge` must not be negative", got=edge)
    return to_device(edge, dtype)


def _roll_out(scene: CompiledScene, frames: int, truncate: int | None) -> State:
    """The states at the ends of ``frames`` frames, by the scene's own step."""
    parts, state = [], scene.state
    for begin in range(0, frames, truncate or frames):
        count = min(truncate or frames, frames - begin)
        if begin:
            state = jax.lax.stop_gradient(state)
        state, states = rollout(scene.model, state, frame_count=count, substeps=scene.substeps)
        parts.append(states)
    return _join(parts, jnp.concatenate)


def _join(states: Sequence[State], function: Callable) -> State:
    return jax.tree.map(lambda *leaves: function(leaves), *states)


def with_static_step(scene: CompiledScene, substeps: int | None = None) -> CompiledScene:
    """The scene with the grid and step that `trajectory` takes, for `mpm.rollout`; arguments and errors as there."""
    substeps = find_static_substeps(scene) if substeps is None else substeps
    if substeps < 1:
        raise UserError("`substeps` must be at least 1", got=substeps)
    timing, domain = scene.config.timing, scene.config.domain
    model = scene.model.replace(
        grid=Grid.whole(domain.size, domain.cells),
        dt=jnp.asarray(timing.frame_dt / substeps, scene.state.x.dtype),
    )
    return dataclasses.replace(scene, model=model, substeps=substeps)


def find_static_substeps(scene: CompiledScene) -> int:
    """Steps per frame that `trajectory` takes: as the scene says, or `SAFETY` times the stable bound at rest.

    It does not depend on the force field's numbers. Where the scene's model or state is traced it cannot be found.
    """
    timing = scene.config.timing
    if timing.substep_dt != "auto":
        return divide_frame(timing.frame_dt, timing.substep_dt)
    with jax.ensure_compile_time_eval():
        bound = float(stable_dt(scene.model, scene.state))
    return divide_frame(timing.frame_dt, SAFETY * bound)


def _prepend_first(first: jax.Array, rest: jax.Array) -> jax.Array:
    return jnp.concatenate([jnp.asarray(first, rest.dtype)[None], rest])
