"""The planner's comparisons: what was asked of the pictures, what they show, by which factor they miss."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from physagent_jax.agents.matching import is_thrown_up, share_time
from physagent_jax.agents.rules import tolerances
from physagent_jax.agents.rules.comparisons import (
    View,
    compare_amount,
    compare_direction,
    explain_unobservable,
    make_unseen_check,
)
from physagent_jax.agents.schema import Check, ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.agents.vectors import add, cosine, dot, norm, scale
from physagent_jax.core.strict import Vector
from physagent_jax.core.turning import find_turning_points
from physagent_jax.perception.schema import Matrix, WindowMotion

_SAME_WAY = 0.7  # cosine: within 45 degrees
_SAME_AXIS = 0.6
_CAME_BACK = 0.6  # of its largest excursion that may be left after letting go
_UNIAXIAL_VOLUME = 0.4  # volume strain per axial strain at a Poisson's ratio of 0.3


def make_checks(index: int, expectation: ExpectedMotion, view: View) -> list[Check]:
    """All checks of one expectation."""
    window = view.window(expectation)
    if window is None:
        first, last = tolerances.round_window(expectation, view.report.frame_count)
        return [
            make_unseen_check(index, expectation, f"frames {first} to {last} are not in the motion report")
        ]
    if _against_each_other(expectation, view):
        return [
            make_unseen_check(index, expectation, "parts that move against each other are not told apart")
        ]
    checks = _CHECKERS[expectation.kind](index, expectation, window, view)
    return [*checks, *_came_back(index, expectation, window, view)]


def _against_each_other(expectation: ExpectedMotion, view: View) -> bool:
    """Whether another part is to move the other way at the same time: the report measures the whole object."""
    if not expectation.partial or expectation.direction is None:
        return False
    return any(
        other.partial
        and other.kind is expectation.kind
        and other.direction is not None
        and cosine(other.direction, expectation.direction) < -_SAME_WAY
        and share_time(other, expectation)
        for other in view.expectations
    )


def _leaves(window: WindowMotion, view: View) -> bool:
    """Whether the object reaches the border inside the window, so that later displacements are too small."""
    frame = view.report.quality.leaves_frame
    return frame is not None and frame <= window.last


def _move(index: int, expectation: ExpectedMotion, window: WindowMotion, view: View) -> list[Check]:
    """Net displacement; after a blow or a release, the largest one."""
    if window.displacement is None:
        return [make_unseen_check(index, expectation, explain_unobservable(window, "displacement"))]
    seen = window.displacement
    direction = expectation.direction
    if expectation.sudden or expectation.released:
        seen = _farthest(seen, direction, window, view)
    seen = _own_part(seen, expectation, view)
    length = norm(seen)
    along = length if direction is None else dot(seen, direction)
    speed = 0.0 if direction is None else view.speed(window.first, direction)
    tolerance = tolerances.expect_move(
        expectation,
        view.report.frame_count,
        view.anchored,
        speed,
        is_thrown_up(expectation, view.expectations, view.brief),
    )
    if _leaves(window, view) and 0 < along < tolerance.low:
        return [
            make_unseen_check(
                index, expectation, f"it leaves the picture at frame {view.report.quality.leaves_frame}"
            )
        ]
    checks = []
    if direction is not None and length >= view.visible:
        checks.append(compare_direction(index, expectation, cosine(seen, direction), _SAME_WAY, "move", view))
    text = f"{along:.2g} body lengths that way{_instead(window, length)}"
    return [
        *checks,
        compare_amount(index, expectation, "how far does it move?", tolerance, along, text, view),
    ]


def _farthest(seen: Vector, direction: Vector | None, window: WindowMotion, view: View) -> Vector:
    """The displacement at its farthest along the direction, anywhere in the window."""
    centroid = view.report.centroid
    start = centroid[window.first]
    path = [add([p, scale(start, -1.0)]) for p in centroid[window.first : window.last + 1] if p and start]
    path += [d for d in (window.peak_displacement,) if d is not None]
    return max([seen, *path], key=norm if direction is None else lambda v: dot(v, direction))


def _own_part(seen: Vector, expectation: ExpectedMotion, view: View) -> Vector:
    """A displacement without what gravity and other moves at the same time add across its direction."""
    direction = expectation.direction
    if direction is None:
        return seen
    others = [view.brief.directions.down] if view.force_field.default_drop else []
    others += [
        other.direction
        for other in view.expectations
        if other.kind is MotionKind.MOVE and other.direction is not None and share_time(other, expectation)
    ]
    for other in others:
        if abs(dot(other, direction)) < 0.5:
            seen = add([seen, scale(other, -max(dot(seen, other), 0.0))])
    return seen


def _instead(window: WindowMotion, moved: float) -> str:
    """What is seen in place of a displacement."""
    turned = window.rotation_degrees or 0.0
    return f", but a rotation by {turned:.0f} degrees" if moved < 0.05 and turned > 20.0 else ""


def _rotate(index: int, expectation: ExpectedMotion, window: WindowMotion, view: View) -> list[Check]:
    if window.rotation_degrees is None or (window.rotation_axis is None and window.rotation_degrees > 0):
        return [make_unseen_check(index, expectation, explain_unobservable(window, "rotation_degrees"))]
    axis = window.rotation_axis
    angle = window.rotation_degrees
    checks = []
    if axis is not None and expectation.direction is not None:
        similarity = cosine(axis, expectation.direction)
        if angle >= tolerances.VISIBLE_DEGREES:
            checks.append(compare_direction(index, expectation, similarity, _SAME_AXIS, "turn", view))
        angle *= similarity
    tolerance = tolerances.expect_rotation(expectation, view.report.frame_count, view.anchored)
    moved = 0.0 if window.displacement is None else norm(window.displacement)
    instead = (
        f", but a displacement by {moved:.2g} body lengths" if angle < tolerance.low and moved > 0.2 else ""
    )
    text = f"{angle:.0f} degrees about its axis{instead}"
    return [
        *checks,
        compare_amount(index, expectation, "how far does it turn?", tolerance, angle, text, view),
    ]


def _stretch(index: int, expectation: ExpectedMotion, window: WindowMotion, view: View) -> list[Check]:
    strain, how = get_seen_strain(expectation, window, view.brief)
    if strain is None:
        return [make_unseen_check(index, expectation, how)]
    squeeze = expectation.kind is MotionKind.SQUEEZE
    tolerance = tolerances.expect_strain(expectation, squeeze)
    value = -strain if squeeze else strain
    question = "how much shorter does it get?" if squeeze else "how much longer does it get?"
    return [
        compare_amount(
            index, expectation, question, tolerance, value, f"{1 + strain:.2f} times its length ({how})", view
        )
    ]


def get_seen_strain(
    expectation: ExpectedMotion, window: WindowMotion, brief: SceneBrief
) -> tuple[float | None, str]:
    """Relative change of length along the expected direction, and how it was measured (or why not).

    The stretch tensor where it is observable, else the bounding box's volume: its cube root for all
    directions, and for one direction the strain of a bar that contracts sideways.
    """
    direction, tensor = expectation.direction, window.stretch
    if tensor is not None and direction is not None:
        hidden = (
            abs(dot(direction, brief.directions.toward)) > _SAME_WAY
            and not window.stretch_view_axis_observable
        )
        if not hidden:
            return _strain_along(tensor, direction), "from the affine fit"
    if window.volume_ratio is None:
        return None, explain_unobservable(window, "stretch" if tensor is None else "volume_ratio")
    if direction is None:
        return max(window.volume_ratio, 0.0) ** (1 / 3) - 1.0, "from the bounding box"
    return (window.volume_ratio - 1.0) / _UNIAXIAL_VOLUME, "from the bounding box"


def _strain_along(tensor: Matrix, direction: Vector) -> float:
    """n.S.n - 1."""
    return (
        dot((dot(tensor[0], direction), dot(tensor[1], direction), dot(tensor[2], direction)), direction)
        - 1.0
    )


def _sway(index: int, expectation: ExpectedMotion, window: WindowMotion, view: View) -> list[Check]:
    """Excursion and number of turns of the centroid along the direction."""
    points = [p for p in view.report.centroid[window.first : window.last + 1] if p is not None]
    if len(points) < 3:
        return [make_unseen_check(index, expectation, "the centroid is not followed")]
    oscillation = view.report.oscillation
    direction = expectation.direction or (oscillation.direction if oscillation else _main_direction(points))
    path = [dot(p, direction) for p in points]
    amplitude = (max(path) - min(path)) / 2.0
    tolerance = tolerances.expect_sway(expectation)
    amount = compare_amount(
        index,
        expectation,
        "how far does it sway?",
        tolerance,
        amplitude,
        f"{amplitude:.2g} body lengths to either side",
        view,
    )
    turns = len(find_turning_points(path, max(0.25 * amplitude, 0.2 * tolerances.VISIBLE)))
    wanted, most = 2 * expectation.repeats - 1, 4 * expectation.repeats + 3
    enough = wanted <= turns <= most
    fix = f"alternate {view.causes(expectation) or 'pushes'} {expectation.repeats} times to and fro"
    return [
        amount,
        Check(
            expectation=index,
            question="how often does it turn back?",
            aspect="repeats",
            expected=f"{wanted} to {most} times",
            observed=f"{turns} turns",
            passed=enough,
            score=1.0 if enough else round(0.9 * min(turns / wanted, most / max(turns, 1)), 6),
            remedy="" if enough else fix,
        ),
    ]


def _main_direction(points: Sequence[Vector]) -> Vector:
    """Direction of the largest excursion from the first point."""
    return max((add([p, scale(points[0], -1.0)]) for p in points), key=norm)


def _fall(index: int, expectation: ExpectedMotion, window: WindowMotion, view: View) -> list[Check]:
    if window.displacement is None:
        return [make_unseen_check(index, expectation, explain_unobservable(window, "displacement"))]
    down = view.brief.directions.down
    fallen = max(dot(d, down) for d in (window.displacement, window.peak_displacement) if d is not None)
    tolerance = tolerances.expect_fall(expectation, view.report.frame_count)
    check = compare_amount(
        index,
        expectation,
        "how far does it fall?",
        tolerance,
        fallen,
        f"{fallen:.2g} body lengths downwards",
        view,
    )
    if check.passed or view.force_field.default_drop or expectation.window[0] >= 1:
        return [check]
    return [check.model_copy(update={"remedy": "set default_drop to true: gravity is off"})]


def _still(index: int, expectation: ExpectedMotion, window: WindowMotion, view: View) -> list[Check]:
    """The largest of displacement, rotation and strain, each in units of what still passes for stillness."""
    ratios = {}
    moves = [norm(d) for d in (window.displacement, window.peak_displacement) if d is not None]
    if moves:
        ratios["moves"] = max(moves) / tolerances.STILL
    if window.rotation_degrees is not None:
        ratios["turns"] = window.rotation_degrees / tolerances.STILL_DEGREES
    if window.stretch is not None:
        seen_axes = [view.brief.directions.right, view.brief.directions.up]
        seen_axes += [view.brief.directions.toward] if window.stretch_view_axis_observable else []
        strains = [abs(_strain_along(window.stretch, axis)) for axis in seen_axes]
        ratios["deforms"] = max(strains) / tolerances.STILL_STRAIN
    if not ratios:
        return [make_unseen_check(index, expectation, explain_unobservable(window, "displacement"))]
    worst = max(ratios, key=lambda name: ratios[name])
    passed = ratios[worst] <= 1.0
    return [
        Check(
            expectation=index,
            question="is it still?",
            aspect="stillness",
            expected="no visible motion",
            observed=f"it {worst} {ratios[worst]:.1f} times as much as can pass for stillness",
            passed=passed,
            score=1.0 if passed else round(0.9 / ratios[worst], 6),
            remedy="" if passed else "remove or counter what moves it in these frames",
        )
    ]


def _came_back(index: int, expectation: ExpectedMotion, window: WindowMotion, view: View) -> list[Check]:
    """After letting go, held objects and deformations come back towards rest; a free object drifts on."""
    if not expectation.released or window.last >= view.report.frame_count - 1:
        return []
    if expectation.kind in (MotionKind.STRETCH, MotionKind.SQUEEZE):
        largest, left = _strain_left(expectation, window, view)
    elif view.anchored and expectation.kind is MotionKind.MOVE and expectation.direction is not None:
        largest, left = _displacement_left(expectation.direction, window, view)
    else:
        return []
    if largest is None or left is None or largest < tolerances.VISIBLE:
        return []
    share = left / largest
    passed = share <= _CAME_BACK
    return [
        Check(
            expectation=index,
            question="does it come back after letting go?",
            aspect="return",
            expected=f"at most {_CAME_BACK:.0%} of its excursion left",
            observed=f"{share:.0%} of it left",
            passed=passed,
            score=1.0 if passed else round(0.9 * _CAME_BACK / share, 6),
            remedy="" if passed else f"let {view.causes(expectation) or 'the cause'} end earlier",
        )
    ]


def _strain_left(
    expectation: ExpectedMotion, window: WindowMotion, view: View
) -> tuple[float | None, float | None]:
    largest, _ = get_seen_strain(expectation, window, view.brief)
    left, _ = get_seen_strain(expectation, view.report.windows[0], view.brief)
    return (None if largest is None else abs(largest)), (None if left is None else abs(left))


def _displacement_left(
    direction: Vector, window: WindowMotion, view: View
) -> tuple[float | None, float | None]:
    points = view.report.centroid[window.first :]
    path = [dot(p, direction) for p in points if p is not None]
    if len(path) < 2 or points[0] is None or points[-1] is None:
        return None, None
    return max(path) - path[0], abs(path[-1] - path[0])


_CHECKERS: dict[MotionKind, Callable[[int, ExpectedMotion, WindowMotion, View], list[Check]]] = {
    MotionKind.MOVE: _move,
    MotionKind.ROTATE: _rotate,
    MotionKind.STRETCH: _stretch,
    MotionKind.SQUEEZE: _stretch,
    MotionKind.SWAY: _sway,
    MotionKind.FALL: _fall,
    MotionKind.STILL: _still,
}
