"""Moves, falls and sways: which way first, which way in all, how far."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from physagent_jax.core.strict import Vector
from physagent_jax.core.turning import find_turning_points
from physagent_jax.motion import tolerances
from physagent_jax.motion.axes import find_lean_axis
from physagent_jax.motion.judging.asked import Asked
from physagent_jax.motion.judging.comparing import (
    SAME_WAY,
    START,
    check_limit,
    compare_amount,
    compare_direction,
    find_spread,
    make_unseen_check,
)
from physagent_jax.motion.judging.counting import check_count, count_turns, estimate_jitter
from physagent_jax.motion.judging.seen import (
    Course,
    View,
    find_farthest,
    find_first_response,
    find_landing,
)
from physagent_jax.motion.judging.toppling import find_sinking, find_sunk_top
from physagent_jax.motion.matching import is_thrown_up, share_time
from physagent_jax.motion.schema import Check, MotionKind
from physagent_jax.motion.vectors import add, cosine, cross, dot, norm, normalise, reject, scale, subtract

_DOWN = 0.7  # cosine
_FIRST = 0.15  # of the farthest excursion: what is seen of a motion first
_KEPT = 0.4  # of the farthest excursion that a free thing has left where it ends
_SEEN_OFF = (
    1.0  # [s] that what was struck stays away at least before it may come back: the blow is seen by then
)
_SINKS = 0.4  # share of what its middle sinks by as it tips over that is seen at least
_ALL_BACK = 1.25  # of the way that it had come: something that is put back where it was may go so far
_ASIDE = 0.22  # [body lengths] that it may wander to either side as it tips over
_TOPPLED = 60.0  # [degrees] off the way down that its middle may go as it tips over
_BOUNCE, _MORE_BOUNCES = (
    0.04,
    2,
)  # [body lengths] that a bounce rises by at least, and more that follow untold
_LANDED = 0.8  # of its way down, from where on what topples lies
_SWUNG = 0.2  # of its length, by which the middle of a limb may go to either side, however slightly it sways
_ABOUT_MIDDLE = 0.6  # of that, of a limb which turns about its own middle
_TURNED = 0.6  # of its way that is enough of a limb which is seen to turn, or of what is seen to bend
_BENT = 0.5  # of a turn of what is held, from where on what bends on a stiff trunk is seen to
_MIDDLE = 0.5  # of the way down of its top that its middle goes as it tips over
_OVERTURNS, _TIPPED = (
    0.7,
    0.3,
)  # cosine of a push and where it tips what it pushes; share of its way that is enough
_ROCKS = 1.5  # of the way of what sways that the middle of what rocks may go: it tilts by as little
_TREMBLES = 3  # turns of what is pressed together as it lands, comes up, and is pressed together again
_SWING = 0.35  # of the amplitude: smaller turns are ripples
_WILD = 0.5  # [body lengths] to either side that is still a wobble
_RIPPLE = 0.4  # of the amplitude: what is soft rings down, and less is no wobble
_RESPONDED = 0.25  # share of the window in which an earlier opposite motion may still go on


def follow(asked: Asked, until: int) -> tuple[Course, Course, Vector]:
    """A move's course without what others add, the same as it is seen, and the velocity before it."""
    first, direction = asked.span[0], asked.direction
    course = asked.course(first, until)
    drift = asked.view.speed_before(first, asked.end)
    if course and direction is not None and cosine(drift, direction) < -0.7 and first > 0:
        course = _cut_at_turning_point(course, direction)
    return asked.clear_of_others(course, drift), course, drift


def _cut_at_turning_point(course: Course, direction: Vector) -> Course:
    """After a motion the other way: from where it turned round, if it did so early."""
    reach = course[0][0] + _RESPONDED * (course[-1][0] - course[0][0])
    start, place = min((point for point in course if point[0] <= reach), key=lambda p: dot(p[1], direction))
    return [(t, subtract(p, place)) for t, p in course if t >= start]


def _cut_at_obstacle(course: Course, direction: Vector, distance: float) -> Course:
    """Until an obstacle is met: what comes after that is the obstacle's doing."""
    end, place = max(course[1:], key=lambda point: dot(point[1], direction))
    met = dot(place, direction) >= tolerances.REACHED * distance
    return [point for point in course if point[0] <= end] if met else course


def _is_bent(asked: Asked, until: int) -> bool:
    """Return whether all of what is held is seen to bend, as a crown on a stiff trunk does over a short way."""
    view, way = asked.view, asked.direction
    axis = (
        find_lean_axis(way, view.brief) if way and asked.motion.manner == "bend" and not asked.end else None
    )
    if axis is None or not view.anchored:
        return False
    turned = max((dot(turn, axis) for _, turn in view.turns(asked.span[0], until)), default=0.0)
    return turned >= _BENT * tolerances.expect_rotation(asked.motion, True).low


def check_move(asked: Asked) -> list[Check]:
    """Displacement: direction of the first response, direction of the path, distance, and whether it is kept."""
    if asked.hidden:
        return [make_unseen_check(asked, asked.hidden)]
    view, motion, direction, (first, last) = asked.view, asked.motion, asked.direction, asked.span
    lasting = motion.sudden or motion.released
    until = asked.until if lasting or not view.anchored else last
    if is_thrown_up(motion, view.expectations, view.brief):
        until = last
    own, raw, drift = follow(asked, until)
    if not own:
        return [make_unseen_check(asked, _explain_lost(view, first, until))]
    if asked.obstacle is not None and direction is not None:
        own, raw = (_cut_at_obstacle(course, direction, asked.obstacle.distance) for course in (own, raw))
    within = [point for point in own if point[0] <= last]
    peak_frame, peak = find_farthest(within if view.anchored and len(within) > 1 and not lasting else own)
    up = view.brief.directions.up
    rises = view.gravity and direction is not None and dot(direction, up) > 0.5
    highest = peak
    if rises and direction is not None:  # it has to come down again, and may land lower
        peak_frame, peak = max(own, key=lambda point: dot(point[1], direction))
        highest = max(own, key=lambda point: dot(point[1], up))[
            1
        ]  # what it goes aside after that is its fall
    along = norm(peak) if direction is None else dot(peak, direction)
    coasting = 0.0 if direction is None else max(dot(drift, direction), 0.0) * (peak_frame - first)
    seconds, at_end = view.seconds(first, until), asked.end is not None
    tolerance = tolerances.expect_move(motion, view.anchored, seconds=seconds, drift=coasting, end=at_end)
    tolerance = view.fit_to_limb(tolerance, motion)
    if asked.limb_turns or _is_bent(asked, until):
        limb = None if motion.limb is None else view.brief.parts[motion.limb]
        share = _TURNED * (_ABOUT_MIDDLE if limb and limb.seated else 1.0)
        tolerance = tolerance.scaled(share, least=0.75 * tolerances.VISIBLE)
    if view.grounded and any(e.kind is MotionKind.ROTATE and e.words == motion.words for e in asked.together):
        tolerance = replace(tolerance, high=2.0 * tolerance.high)  # what rolls goes on rolling
    if direction is not None and any(cosine(way, direction) > _OVERTURNS for way in view.find_topples()):
        # What it brings about is judged there.
        tolerance = replace(tolerance.scaled(_TIPPED, least=tolerances.LEAST), high=2.0 * tolerance.high)
    if asked.obstacle is not None:
        tolerance = tolerance.limited(asked.obstacle.distance)
    if direction is not None and motion.put_back:
        there = asked.course(0, first)  # however gently, it goes all the way back
        come = -dot(there[-1][1], direction) if there else 0.0
        tolerance = replace(tolerance, high=max(tolerance.high, _ALL_BACK * come))
    lowers = direction is not None and dot(direction, up) < -_DOWN and first > 0
    if lowers and view.grounded and not at_end and (before := view.course(0, first)):
        tolerance = tolerance.limited(dot(before[-1][1], up))  # to the ground, and no farther
    lost = any(view.get_places(asked.end)[t] is None for t in range(first, until + 1))
    if lost and 0 < along < tolerance.low:
        return [make_unseen_check(asked, _explain_lost(view, first, until))]
    checks = []
    if direction is not None and norm(peak) >= view.visible:
        way = highest if rises and norm(highest) >= view.visible else peak
        checks += _check_direction(asked, direction, (own, raw), way, drift)
    if motion.amount is None or motion.amount.unit in ("seconds", "degrees", "factor"):
        words = f"{along:.2g} body lengths that way{_describe_instead(view, along, first, last)}"
        checks.append(compare_amount(asked, "how far does it move?", tolerance, along, words))
    free = not view.anchored and motion.repeats == 1 and not rises and not at_end
    if free and direction is not None and peak_frame < own[-1][0] and along >= tolerance.low:
        seen_off = own
        if (
            view.grounded and motion.sudden and asked.obstacle is None
        ):  # what was struck may come rolling back
            gone = next(t for t, p in own if dot(p, direction) >= _KEPT * along)
            seen_off = [each for each in own if each[0] <= gone + _SEEN_OFF / view.report.frame_dt] or own
        left = dot(seen_off[-1][1], direction) / along
        checks.append(check_limit(asked, "keeps_way", left, _KEPT, asked.sigma / along))
    return checks


def _check_direction(
    asked: Asked, direction: Vector, courses: tuple[Course, Course], peak: Vector, drift: Vector
) -> list[Check]:
    """By first response and by path: a rebound after a motion the other way is not what was asked for."""
    own, raw = courses
    threshold = max(asked.view.visible, _FIRST * norm(peak))
    start = own[0][0]
    tried = [own]
    if norm(drift) > 1e-3:
        tried.append([(t, subtract(p, scale(drift, float(t - start)))) for t, p in raw])
    found = [response for course in tried if (response := find_first_response(course, threshold))]
    checks = []
    falls = asked.motion.manner == "detach"  # it may rise first, and it rolls on
    if found and not falls:
        frame, first = max(found, key=lambda response: cosine(response[1], direction))
        question, how = "which way does it start?", f", at frame {frame}"
        checks.append(compare_direction(asked, question, first, how=how, within=START))
    within = START if asked.limb_turns or falls else SAME_WAY
    checks.append(compare_direction(asked, "which way does it go?", peak, within=within))
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


def check_fall(asked: Asked) -> list[Check]:
    """From the highest place in the window down to the lowest after it.

    What is thrown up falls when gravity says, not when the sentence's next part begins: it is watched from the throw.
    """
    view, motion, (first, last) = asked.view, asked.motion, asked.span
    throws = [e for e in view.expectations if is_thrown_up(e, view.expectations, view.brief)]
    first = min([first, *(view.span(e)[0] for e in throws if e.window[0] <= motion.window[0])])
    course = view.course(first, last)
    if not course:
        return [make_unseen_check(asked, _explain_lost(view, first, last))]
    down = asked.direction or view.brief.directions.down
    heights = [-dot(p, down) for _, p in course]
    top = max(range(len(heights)), key=lambda i: heights[i])
    bottom = min(range(top, len(heights)), key=lambda i: heights[i])
    fallen = heights[top] - heights[bottom]
    topples = any(view.topples(e) and share_time(e, motion) for e in view.expectations)
    if topples:  # where it rolls on from where it lies is no fall
        bottom = next(i for i in range(top, len(heights)) if heights[top] - heights[i] >= _LANDED * fallen)
    way = subtract(course[bottom][1], course[top][1])
    moves = [e.direction for e in view.expectations if e.kind is MotionKind.MOVE and e.direction is not None]
    level = [reject(each, down) for each in moves]  # what was thrown that way goes on that way as it falls
    for other in (
        *(unit for each in level if norm(each) > 0.3 and (unit := normalise(each))),
        *view.find_topples(),
    ):
        way = reject(way, other, low=0.0)
    tolerance = tolerances.expect_fall(view.seconds(first, last))
    if topples:
        sinks = _SINKS * find_sinking(view, view.find_topples())
        if sinks < tolerances.LEAST:
            return []  # it is broader than high, and hardly gets lower
        tolerance = replace(
            tolerance, low=min(tolerance.low, sinks, tolerances.LEAST)
        )  # its lean tells the rest
        sunk = _MIDDLE * find_sunk_top(view, first, last)  # its middle may be low at first
        way, fallen = add([way, scale(down, max(sunk - dot(way, down), 0.0))]), max(fallen, sunk)
        for across in (cross(each, down) for each in view.find_topples()):
            way = reject(way, across, -_ASIDE, _ASIDE)
    checks = []
    if norm(way) >= view.visible:
        forth = all(dot(way, each) >= -_ASIDE for each in view.find_topples())
        within = _TOPPLED if topples and forth else SAME_WAY  # where it lands then, its lean tells
        checks.append(compare_direction(asked, "which way does it fall?", way, wanted=down, within=within))
    words = f"{fallen:.2g} body lengths downwards"
    if motion.amount is None or motion.amount.unit == "seconds":
        checks.append(compare_amount(asked, "how far does it fall?", tolerance, fallen, words))
    if motion.rebounds:
        checks.append(_count_bounces(asked, first, top))
    if motion.jiggles:
        checks.append(_check_trembling(asked, find_landing(course, down)))
    if fallen >= tolerance.low or view.force_field.default_drop or motion.window[0] >= 1:
        return checks
    fix = {"remedy": "set default_drop to true: nothing makes it fall"}
    return [check if check.passed else check.model_copy(update=fix) for check in checks]


def _count_bounces(asked: Asked, first: int, top: int) -> Check:
    """The number of times that it comes up from what it falls onto, above where it comes to rest.

    What is soft is pressed together below that and springs back, and has not left the ground.
    """
    view, up = asked.view, asked.view.brief.directions.up
    course = view.course(first, view.last)
    rest = dot(course[-1][1], up)
    heights = [max(dot(p, up), rest) for t, p in course if t <= max(asked.until, course[top][0])][top:]
    told = asked.motion.rebounds
    least = told if asked.motion.counted else 1
    return check_count(
        asked,
        "how often does it bounce?",
        lambda limit: (len(find_turning_points(heights, limit)) + 1) // 2,
        least=least,
        most=told + _MORE_BOUNCES,
        aim=told,
        threshold=_BOUNCE,
        span=max(heights) - rest,
        noise=math.sqrt(2.0) * estimate_jitter(heights),
        noun="times",
        fix=f"let it be thrown up where it lands {told} times",
    )


def check_sway(asked: Asked) -> list[Check]:
    """Excursion to either side, its line, and how often it goes back; or what else comes and goes as it wobbles."""
    checks = _check_swing(asked)
    if not asked.wobbles or all(check.passed for check in checks):
        return checks
    return next((own for own in _list_wobbles(asked) if all(check.passed for check in own)), checks)


def _list_wobbles(asked: Asked) -> Iterator[list[Check]]:
    """Checks of each figure of the whole that may come and go: its place, its tilt, its height and its breadth.

    What falls first wobbles from where it lands on.
    """
    view, (first, last), table = asked.view, asked.span, asked.view.brief.directions
    falls = [view.span(e) for e in view.expectations if e.kind is MotionKind.FALL and e.window[0] < first]
    for begin, until in falls[-1:]:
        fall = view.course(begin, max(until, last))
        first = min(first, find_landing(fall, table.down)) if fall else first
    course = view.course(first, last)
    paths = [[dot(p, axis) for _, p in course] for axis in (table.right, table.up, table.toward)]
    tolerance = tolerances.expect_sway(asked.motion, view.anchored)
    tolerance = replace(
        tolerance, low=max(tolerance.low, tolerances.VISIBLE), high=max(_WILD, tolerance.high)
    )
    for path in paths + _list_changes(view, first, last):
        amplitude = (max(path) - min(path)) / 2.0 if len(path) > 2 else 0.0
        if amplitude >= tolerance.low:
            words = f"{amplitude:.2g} body lengths to either side"
            count = count_turns(asked, path, max(_RIPPLE * amplitude, tolerances.VISIBLE))
            yield [compare_amount(asked, "how far does it wobble?", tolerance, amplitude, words), count]


def _list_changes(view: View, first: int, last: int) -> list[list[float]]:
    """Ways of the ends by its tilt, of the sides and the top by its breadth and height, by frame [body lengths].

    What is broad and low tilts with its sides up and down, and what is tall with its top to and fro.
    """
    table, turns = view.brief.directions, view.turns(first, last)
    width, height, depth = view.brief.extents
    arms = ((table.right, max(height, depth)), (table.toward, max(height, width)))
    tilts = [[math.radians(dot(v, axis)) * arm / 2 for _, v in turns] for axis, arm in arms]
    sides = ((table.right, width), (table.up, height))
    return tilts + [
        [strain * length / 2 for _, strain in view.strains(axis, first, last)] for axis, length in sides
    ]


def _check_trembling(asked: Asked, landed: int) -> Check:
    """The number of times that what is soft is seen to give and to come back where it has landed."""
    paths = [path for path in _list_changes(asked.view, landed, asked.view.last) if path]
    if not paths:
        return make_unseen_check(asked, "its shape is not followed where it lands")
    path = max(paths, key=lambda each: len(find_turning_points(each, tolerances.VISIBLE)))
    return check_count(
        asked,
        "how often does it wobble where it lands?",
        lambda limit: len(find_turning_points(path, limit)),
        least=_TREMBLES,
        most=math.ceil(len(path) / 2),
        aim=2.0 * _TREMBLES,
        threshold=tolerances.VISIBLE,
        span=max(path) - min(path),
        noise=math.sqrt(2.0) * estimate_jitter(path),
        noun="turns",
        fix="make it softer, and let nothing hold it where it lands",
    )


def _check_swing(asked: Asked) -> list[Check]:
    """Excursion of the middle to either side, its line, and how often it goes back to its place."""
    if asked.hidden:
        return [make_unseen_check(asked, asked.hidden)]
    course = asked.clear_of_others(asked.course(*asked.span), (0.0, 0.0, 0.0))
    if len(course) < 3:
        return [make_unseen_check(asked, "its path is not followed")]
    line, amount = _find_line(course), asked.motion.amount
    direction = asked.direction or line
    path = [dot(p, direction) for _, p in course]
    amplitude = (max(path) - min(path)) / 2.0
    tolerance = tolerances.expect_sway(asked.motion, asked.view.anchored, end=asked.end is not None)
    tolerance = asked.view.fit_to_limb(tolerance, asked.motion)
    if (limb := asked.motion.limb) is not None:  # a long one goes far at however small an angle
        arm = norm(asked.view.brief.parts[limb].arm)
        tolerance = replace(tolerance, high=max(tolerance.high, _SWUNG * arm))
    if asked.motion.manner == "rock":  # the middle of what is low goes less far as it is tilted
        low, high = tolerance.low * asked.view.brief.extents[1], _ROCKS * tolerance.high
        tolerance = replace(tolerance, low=low, high=high)
    words = f"{amplitude:.2g} body lengths to either side"
    checks = []
    if amount is None or amount.unit == "seconds":
        half_width = _find_half_width(asked, amplitude)
        question = "how far does it sway?"
        checks.append(compare_amount(asked, question, tolerance, amplitude, words, half_width=half_width))
    if asked.direction is not None and amplitude >= 0.5 * tolerance.low:
        sense = line if dot(line, direction) >= 0 else scale(line, -1.0)
        spread = find_spread(2.0 * amplitude, asked.view)
        checks.append(compare_direction(asked, "along which line?", sense, spread))
    hysteresis = max(2.0 * _SWING * amplitude, 0.5 * tolerances.VISIBLE)
    if not asked.motion.counted:  # what swings on afterwards belongs to it
        further = asked.clear_of_others(
            asked.course(asked.span[0], _find_end_of_swings(asked)), (0.0, 0.0, 0.0)
        )
        path = [dot(p, direction) for _, p in further]
    return [*checks, count_turns(asked, path, hysteresis, _find_rest(asked, direction))]


def _find_end_of_swings(asked: Asked) -> int:
    """The last frame before another motion is asked for: stillness is not, which what swings comes to by itself."""
    view, (_, last) = asked.view, asked.span
    later = [each.window[0] for each in view.expectations if each.kind is not MotionKind.STILL]
    return int(min((begin for begin in later if begin >= last - 0.5), default=view.last))


def _find_half_width(asked: Asked, amplitude: float) -> float | None:
    """The uncertainty of a part's swings after it has gone farther, which is what the report's is of; None = that."""
    course = asked.view.course(0, asked.view.last, asked.end) if asked.motion.limb is not None else []
    farthest = norm(find_farthest(course)[1]) if course else 0.0
    if farthest <= 2.0 * amplitude:
        return None
    return asked.view.uncertainty(asked.figure) * 2.0 * amplitude / farthest


def _find_rest(asked: Asked, direction: Vector) -> float | None:
    """The place in which the clip begins, on a sway's path; None for what is free, or a part that goes by itself."""
    begin, places = asked.span[0], asked.view.get_places(asked.end)
    first, here = places[0], places[begin]
    if not asked.view.anchored or asked.motion.limb is not None or first is None or here is None:
        return None
    return dot(subtract(first, here), direction)


def _find_line(course: Course) -> Vector:
    """Direction between the two places that are farthest apart, from the farthest place."""
    _, far = find_farthest(course)
    _, other = max(course, key=lambda point: norm(subtract(point[1], far)))
    return subtract(far, other)
