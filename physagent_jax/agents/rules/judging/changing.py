"""Turns, changes of length, and stillness."""

from __future__ import annotations

import math

from physagent_jax.agents.rules import tolerances
from physagent_jax.agents.rules.judging.comparing import (
    compare_amount,
    compare_direction,
    make_limit_check,
    make_unseen_check,
)
from physagent_jax.agents.rules.judging.moving import count_turns, find_track
from physagent_jax.agents.rules.judging.seen import View, find_farthest, find_first_response
from physagent_jax.agents.schema import Check, ExpectedMotion, MotionKind
from physagent_jax.agents.vectors import cross, dot, norm, normalise
from physagent_jax.core.strict import Vector

_FIRST = 0.2  # of the largest turn or strain: what is seen of it first
_OWN_AXIS = 0.6  # of the asked strain that other directions may show the same way
_UPRIGHT = 0.7  # cosine
_OUTLINE = "from the outline"
_KEPT = 0.4  # of the largest turn that a free thing has left where it ends


def check_rotation(index: int, expectation: ExpectedMotion, view: View) -> list[Check]:
    """Sense and axis by first response and by path, and the angle."""
    end, why = find_track(expectation, view)
    if why:
        return [make_unseen_check(index, expectation, why)]
    first, last = view.span(expectation)
    until = view.until(expectation) if expectation.released or not view.anchored else last
    turns = view.turns_asked(expectation, first, until, end)
    turns = turns or view.turns_asked(expectation, first, last, end)
    if not turns:
        return [make_unseen_check(index, expectation, _explain(view, first, last))]
    axis = expectation.direction
    at, peak = find_farthest(turns)
    angle = norm(peak) if axis is None else dot(peak, axis)
    checks = []
    if axis is not None and norm(peak) >= tolerances.VISIBLE_DEGREES:
        spread = max(view.sigma("axis"), 1.0)
        threshold = max(tolerances.VISIBLE_DEGREES, _FIRST * norm(peak), view.uncertainty("rotation"))
        response = find_first_response(turns, threshold)
        if response and response[0] < at:
            checks.append(
                compare_direction(
                    index, expectation, "about which axis does it start to turn?", response[1], view, spread
                )
            )
        checks.append(
            compare_direction(index, expectation, "about which axis does it turn?", peak, view, spread)
        )
    if expectation.repeats > 1:
        path = [dot(v, axis or peak) for _, v in _take_whole_course(view, first, end)]
        checks.append(count_turns(index, expectation, view, path, 0.35 * (max(path) - min(path)) + 1.0))
    if expectation.amount is not None and expectation.amount.unit == "degrees":
        return checks
    tolerance = tolerances.expect_rotation(
        expectation, view.report.frame_count, view.anchored, seconds=view.seconds(first, until)
    )
    moved = view.course(first, last)
    shift = norm(find_farthest(moved)[1]) if moved else 0.0
    instead = (
        f", but a displacement by {shift:.2g} body lengths" if angle < tolerance.low and shift > 0.2 else ""
    )
    words = f"{angle:.0f} degrees about its axis{instead}"
    checks.append(
        compare_amount(index, expectation, "how far does it turn?", tolerance, angle, words, view, "rotation")
    )
    if not view.anchored and end is None and expectation.repeats == 1 and axis and angle >= tolerance.low:
        left = dot(turns[-1][1], axis) / angle
        checks.append(
            make_limit_check(
                index,
                "does it keep its turn?",
                f"at least {_KEPT:.0%} of it left",
                f"{left:.0%} of it left",
                left,
                _KEPT,
                aspect="direction",
                at_least=True,
                sigma=view.sigma("rotation") / angle,
                remedy="let nothing turn it back",
            )
        )
    return checks


def _take_whole_course(view: View, first: int, end):
    return view.turns(first, view.last, end)


def _explain(view: View, first: int, last: int) -> str:
    window = view.window(first, last)
    return (
        window.unobservable.get("rotation_degrees", "its turn is not known")
        if window
        else (f"frames {first} to {last} are not in the motion report")
    )


def check_strain(index: int, expectation: ExpectedMotion, view: View) -> list[Check]:
    """Change of length along the direction: sign by first response, amount, and that it is that direction's own."""
    squeeze = expectation.kind is MotionKind.SQUEEZE
    if expectation.part is not None:
        return [make_unseen_check(index, expectation, "the length of a part is not measured")]
    first, last = view.span(expectation)
    until = view.until(expectation) if expectation.released else last
    strains, how, half_width = measure_strains(expectation, view, first, until)
    if not strains:
        return [make_unseen_check(index, expectation, how)]
    sign = -1.0 if squeeze else 1.0
    along = [(t, sign * strain) for t, strain in strains]
    peak = max((value for _, value in along), key=abs)
    checks = []
    threshold = max(tolerances.VISIBLE_STRAIN, _FIRST * abs(peak), half_width / 2)
    response = next(((t, value) for t, value in along if abs(value - along[0][1]) > threshold), None)
    response = response and (response[0], response[1] - along[0][1])
    if response and len(along) > 2:
        checks.append(
            make_limit_check(
                index,
                "does it get shorter first?" if squeeze else "does it get longer first?",
                "shorter" if squeeze else "longer",
                f"{1 + sign * response[1]:.2f} times its length at frame {response[0]}",
                1.0 + response[1],
                1.0,
                aspect="direction",
                at_least=True,
                sigma=view.sigma("stretch"),
                gain=-1.0,
                remedy=f"reverse {view.causes(expectation) or 'what deforms it'}",
            )
        )
    if expectation.repeats > 1:
        checks.append(_count_strains(index, expectation, view, first))
    if expectation.direction is not None and peak >= tolerances.VISIBLE_STRAIN:
        checks += _check_own_axis(index, expectation, view, until, along, peak)
    if expectation.amount is not None and expectation.amount.unit != "seconds":
        return checks
    tolerance = tolerances.expect_strain(expectation, squeeze)
    question = "how much shorter does it get?" if squeeze else "how much longer does it get?"
    words = f"{1 + sign * peak:.2f} times its length ({how})"
    checks.append(
        compare_amount(
            index, expectation, question, tolerance, peak, words, view, "stretch", half_width=half_width
        )
    )
    return checks


Strains = tuple[list[tuple[int, float]], str, float]


def measure_strains(expectation: ExpectedMotion, view: View, first: int, until: int) -> Strains:
    """Relative change of length per frame, how it was measured or why not, and its half width.

    Along one direction from the affine fit or the outline. In all directions, the mean of three.
    """
    usual = view.uncertainty("stretch")
    window = view.window(first, until)
    why = window.unobservable if window else {}
    lost = why.get("stretch", "its shape is not known")
    if expectation.direction is not None:
        if view.hides(expectation.direction):
            return [], "the stretch along the line of sight is hidden", usual
        strains, how, half_width = _measure_along(expectation.direction, view, first, until)
        strains = _measure_from_rest(expectation, view, strains, first, how)
        return strains, how if strains else lost, half_width
    table = view.brief.directions
    axes = [table.right, table.up, table.toward]
    shown = [view.strains(axis, first, until) for axis in axes if not view.hides(axis)]
    if not all(shown):
        volumes = view.volumes(first, until)
        if len(volumes) < 2:
            return [], lost, usual
        return [(t, max(v, 0.0) ** (1 / 3) - 1.0) for t, v in volumes], "from the bounding box", usual
    values = list(zip(*shown))
    return [(each[0][0], sum(v for _, v in each) / len(each)) for each in values], "in all directions", usual


def _measure_along(direction: Vector, view: View, first: int, until: int) -> Strains:
    """From the affine fit, or from the outline where that has changed by more, the same way.

    The fit goes by points on the surface, of which most may lie where nothing happens: between plates that press the
    ends together, say. Upwards it has to show something too: what stands up (ears, leaves) is thin and bends first.
    """
    strains, usual = view.strains(direction, first, until), view.uncertainty("stretch")
    fitted = dict(strains)
    outline = [point for point in view.outline(direction, first, until) if point[0] in fitted]
    if len(outline) < 2:
        return strains, "from the affine fit", usual
    frame, value, half_width = max(outline, key=lambda point: abs(point[1]) - point[2])
    sure = math.copysign(max(abs(value) - half_width, 0.0), value)
    upright = abs(dot(direction, view.brief.directions.up)) > _UPRIGHT
    least = tolerances.VISIBLE_STRAIN if upright else -tolerances.VISIBLE_STRAIN
    if math.copysign(1.0, value) * fitted[frame] < least or abs(sure) <= abs(fitted[frame]):
        return strains, "from the affine fit", usual
    return [(t, v) for t, v, _ in outline], _OUTLINE, half_width


def _measure_from_rest(
    expectation: ExpectedMotion, view: View, strains: list[tuple[int, float]], first: int, how: str
) -> list[tuple[int, float]]:
    """Relative to rest by the same measure, if it was deformed the other way before: springing back is no stretch."""
    before = []
    if first > 0 and expectation.direction and how == _OUTLINE:
        before = [(t, v) for t, v, _ in view.outline(expectation.direction, 0, first)]
    elif first > 0 and expectation.direction:
        before = view.strains(expectation.direction, 0, first)
    start = before[-1][1] if before and before[-1][0] == first else 0.0
    if (start > 0.0) == (expectation.kind is MotionKind.STRETCH):
        return strains
    return [(t, (1.0 + v) * (1.0 + start) - 1.0) for t, v in strains]


def _count_strains(index: int, expectation: ExpectedMotion, view: View, first: int) -> Check:
    strains, how, _ = measure_strains(expectation, view, first, view.last)
    if len(strains) < 4:
        return make_unseen_check(index, expectation, how or "no course of its shape", "how often?")
    path = [value for _, value in strains]
    return count_turns(index, expectation, view, path, 0.35 * (max(path) - min(path)) + 0.01)


def _check_own_axis(
    index: int,
    expectation: ExpectedMotion,
    view: View,
    until: int,
    along: list[tuple[int, float]],
    peak: float,
) -> list[Check]:
    """Along the direction more than across it: else it swells, shrinks, or bends."""
    direction = expectation.direction
    assert direction is not None
    frame = max(along, key=lambda point: point[1])[0]
    sign = -1.0 if expectation.kind is MotionKind.SQUEEZE else 1.0
    across = []
    for axis in _find_two_across(direction):
        if not view.hides(axis):
            values = dict(view.strains(axis, view.span(expectation)[0], until))
            if frame in values:
                across.append(sign * values[frame])
    if not across or any(e.kind is expectation.kind for e in view.together(expectation)):
        return []
    most = max(across)
    verb = "shorter" if sign < 0 else "longer"
    return [
        make_limit_check(
            index,
            f"is it mainly that direction that gets {verb}?",
            f"others at most {_OWN_AXIS:.0%} of it",
            f"another direction changes by {sign * most:+.2f}, this one by {sign * peak:+.2f}",
            max(most, 0.0),
            _OWN_AXIS * peak,
            aspect="direction",
            sigma=view.sigma("stretch"),
            remedy="scale it along that direction only",
        )
    ]


def _find_two_across(direction: Vector) -> list[Vector]:
    helper = (0.0, 0.0, 1.0) if abs(direction[2]) < 0.9 else (1.0, 0.0, 0.0)
    one = normalise(cross(direction, helper)) or helper
    return [one, cross(direction, one)]


def check_still(index: int, expectation: ExpectedMotion, view: View) -> list[Check]:
    """The largest of displacement, rotation and strain, each in units of what still passes for stillness."""
    first, last = view.span(expectation)
    ratios = {}
    course = view.course(first, last)
    if course:
        ratios["moves"] = norm(find_farthest(course)[1]) / tolerances.STILL
    for end in view.report.parts:
        if part := view.course(first, last, end):
            moved = norm(find_farthest(part)[1]) / (1.5 * tolerances.STILL)
            ratios["moves at one end"] = max(moved, ratios.get("moves at one end", 0.0))
    beside = {e.kind for e in view.together(expectation)}
    reshaped = bool(beside & {MotionKind.STRETCH, MotionKind.SQUEEZE})  # "stretch it while it stays in place"
    if reshaped or MotionKind.ROTATE in beside:
        ratios.pop("moves at one end", None)
    if (turns := view.turns(first, last)) and not (reshaped or MotionKind.ROTATE in beside):
        ratios["turns"] = norm(find_farthest(turns)[1]) / tolerances.STILL_DEGREES
    table = view.brief.directions
    for axis in (table.right, table.up, table.toward):
        if not reshaped and not view.hides(axis) and (strains := view.strains(axis, first, last)):
            largest = max(abs(value) for _, value in strains) / tolerances.STILL_STRAIN
            ratios["deforms"] = max(largest, ratios.get("deforms", 0.0))
    if "moves" not in ratios:
        window = view.window(first, last)
        reason = window.unobservable.get("displacement", "") if window else ""
        return [make_unseen_check(index, expectation, reason or "its place is not known throughout")]
    worst = max(ratios, key=lambda name: ratios[name])
    figure = {"turns": "rotation", "deforms": "stretch"}.get(worst, "displacement")
    unit = {
        "rotation": tolerances.STILL_DEGREES,
        "stretch": tolerances.STILL_STRAIN,
        "displacement": tolerances.STILL,
    }[figure]
    return [
        make_limit_check(
            index,
            "is it still?",
            "no visible motion",
            f"it {worst} {ratios[worst]:.1f} times as much as can pass for stillness",
            ratios[worst],
            1.0,
            aspect="stillness",
            sigma=view.sigma(figure) / unit,
            remedy="remove or counter what moves it in these frames",
        )
    ]
