"""Moves, falls and sways: which way first, which way in all, how far."""

from __future__ import annotations

import math

from physagent_jax.agents.matching import is_thrown_up
from physagent_jax.agents.rules import tolerances
from physagent_jax.agents.rules.judging.comparing import (
    compare_amount,
    compare_direction,
    find_spread,
    make_limit_check,
    make_unseen_check,
)
from physagent_jax.agents.rules.judging.counting import estimate_jitter, find_count_confidence
from physagent_jax.agents.rules.judging.seen import Course, View, find_farthest, find_first_response
from physagent_jax.agents.schema import Check, ExpectedMotion, MotionKind
from physagent_jax.agents.vectors import add, clamp, cosine, dot, norm, scale
from physagent_jax.core.strict import Vector
from physagent_jax.core.turning import find_turning_points
from physagent_jax.perception.schema import PartMotion

_FIRST = 0.15  # of the farthest excursion: what is seen of a motion first
_KEPT = 0.4  # of the farthest excursion that a free thing has left where it ends
_SWING = 0.35  # of the amplitude: smaller turns are ripples
_RESPONDED = 0.25  # share of the window in which an earlier opposite motion may still go on


def find_track(expectation: ExpectedMotion, view: View) -> tuple[PartMotion | None, str]:
    """The end that is asked about, None for the whole; and why it cannot be seen, if so."""
    if expectation.part is None:
        return None, ""
    where = scale(expectation.part, -1.0) if expectation.excludes_part else expectation.part
    end = view.find_end(where)
    return (end, "") if end else (None, "the ends of the object are not told apart")


def follow(
    expectation: ExpectedMotion, view: View, until: int, end: PartMotion | None
) -> tuple[Course, Course, Vector]:
    """A move's course without what others add, the same as it is seen, and the velocity before it."""
    first, _ = view.span(expectation)
    course = view.course(first, until, end)
    drift = view.speed_before(first, end)
    direction = expectation.direction
    if course and direction is not None and cosine(drift, direction) < -0.7 and first > 0:
        course = _cut_at_turning_point(course, direction)
    return view.without_others(course, expectation, drift), course, drift


def _cut_at_turning_point(course: Course, direction: Vector) -> Course:
    """After a motion the other way: from where it turned round, if it did so early."""
    reach = course[0][0] + _RESPONDED * (course[-1][0] - course[0][0])
    start, place = min((point for point in course if point[0] <= reach), key=lambda p: dot(p[1], direction))
    return [(t, add([p, scale(place, -1.0)])) for t, p in course if t >= start]


def _cut_at_obstacle(course: Course, direction: Vector, distance: float) -> Course:
    """Until an obstacle is met: what comes after that is the obstacle's doing."""
    end, place = max(course[1:], key=lambda point: dot(point[1], direction))
    met = dot(place, direction) >= tolerances.REACHED * distance
    return [point for point in course if point[0] <= end] if met else course


def check_move(index: int, expectation: ExpectedMotion, view: View) -> list[Check]:
    """Displacement: direction of the first response, direction of the path, distance, and whether it is kept."""
    end, why = find_track(expectation, view)
    if why:
        return [make_unseen_check(index, expectation, why)]
    first, last = view.span(expectation)
    lasting = expectation.sudden or expectation.released
    until = view.until(expectation) if lasting or not view.anchored else last
    thrown = is_thrown_up(expectation, view.expectations, view.brief)
    if thrown:
        until = last
    own, raw, drift = follow(expectation, view, until, end)
    if not own:
        return [make_unseen_check(index, expectation, _explain_lost(view, first, until))]
    obstacle, direction = view.find_obstacle(expectation), expectation.direction
    if obstacle is not None and direction is not None:
        own, raw = (_cut_at_obstacle(course, direction, obstacle.distance) for course in (own, raw))
    within = [point for point in own if point[0] <= last]
    peak_frame, peak = find_farthest(within if view.anchored and len(within) > 1 and not lasting else own)
    rises = view.gravity and direction is not None and dot(direction, view.brief.directions.up) > 0.5
    if rises and direction is not None:  # it has to come down again, and may land lower
        peak_frame, peak = max(own, key=lambda point: dot(point[1], direction))
    along = norm(peak) if direction is None else dot(peak, direction)
    coasting = 0.0 if direction is None else max(dot(drift, direction), 0.0) * (peak_frame - first)
    tolerance = tolerances.expect_move(
        expectation,
        view.report.frame_count,
        view.anchored,
        seconds=view.seconds(first, until),
        drift=coasting,
        end=end is not None,
    )
    if obstacle is not None:
        tolerance = tolerance.limited(obstacle.distance)
    lost = next((t for t in range(first, until + 1) if view.report.centroid[t] is None), None)
    if lost is not None and 0 < along < tolerance.low:
        return [make_unseen_check(index, expectation, _explain_lost(view, first, until))]
    checks = []
    if direction is not None and norm(peak) >= view.visible:
        checks += _check_direction(index, expectation, view, (own, raw), peak, drift)
    quantity = expectation.amount
    if quantity is None or quantity.unit in ("seconds", "degrees", "factor"):
        name = f"{along:.2g} body lengths that way{_describe_instead(view, along, first, last)}"
        checks.append(
            compare_amount(
                index, expectation, "how far does it move?", tolerance, along, name, view, "displacement"
            )
        )
    free = not view.anchored and expectation.repeats == 1 and not rises and end is None
    if free and direction is not None and peak_frame < own[-1][0] and along >= tolerance.low:
        left = dot(own[-1][1], direction) / along
        checks.append(
            make_limit_check(
                index,
                "does it keep the way that it went?",
                f"at least {_KEPT:.0%} of its way left",
                f"{left:.0%} of it left",
                left,
                _KEPT,
                aspect="direction",
                at_least=True,
                sigma=view.sigma("displacement") / along,
                remedy=f"let nothing bring it back after {view.causes(expectation) or 'the push'}",
            )
        )
    return checks


def _check_direction(
    index: int,
    expectation: ExpectedMotion,
    view: View,
    courses: tuple[Course, Course],
    peak: Vector,
    drift: Vector,
) -> list[Check]:
    """By first response and by path: a rebound after a motion the other way is not what was asked for."""
    own, raw = courses
    direction = expectation.direction
    assert direction is not None
    threshold = max(view.visible, _FIRST * norm(peak))
    start = own[0][0]
    less_drift = [(t, add([p, scale(drift, float(start - t))])) for t, p in raw]
    responses = [find_first_response(course, threshold) for course in (own, less_drift)]
    found = [response for response in responses[: 2 if norm(drift) > 1e-3 else 1] if response]
    checks = []
    if found:
        frame, first = max(found, key=lambda response: cosine(response[1], direction))
        checks.append(
            compare_direction(
                index, expectation, "which way does it start?", first, view, find_spread(norm(first), view),
                how=f", at frame {frame}",
            )
        )  # fmt: skip
    checks.append(
        compare_direction(
            index, expectation, "which way does it go?", peak, view, find_spread(norm(peak), view)
        )
    )
    return checks


def _explain_lost(view: View, first: int, until: int) -> str:
    """Explain why a displacement is not known."""
    leaves = view.report.quality.leaves_frame
    if leaves is not None and leaves <= until:
        return f"it leaves the picture at frame {leaves}"
    window = view.window(first, until) or view.report.windows[0]
    return window.unobservable.get("displacement", "its place is not known throughout")


def _describe_instead(view: View, moved: float, first: int, last: int) -> str:
    """Describe the motion that is seen in place of a displacement."""
    turns = view.turns(first, last)
    turned = norm(find_farthest(turns)[1]) if turns else 0.0
    return f", but a rotation by {turned:.0f} degrees" if moved < 0.05 and turned > 20.0 else ""


def check_fall(index: int, expectation: ExpectedMotion, view: View) -> list[Check]:
    """From the highest place in the window down to the lowest after it.

    What is thrown up falls when gravity says, not when the sentence's next part begins: it is watched from the throw.
    """
    first, last = view.span(expectation)
    throws = [e for e in view.expectations if is_thrown_up(e, view.expectations, view.brief)]
    first = min([first, *(view.span(e)[0] for e in throws if e.window[0] <= expectation.window[0])])
    course = view.course(first, last)
    if not course:
        return [make_unseen_check(index, expectation, _explain_lost(view, first, last))]
    down = expectation.direction or view.brief.directions.down
    heights = [(t, -dot(p, down)) for t, p in course]
    top = max(range(len(heights)), key=lambda i: heights[i][1])
    bottom = min(range(top, len(heights)), key=lambda i: heights[i][1])
    fallen = heights[top][1] - heights[bottom][1]
    way = add([course[bottom][1], scale(course[top][1], -1.0)])
    moves = [e.direction for e in view.expectations if e.kind is MotionKind.MOVE and e.direction is not None]
    for other in (*(each for each in moves if abs(dot(each, down)) < 0.5), *view.find_topples()):
        way = add([way, scale(other, -max(dot(way, other), 0.0))])
    tolerance = tolerances.expect_fall(expectation, view.seconds(first, last))
    checks = []
    if norm(way) >= view.visible:
        checks.append(
            compare_direction(
                index, expectation, "which way does it fall?", way, view, find_spread(norm(way), view), down
            )
        )  # fmt: skip
    words = f"{fallen:.2g} body lengths downwards"
    if expectation.amount is None or expectation.amount.unit == "seconds":
        checks.append(
            compare_amount(
                index, expectation, "how far does it fall?", tolerance, fallen, words, view, "displacement"
            )
        )
    if fallen >= tolerance.low or view.force_field.default_drop or expectation.window[0] >= 1:
        return checks
    fix = {"remedy": "set default_drop to true: nothing makes it fall"}
    return [check if check.passed else check.model_copy(update=fix) for check in checks]


def check_sway(index: int, expectation: ExpectedMotion, view: View) -> list[Check]:
    """Excursion to either side, its line, and how often it turns back."""
    end, why = find_track(expectation, view)
    if why:
        return [make_unseen_check(index, expectation, why)]
    first, last = view.span(expectation)
    course = view.without_others(view.course(first, last, end), expectation, (0.0, 0.0, 0.0))
    if len(course) < 3:
        return [make_unseen_check(index, expectation, "its path is not followed")]
    line = _find_line(course)
    direction = expectation.direction or line
    path = [dot(p, direction) for _, p in course]
    amplitude = (max(path) - min(path)) / 2.0
    tolerance = tolerances.expect_sway(expectation, view.anchored, end=end is not None)
    words = f"{amplitude:.2g} body lengths to either side"
    checks = []
    if expectation.amount is None or expectation.amount.unit == "seconds":
        checks.append(
            compare_amount(
                index, expectation, "how far does it sway?", tolerance, amplitude, words, view, "displacement"
            )
        )
    if expectation.direction is not None and amplitude >= 0.5 * tolerance.low:
        sense = line if dot(line, direction) >= 0 else scale(line, -1.0)
        spread = find_spread(2.0 * amplitude, view)
        checks.append(compare_direction(index, expectation, "along which line?", sense, view, spread))
    hysteresis = max(2.0 * _SWING * amplitude, 0.5 * tolerances.VISIBLE)
    return [*checks, count_turns(index, expectation, view, path, hysteresis)]


def count_turns(
    index: int, expectation: ExpectedMotion, view: View, path: list[float], hysteresis: float
) -> Check:
    """To and fro ``repeats`` times is ``2 repeats - 1`` turns, and some more while it comes to rest.

    Without a count (once), any number that can be followed is a sway.

    Args:
        index: Which expectation.
        expectation: What was asked.
        view: What was seen.
        path: Position per frame.
        hysteresis: Ways back that are shorter do not count, in the path's unit.
    """
    count = expectation.repeats
    wanted, most = 2 * count - 1, (2 * count + 2 if count > 1 else 7)
    turns = len(find_turning_points(path, hysteresis))
    passed = wanted <= turns <= most
    confidence = find_count_confidence(
        lambda threshold: len(find_turning_points(path, threshold)),
        lambda seen: wanted <= seen <= most,
        hysteresis,
        max(path) - min(path),
        math.sqrt(2.0) * estimate_jitter(path),
    )
    middle, half = 0.5 * (wanted + most), 0.5 * (most - wanted) + 0.5
    fix = f"alternate {view.causes(expectation) or 'pushes'} {count} times to and fro"
    return Check(
        expectation=index,
        question="how often does it turn back?",
        aspect="repeats",
        expected=f"{wanted} to {most} times",
        observed=f"{turns} turns",
        passed=passed,
        score=1.0 if passed else round(0.9 * min(turns / wanted, most / max(turns, 1)), 6),
        margin=round(clamp((half - abs(turns - middle)) / half, -10.0, 1.0), 6),
        confidence=confidence,
        remedy="" if passed else fix,
    )


def _find_line(course: Course) -> Vector:
    """Direction between the two places that are farthest apart, from the farthest place."""
    _, far = find_farthest(course)
    _, other = max(course, key=lambda point: norm(add([point[1], scale(far, -1.0)])))
    return add([far, scale(other, -1.0)])
