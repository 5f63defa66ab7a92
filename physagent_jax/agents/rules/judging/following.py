"""The course of a motion: sudden or not, repetitions, duration, return or stay, and order."""

from __future__ import annotations

import math

from physagent_jax.agents.rules import tolerances
from physagent_jax.agents.rules.judging.changing import measure_strains
from physagent_jax.agents.rules.judging.comparing import (
    compare_amount,
    find_confidence,
    make_limit_check,
    make_unseen_check,
)
from physagent_jax.agents.rules.judging.counting import (
    estimate_crossing,
    estimate_jitter,
    find_count_confidence,
)
from physagent_jax.agents.rules.judging.moving import find_track, follow
from physagent_jax.agents.rules.judging.seen import View
from physagent_jax.agents.schema import Check, ExpectedMotion, MotionKind
from physagent_jax.agents.vectors import clamp, dot, norm
from physagent_jax.core.turning import find_turning_points
from physagent_jax.perception.schema import PartMotion

Signal = list[tuple[int, float]]

AXIAL = (MotionKind.STRETCH, MotionKind.SQUEEZE)
_CAME_BACK = 0.5  # of the largest excursion that may be left after letting go
_STAYED = 0.65  # of the largest excursion that has to be left where it should stay
_UNEVEN = 0.2  # of its way that it may be ahead of, or behind, what goes at one speed
_SUDDEN = 0.3  # [s] in which a blow has brought most of the speed that it brings
_PULSE = 0.35  # of the hardest: what counts as another blow
_LEAKS = 0.5  # of a motion that may be seen before its time
_REST = 0.25  # share of what follows that is looked at for where it comes to rest


def measure_signal(expectation: ExpectedMotion, view: View, first: int, until: int) -> Signal:
    """A motion as one number per frame, positive the way that was asked for; empty if it cannot be seen."""
    end, why = find_track(expectation, view)
    if why:
        return []
    if expectation.kind in AXIAL:
        sign = -1.0 if expectation.kind is MotionKind.SQUEEZE else 1.0
        return [(t, sign * v) for t, v in measure_strains(expectation, view, first, until)[0]]
    if expectation.kind is MotionKind.ROTATE:
        turns = view.turns_asked(expectation, first, until, end)
        axis = expectation.direction
        return [(t, norm(v) if axis is None else dot(v, axis)) for t, v in turns]
    course = view.course(first, until, end)
    if first == view.span(expectation)[0]:
        course = follow(expectation, view, until, end)[0]
    direction = view.brief.directions.down if expectation.kind is MotionKind.FALL else expectation.direction
    return [(t, norm(p) if direction is None else dot(p, direction)) for t, p in course]


def visible(expectation: ExpectedMotion) -> float:
    """Least value of a signal that is seen."""
    if expectation.kind in AXIAL:
        return tolerances.VISIBLE_STRAIN
    return tolerances.VISIBLE_DEGREES if expectation.kind is MotionKind.ROTATE else tolerances.VISIBLE


def figure_of(expectation: ExpectedMotion) -> str:
    """The uncertainty of the report that a signal has."""
    if expectation.kind in AXIAL:
        return "stretch"
    return "rotation" if expectation.kind is MotionKind.ROTATE else "displacement"


def check_following(index: int, expectation: ExpectedMotion, view: View) -> list[Check]:
    """All that is asked beside direction and amount."""
    if expectation.kind is MotionKind.STILL:
        return []
    return [
        *_check_quantity(index, expectation, view),
        *_check_sudden(index, expectation, view),
        *_check_even(index, expectation, view),
        *_check_blows(index, expectation, view),
        *_check_return(index, expectation, view),
        *_check_stay(index, expectation, view),
        *_check_order(index, expectation, view),
        *_check_part(index, expectation, view),
    ]


def _check_quantity(index: int, expectation: ExpectedMotion, view: View) -> list[Check]:
    """The named quantity as a target."""
    amount = expectation.amount
    if amount is None:
        return []
    question = "is it as much as the sentence says?"
    tolerance = tolerances.expect_quantity(amount, expectation.kind, view.brief)
    first, last = view.span(expectation)
    until = view.until(expectation) if expectation.released or expectation.sudden else last
    end, why = find_track(expectation, view)
    if tolerance is None or why:
        why = why or f"{amount.unit} say nothing about such a motion"
        return [make_unseen_check(index, expectation, why, question)]
    if amount.unit == "seconds":
        return _check_duration(index, expectation, view, tolerance)
    if tolerance.unit == "degrees" and expectation.kind is not MotionKind.ROTATE:
        signal, figure = [(t, norm(v)) for t, v in view.turns(first, until, end)], "rotation"
    else:
        signal = measure_signal(expectation, view, first, until)
        figure = figure_of(expectation)
    if not signal:
        return [make_unseen_check(index, expectation, "its course is not known", question)]
    values = [value for _, value in signal]
    value = max(values)
    if expectation.kind is MotionKind.SWAY:
        value = (max(values) - min(values)) / 2.0
    seen = f"{value:.3g} {tolerance.unit}"
    return [compare_amount(index, expectation, question, tolerance, value, seen, view, figure)]


def _check_duration(
    index: int, expectation: ExpectedMotion, view: View, tolerance: tolerances.Tolerance
) -> list[Check]:
    """Check the cause's duration: a free thing gains speed for so long, a held one is kept away from rest."""
    question = "does it last as long as the sentence says?"
    first, _ = view.span(expectation)
    signal = measure_signal(expectation, view, first, view.last)
    if len(signal) < 5:
        return [make_unseen_check(index, expectation, "its course is not known", question)]
    jitter = estimate_jitter([v for _, v in signal])
    is_held = view.anchored or expectation.kind in (*AXIAL, MotionKind.SWAY)
    if is_held:
        largest = max(abs(v) for _, v in signal)
        level = (0.2 if expectation.kind is MotionKind.SWAY else 0.6) * largest
        away = [t for t, v in signal if abs(v) >= level]
        begun = next(t for t, v in signal if abs(v) >= min(0.1 * largest, level))
        ended = away[-1]
        off = [estimate_crossing(signal, t, jitter) for t in (begun, ended)]
    else:
        speeds = _measure_speeds(signal)
        fastest = max(v for _, v in speeds)
        begun = next((t for t, v in speeds if v >= 0.1 * fastest), first)
        ended = next((t for t, v in speeds if v >= 0.95 * fastest), first)
        off = [estimate_crossing(speeds, t, jitter / math.sqrt(2.0)) for t in (begun, ended)]
    value = view.seconds(begun, ended) + view.report.frame_dt
    if ended >= view.last - 1 and value < tolerance.high:
        value = max(value, min(tolerance.target, view.seconds(first, view.last) + view.report.frame_dt))
    passed = tolerance.low <= value <= tolerance.high
    fix = f"let {view.causes(expectation) or 'the cause'} act {tolerance.gain(value):.2g} times as long"
    return [
        Check(
            expectation=index,
            question=question,
            expected=tolerance.text(),
            observed=f"{value:.2g} seconds",
            passed=passed,
            aspect="order",
            score=round(tolerance.score(value), 6),
            margin=round(tolerance.margin(value), 6),
            confidence=find_confidence(tolerance.distance(value), math.hypot(*off) * view.report.frame_dt),
            remedy="" if passed else fix,
        )
    ]


def _measure_speeds(signal: Signal, width: int = 2) -> Signal:
    """Rate per frame, as a difference over ``width`` frames."""
    pairs = zip(signal, signal[width:])
    return [(a[0], (b[1] - a[1]) / (b[0] - a[0])) for a, b in pairs]


def _check_sudden(index: int, expectation: ExpectedMotion, view: View) -> list[Check]:
    """After a blow the speed is there at once."""
    if not expectation.sudden or expectation.kind not in (MotionKind.MOVE, MotionKind.ROTATE):
        return []
    first, last = view.span(expectation)
    reach = first + max(round((last - first) / expectation.repeats), 3)
    signal = measure_signal(expectation, view, first, min(reach, last))
    if len(signal) < 4 or max(abs(v) for _, v in signal) < visible(expectation):
        return []
    top = max(range(len(signal)), key=lambda i: abs(signal[i][1]))
    speeds = _measure_speeds(signal[: max(top + 1, 4)], 2)  # what comes after it is not the blow's doing
    fastest = max(speeds, key=lambda point: abs(point[1]))[1]
    level = max(0.25 * visible(expectation), 0.15 * max(abs(v) for _, v in signal))
    onset = next(t for t, v in signal if abs(v) >= level)
    reached = next(t for t, v in speeds if abs(v) >= 0.7 * abs(fastest))
    seconds = max(view.seconds(onset, reached), 0.0)
    return [
        make_limit_check(
            index,
            "does it start at once?",
            f"most of its speed within {_SUDDEN:g} s",
            f"after {seconds:.2g} s",
            seconds,
            _SUDDEN,
            aspect="order",
            sigma=view.report.frame_dt,
            remedy=f"make {view.causes(expectation) or 'the cause'} an impulse",
        )
    ]


def _check_even(index: int, expectation: ExpectedMotion, view: View) -> list[Check]:
    """At one speed: the place over time is a straight line. What starts from rest is a quarter of its way behind."""
    if not expectation.even:
        return []
    first, last = view.span(expectation)
    signal = measure_signal(expectation, view, first, last)
    question = "does it go at one speed?"
    if len(signal) < 4:
        return [make_unseen_check(index, expectation, "its course is not known", question)]
    (begin, start), (end, way) = signal[0], max(signal, key=lambda point: abs(point[1]))
    if abs(way - start) < visible(expectation) or end - begin < 3:
        return []
    line = [(t, (v - start) / (way - start) - (t - begin) / (end - begin)) for t, v in signal if t <= end]
    off = max((v for _, v in line), key=abs)
    return [
        make_limit_check(
            index,
            question,
            f"at most {_UNEVEN:.0%} of its way ahead or behind",
            f"{abs(off):.0%} {'ahead' if off > 0 else 'behind'}",
            abs(off),
            _UNEVEN,
            aspect="order",
            sigma=math.sqrt(2.0) * view.sigma(figure_of(expectation)) / abs(way - start),
            remedy=f"let {view.causes(expectation) or 'its cause'} be a blow, or prescribe its velocity",
        )
    ]


def _check_blows(index: int, expectation: ExpectedMotion, view: View) -> list[Check]:
    """Separate pushes: runs of acceleration of a free thing, excursions of a held one."""
    if expectation.kind is not MotionKind.MOVE or expectation.repeats < 2:
        return []
    first, _ = view.span(expectation)
    signal = measure_signal(expectation, view, first, view.until(expectation))
    question = "how many times is it pushed?"
    if len(signal) < 6:
        return [make_unseen_check(index, expectation, "its course is not known", question)]
    count = expectation.repeats
    if view.anchored:
        values = [v for _, v in signal]
        threshold, span = (
            max(0.4 * (max(values) - min(values)), tolerances.VISIBLE / 2),
            max(values) - min(values),
        )
        most, noise = 2 * count, math.sqrt(2.0)

        def find_count(limit: float) -> int:
            return (len(find_turning_points(values, limit)) + 1) // 2
    else:
        gains = _measure_gains(signal)
        span = max(v for _, v in gains)
        threshold, most, noise = (
            _PULSE * span,
            count,
            math.sqrt(1.5),
        )  # of half the differences of differences

        def find_count(limit: float) -> int:
            return _count_pulses(gains, limit)

    seen = find_count(threshold)
    passed = count <= seen <= most
    jitter = estimate_jitter([v for _, v in signal])
    return [
        Check(
            expectation=index,
            question=question,
            expected=f"{count} times" if most == count else f"{count} to {most} times",
            observed=f"{seen} times",
            passed=passed,
            aspect="repeats",
            score=1.0 if passed else round(0.9 * min(seen / count, most / max(seen, 1)), 6),
            margin=round(clamp(1.0 - abs(seen - count) / (0.5 + most - count), -10.0, 1.0), 6),
            confidence=find_count_confidence(
                find_count, lambda n: count <= n <= most, threshold, span, noise * jitter
            ),
            remedy="" if passed else f"let it be pushed {count} separate times",
        )
    ]


def _measure_gains(signal: Signal) -> Signal:
    """By how much the speed grows over two frames."""
    speeds = [(signal[0][0] - 2, 0.0), (signal[0][0] - 1, 0.0), *_measure_speeds(signal, 2)]
    return [(a[0], b[1] - a[1]) for a, b in zip(speeds, speeds[2:])]


def _count_pulses(gains: Signal, limit: float) -> int:
    """Runs of frames in which the speed grows by ``limit`` or more; short pauses do not part them."""
    runs, before = 0, None
    for t, v in gains:
        if v >= limit:
            if before is None or t - before > 3:
                runs += 1
            before = t
    return runs


def _check_return(index: int, expectation: ExpectedMotion, view: View) -> list[Check]:
    """After letting go, held objects and deformations come back towards rest; a free object may drift on."""
    if not expectation.released or expectation.kind in (MotionKind.SWAY, MotionKind.FALL):
        return []
    if expectation.kind not in AXIAL and not view.anchored:
        return []
    first, last = view.span(expectation)
    until = view.until(expectation)
    question = "does it come back after letting go?"
    if until - last < 3:
        if expectation.sudden or expectation.repeats > 1:
            return []
        return [make_unseen_check(index, expectation, "the clip ends before it can come back", question)]
    signal = measure_signal(expectation, view, first, until)
    end, _ = find_track(expectation, view)
    series = view.report.stretch if expectation.kind in AXIAL else _get_series(view, end)
    if not series or len(signal) < 4:
        return [make_unseen_check(index, expectation, "its course is not known", question)]
    largest = max(abs(v) for _, v in signal)
    if largest < visible(expectation):
        return []
    rest = [v for t, v in signal if t >= until - _REST * (until - last)]
    if not rest:
        return [make_unseen_check(index, expectation, "its end is not seen", question)]
    left = abs(sum(rest) / len(rest)) / largest
    return [
        make_limit_check(
            index,
            question,
            f"at most {_CAME_BACK:.0%} of its excursion left",
            f"{left:.0%} of it left",
            left,
            _CAME_BACK,
            aspect="return",
            sigma=view.sigma(figure_of(expectation)) / largest,
            remedy=f"let {view.causes(expectation) or 'the cause'} end earlier",
        )
    ]


def _get_series(view: View, end: PartMotion | None):
    return view.report.centroid if end is None else end.centroid


def _check_stay(index: int, expectation: ExpectedMotion, view: View) -> list[Check]:
    """Check that the object stays where it was brought."""
    if not expectation.stays:
        return []
    first, _ = view.span(expectation)
    until = view.until(expectation)
    signal = measure_signal(expectation, view, first, until)
    question = "does it stay where it was brought?"
    if len(signal) < 4:
        return [make_unseen_check(index, expectation, "its course is not known", question)]
    largest = max(v for _, v in signal)
    if largest < visible(expectation):
        return []
    rest = [v for t, v in signal if t >= until - _REST * (until - first)]
    if not rest:
        return [make_unseen_check(index, expectation, "its end is not seen", question)]
    left = min(rest) / largest
    wanders = (max(rest) - min(rest)) / largest
    sigma = view.sigma(figure_of(expectation)) / largest
    causes = view.causes(expectation) or "the cause"
    return [
        make_limit_check(
            index, question, f"at least {_STAYED:.0%} of its excursion left", f"{left:.0%} of it left",
            left, _STAYED, aspect="return", at_least=True, sigma=sigma, remedy=f"let {causes} act to the end",
        ),
        make_limit_check(
            index, question, f"it moves by at most {1 - _STAYED:.0%} of its excursion there",
            f"it moves by {wanders:.0%}", wanders, 1 - _STAYED, aspect="stillness", sigma=sigma,
            remedy="stop it where it was brought",
        ),
    ]  # fmt: skip


def _check_order(index: int, expectation: ExpectedMotion, view: View) -> list[Check]:
    """Check that what comes later is not seen before its time."""
    first, last = view.span(expectation)
    earlier = [e for e in view.expectations if view.span(e)[0] < first - 1]
    if first < 3 or expectation.kind in (MotionKind.FALL, MotionKind.SWAY) or expectation.repeats > 1:
        return []
    if not earlier or any(_is_alike(e, expectation) for e in earlier):
        return []
    begin = min(view.span(e)[0] for e in earlier)
    before = measure_signal(expectation, view, begin, first)
    during = measure_signal(expectation, view, first, view.until(expectation))
    if len(before) < 2 or not during:
        return []
    most, leaked = max(v for _, v in during), max(v for _, v in before)
    if most < visible(expectation):
        return []
    return [
        make_limit_check(
            index,
            "does it come in its turn?",
            f"less than {_LEAKS:.0%} of it before frame {first}",
            f"{max(leaked, 0.0) / most:.0%} of it before",
            max(leaked, 0.0) / most,
            _LEAKS + visible(expectation) / most,
            aspect="order",
            sigma=view.sigma(figure_of(expectation)) / most,
            remedy=f"let {view.causes(expectation) or 'its cause'} begin at frame {first}",
        )
    ]


def _is_alike(one: ExpectedMotion, other: ExpectedMotion) -> bool:
    """Return whether one motion also shows as the other."""
    if one.kind is MotionKind.SWAY and other.kind is MotionKind.MOVE:
        return True
    if one.kind is not other.kind:
        return one.kind is MotionKind.FALL and other.kind is MotionKind.MOVE
    return one.direction is None or other.direction is None or dot(one.direction, other.direction) > 0.3


def _check_part(index: int, expectation: ExpectedMotion, view: View) -> list[Check]:
    """The named end moves more than the opposite one; one that is excepted moves less."""
    if expectation.part is None or expectation.kind not in (
        MotionKind.MOVE,
        MotionKind.SWAY,
        MotionKind.ROTATE,
    ):
        return []
    moving, why = find_track(expectation, view)
    if moving is None:
        return []  # told already
    resting = view.find_end(tuple(-c for c in moving.direction))  # type: ignore[arg-type]
    first, last = view.span(expectation)
    own, other = _measure_extent(expectation, view, moving, first, last), None
    if resting is not None:
        other = _measure_extent(expectation, view, resting, first, last)
    question = "does that part move, and the rest less?"
    if own is None or other is None:
        return [make_unseen_check(index, expectation, why or "the ends are not followed", question)]
    limit = _REST_SHARE[expectation.excludes_part]
    if own < visible(expectation):
        return []  # nothing moves: told by the amount
    both = any(e.part and e.part != expectation.part for e in view.together(expectation))
    if both:
        return []
    return [
        make_limit_check(
            index,
            question,
            f"the opposite end at most {limit:.0%} as much",
            f"{other / own:.0%} as much",
            other / own,
            limit,
            aspect="part",
            sigma=view.sigma(figure_of(expectation)) / own,
            remedy=f"let {view.causes(expectation) or 'the cause'} act on that part only, or hold the rest",
        )
    ]


_REST_SHARE = {False: 0.75, True: 0.4}
"""Share of the moving end's motion that the other may show: a part drags the rest along; an excepted one hardly
moves."""


def _measure_extent(
    expectation: ExpectedMotion, view: View, end: PartMotion, first: int, last: int
) -> float | None:
    """The largest motion or turn of an end along the asked direction."""
    course = (
        view.turns(first, last, end)
        if expectation.kind is MotionKind.ROTATE
        else view.course(first, last, end)
    )
    if not course:
        return None
    direction = expectation.direction
    return max(norm(p) if direction is None else abs(dot(p, direction)) for _, p in course)
