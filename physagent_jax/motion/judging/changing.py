"""Turns, changes of length, and stillness."""

from __future__ import annotations

import math
from dataclasses import replace

from physagent_jax.core.strict import Vector
from physagent_jax.motion import tolerances
from physagent_jax.motion.judging.asked import Asked
from physagent_jax.motion.judging.comparing import (
    SAME_WAY,
    START,
    check_limit,
    compare_amount,
    compare_direction,
    make_unseen_check,
)
from physagent_jax.motion.judging.counting import count_turns
from physagent_jax.motion.judging.seen import ALONG_END, Signal, View, find_farthest, find_first_response
from physagent_jax.motion.judging.toppling import check_topple
from physagent_jax.motion.matching import AXIAL, is_last_rest
from physagent_jax.motion.schema import Check, MotionKind
from physagent_jax.motion.vectors import (
    cosine,
    cross,
    dot,
    norm,
    normalise,
    scale,
    subtract,
)
from physagent_jax.perception.reasons import BY_SIZE
from physagent_jax.perception.schema import PartMotion

_FIRST = 0.2  # of the largest turn or strain: what is seen of it first
_OWN_AXIS = 0.6  # of the asked strain that other directions may show the same way
_UPRIGHT = 0.7  # cosine
_SLIGHT, _AJAR, _OPEN = (
    0.45,
    45.0,
    180.0,
)  # strength of "slightly" at most; [degrees] that a part is then open, or else
_FITTED, _OUTLINE, _OWN = "from the affine fit", "from the outline", "of the part"
_BETWEEN = 2 / 3  # of its length, between the middles of its ends, each a third of it
_KEPT = 0.4  # of the largest turn that a free thing has left where it ends
_AT_REST = 0.5  # [s] at the end in which what comes to rest is looked at
_HARDLY = 0.1  # of the most that it did in as long a time: less is hardly seen beside it
_HARDLY_AT_MOST = 2.0  # times what passes for stillness by itself
_GLIMPSE = 4  # frames after the planned ones that do not tell yet how it is left
_LIMITS_OF_STILLNESS = {
    "moves": ("displacement", tolerances.STILL),
    "moves at one end": ("displacement", tolerances.STILL),
    "turns": ("rotation", tolerances.STILL_DEGREES),
    "deforms": ("stretch", tolerances.STILL_STRAIN),
}

Strains = tuple[Signal, str, float]
"""Relative change of length per frame, how it was measured or why not, and its half width."""


def check_rotation(asked: Asked) -> list[Check]:
    """Sense and axis by first response and by path, and the angle."""
    if asked.hidden:
        return [make_unseen_check(asked, asked.hidden)]
    view, motion, axis, (first, last) = asked.view, asked.motion, asked.direction, asked.span
    until = asked.until if motion.released or not view.anchored else last
    turns = asked.turns(first, until) or asked.turns(first, last)
    if not turns:
        unknown = "its turn is not known"
        if view.window(first, last) is None:
            unknown = f"frames {first} to {last} are not in the motion report"
        return [make_unseen_check(asked, view.explain("rotation_degrees", first, last, unknown))]
    if view.topples(motion):
        return check_topple(asked, turns)
    at, peak = find_farthest(turns)
    angle = norm(peak) if axis is None else dot(peak, axis)
    if view.is_aloft(motion):
        angle = max(angle, 180.0 * view.count_half_turns())
    checks = []
    if axis is not None and norm(peak) >= tolerances.VISIBLE_DEGREES:
        spread = max(view.sigma("axis"), 1.0)
        threshold = max(tolerances.VISIBLE_DEGREES, _FIRST * norm(peak), view.uncertainty("rotation"))
        response = find_first_response(turns, threshold)
        if response and response[0] < at:
            question = "about which axis does it start to turn?"
            checks.append(compare_direction(asked, question, response[1], spread, within=START))
        within = START if asked.tumbles or asked.rolls_as_it_lies else SAME_WAY
        checks.append(compare_direction(asked, "about which axis does it turn?", peak, spread, within=within))
    if motion.repeats > 1:
        path = [dot(v, axis or peak) for _, v in view.turns(first, view.last, asked.end)]
        checks.append(count_turns(asked, path, 0.35 * (max(path) - min(path)) + 1.0))
    if motion.manner == "circle":
        checks.append(_check_circle(asked))
    if motion.amount is not None and motion.amount.unit == "degrees":
        return checks
    tolerance = tolerances.expect_rotation(motion, view.anchored, seconds=view.seconds(first, until))
    if view.grounded and any(e.kind is MotionKind.MOVE and e.words == motion.words for e in asked.together):
        tolerance = replace(
            tolerance, high=tolerances.TURN[2][2]
        )  # how gently it was pushed tells no end of rolling
    if asked.opens:
        most = _OPEN if motion.strength > _SLIGHT else _AJAR
        tolerance = replace(tolerance, high=max(tolerance.high, most))
    moved = view.course(first, last)
    shift = norm(find_farthest(moved)[1]) if moved else 0.0
    words = f"{angle:.0f} degrees about its axis"
    if angle < tolerance.low and shift > 0.2:
        words += f", but a displacement by {shift:.2g} body lengths"
    checks.append(compare_amount(asked, "how far does it turn?", tolerance, angle, words))
    free = not (view.anchored or motion.released) and asked.end is None and motion.repeats == 1
    free &= not view.is_aloft(motion)
    if free and axis and angle >= tolerance.low:
        left = dot(turns[-1][1], axis) / angle
        checks.append(check_limit(asked, "keeps_turn", left, _KEPT, asked.sigma / angle))
    return checks


def _check_circle(asked: Asked) -> Check:
    """The way by which it goes out and comes back: what only drifts as it turns is in no circle."""
    question, (first, last) = "how wide is its circle?", asked.span
    ways = [norm(place) for _, place in asked.view.course(first, last) or ()]
    if not ways:
        return make_unseen_check(asked, "its path is not known", question)
    seen = f"{max(ways):.2g} body lengths away at most, and {ways[-1]:.2g} in the end"
    return compare_amount(
        asked, question, tolerances.CIRCLE, max(ways) - ways[-1], seen, figure="displacement"
    )


def check_strain(asked: Asked) -> list[Check]:
    """Change of length along the direction: sign by first response, amount, and that it is that direction's own.

    An end that is pressed or drawn along itself shows in its way to the other end; any other part in its own shape.
    """
    view, motion, sign, (first, last) = asked.view, asked.motion, asked.sign, asked.span
    until = asked.until if motion.released else last
    strains, how, half_width = measure_strains(asked, first, until)
    if not strains:
        return [make_unseen_check(asked, how)]
    change = "shorter" if sign < 0 else "longer"
    along = [(t, sign * strain) for t, strain in strains]
    peak = max((value for _, value in along), key=abs)
    checks = []
    threshold, start = max(tolerances.VISIBLE_STRAIN, _FIRST * abs(peak), half_width / 2), along[0][1]
    response = next(((t, value - start) for t, value in along if abs(value - start) > threshold), None)
    if response and len(along) > 2:
        frame, strain = response
        figures = {"change": change, "length": 1 + sign * strain, "frame": frame}
        sigma = view.sigma("stretch")
        checks.append(check_limit(asked, "strain_first", 1.0 + strain, 1.0, sigma, gain=-1.0, **figures))
    if motion.repeats > 1:
        checks.append(_count_strains(asked, first))
    if asked.end is None and asked.direction is not None and peak >= tolerances.VISIBLE_STRAIN:
        checks += _check_own_axis(asked, asked.direction, until, along, peak)
    if motion.amount is not None and motion.amount.unit != "seconds":
        return checks
    tolerance = tolerances.expect_strain(motion, motion.kind is MotionKind.SQUEEZE)
    if how == _OWN:  # what is beside it does not tell how large it was
        tolerance = replace(tolerance, high=max(tolerance.high, tolerances.MOST_OF_PART))
    words = f"{1 + sign * peak:.2f} times its length ({how})"
    question = f"how much {change} does it get?"
    return [*checks, compare_amount(asked, question, tolerance, peak, words, half_width=half_width)]


def measure_strains(asked: Asked, first: int, until: int) -> Strains:
    """Along one direction from the affine fit or the outline; in all directions the mean of three.

    Of an end that is pressed or drawn along itself by its way to the other end, of any other part by its own fit.
    """
    view, direction = asked.view, asked.direction
    usual, lost = view.uncertainty("stretch"), view.explain("stretch", first, until, "its shape is not known")
    if asked.end is not None:
        part = asked.motion.part
        along = direction is not None and part is not None and abs(cosine(part, direction)) >= ALONG_END
        if along and direction is not None and asked.motion.limb is None:
            return _measure_between_ends(asked, asked.end, direction, first, until)
        return _measure_part(view, asked.end, direction, first, until)
    if direction is not None:
        if view.hides(direction):
            return [], "the stretch along the line of sight is hidden", usual
        strains, how, half_width = _measure_along(direction, view, first, until)
        strains = _measure_from_rest(asked, direction, strains, first, how)
        return strains, how if strains else lost, half_width
    if not view.shows_approach(first, until):
        return [], BY_SIZE, usual
    shown = [view.strains(axis, first, until) for axis in view.visible_axes]
    if not all(shown):
        volumes = view.volumes(first, until)
        if not volumes:
            return [], lost, usual
        return [(t, max(v, 0.0) ** (1 / 3) - 1.0) for t, v in volumes], "from the bounding box", usual
    values = list(zip(*shown))
    return [(each[0][0], sum(v for _, v in each) / len(each)) for each in values], "in all directions", usual


def _measure_part(view: View, part: PartMotion, direction: Vector | None, first: int, until: int) -> Strains:
    """Relative change of a part's own length along a direction, or the mean of those that are seen."""
    axes = [axis for axis in ([direction] if direction else view.visible_axes) if not view.hides(axis)]
    measured = [_measure_along(axis, view, first, until, part) for axis in axes]
    shown = [dict(strains) for strains, _, _ in measured]
    if not shown or not all(shown):
        return [], "the length of a part is not measured", view.uncertainty("stretch")
    half_width = max(width for _, _, width in measured)
    common = sorted(set.intersection(*map(set, shown)))
    return [(t, sum(each[t] for each in shown) / len(shown)) for t in common], _OWN, half_width


def _measure_between_ends(asked: Asked, end: PartMotion, way: Vector, first: int, until: int) -> Strains:
    """Relative change of the distance between the middles of an end and of the one across from it."""
    view = asked.view
    other, box = view.find_end(scale(end.direction, -1.0)), view.report.box[first]
    if other is None or box is None:
        return [], "the ends are not followed", view.uncertainty("stretch")
    apart = _BETWEEN * max(sum(abs(u) * (b - a) for u, a, b in zip(way, box.low, box.high)), 1e-6)
    there, ahead = dict(view.course(first, until, other)), math.copysign(1.0, dot(end.direction, way))
    course = [(t, subtract(p, there[t])) for t, p in view.course(first, until, end) if t in there]
    half_width = math.sqrt(2.0) * view.uncertainty("displacement") / apart
    return [(t, ahead * dot(p, way) / apart) for t, p in course], "from its ends", half_width


def _measure_along(
    direction: Vector, view: View, first: int, until: int, part: PartMotion | None = None
) -> Strains:
    """From the affine fit, or from the outline where that has changed by more, the same way.

    The fit goes by points on the surface, of which most may lie where nothing happens: between plates that press the
    ends together, say. Upwards it has to show something too: what stands up (ears, leaves) is thin and bends first.
    """
    strains, usual = view.strains(direction, first, until, part), view.uncertainty("stretch")
    fitted = dict(strains)
    outline = [point for point in view.outline(direction, first, until, part) if point[0] in fitted]
    if len(outline) < 2:
        return strains, _FITTED, usual
    frame, value, half_width = max(outline, key=lambda point: abs(point[1]) - point[2])
    sure = max(abs(value) - half_width, 0.0)
    upright = part is None and abs(dot(direction, view.brief.directions.up)) > _UPRIGHT
    least = tolerances.VISIBLE_STRAIN if upright else -tolerances.VISIBLE_STRAIN
    if math.copysign(1.0, value) * fitted[frame] < least or sure <= abs(fitted[frame]):
        return strains, _FITTED, usual
    return [(t, v) for t, v, _ in outline], _OUTLINE, half_width


def _measure_from_rest(asked: Asked, direction: Vector, strains: Signal, first: int, how: str) -> Signal:
    """Relative to rest by the same measure, if it was deformed the other way before: springing back is no stretch."""
    before = []
    if first > 0 and how == _OUTLINE:
        before = [(t, v) for t, v, _ in asked.view.outline(direction, 0, first)]
    elif first > 0:
        before = asked.view.strains(direction, 0, first)
    start = before[-1][1] if before and before[-1][0] == first else 0.0
    if (start > 0.0) == (asked.kind is MotionKind.STRETCH):
        return strains
    return [(t, (1.0 + v) * (1.0 + start) - 1.0) for t, v in strains]


def _count_strains(asked: Asked, first: int) -> Check:
    strains, how, _ = measure_strains(asked, first, asked.view.last)
    if len(strains) < 4:
        return make_unseen_check(asked, how or "no course of its shape", "how often?")
    path = [value for _, value in strains]
    return count_turns(asked, path, 0.35 * (max(path) - min(path)) + 0.01)


def _check_own_axis(asked: Asked, direction: Vector, until: int, along: Signal, peak: float) -> list[Check]:
    """Along the direction more than across it: else it swells, shrinks, or bends."""
    view, frame = asked.view, max(along, key=lambda point: point[1])[0]
    helper = (0.0, 0.0, 1.0) if abs(direction[2]) < 0.9 else (1.0, 0.0, 0.0)
    one = normalise(cross(direction, helper)) or helper
    across = []
    for axis in (one, cross(direction, one)):
        values = {} if view.hides(axis) else dict(view.strains(axis, asked.span[0], until))
        if frame in values:
            across.append(asked.sign * values[frame])
    if not across or any(e.kind is asked.kind for e in asked.together):
        return []
    most = max(across)
    figures = {"most": asked.sign * most, "peak": asked.sign * peak, "share": _OWN_AXIS}
    figures["change"] = "shorter" if asked.sign < 0 else "longer"
    sigma = view.sigma("stretch")
    return [check_limit(asked, "own_axis", max(most, 0.0), _OWN_AXIS * peak, sigma, **figures)]


def check_still(asked: Asked) -> list[Check]:
    """The largest of displacement, rotation and strain, each in units of what still passes for stillness.

    What comes to rest is looked at for a while at the clip's true end. There it may go on by what is hardly seen
    beside the most that it did before in as long a time.
    """
    view, (first, last) = asked.view, asked.span
    turned = any(e.kind is MotionKind.ROTATE for e in asked.together)
    limits, pace = dict.fromkeys(_LIMITS_OF_STILLNESS, 1.0), 1.0
    if is_last_rest(asked.motion, view.expectations):
        count = max(round(_AT_REST / view.report.frame_dt), 1)
        for begin in range(0, max(first - count, 0) + 1, max(count // 2, 1)):
            for name, most in _measure_unrest(asked, view, begin, min(begin + count, last)).items():
                limits[name] = max(limits[name], min(_HARDLY * most, _HARDLY_AT_MOST))
        if view.ending and view.ending.frame_count > _GLIMPSE:
            view = replace(view, report=view.ending)
            first, last = max(view.last - count, 0), view.last
            pace = count / (last - first)
        first = max(first, last - count)
    ratios = {n: pace * v / limits[n] for n, v in _measure_unrest(asked, view, first, last).items()}
    if view.sight is not None:
        lost = view.explain("rotation_degrees", first, last, "")
        if why := (lost if not turned else "") or ("" if view.shows_approach(first, last) else BY_SIZE):
            return [make_unseen_check(asked, why)]
    if "moves" not in ratios:
        why = view.explain("displacement", first, last, "") or "its place is not known throughout"
        return [make_unseen_check(asked, why)]
    worst = max(ratios, key=lambda name: ratios[name])
    figure, unit = _LIMITS_OF_STILLNESS[worst]
    sigma = view.sigma(figure) / (unit * limits[worst])
    return [check_limit(asked, "still", ratios[worst], 1.0, sigma, what=worst)]


def _measure_unrest(asked: Asked, view: View, first: int, last: int) -> dict[str, float]:
    """Displacement, rotation and strain in units of what passes for stillness, as far as they are seen.

    What is asked beside the stillness is no unrest: "stretch it while it stays in place". A limb is to stay where it
    is, whatever the others do.
    """
    beside = {e.kind for e in asked.together}
    if (limb := asked.motion.limb) is not None and any(e.limb is not None for e in asked.together):
        own = next((each for each in view.report.parts if each.limb == limb), None)
        course = view.course(first, last, own) if own else []
        return {"moves": norm(find_farthest(course)[1]) / tolerances.STILL} if course else {}
    reshaped, ratios = not {*AXIAL}.isdisjoint(beside), {}
    if course := view.course(first, last):
        ratios["moves"] = norm(find_farthest(course)[1]) / tolerances.STILL
    if not reshaped and MotionKind.ROTATE not in beside:
        for part in (view.course(first, last, end) for end in view.report.parts):
            moved = norm(find_farthest(part)[1]) / (1.5 * tolerances.STILL) if part else 0.0
            ratios["moves at one end"] = max(moved, ratios.get("moves at one end", 0.0))
        if turns := view.turns(first, last):
            ratios["turns"] = norm(find_farthest(turns)[1]) / tolerances.STILL_DEGREES
    for axis in [] if reshaped else view.visible_axes:
        if strains := view.strains(axis, first, last):
            largest = max(abs(value) for _, value in strains) / tolerances.STILL_STRAIN
            ratios["deforms"] = max(largest, ratios.get("deforms", 0.0))
    return ratios
