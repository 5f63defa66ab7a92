"""Entries that leave an object standing upright: level motions, blows after which it lands, turns that come back."""

from __future__ import annotations

import math
from collections.abc import Sequence

from physagent_jax.forces.schema import Action, VelocityConstraint
from physagent_jax.forces.skills import get_skill

Entry = Action | VelocityConstraint
_LEVEL = 0.5  # vertical component of a way
_ROUNDED = 0.5  # frames, by which an action's end may be rounded
_BACK = 0.02  # of all turns, by which what comes back may miss its place


def begin_of(entry: Entry) -> float:
    """Frame at which an entry begins."""
    return (entry.active_time or (0.0,))[0]


def end_of(entry: Entry) -> float:
    """Frame at which an entry ends."""
    return (entry.active_time or (0.0, math.inf))[1]


def leave_upright(entries: Sequence[Entry], frame: float) -> bool:
    """Return whether the whole of what stood stands upright again at a frame, after all of some entries."""
    if not all(each.region is None and end_of(each) <= frame + _ROUNDED for each in entries):
        return False
    turns = [each for each in entries if get_skill(each).is_axis]
    if not all(get_skill(each).prescribes for each in turns):
        return False
    sizes = [each.magnitude * each.gain * (end_of(each) - begin_of(each)) for each in turns]
    left = [sum(size * each.vector[i] for size, each in zip(sizes, turns)) for i in range(3)]
    back = math.hypot(*left) <= _BACK * sum(map(abs, sizes))
    return back and all(_lands(each) for each in entries if each not in turns)


def _lands(entry: Entry) -> bool:
    """Return whether an entry moves what stands along the ground, or throws it: it comes down again."""
    skill = get_skill(entry)
    return "move" in skill.causes[:1] and (skill.is_sudden or abs(entry.vector[2]) < _LEVEL)
