"""Pushes to and fro of a free object: how far each goes is what M says, however short they are.

How far a push goes grows with the square of its time: one that carries the object visibly in two seconds shows nothing
in a tenth of one. A train of pushes that follow each other, each against the one before, and that in all give back what
they took, swings the object about one place. With half a period h, M = 1 is to swing it by s to either side,

    k = 8 s / h^2,   against drag d   k = 2 s d / (h - 2 t),   t = ln(1 + tanh(d h / 2)) / d,

t the time in which a push stops what the one before has set going: the steady state of a square wave. Each push also
knows the speed that it begins with, which a brake has too: friction is made up for on the way from there.
"""

from __future__ import annotations

from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np
from jax.core import Tracer

from physagent_jax.forces.binding import Stroke
from physagent_jax.forces.parameters import ActionParameters
from physagent_jax.forces.schema import Action, ForceField, SkillScaling
from physagent_jax.forces.skills import get_skill

LEAST_PUSHES = 3  # out, back and to rest; two are a push and its brake
_PARALLEL = 0.99  # cosine
_GAP = 1.0  # [frames] between pushes that follow each other
_BALANCE = 0.25  # of the strongest push: what the others may leave of its velocity


def find_strokes(
    field: ForceField, values: Sequence[ActionParameters], scaling: SkillScaling, frame_dt: float
) -> dict[int, Stroke]:
    """Velocity changes of successive pushes, by their place in ``field.actions``.

    Args:
        field: The force field.
        values: Its numbers, traced or not.
        scaling: What M = 1 means; what is held has no such pushes.
        frame_dt: Seconds per frame [s].
    """
    strokes: dict[int, Stroke] = {}
    for run in [] if scaling.holding is not None else find_runs(field):
        actions, numbers = [field.actions[i] for i in run], [values[i] for i in run]
        spans = [(each.window[1] - each.window[0]) * frame_dt for each in numbers]
        xp = jnp if any(isinstance(span, Tracer) for span in spans) else np
        k, swings = scaling.translation, is_swing(actions)
        if swings and scaling.swing is not None:
            half_period = xp.max(xp.stack([xp.asarray(span) for span in spans]))
            k = _find_scale(scaling.swing, scaling.damping_rate, half_period, xp)
        velocity, first = xp.zeros(()), _find_way(actions[0])
        for index, action, each, span in zip(run, actions, numbers, spans):
            side = np.sign(_find_way(action) @ first)
            strokes[index] = Stroke(k, side * velocity, swings)
            velocity = _go_on(velocity, side * k * xp.abs(each.magnitude), scaling.damping_rate, span, xp)
    return strokes


def find_runs(field: ForceField) -> list[list[int]]:
    """Places of pushes of the same particles along one line that follow each other, two at least."""
    pushes = [
        index
        for index, action in enumerate(field.actions)
        if get_skill(action).swings and action.active_time is not None
    ]
    runs: list[list[int]] = []
    for index in sorted(pushes, key=lambda i: field.actions[i].active_time or ()):
        before = next((r for r in runs if _follows(field.actions[r[-1]], field.actions[index])), None)
        if before is None:
            runs.append([index])
        else:
            before.append(index)
    return [run for run in runs if len(run) > 1]


def _find_way(action: Action) -> np.ndarray:
    return np.sign(action.magnitude) * np.asarray(action.vector)


def _follows(before: Action, action: Action) -> bool:
    """Return whether a push begins where another ends, along the same line."""
    assert before.active_time is not None and action.active_time is not None
    late = action.active_time[0] - before.active_time[1]
    same = before.region == action.region
    alike = float(_find_way(before) @ _find_way(action))
    return same and abs(late) <= _GAP and abs(alike) > _PARALLEL


def is_swing(actions: Sequence[Action]) -> bool:
    """Return whether each of successive pushes goes against the one before, and they give back what they took."""
    ways = [_find_way(action) for action in actions]
    if len(actions) < LEAST_PUSHES or any(a @ b > 0 for a, b in zip(ways, ways[1:])):
        return False
    given = [abs(a.magnitude) * (a.active_time[1] - a.active_time[0]) for a in actions if a.active_time]
    left = abs(sum(size if index % 2 else -size for index, size in enumerate(given)))
    return left <= _BALANCE * max(given)


def _find_scale(amplitude: float, drag: float, half_period, xp):
    """The k of the formulas above [m/s^2]."""
    if not drag:
        return 8 * amplitude / half_period**2
    turned = xp.log1p(xp.tanh(0.5 * drag * half_period)) / drag
    return 2 * amplitude * drag / (half_period - 2 * turned)


def _go_on(speed, acceleration, drag: float, time, xp):
    """The speed after a steady push for ``time``."""
    if not drag:
        return speed + acceleration * time
    return speed * xp.exp(-drag * time) - acceleration * xp.expm1(-drag * time) / drag


def describe_swing(amplitude: float) -> str:
    """Describe the effect of M = 1 on a to-and-fro motion."""
    return f"to and fro, a push of 1 swings it by {amplitude:.3g} m to either side"
