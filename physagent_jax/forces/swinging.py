"""Pushes to and fro: how far each goes is what M says, however short they are, of a free object and of a held one.

How far a push goes grows with the square of its time: one that carries the object visibly in two seconds shows nothing
in a tenth of one. A train of pushes that follow each other, each against the one before, and that in all give back what
they took, swings the object about one place. With half a period h, M = 1 is to swing it by s to either side,

    k = 8 s / h^2,   against drag d   k = 2 s d / (h - 2 t),   t = ln(1 + tanh(d h / 2)) / d,

t the time in which a push stops what the one before has set going: the steady state of a square wave. Each push also
knows the speed that it begins with, which a brake has too: friction is made up for on the way from there.

What is held, and a part of it, is an oscillator with a way of u per steady acceleration: pushes in time with it would
swing it farther each time, quick ones hardly. Where it turns back during a push, each gets the k that brings it to s
on its side, or none if it swings that far by itself. Quicker ones get the same k = s / (p u), with p u how far to
either side the pushes of a train with k = 1 swing it; the first and the last of them get half of it, unless they are
half as long: a mass that is pushed as long to either side only comes to rest by the second push, and drifts.
"""

from __future__ import annotations

from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np
from jax.core import Tracer

from physagent_jax.forces.binding import Stroke
from physagent_jax.forces.holding import OVERSHOOT, find_frequency, find_way
from physagent_jax.forces.parameters import ActionParameters
from physagent_jax.forces.responses import find_response
from physagent_jax.forces.schema import Action, ForceField, SkillScaling
from physagent_jax.forces.skills import get_skill

LEAST_PUSHES = 3  # out, back and to rest; two are a push and its brake
_PARALLEL = 0.99  # cosine
_GAP = 1.0  # [frames] between pushes that follow each other
_BALANCE = 0.25  # of the strongest push: what the others may leave of its velocity
_LOST = -np.log(OVERSHOOT - 1)  # logarithmic decrement of half a swing with that overshoot
_DAMPING = _LOST / np.hypot(np.pi, _LOST)  # ratio where nobody chose one
_SAMPLES = 16  # of a push, at which the way is looked at
_AS_LONG = 0.75  # of the next push, from which on the first is no half one
_TURNS = 0.8 * np.pi  # phase of its own swing that a push must last for it to turn back


def find_strokes(
    field: ForceField, values: Sequence[ActionParameters], scaling: SkillScaling, frame_dt: float
) -> dict[int, Stroke]:
    """Velocity changes of successive pushes, by their place in ``field.actions``.

    Args:
        field: The force field.
        values: Its numbers, traced or not.
        scaling: What M = 1 means; of what is held or bends, only trains to and fro are found, and no speeds.
        frame_dt: Seconds per frame [s].
    """
    strokes: dict[int, Stroke] = {}
    for run in find_runs(field):
        actions, numbers = [field.actions[i] for i in run], [values[i] for i in run]
        spans = [(each.window[1] - each.window[0]) * frame_dt for each in numbers]
        xp = jnp if any(isinstance(span, Tracer) for span in spans) else np
        k, swings = scaling.translation, is_swing(actions)
        response = find_response(scaling, actions[0])
        if response is not None or scaling.holding is not None:
            if not _alternate(actions):  # what is held goes back by itself: they need not balance
                continue
            held, way = scaling.holding, numbers[0].vector
            if response is not None and response.answer is not None:
                shares = _find_shares(response.frequency, _DAMPING, actions, spans)
                pushes = [response.swing / response.answer * each for each in shares]
            elif response is None and held is not None and held.square is not None and scaling.swing:
                ratio = _DAMPING if held.damping_ratio is None else held.damping_ratio
                shares = _find_shares(find_frequency(held, way), ratio, actions, spans)
                pushes = [
                    xp.minimum(scaling.swing / find_way(held, way) * each, held.most) for each in shares
                ]
            else:
                continue
            strokes |= {index: Stroke(each, 0.0, True) for index, each in zip(run, pushes)}
            continue
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


def _alternate(actions: Sequence[Action]) -> bool:
    """Return whether each goes against the one before."""
    ways = [_find_way(action) for action in actions]
    return len(actions) >= LEAST_PUSHES and all(a @ b < 0 for a, b in zip(ways, ways[1:]))


def is_swing(actions: Sequence[Action]) -> bool:
    """Return whether each of successive pushes goes against the one before, and they give back what they took."""
    if not _alternate(actions):
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


def _find_shares(frequency, ratio: float, actions: Sequence[Action], spans: Sequence) -> list:
    """The pushes that swing an oscillator by 1 to either side, over the steady one that would bend it by 1."""
    xp = jnp if any(isinstance(each, Tracer) for each in (frequency, *spans)) else np
    slow = frequency * xp.min(xp.stack([xp.asarray(each) for each in spans])) >= _TURNS
    place, speed, most, least = 0.0, 0.0, 0.0, 0.0  # of a train with pushes of 1
    near, rate, shares = 0.0, 0.0, []  # of one with the shares
    first = xp.where(spans[0] > _AS_LONG * spans[1], 0.5, 1.0)
    last = xp.where(spans[-1] > _AS_LONG * spans[-2], 0.5, 1.0)
    weights = [first, *[1.0] * (len(actions) - 2), last]
    for action, span, weight in zip(actions, spans, weights):
        side = np.sign(_find_way(action) @ _find_way(actions[0]))
        places, speeds = _answer(frequency, ratio, span, place, speed, weight * side)
        place, speed = places[-1], speeds[-1]
        most, least = xp.maximum(most, places.max()), xp.minimum(least, places.min())
        pushed, rising = _answer(frequency, ratio, span, 0.0, 0.0, 1.0)
        left, going = _answer(frequency, ratio, span, near, rate, 0.0)
        shares.append(xp.maximum(((1 - side * left) / pushed).min(), 0.0))
        near, rate = (
            each[-1] for each in (left + side * shares[-1] * pushed, going + side * shares[-1] * rising)
        )
    return [xp.where(slow, each, weight * 2 / (most - least)) for each, weight in zip(shares, weights)]


def _answer(frequency, ratio: float, span, place, speed, rest) -> tuple:
    """Places and speeds of an oscillator during a push that would hold it at ``rest``, shape (samples,)."""
    xp = jnp if any(isinstance(each, Tracer) for each in (frequency, span)) else np
    decay, turned = ratio * frequency, np.sqrt(1 - ratio**2) * frequency
    time = span * np.linspace(0, 1, _SAMPLES + 1)[1:]
    fades, cos, sin = xp.exp(-decay * time), xp.cos(turned * time), xp.sin(turned * time) / turned
    off = place - rest
    places = rest + fades * (off * cos + (speed + decay * off) * sin)
    return places, fades * (speed * cos - (off * frequency**2 + decay * speed) * sin)


def _go_on(speed, acceleration, drag: float, time, xp):
    """The speed after a steady push for ``time``."""
    if not drag:
        return speed + acceleration * time
    return speed * xp.exp(-drag * time) - acceleration * xp.expm1(-drag * time) / drag


def describe_swing(amplitude: float) -> str:
    """Describe the effect of M = 1 on a to-and-fro motion."""
    return f"to and fro, a push of 1 swings it by {amplitude:.3g} m to either side"
