"""The manner that is told beside the kind of motion: what bends keeps its foot, what is thrown flies."""

from __future__ import annotations

import math

from physagent_jax.core.strict import Vector
from physagent_jax.motion.judging.asked import Asked
from physagent_jax.motion.judging.comparing import check_limit, make_unseen_check
from physagent_jax.motion.schema import Check, MotionKind
from physagent_jax.motion.swaying import bends, leads_aside
from physagent_jax.motion.vectors import norm, reject, scale, subtract
from physagent_jax.perception.schema import Box

_FOOT = 0.6  # of the top's way that the foot may go: of what tips about its middle it goes as far
_FLIGHT = 0.04  # [body lengths] between what flies and the ground
_LESS = 0.75  # of its outline at first that what was folded or crumpled may have
_APART = 0.15  # [body lengths] by which the ends of what is split come apart at least
_LASTING = 3  # frames that a flight takes


def check_manner(asked: Asked) -> list[Check]:
    """Check that what stands and is to bend or sway does not slide instead, and that what is thrown flies."""
    view, motion, up = asked.view, asked.motion, asked.view.brief.directions.up
    whole = motion.part is None and motion.limb is None
    if not view.grounded or view.anchored or not whole or not leads_aside(asked.direction, view.brief):
        return []
    if bends(motion):
        return _check_foot(asked, up)
    thrown = motion.kind is MotionKind.MOVE and motion.manner == "fly"
    return _check_flight(asked, up) if thrown else []


def check_outline(asked: Asked) -> list[Check]:
    """The outline of what is folded or crumpled over that at first: of what is turned over no track tells the place.

    What is folded gets shorter along its line; what is crumpled takes less room in the picture.
    """
    boxes = [box for box in asked.view.report.box[asked.span[0] : asked.until + 1] if box is not None]
    table, name = asked.view.brief.directions, f"{asked.motion.manner}s"
    lines = (table.right, table.up) if asked.motion.part is None else (asked.motion.part,)
    if len(boxes) <= _LASTING:
        return [make_unseen_check(asked, "its outline is not known throughout")]
    sizes = [[_find_length(box, line) for line in lines] for box in (boxes[0], boxes[-1])]
    before, after = map(math.prod, sizes)
    return [check_limit(asked, name, after / before, _LESS, asked.sigma / min(sizes[0]))]


def check_split(asked: Asked) -> list[Check]:
    """The room between two opposite ends of what is split, in the end: what is only stretched comes back."""
    view, table, apart = asked.view, asked.view.brief.directions, []
    for way in (table.right, table.up, table.toward):
        ends = [view.find_end(each) for each in (way, scale(way, -1.0))]
        one, other = (dict(view.course(asked.span[0], view.last, each)) if each else {} for each in ends)
        apart += [norm(subtract(place, other[t])) for t, place in one.items() if t in other][-1:]
    if not apart:
        return [make_unseen_check(asked, "the ends of the object are not told apart")]
    return [check_limit(asked, "splits", max(apart), _APART, asked.sigma)]


def _check_foot(asked: Asked, up: Vector) -> list[Check]:
    """The level way of the foot over that of the top."""
    view, first = asked.view, asked.span[0]
    low, high = (view.find_end(each) for each in (scale(up, -1.0), up))
    if low is None or high is None:
        return []  # a report of windows alone tells no ends
    foot = dict(view.course(first, asked.until, low))
    top = [(t, p) for t, p in view.course(first, asked.until, high) if t in foot]
    slid = max((norm(reject(p, up)) for p in foot.values()), default=0.0)
    bent = max((norm(reject(subtract(p, foot[t]), up)) for t, p in top), default=0.0)
    if slid + bent < view.visible:
        return []  # that nothing moves is told by the amount
    return [check_limit(asked, "slides", slid / (slid + bent), _FOOT, asked.sigma / (slid + bent))]


def _check_flight(asked: Asked, up: Vector) -> list[Check]:
    """The room between its lowest point and where that was at first."""
    boxes = asked.view.report.box[asked.span[0] : asked.until + 1]
    lowest = [_find_lowest(box, up) for box in boxes if box is not None]
    if len(lowest) <= _LASTING:
        return []
    rise = sorted((each - lowest[0] for each in lowest), reverse=True)[_LASTING - 1]
    return [check_limit(asked, "flies", rise, _FLIGHT, asked.sigma)]


def _find_length(box: Box, line: Vector) -> float:
    return sum(abs(u) * (high - low) for u, low, high in zip(line, box.low, box.high))


def _find_lowest(box: Box, up: Vector) -> float:
    return sum(min(u * low, u * high) for u, low, high in zip(up, box.low, box.high))
