"""Collateral motion: turning, deformation, break-up, leaving the picture, motion at other times.

Limits leave room for what physically goes with the asked motion: a pushed thing turns a little, a blown or dropped one
tumbles, a stretched one gets thinner, a bent one leans, what stands on the ground may tip. They are judged over the
whole clip, once per judgement.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from physagent_jax.agents.rules import tolerances
from physagent_jax.agents.rules.judging.comparing import make_limit_check, make_unseen_check
from physagent_jax.agents.rules.judging.seen import View
from physagent_jax.agents.rules.judging.stages import group_stages
from physagent_jax.agents.schema import Check, ExpectedMotion, MotionKind
from physagent_jax.agents.vectors import add, clamp, cross, dot, norm, normalise, scale
from physagent_jax.core.strict import Vector
from physagent_jax.perception.schema import Box, Matrix

_LASTING = 3  # frames: what is seen for less is noise or a flash
_TEARS = (
    "tear",
    "tore",
    "torn",
    "break",
    "broke",
    "burst",
    "shatter",
    "rip",
    "split",
    "apart",
    "explo",
    "piece",
)
_AXIAL = (MotionKind.STRETCH, MotionKind.SQUEEZE)
_TRAVELS = (MotionKind.MOVE, MotionKind.FALL, MotionKind.SWAY)
_VIOLENT = 1.3  # strength from which leaving the picture at the end is part of it
_LATE = 0.75  # share of the clip

_ASIDE = 0.22  # [body lengths] that a thing may wander while it is only turned or deformed
_TOPPLED = 0.7  # [body lengths] that the centre of what tips over goes: half its height and half its breadth
_TURN_PUSHED = (
    30.0  # [degrees] that a pushed or deformed thing may turn; a little more than is told as a turn
)
_TURN_TUMBLING = 500.0  # [degrees] of what is hit, dropped, or acted on at one end
_TURN_HELD = 70.0  # [degrees] that the affine fit of a bent thing may show
_STRAIN = 0.3  # [1] that a soft thing may deform while it is pushed or turned
_STRAIN_HIT = 0.5  # [1] the same when it lands or is hit, or bends while it is held
_SIZE = 1.35  # times the diagonal of its box: more is breaking up
_EARLY = 0.05  # [body lengths], and the same in degrees / 100 and strain


def check_collateral(view: View) -> list[Check]:
    """Check of everything that was not asked for; they name the first expectation, for want of a better one."""
    asked = [e for e in view.expectations if e.kind is not MotionKind.STILL]
    if not asked:
        return _check_whole(view) + _check_picture(view, asked) + _check_observed(view)
    return [
        *_check_aside(view, asked),
        *_check_turning(view, asked),
        *_check_deformation(view, asked),
        *_check_whole(view),
        *_check_picture(view, asked),
        *_check_observed(view),
        *_check_early(view, asked),
    ]


def _find_lasting(values: Iterable[float]) -> float:
    """The largest value that is reached in some frames, not in one alone."""
    ordered = sorted(values, reverse=True)
    return ordered[min(_LASTING, len(ordered)) - 1] if ordered else 0.0


def _is_rough(view: View, asked: list[ExpectedMotion]) -> bool:
    """Return whether it is hit, dropped, thrown or toppled, after which things tumble."""
    return any(e.sudden or e.kind is MotionKind.FALL for e in asked) or view.force_field.default_drop


def _check_aside(view: View, asked: list[ExpectedMotion]) -> list[Check]:
    """Displacement across all directions that were asked for."""
    course = view.course(0, view.last)
    if not course:
        return []
    up, down = view.brief.directions.up, view.brief.directions.down
    moves = [e for e in asked if e.kind in _TRAVELS]
    if any(e.direction is None and e.kind is not MotionKind.FALL for e in moves):
        return []
    lines = [e.direction or down for e in moves]
    vertical = view.gravity or any(e.kind is MotionKind.FALL for e in asked)
    longest = max(norm(p) for _, p in course)
    limit = _ASIDE if not moves else max(_ASIDE, 0.75 * max(_measure_reach(course, lines), 0.0))
    strains = [e.strength for e in asked if e.kind in _AXIAL]
    if strains and (view.anchored or view.grounded):
        limit += 0.3 * max(strains)  # held at one end, or standing: the centre follows
    if view.grounded and any(e.kind is MotionKind.ROTATE for e in asked):
        limit += 0.35  # it rolls on what it touches
    for way in view.find_topples():  # the centre goes along with the top
        course = [(t, add([p, scale(way, -clamp(dot(p, way), 0.0, _TOPPLED))])) for t, p in course]
    if vertical:  # falls, lands and tips: up and down is judged with half the weight
        course = [(t, add([p, scale(up, -0.5 * dot(p, up))])) for t, p in course]
        if any(e.kind is MotionKind.FALL for e in asked) or view.force_field.default_drop:
            course = [(t, add([p, scale(up, -dot(p, up))])) for t, p in course]
    aside = [(t, _measure_distance(p, lines)) for t, p in course]
    value = _find_lasting(v for _, v in aside)
    words = f"{value:.2g} body lengths" + (f" of {longest:.2g} in all" if moves else "")
    return [
        make_limit_check(
            _blame(view, _find_onset(aside, limit)),
            "does it move where nobody asked it to?",
            f"at most {limit:.2g} body lengths aside"
            if moves
            else f"it stays within {limit:.2g} body lengths",
            words,
            value,
            limit,
            aspect="collateral",
            sigma=view.sigma("displacement"),
            gain=limit / max(value, 1e-6),
            remedy="act more gently, or through the middle of the object",
        )
    ]


def _measure_reach(course, lines: list[Vector]) -> float:
    """Farthest displacement along any of the directions."""
    return max(abs(dot(p, line)) for _, p in course for line in lines) if lines else 0.0


def _measure_distance(p: Vector, lines: list[Vector]) -> float:
    """Length of a vector's part outside of what the lines span."""
    basis: list[Vector] = []
    for line in lines:
        for b in basis:
            line = add([line, scale(b, -dot(line, b))])
        unit = normalise(line) if norm(line) > 0.2 else None
        if unit is not None:
            basis.append(unit)
    for b in basis:
        p = add([p, scale(b, -dot(p, b))])
    return norm(p)


def _check_turning(view: View, asked: list[ExpectedMotion]) -> list[Check]:
    """The whole's rotation where none was asked for; about another axis, if one was."""
    turns = view.turns(0, view.last)
    if not turns:
        return []
    rotations = [e for e in asked if e.kind is MotionKind.ROTATE]
    if any(e.direction is None for e in rotations) or any(
        e.amount and e.amount.unit == "degrees" for e in asked if e.kind is not MotionKind.ROTATE
    ):
        return []
    limit = _TURN_PUSHED
    if view.anchored:
        limit = _TURN_HELD
    if rotations:
        largest = max(norm(v) for _, v in turns)
        limit = max(limit, 0.75 * largest)
    elif any(e.part is not None or e.partial for e in asked) and not view.anchored:
        limit = _TURN_TUMBLING
    if _is_rough(view, asked):
        limit = max(limit, _TURN_HELD if view.anchored else _TURN_TUMBLING)
    axes = [e.direction for e in rotations if e.direction is not None]
    beside = [(t, _measure_distance(v, axes)) for t, v in turns]
    value = _find_lasting(v for _, v in beside)
    return [
        make_limit_check(
            _blame(view, _find_onset(beside, limit)),
            "does it turn about another axis?" if rotations else "does it turn although nobody asked for it?",
            f"at most {limit:.0f} degrees",
            f"{value:.0f} degrees",
            value,
            limit,
            aspect="collateral",
            sigma=view.sigma("rotation"),
            gain=limit / max(value, 1e-6),
            remedy="act through the middle of the object, or more gently",
        )
    ]


def _check_deformation(view: View, asked: list[ExpectedMotion]) -> list[Check]:
    """Principal strains where none was asked for; the volume, if a stretch or squeeze was."""
    tensors = _list_tensors(view)
    if not tensors:
        return []
    axial = [e for e in asked if e.kind in _AXIAL]
    sigma = view.sigma("stretch")
    if axial:
        if any(e.direction is None for e in axial):
            return []
        volumes = [(t, abs(math.log(max(_compute_determinant(S), 1e-6)))) for t, S in tensors]
        volume = _find_lasting(v for _, v in volumes)
        limit = 0.75 + 0.4 * max(e.strength for e in axial)
        return [
            make_limit_check(
                _blame(view, _find_onset(volumes, limit)),
                "does its volume change with it?",
                f"between {math.exp(-limit):.2f} and {math.exp(limit):.2f} times",
                f"by a factor of {math.exp(volume):.2f} up or down",
                volume,
                limit,
                aspect="collateral",
                sigma=2.0 * sigma,
                remedy="deform it more gently",
            )
        ]
    limit = _STRAIN_HIT if view.anchored or _is_rough(view, asked) else _STRAIN
    if any(e.part is not None or e.partial for e in asked):
        limit = max(limit, _STRAIN_HIT)
    hidden = (
        None
        if any(w.stretch_view_axis_observable for w in view.report.windows)
        else view.brief.directions.toward
    )
    strains = [(t, _find_largest_strain(S, hidden)) for t, S in tensors]
    value = _find_lasting(v for _, v in strains)
    return [
        make_limit_check(
            _blame(view, _find_onset(strains, limit)),
            "does its shape change although nobody asked for it?",
            f"by at most {limit:.0%}",
            f"by {value:.0%}",
            value,
            limit,
            aspect="collateral",
            sigma=sigma,
            gain=limit / max(value, 1e-6),
            remedy="act more gently, or make it stiffer",
        )
    ]


def _list_tensors(view: View) -> list[tuple[int, Matrix]]:
    """Stretch tensors with their frames: of every frame, or of the windows at their ends."""
    if view.report.stretch:
        return [(t, S) for t, S in enumerate(view.report.stretch) if S is not None]
    return [(w.last, w.stretch) for w in view.report.windows if w.stretch is not None]


def _find_largest_strain(S: Matrix, hidden: Vector | None) -> float:
    """Largest principal strain [1]; a shrinkage counts by how much its inverse grows.

    A direction that cannot be seen is left out by taking its rows and columns as unchanged.
    """
    if hidden is not None:
        S = _remove(S, hidden)
    high, _, low = find_eigenvalues(S)
    return max(high - 1.0, min(1.0 / max(low, 0.1), 10.0) - 1.0, 0.0)


def _remove(S: Matrix, axis: Vector) -> Matrix:
    """P S P + a a^T, with P the projection across the axis."""
    rows = []
    for i in range(3):
        row = []
        for j in range(3):
            total = axis[i] * axis[j]
            for k in range(3):
                for m in range(3):
                    total += ((i == k) - axis[i] * axis[k]) * S[k][m] * ((m == j) - axis[m] * axis[j])
            row.append(total)
        rows.append((row[0], row[1], row[2]))
    return (rows[0], rows[1], rows[2])


def find_eigenvalues(S: Matrix) -> tuple[float, float, float]:
    """Eigenvalues of a symmetric 3x3 matrix, largest first (Smith 1961, the trigonometric solution)."""
    q = (S[0][0] + S[1][1] + S[2][2]) / 3.0
    off = S[0][1] ** 2 + S[0][2] ** 2 + S[1][2] ** 2
    p = math.sqrt(max(sum((S[i][i] - q) ** 2 for i in range(3)) + 2.0 * off, 0.0) / 6.0)
    if p < 1e-12:
        return q, q, q
    B = [[(S[i][j] - q * (i == j)) / p for j in range(3)] for i in range(3)]
    r = max(-1.0, min(1.0, _compute_determinant(B) / 2.0))
    angle = math.acos(r) / 3.0
    first = q + 2.0 * p * math.cos(angle)
    third = q + 2.0 * p * math.cos(angle + 2.0 * math.pi / 3.0)
    return first, 3.0 * q - first - third, third


def _compute_determinant(rows) -> float:
    a, b, c = rows
    return dot(tuple(a), cross(tuple(b), tuple(c)))  # type: ignore[arg-type]


def _check_whole(view: View) -> list[Check]:
    """Return whether it stays in one piece: pieces that are seen, and the box around them."""
    asked = view.expectations
    torn = any(any(stem in e.words.lower() for stem in _TEARS) for e in asked)
    checks = []
    seen = [(t, float(count)) for t, count in enumerate(view.report.pieces) if count is not None]
    pieces = [count for _, count in seen]
    if pieces and not torn:
        whole = min(pieces[:_LASTING])
        extra = _find_lasting(pieces) - whole
        checks.append(
            make_limit_check(
                _blame(view, _find_onset([(t, n - whole) for t, n in seen], 1.0)),
                "does it stay in one piece?", "no pieces come off",
                f"{extra:.0f} pieces come off" if extra else "none", extra, 0.5,
                aspect="integrity", sigma=0.3, gain=0.6, remedy="act more gently: it breaks",
            )
        )  # fmt: skip
    growth = _measure_growth(view)
    if growth is not None:
        amounts = [e.amount.value for e in asked if e.amount and e.amount.unit == "factor"]
        stretched = [e.strength for e in asked if e.kind is MotionKind.STRETCH]
        limit = _SIZE * max(
            [1.0, *amounts, *(tolerances.pick_band(tolerances.STRETCH, s, "").high + 1 for s in stretched)]
        )
        if any(e.kind is MotionKind.SQUEEZE for e in asked):
            limit *= 1.4  # it bulges
        checks.append(
            make_limit_check(
                _blame(view, _find_onset(_list_growths(view), limit - 1.0)),
                "does it hold together?", f"at most {limit:.2f} times its size",
                f"{growth:.2f} times its size", max(growth - 1.0, 0.0), limit - 1.0,
                aspect="integrity", sigma=view.sigma("stretch"), gain=0.5, remedy="act more gently: it bursts",
            )
        )  # fmt: skip
    return checks


def _measure_growth(view: View) -> float | None:
    """Largest diagonal of the box over that of frame 0, which a rigid turn hardly changes; None if not seen."""
    boxes = [box for box in view.report.box if box is not None]
    if len(boxes) > 1:
        rest = _measure_diagonal(boxes[0])
        return _find_lasting(_measure_diagonal(box) for box in boxes) / max(rest, 1e-6)
    ratios = [w.volume_ratio for w in view.report.windows if w.volume_ratio is not None]
    return max(ratios) ** (1 / 3) if ratios else None


def _list_growths(view: View) -> list[tuple[int, float]]:
    """Growth of the box's diagonal since the first box, frame by frame."""
    boxes = [(t, box) for t, box in enumerate(view.report.box) if box is not None]
    rest = max(_measure_diagonal(boxes[0][1]), 1e-6) if boxes else 1.0
    return [(t, _measure_diagonal(box) / rest - 1.0) for t, box in boxes]


def _measure_diagonal(box: Box) -> float:
    return norm(add([box.high, scale(box.low, -1.0)]))


def _check_picture(view: View, asked: list[ExpectedMotion]) -> list[Check]:
    """Leaving the picture; what is blown away violently may do so at the end."""
    leaves = view.report.quality.leaves_frame
    if leaves == 0:
        return []  # it is cut off by the camera, not by its motion
    if all(place is None for place in view.report.centroid):
        return []  # nobody knows
    far = any(e.strength >= _VIOLENT and e.kind in _TRAVELS for e in asked)
    limit = max((_LATE if far else 0.95) * view.last, 1.0)
    value = float(view.last + 1 if leaves is None else leaves)
    return [
        make_limit_check(
            _blame(view, leaves, _TRAVELS),
            "does it stay in the picture?",
            "to the end" if not far else f"until frame {limit:.0f} at least",
            "it does" if leaves is None else f"it leaves it at frame {leaves}",
            value,
            limit,
            aspect="collateral",
            at_least=True,
            sigma=1.0,
            gain=0.6,
            remedy="act more gently: it leaves the picture",
        )
    ]


def _check_observed(view: View) -> list[Check]:
    """No success for a clip of which a lasting part is not observable; where it leaves the picture is judged there."""
    if view.report.quality.leaves_frame:
        return []
    unseen = [t for t, place in enumerate(view.report.centroid) if place is None]
    if len(unseen) < _LASTING:
        return []
    index = _blame(view, unseen[0])
    why = f"its place is not known in {len(unseen)} of {view.report.frame_count} frames, first in frame {unseen[0]}"
    return [make_unseen_check(index, view.expectations[index], why, "is it seen throughout?")]


def _check_early(view: View, asked: list[ExpectedMotion]) -> list[Check]:
    """Motion before the first that is asked for."""
    begin = min(view.span(e)[0] for e in view.expectations)
    waits = [view.span(e)[1] for e in view.expectations if e.kind is MotionKind.STILL]
    if begin < 4 or waits and min(waits) <= begin:
        return []
    value = _find_lasting(norm(p) for _, p in view.course(0, begin)) / _EARLY
    value = max(value, _find_lasting(norm(v) for _, v in view.turns(0, begin)) / (100.0 * _EARLY))
    return [
        make_limit_check(
            _blame(view, begin),
            "does it wait for its time?",
            f"no visible motion before frame {begin}",
            f"it moves {value:.1f} times as much as can pass for stillness",
            value,
            1.0,
            aspect="order",
            sigma=view.sigma("displacement") / _EARLY,
            remedy=f"let nothing act before frame {begin}",
        )
    ]


def _blame(view: View, begun: int | None = None, kinds: Sequence[MotionKind] = ()) -> int:
    """The expectation that a check is filed under: the strongest cause has most to do with it.

    Args:
        view: What is seen and asked.
        begun: Frame at which it shows; only motions of the last stage that has begun by then are blamed. None = all.
        kinds: Kinds of motion that cause it; stages with one of them go first.
    """
    members = range(len(view.expectations))
    if begun is not None:
        stages = [stage for stage in group_stages(view.expectations) if _is_active(stage, view, begun)]
        causing = [stage for stage in stages if any(view.expectations[i].kind in kinds for i in stage)]
        members = (causing or stages or [members])[-1]
    strengths = {i: _get_strength(view.expectations[i]) for i in members}
    return max(strengths, key=lambda i: strengths[i]) if strengths else 0


def _is_active(stage: Sequence[int], view: View, frame: int) -> bool:
    """Return whether a stage has begun by a frame, and not only by being still."""
    motions = [view.expectations[i] for i in stage]
    moves = any(motion.kind is not MotionKind.STILL for motion in motions)
    return moves and min(view.span(motion)[0] for motion in motions) <= frame


def _get_strength(expectation: ExpectedMotion) -> float:
    return expectation.strength if expectation.kind is not MotionKind.STILL else 0.0


def _find_onset(values: Iterable[tuple[int, float]], limit: float) -> int | None:
    """The first frame at which a value has come half the way to its limit; None if it never does."""
    return next((frame for frame, value in values if value >= 0.5 * limit), None)
