"""Derivatives that go back only so far, as published methods of score distillation have them.

DreamPhysics and Physics3D differentiate the last substep before a picture, OmniPhysGS the frames of a stage. What was
before is taken as given. The values are those of the whole simulation. (`pa.trajectory` cuts after whole frames only.)
"""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.errors import UserError
from physagent_jax.mpm import Model, Schedule, State, replay


@dataclasses.dataclass(frozen=True)
class Truncation:
    """The reach of a derivative into the past.

    Attributes:
        first: The state of this frame is taken as given, and frames up to it have no derivative.
        substeps: Before each picture, at most; None = all since ``first``.
    """

    first: int = 0
    substeps: int | None = None

    def __post_init__(self):
        if self.first < 0 or (self.substeps is not None and self.substeps < 1):
            raise UserError(
                "a derivative must go back at least one substep, to a frame of the clip", got=self
            )

    def count_cost(self, frame_count: int, whole: float) -> float:
        """Forward-equivalents, where a derivative of the whole clip costs ``whole``.

        Frames without a derivative are simulated once more; a substep per picture costs nothing beside that.
        """
        if self.substeps is not None:
            return 1.0
        before = self.first / (frame_count - 1)
        return before + (1 - before) * whole


WHOLE = Truncation()


def replay_truncated(
    model: Model, state: State, schedule: Schedule, truncation: Truncation
) -> tuple[jax.Array, jax.Array]:
    """Positions [m], shape (T, n, 3), and deformation gradients, shape (T, n, 3, 3), of all frames.

    Args:
        model: What to simulate; its numbers may be traced.
        state: At the start.
        schedule: Schedule of a simulation of it.
        truncation: How far derivatives go back.

    Raises:
        UserError: The clip is not longer than what is taken as given.
    """
    if truncation.first >= len(schedule.frames):
        raise UserError("nothing of the clip has a derivative", got=truncation)
    if truncation.substeps is None:
        states = _replay_from(model, state, schedule, truncation.first)
    else:
        states = _replay_ends(model, state, schedule, truncation)
    states = (jax.lax.stop_gradient(state), *states)
    return jnp.stack([each.x for each in states]), jnp.stack([each.F for each in states])


def _replay_from(model: Model, state: State, schedule: Schedule, first: int) -> tuple[State, ...]:
    given: tuple = ()
    if first:
        given = jax.lax.stop_gradient(
            replay(jax.lax.stop_gradient(model), state, Schedule(schedule.frames[:first]))
        )
        state = given[-1]
    return (*given, *replay(model, state, Schedule(schedule.frames[first:])))


def _replay_ends(model: Model, state: State, schedule: Schedule, truncation: Truncation) -> tuple[State, ...]:
    """Everything as given, then the last substeps of every frame again, each from its own state."""
    parts, ends = [], []
    for frame in schedule.frames:
        last = min(truncation.substeps or frame.substeps, frame.substeps)
        if frame.substeps > last:
            parts.append(dataclasses.replace(frame, substeps=frame.substeps - last))
        ends.append((len(parts), dataclasses.replace(frame, substeps=last)))
        parts.append(ends[-1][1])
    fixed = jax.lax.stop_gradient(model)
    states = (state, *replay(fixed, state, Schedule(tuple(parts))))
    made = []
    for index, (place, frame) in enumerate(ends):
        if index < truncation.first:
            made.append(jax.lax.stop_gradient(states[place + 1]))
        else:
            made += replay(model, jax.lax.stop_gradient(states[place]), Schedule((frame,)))
    return tuple(made)
