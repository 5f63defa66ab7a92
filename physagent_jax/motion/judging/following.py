"""The course of a motion: sudden or not, repetitions, duration, return or stay, and order."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

from physagent_jax.core.turning import find_turning_points
from physagent_jax.motion import tolerances
from physagent_jax.motion.judging.asked import Asked
from physagent_jax.motion.judging.changing import measure_strains
from physagent_jax.motion.judging.comparing import (
    check_limit,
    compare_amount,
    compare_range,
    make_unseen_check,
    read_words,
)
from physagent_jax.motion.judging.counting import check_count, estimate_crossing, estimate_jitter
from physagent_jax.motion.judging.moving import follow
from physagent_jax.motion.judging.seen import Course, Signal
from physagent_jax.motion.matching import AXIAL
from physagent_jax.motion.schema import Check, ExpectedMotion, MotionKind
from physagent_jax.motion.vectors import dot, norm, scale
from physagent_jax.perception.schema import PartMotion

_CAME_BACK = 0.5  # of the largest excursion that may be left after letting go
_STAYED = 0.65  # of the largest excursion that has to be left where it should stay
_UNEVEN = 0.2  # of its way that it may be ahead of, or behind, what goes at one speed
_SUDDEN = 0.3  # [s] in which a blow has brought most of the speed that it brings
_PULSE = 0.35  # of the hardest: what counts as another blow
_HOP = 0.18  # of the highest: what counts as another leap
_FULL = 3.5  # times as high: what is a leap, and no rebound
_LEAKS = 0.5  # of a motion that may be seen before its time
_UNSEEN = 0.5  # share of its frames in which a part may be lost from sight
_REST = 0.25  # share of what follows that is looked at for where it comes to rest
_REACHES = 0.4  # of the height of its tip: the middle goes down by half of it as the tip comes to the ground
_REST_SHARE = {False: 0.75, True: 0.4}
"""Share of the moving end's motion that the other may show: a part drags the rest along; an excepted one hardly
moves."""
_PRESSED_REST = 0.15  # the same of an end that is pressed or drawn along itself
_ENOUGH = 0.42  # of such an angle: what rolls over has come to lie on its back, and what opens stands open
_OPENED = 12.0  # [degrees] that what opens or closes is turned by at least
_ASKEW = 15.0  # [degrees] off an angle that is only told from what is foreshortened, and half of a small one
_WORDS = read_words()
_QUANTITY = "is it as much as the sentence says?"
_DURATION = "does it last as long as the sentence says?"
_BLOWS = "how many times is it pushed?"


def measure_signal(asked: Asked, first: int, until: int) -> Signal:
    """A motion as one number per frame, positive the way that was asked for; empty if it cannot be seen."""
    if asked.hidden:
        return []
    direction = asked.direction
    if asked.kind in AXIAL:
        return [(t, asked.sign * v) for t, v in measure_strains(asked, first, until)[0]]
    if asked.kind is MotionKind.ROTATE:
        course = asked.turns(first, until)
    elif first == asked.span[0]:
        course = follow(asked, until)[0]
    else:
        course = asked.course(first, until)
    if asked.kind is MotionKind.FALL:
        direction = asked.view.brief.directions.down
    return [(t, norm(p) if direction is None else dot(p, direction)) for t, p in course]


def check_following(asked: Asked) -> list[Check]:
    """All that is asked beside direction and amount; what cannot be seen of it is a check of its own."""
    checks: list[Check] = []
    for question, find_checks in _CHECKS if asked.kind is not MotionKind.STILL else ():
        try:
            checks += find_checks(asked)
        except _Unseen as unseen:
            checks.append(make_unseen_check(asked, str(unseen), question))
    return checks


class _Unseen(Exception):
    """Something asked for that the pictures do not show, with the reason."""


def _observe(asked: Asked, first: int, until: int, least: int) -> Signal:
    """A motion's signal with ``least`` frames."""
    signal = measure_signal(asked, first, until)
    if len(signal) < least:
        raise _Unseen("its course is not known")
    return signal


def _check_quantity(asked: Asked) -> list[Check]:
    """The named quantity as a target."""
    motion, (first, last) = asked.motion, asked.span
    if motion.amount is None:
        return []
    tolerance = tolerances.expect_quantity(motion.amount, motion.kind, asked.view.brief)
    if tolerance is None or asked.hidden:
        raise _Unseen(asked.hidden or f"{motion.amount.unit} say nothing about such a motion")
    if motion.amount.unit == "seconds":
        return _check_duration(asked, tolerance)
    if tolerance.unit == "degrees" and asked.askew:
        tolerance = tolerance.widened(min(_ASKEW, 0.5 * motion.amount.value))
    if tolerance.unit == "degrees" and motion.may_stop_short:
        tolerance = dataclasses.replace(tolerance, low=min(tolerance.low, _ENOUGH * motion.amount.value))
    until, figure = asked.until if motion.released or motion.sudden else last, asked.figure
    if tolerance.unit == "degrees" and motion.kind is not MotionKind.ROTATE:
        figure = "rotation"
        values = [norm(v) for _, v in asked.view.turns(first, until, asked.end)]
    else:
        values = [v for _, v in measure_signal(asked, first, until)]
    if not values:
        raise _Unseen("its course is not known")
    value = (max(values) - min(values)) / 2.0 if motion.kind is MotionKind.SWAY else max(values)
    seen = f"{value:.3g} {tolerance.unit}"
    return [compare_amount(asked, _QUANTITY, tolerance, value, seen, figure=figure)]


def _check_duration(asked: Asked, tolerance: tolerances.Tolerance) -> list[Check]:
    """Check the cause's duration: a free thing gains speed for so long, a held one is kept away from rest."""
    view, first = asked.view, asked.span[0]
    signal = measure_signal(asked, first, view.last)
    if len(signal) < 5:
        return [make_unseen_check(asked, "its course is not known", _DURATION)]
    jitter = estimate_jitter([v for _, v in signal])
    if view.anchored or asked.kind in (*AXIAL, MotionKind.SWAY):
        series = [(t, abs(v)) for t, v in signal]
        largest = max(v for _, v in series)
        level = (0.2 if asked.kind is MotionKind.SWAY else 0.6) * largest
        begun = next(t for t, v in series if v >= min(0.1 * largest, level))
        ended = [t for t, v in series if v >= level][-1]
    else:
        signal, jitter = _measure_speeds(signal), jitter / math.sqrt(2.0)
        fastest = max(v for _, v in signal)
        begun = next((t for t, v in signal if v >= 0.1 * fastest), first)
        ended = next((t for t, v in signal if v >= 0.95 * fastest), first)
    dt, off = (
        view.report.frame_dt,
        math.hypot(*(estimate_crossing(signal, t, jitter) for t in (begun, ended))),
    )
    value = view.seconds(begun, ended) + dt
    if ended >= view.last - 1 and value < tolerance.high:
        value = max(value, min(tolerance.target, view.seconds(first, view.last) + dt))
    compared = compare_range(tolerance, value, off * dt)
    fix = f"let {asked.causes or 'the cause'} act {tolerance.gain(value):.2g} times as long"
    compared |= {"observed": f"{value:.2g} seconds", "remedy": "" if compared["passed"] else fix}
    return [Check(expectation=asked.index, question=_DURATION, aspect="order", **compared)]


def _measure_speeds(signal: Signal) -> Signal:
    """Rate per frame, as a difference over two frames."""
    return [(a[0], (b[1] - a[1]) / (b[0] - a[0])) for a, b in zip(signal, signal[2:])]


def _check_sudden(asked: Asked) -> list[Check]:
    """After a blow the speed is there at once; what is knocked over gathers it as it falls."""
    if not asked.motion.sudden or asked.kind not in (MotionKind.MOVE, MotionKind.ROTATE):
        return []
    if {MotionKind.ROTATE, MotionKind.FALL} <= {each.kind for each in asked.together}:
        return []
    view, (first, last) = asked.view, asked.span
    reach = first + max(round((last - first) / asked.motion.repeats), 3)
    signal = measure_signal(asked, first, min(reach, last))
    if len(signal) < 4 or max(abs(v) for _, v in signal) < asked.visible:
        return []
    top = max(range(len(signal)), key=lambda i: abs(signal[i][1]))
    speeds = _measure_speeds(signal[: max(top + 1, 4)])  # what comes after it is not the blow's doing
    fastest = max(abs(v) for _, v in speeds)
    level = max(0.25 * asked.visible, 0.15 * abs(signal[top][1]))
    onset = next(t for t, v in signal if abs(v) >= level)
    reached = next(t for t, v in speeds if abs(v) >= 0.7 * fastest)
    seconds = max(view.seconds(onset, reached), 0.0)
    return [check_limit(asked, "sudden", seconds, _SUDDEN, view.report.frame_dt)]


def _check_even(asked: Asked) -> list[Check]:
    """At one speed: the place over time is a straight line. What starts from rest is a quarter of its way behind."""
    if not asked.motion.even:
        return []
    signal = _observe(asked, *asked.span, 4)
    (begin, start), (end, place) = signal[0], max(signal, key=lambda point: abs(point[1]))
    way = place - start
    if abs(way) < asked.visible or end - begin < 3:
        return []
    line = [(v - start) / way - (t - begin) / (end - begin) for t, v in signal if t <= end]
    off = max(line, key=abs)
    sigma, side = math.sqrt(2.0) * asked.sigma / abs(way), "ahead" if off > 0 else "behind"
    return [check_limit(asked, "even", abs(off), _UNEVEN, sigma, side=side)]


def _check_blows(asked: Asked) -> list[Check]:
    """Separate pushes: runs of acceleration of a free thing, excursions of a held one, leaps of what hops."""
    count = asked.motion.repeats
    if asked.kind is not MotionKind.MOVE or count < 2:
        return []
    signal = _observe(asked, asked.span[0], asked.until, 6)
    values = [v for _, v in signal]
    gains = _measure_gains(signal)
    if asked.hops:  # along an aslant way what goes on is not seen to come down
        values = [dot(p, asked.view.brief.directions.up) for _, p in follow(asked, asked.until)[0]]

    def count_excursions(limit: float) -> int:
        return (len(find_turning_points(values, limit)) + 1) // 2

    def count_leaps(limit: float) -> int:
        """Rises, the last one that has begun included; lower ones, as of a rebound, as far as the count needs them."""
        some, high = ((len(find_turning_points(values, each)) + 2) // 2 for each in (limit, _FULL * limit))
        return min(max(count, high), some)

    def count_pulses(limit: float) -> int:
        return _count_pulses(gains, limit)

    if asked.hops:
        counter, most, noise, span = count_leaps, count, math.sqrt(2.0), max(values) - min(values)
        threshold = max(_HOP * span, tolerances.VISIBLE / 2)
    elif asked.view.anchored:
        counter, most, noise, span = count_excursions, 2 * count, math.sqrt(2.0), max(values) - min(values)
        threshold = max(0.4 * span, tolerances.VISIBLE / 2)
    else:  # the noise is that of half the differences of differences
        counter, most, noise, span = count_pulses, count, math.sqrt(1.5), max(v for _, v in gains)
        threshold = _PULSE * span
    return [
        check_count(
            asked,
            _BLOWS,
            counter,
            least=count,
            most=most,
            aim=count,
            threshold=threshold,
            span=span,
            noise=noise * estimate_jitter(values),
            noun="times",
            fix=f"let it be pushed {count} separate times",
        )
    ]


def _measure_gains(signal: Signal) -> Signal:
    """By how much the speed grows over two frames."""
    speeds = [(signal[0][0] - 2, 0.0), (signal[0][0] - 1, 0.0), *_measure_speeds(signal)]
    return [(a[0], b[1] - a[1]) for a, b in zip(speeds, speeds[2:])]


def _count_pulses(gains: Signal, limit: float) -> int:
    """Runs of frames in which the speed grows by ``limit`` or more; short pauses do not part them."""
    frames = [t for t, v in gains if v >= limit]
    return len(frames[:1]) + sum(later - before > 3 for before, later in zip(frames, frames[1:]))


def _check_return(asked: Asked) -> list[Check]:
    """After letting go, held objects and deformations come back towards rest; a free object may drift on."""
    motion, view, (first, last), until = asked.motion, asked.view, asked.span, asked.until
    if not motion.released or motion.kind in (MotionKind.SWAY, MotionKind.FALL):
        return []
    if motion.kind not in AXIAL and not view.anchored:
        return []
    if until - last < 3:
        if motion.sudden or motion.repeats > 1:
            return []
        if not motion.springs:
            raise _Unseen("the clip ends before it can come back")
        last = until - 3  # it has come back before what it does next
    signal = _observe(asked, first, until, 4)
    if (
        motion.kind in AXIAL and asked.end is None and motion.direction is not None
    ):  # its outline is seen for longer
        lengths, known = view.lengths(motion.direction, first, until), signal[-1][0]
        signal = [*signal, *((t, asked.sign * v) for t, v in lengths if t > known)]
    if not (view.report.stretch if motion.kind in AXIAL else view.get_places(asked.end)):
        raise _Unseen("its course is not known")
    largest = max(abs(v) for _, v in signal)
    if largest < asked.visible:
        return []
    rest = _take_rest(signal, last, until)
    left = abs(sum(rest) / len(rest)) / largest
    return [check_limit(asked, "returns", left, _CAME_BACK, asked.sigma / largest)]


def _check_reach(asked: Asked) -> list[Check]:
    """A part that is to come to the ground goes most of the way there, from as high as its tip is."""
    motion, view = asked.motion, asked.view
    if not motion.to_ground or asked.end is None or motion.kind is not MotionKind.MOVE:
        return []
    table, height = view.brief.directions, view.brief.extents[1]
    if motion.limb is None:
        above = (0.5 + dot(asked.end.direction, table.up) / 3) * height
    else:
        limb = view.brief.parts[motion.limb]
        share = dot(limb.joint, table.up)
        above = (share if share >= 0 else 1 + share) * height + dot(limb.arm, table.up)
    way = max(dot(p, table.down) for _, p in _observe_course(asked))
    least = _REACHES * max(above, tolerances.LEAST)
    return [check_limit(asked, "reaches", way, least, asked.sigma, gain=least / max(way, 0.1 * least))]


def _check_opening(asked: Asked) -> list[Check]:
    """A lid, a door or a jaw that opens or closes turns about its hinge; lifted off level, it does not open."""
    if not asked.opens or asked.end is None or asked.kind is not MotionKind.MOVE:
        return []
    turned = max((norm(v) for _, v in asked.view.turns(*asked.span, asked.end)), default=None)
    return (
        [] if turned is None else [check_limit(asked, "opens", turned, _OPENED, asked.view.sigma("rotation"))]
    )


def _observe_course(asked: Asked) -> Course:
    course = asked.course(asked.span[0], asked.until)
    if not course:
        raise _Unseen("its course is not known")
    return course


def _take_rest(signal: Signal, since: int, until: int) -> list[float]:
    """The last part of what follows a frame, in which a motion comes to rest."""
    rest = [v for t, v in signal if t >= until - _REST * (until - since)]
    if not rest:
        raise _Unseen("its end is not seen")
    return rest


def _check_stay(asked: Asked) -> list[Check]:
    """Check that the object stays where it was brought."""
    first, until = asked.span[0], asked.until
    if not asked.motion.stays:
        return []
    signal = _observe(asked, first, until, 4)
    largest = max(v for _, v in signal)
    if largest < asked.visible:
        return []
    rest, sigma = _take_rest(signal, first, until), asked.sigma / largest
    left, wanders = min(rest) / largest, (max(rest) - min(rest)) / largest
    stays = check_limit(asked, "stays", left, _STAYED, sigma)
    return [stays, check_limit(asked, "rests", wanders, 1 - _STAYED, sigma)]


def _check_order(asked: Asked) -> list[Check]:
    """Check that what comes later is not seen before its time."""
    view, first = asked.view, asked.span[0]
    earlier = [e for e in view.expectations if view.span(e)[0] < first - 1]
    if first < 3 or asked.kind in (MotionKind.FALL, MotionKind.SWAY) or asked.motion.repeats > 1:
        return []
    if not earlier or any(_is_alike(e, asked.motion) for e in earlier):
        return []
    before = measure_signal(asked, min(view.span(e)[0] for e in earlier), first)
    during = measure_signal(asked, first, asked.until)
    if len(before) < 2 or not during:
        return []
    most, leaked = max(v for _, v in during), max(v for _, v in before)
    if most < asked.visible:
        return []
    share, limit = max(leaked, 0.0) / most, _LEAKS + asked.visible / most
    return [check_limit(asked, "in_turn", share, limit, asked.sigma / most, share=_LEAKS, frame=first)]


def _is_alike(one: ExpectedMotion, other: ExpectedMotion) -> bool:
    """Return whether one motion also shows as the other."""
    if one.kind is not other.kind:
        return one.kind in (MotionKind.SWAY, MotionKind.FALL) and other.kind is MotionKind.MOVE
    return one.direction is None or other.direction is None or dot(one.direction, other.direction) > 0.3


def _check_part(asked: Asked) -> list[Check]:
    """The named end moves more than the opposite one, a part also more than the whole; one that is excepted less.

    What is pressed evenly moves at its other end by a fifth of the way of the named one.
    """
    motion, moving, view = asked.motion, asked.end, asked.view
    if moving is None or motion.kind in (MotionKind.FALL, MotionKind.STILL) or asked.carried:
        return []
    resting = view.find_end(scale(moving.direction, -1.0))
    own = _measure_extent(asked, moving)
    other = None if resting is None else _measure_extent(asked, resting)
    if own is None or other is None:
        raise _Unseen("the ends are not followed")
    places = moving.centroid[asked.span[0] : asked.span[1] + 1]
    if motion.limb is not None and sum(each is None for each in places) > _UNSEEN * len(places):
        raise _Unseen("the part is lost on the way")
    if any(e.part and e.part != motion.part for e in asked.together):
        if motion.limb is None:
            return []
        other = 0.0
    if motion.limb is not None and asked.kind is not MotionKind.ROTATE:
        whole = max((norm(p) for _, p in view.course(*asked.span)), default=0.0)
        other = max(other, whole - view.brief.parts[motion.limb].share * own)  # the part is of the whole
    if own < asked.visible:
        return []  # that nothing moves is told by the amount
    limit = _PRESSED_REST if motion.kind in AXIAL else _REST_SHARE[motion.excludes_part]
    return [check_limit(asked, "part", other / own, limit, asked.sigma / own)]


def _measure_extent(asked: Asked, end: PartMotion) -> float | None:
    """The largest motion or turn of an end along the asked direction."""
    measure = asked.view.turns if asked.kind is MotionKind.ROTATE else asked.view.course
    direction, course = asked.direction, measure(*asked.span, end)
    extents = (norm(p) if direction is None else abs(dot(p, direction)) for _, p in course)
    return max(extents, default=None)


_CHECKS: tuple[tuple[str, Callable[[Asked], list[Check]]], ...] = (
    (_QUANTITY, _check_quantity),
    (_WORDS["sudden"]["question"], _check_sudden),
    (_WORDS["even"]["question"], _check_even),
    (_BLOWS, _check_blows),
    (_WORDS["returns"]["question"], _check_return),
    (_WORDS["stays"]["question"], _check_stay),
    (_WORDS["in_turn"]["question"], _check_order),
    (_WORDS["reaches"]["question"], _check_reach),
    (_WORDS["opens"]["question"], _check_opening),
    (_WORDS["part"]["question"], _check_part),
)
