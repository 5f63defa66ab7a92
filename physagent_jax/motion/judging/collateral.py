"""Collateral motion: turning, deformation, break-up, leaving the picture, motion at other times.

Physics brings along more than a sentence says: a pushed thing turns a little and may tip over, a blown, hit or dropped
one tumbles, a stretched one gets thinner, a bent one leans. A viewer takes that as a part of it. Collateral motion
counts where it hides what was asked (as large as that, broken up, out of the picture) or contradicts it (it spins where
it should slide, rises, or falls over where it should stay upright). It is judged over the whole clip, once per
judgement.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence

from physagent_jax.core.strict import Vector
from physagent_jax.motion import tolerances
from physagent_jax.motion.judging.asked import Asked
from physagent_jax.motion.judging.comparing import check_limit, make_unseen_check
from physagent_jax.motion.judging.posing import UPRIGHT, check_pose
from physagent_jax.motion.judging.seen import Course, Signal, View, find_landing
from physagent_jax.motion.judging.stages import group_stages
from physagent_jax.motion.judging.toppling import find_lean
from physagent_jax.motion.landing import LIMP
from physagent_jax.motion.matching import AXIAL
from physagent_jax.motion.schema import Check, ExpectedMotion, MotionKind
from physagent_jax.motion.vectors import cross, dot, norm, normalise, reject, rotate, scale, subtract
from physagent_jax.perception.schema import Matrix

_LASTING = 3  # frames: what is seen for less is noise or a flash
_TEARS = "tear tore torn break broke burst shatter rip split apart explo piece crack crumbl snap melt".split()
_SHATTERS = re.compile(
    r"(?<!not )(?<!without )\b(shatter|break(s|ing)?\b(?! free| away)|splinter|crumbl|crack(s|ing)?\b|melt|dissolv|"
    r"explod|\w+ pieces|(fall|come)(s|ing)? apart|smash(es|ed|ing)? on\b|(in|to) (bits|shards))"
)
"""Words of who asks that its matter gives way, in whichever clause."""
_SCATTERED = 5.0  # times farther that pieces may fly: those of a glass that bursts lie over five of it
_TRAVELS = (MotionKind.MOVE, MotionKind.FALL, MotionKind.SWAY)
_VIOLENT = 1.3  # strength from which leaving the picture at the end is part of it
_LATE, _END = 0.75, 0.95  # share of the clip

_LEVEL = 0.5  # sine of a way's slope
_ASIDE = 0.22  # [body lengths] that a thing may wander while it is only turned or deformed
_BESIDE = 0.9  # of the way along what was asked that it may go across: less than is another direction
_TOPPLED = 0.7  # [body lengths] that the centre of what tips over goes: half its height and half its breadth
_HALF = 0.5  # [body lengths] of its way as it tips over beside which it may roll aside
_TURN_PUSHED = 30.0  # [degrees] that what is deformed, or pushed in empty space, may turn
_TURN_PRESSED = (
    15.0  # [degrees] the same of what is only pressed as it stands: from more on it is about to fall over
)
_TURN_SAGGING = 45.0  # [degrees] the same of what sags by its own weight
_TURN_SLID = 60.0  # [degrees] about the vertical that what is pushed over the ground may turn
_TURN_TIPPED = (
    120.0  # [degrees] about a level axis of what stands and is pushed over: a quarter turn, and rocking
)
_TURN_TUMBLING = 500.0  # [degrees] of what is hit, dropped, or acted on at one end
_ON_END = 0.9  # cosine of an axis to the vertical, about which what stands turns on its foot
_FALLEN_OVER = 50.0  # [degrees] that what turns on its foot may lean
_TURN_HELD = 70.0  # [degrees] that the affine fit of a bent thing may show
_HALF_OF_IT = 0.4  # share of the object that a limb has which bends it all
_BENT_DOUBLE = 80.0  # [degrees]
_STRAIN = 0.4  # [1] that a soft thing may deform while it is pushed
_STRAIN_HIT = 0.6  # [1] the same when it turns, or bends while it is held
_ANOTHER_SIDE = (
    45.0  # [degrees] from which on another side is seen, so that the shape is told from fewer points
)
_SHEARED, _PER_OUTLINE = 0.3, 4.0
"""[1] that a thing may be strained without a change of its outline, and more for each such change: of a flat side that
is seen aslant, no point tells how thick it is."""
_STRAIN_TUMBLING = 1.0
"""[1] of what tumbles, whose far side nobody sees from the start."""
_STRAIN_PRESSED = 3.0  # [1] of what is soft and lands: it is pressed to a quarter, and comes back
_STRAIN_TWISTED = (
    0.75  # [1] of what turns one way at one end and the other way at the other, which no one map fits
)
_SIZE = 1.35  # times the diagonal of its box: more is breaking up
_ZERO = (0.0, 0.0, 0.0)
_EARLY = 0.05  # [body lengths], and the same in degrees / 100 and strain


def check_collateral(view: View) -> list[Check]:
    """Check of everything that was not asked for; they name the first expectation, for want of a better one."""
    asked = [e for e in view.expectations if e.kind is not MotionKind.STILL]
    always = [*_check_whole(view), *_check_picture(view, asked), *_check_observed(view), *check_pose(view)]
    if not asked:
        return always
    before = [*_check_aside(view, asked), *_check_turning(view, asked), *_check_deformation(view, asked)]
    return [*before, *always, *_check_early(view)]


def _find_lasting(values: Iterable[float]) -> float:
    """The largest value that is reached in some frames, not in one alone."""
    ordered = sorted(values, reverse=True)
    return ordered[min(_LASTING, len(ordered)) - 1] if ordered else 0.0


def _check_lasting(
    view: View, name: str, series: Signal, limit: float, sigma: float, gentler: bool = True, **figures: object
) -> list[Check]:
    """Check what lasts of a series against a limit; ``gentler`` asks for as much less of the cause as it exceeds."""
    value = _find_lasting(v for _, v in series)
    gain = limit / max(value, 1e-6) if gentler else None
    return [check_limit(_blame(view, _find_onset(series, limit)), name, value, limit, sigma, gain, **figures)]


def _is_rough(view: View, asked: list[ExpectedMotion]) -> bool:
    """Return whether it is hit, dropped, thrown or toppled, or leaps: things tumble then, and what is loose flaps."""
    rough = any(e.sudden or e.kind is MotionKind.FALL or _leaps(view, e) for e in asked)
    return rough or view.force_field.default_drop


def _leaps(view: View, motion: ExpectedMotion) -> bool:
    """Return whether what stands free goes up and down as a whole, and lands each time."""
    way, whole = motion.direction, motion.part is None and motion.limb is None
    stands = view.grounded and not view.anchored and whole and motion.kind is MotionKind.SWAY
    return stands and way is not None and abs(dot(way, view.brief.directions.up)) > _ON_END


def _is_partial(asked: list[ExpectedMotion]) -> bool:
    return any(e.part is not None or e.partial for e in asked)


def _check_aside(view: View, asked: list[ExpectedMotion]) -> list[Check]:
    """Displacement across all directions that were asked for."""
    course = view.course(0, view.last)
    up, down = view.brief.directions.up, view.brief.directions.down
    moves = [e for e in asked if e.kind in _TRAVELS]
    untold = any(e.direction is None and e.kind is not MotionKind.FALL for e in moves)
    circles = any(e.manner in ("circle", "slash") for e in asked)
    if not course or untold or circles or _comes_apart(view):
        return []
    lines = [e.direction or down for e in moves]
    longest = max(norm(p) for _, p in course)
    reach = max((abs(dot(p, line)) for _, p in course for line in lines), default=0.0)
    along = max((dot(p, way) for _, p in course for way in view.find_topples()), default=0.0)
    reach = max(reach, min(along, _HALF))
    limit = max(_ASIDE, _BESIDE * reach)
    strained = [e for e in asked if e.kind in AXIAL]
    if strained and (view.anchored or view.grounded):  # held at one end, or standing: the centre follows
        told = (e.amount.value for e in strained if e.amount and e.amount.unit == "factor")
        limit += max([0.3 * e.strength for e in strained] + [0.5 * abs(each - 1.0) for each in told])
    if view.grounded and any(e.kind is MotionKind.ROTATE for e in asked):
        limit += 0.35  # it rolls on what it touches
    if strained and view.grounded and not view.anchored and any(e.released for e in strained):
        course = [
            (t, reject(p, up, low=0.0)) for t, p in course
        ]  # what springs back on the ground may leap up
    for way in view.find_topples():  # the centre goes along with the top
        course = [(t, reject(p, way, 0.0, _TOPPLED)) for t, p in course]
    if view.force_field.default_drop or any(e.kind is MotionKind.FALL for e in asked):
        landed = find_landing(course, down)
        course = [(t, _shorten(reject(p, up), _HALF if t > landed else 0.0)) for t, p in course]
    elif (
        view.gravity
    ):  # it lands and tips: that is judged with half the weight, and what is hit may hop as well
        hops = any(e.sudden for e in asked)
        course = [
            (t, subtract(p, scale(up, 0.5 * dot(p, up)) if hops or dot(p, up) < 0 else _ZERO))
            for t, p in course
        ]
    aside = _measure_distances(course, lines)
    name, sigma = "aside" if moves else "away", view.sigma("displacement")
    return _check_lasting(view, name, aside, limit, sigma, longest=longest)


def _shorten(vector: Vector, length: float) -> Vector:
    return scale(normalise(vector) or _ZERO, max(norm(vector) - length, 0.0))


def _measure_distances(course: Course, lines: Sequence[Vector]) -> Signal:
    """Length of each vector's part outside of what the lines span."""
    return [(t, norm(p)) for t, p in _reject_all(course, lines)]


def _reject_all(course: Course, lines: Sequence[Vector]) -> Course:
    """Each vector's part outside of what the lines span."""
    basis: list[Vector] = []
    for line in lines:
        for b in basis:
            line = reject(line, b)
        unit = normalise(line) if norm(line) > 0.2 else None
        if unit is not None:
            basis.append(unit)
    rest = []
    for t, p in course:
        for b in basis:
            p = reject(p, b)
        rest.append((t, p))
    return rest


def _check_turning(view: View, asked: list[ExpectedMotion]) -> list[Check]:
    """The whole's rotation where none was asked for; about another axis, if one was."""
    turns = view.turns(0, view.last)
    rotations = [e for e in asked if e.kind is MotionKind.ROTATE]
    bent = any(e.amount and e.amount.unit == "degrees" for e in asked if e.kind is not MotionKind.ROTATE)
    if not turns or bent or _gives_way(view) or any(e.direction is None for e in rotations):
        return []
    limit = _TURN_HELD if view.anchored else _TURN_PUSHED
    if view.grounded and not view.anchored and all(e.kind is MotionKind.SQUEEZE for e in asked):
        pressed = view.force_field.actions or view.force_field.constraints
        limit = _TURN_PRESSED if pressed else _TURN_SAGGING
    if rotations:
        limit = max(limit, 0.75 * max(norm(v) for _, v in turns))
    if not view.anchored and (_is_rough(view, asked) or (_is_partial(asked) and not rotations)):
        limit = max(limit, _TURN_TUMBLING)
    axes, sigma = [e.direction for e in rotations if e.direction is not None], view.sigma("rotation")
    name, up = "turns_otherwise" if rotations else "turns_unasked", view.brief.directions.up
    upright = all(abs(dot(axis, up)) > _ON_END for axis in axes) and view.grounded and not view.anchored
    if axes and upright and not _is_rough(view, asked) and len(rotations) == len(asked):
        leans = [(t, norm(find_lean(v, up))) for t, v in turns]
        return _check_lasting(view, "falls_over", leans, _FALLEN_OVER, sigma)
    if not _may_tip(view, asked):
        return _check_lasting(view, name, _measure_distances(turns, axes), limit, sigma)
    about = [(t, abs(dot(v, up))) for t, v in _reject_all(turns, axes)]
    over = _measure_distances(turns, [*axes, up])
    spins = _check_lasting(view, name, about, max(limit, _TURN_SLID), sigma)
    tips = _check_lasting(view, "tips", over, max(limit, _TURN_TIPPED), sigma)
    return [*spins, *tips]


def _may_tip(view: View, asked: list[ExpectedMotion]) -> bool:
    """Return whether it stands free and is moved along the ground, so that friction may tip it over."""
    if view.anchored or not view.grounded or UPRIGHT.search(view.sentence.lower()):
        return False
    up = view.brief.directions.up
    return any(
        e.kind is MotionKind.MOVE and e.direction and abs(dot(e.direction, up)) < _LEVEL for e in asked
    )


def _check_deformation(view: View, asked: list[ExpectedMotion]) -> list[Check]:
    """Principal strains where none was asked for; the volume, if a stretch or squeeze was."""
    tensors = [] if view.brief.rigid else _list_tensors(view)  # seen from another side, it only looks changed
    axial = [e for e in asked if e.kind in AXIAL]
    if (
        not tensors
        or any(e.direction is None for e in axial)
        or any(e.manner in ("fold", "hinge") or _is_bent_double(e) for e in asked)
        or all(_is_wheel(view, e) for e in asked)
    ):
        return []
    sigma = view.sigma("stretch")
    if axial:
        volumes = [(t, abs(math.log(max(_compute_determinant(S), 1e-6)))) for t, S in tensors]
        limit = 0.75 + 0.4 * max(e.strength for e in axial)
        factor = math.exp(_find_lasting(v for _, v in volumes))
        figures = {"least": math.exp(-limit), "most": math.exp(limit), "factor": factor}
        return _check_lasting(view, "volume", volumes, limit, 2.0 * sigma, gentler=False, **figures)
    tumbles = _is_rough(view, asked) and not view.anchored
    if _gives_way(view) or tumbles and LIMP.search(view.sentence.lower()):
        return []
    swings = any(e.kind in (MotionKind.ROTATE, MotionKind.SWAY) for e in asked)
    yielding = view.anchored or swings or _is_rough(view, asked) or _is_partial(asked)
    toward = view.brief.directions.toward
    hidden = None if any(w.stretch_view_axis_observable for w in view.report.windows) else toward
    unseen = _list_unseen_sides(view) if swings else set()
    strains = [
        (t, _find_largest_strain(S, hidden) * (_STRAIN_HIT / _STRAIN_TUMBLING if t in unseen else 1.0))
        for t, S in tensors
    ]
    shown = _list_shown_changes(view)
    strains = [(t, min(v, _SHEARED + _PER_OUTLINE * shown[t]) if t in shown else v) for t, v in strains]
    left = (
        _find_left(view, strains)
        if (swings or tumbles) and not view.anchored and not _is_partial(asked) and not view.keeps_dents
        else []
    )
    if left and min(v for _, v in left) > _STRAIN:  # it swings or lands, and is out of shape from then on
        return _check_lasting(view, "shape", left, _STRAIN, sigma)
    twists = sum(e.kind is MotionKind.ROTATE and e.part is not None for e in asked) > 1
    limbs = [view.brief.parts[e.limb] for e in asked if e.limb is not None]
    poked = any(each.touched for each in view.force_field.constraints)
    turned_limb = bool(limbs)  # no one map fits what is led beside what is held
    limit = (
        _STRAIN_PRESSED
        if (tumbles or poked) and view.soft or any(limb.share > _HALF_OF_IT for limb in limbs)
        else _STRAIN_TUMBLING
        if tumbles or turned_limb
        else _STRAIN_TWISTED
        if twists
        else _STRAIN_HIT
        if yielding
        else _STRAIN
    )
    return _check_lasting(view, "shape", strains, limit, sigma)


def _is_wheel(view: View, motion: ExpectedMotion) -> bool:
    """Return whether it turns a piece of its own about its axle, in which nothing bends; alike blades look bent."""
    part = None if motion.limb is None else view.brief.parts[motion.limb]
    return motion.kind is MotionKind.ROTATE and part is not None and bool(part.axle and part.moved.rigid)


def _is_bent_double(motion: ExpectedMotion) -> bool:
    """Return whether it is bent so far that one map of all its points fits it no more."""
    amount = motion.amount if motion.manner == "bend" else None
    return amount is not None and amount.unit == "degrees" and amount.value > _BENT_DOUBLE


def _list_unseen_sides(view: View) -> set[int]:
    """Frames in which it has turned so far out of the picture plane that the shape is told from another side."""
    toward = view.brief.directions.toward
    return {t for t, v in view.turns(0, view.last) if norm(reject(v, toward)) > _ANOTHER_SIDE}


def _list_shown_changes(view: View) -> dict[int, float]:
    """The largest change of the outline's lengths [1], by frame, while it has hardly turned."""
    up, right = view.brief.directions.up, view.brief.directions.right
    lines = [dict(view.lengths(axis, 0, view.last)) for axis in (up, right)]
    upright = [t for t, v in view.turns(0, view.last) if norm(v) < _ANOTHER_SIDE]
    return {t: max(abs(each[t]) for each in lines) for t in upright if all(t in each for each in lines)}


def _find_left(view: View, strains: Signal) -> Signal:
    """Strains at the end of the clip; none where it has turned so far that another side is seen than at first."""
    turns = view.turns(0, view.last)
    if not turns or norm(turns[-1][1]) > _ANOTHER_SIDE:
        return []
    return [(t, v) for t, v in strains if t >= _LATE * view.last]


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
    """P S P + a a^T, with P the projection across the axis a."""
    across = [reject(row, axis) for row in S]  # S P
    columns = [reject(column, axis) for column in zip(*across)]  # (P S P)^T
    x, y, z = (tuple(c + a * b for c, b in zip(column, axis)) for column, a in zip(columns, axis))
    return x, y, z  # type: ignore[return-value]  # symmetric, as S is


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
    shattered = _gives_way(view)
    torn = shattered or any(any(stem in e.words.lower() for stem in _TEARS) for e in asked)
    checks = []
    pieces = [(t, float(count)) for t, count in enumerate(view.report.pieces) if count is not None]
    if pieces and not torn:
        whole = min(count for _, count in pieces[:_LASTING]) + len(_list_taken_off(view))
        extra = [(t, max(count - whole, 0.0)) for t, count in pieces]
        value = _find_lasting(count for _, count in extra)
        seen = f"{value:.0f} pieces come off" if value else "none"
        blamed = _blame(view, _find_onset(extra, 1.0))
        checks.append(check_limit(blamed, "pieces", value, 0.5, 0.3, 0.6, seen=seen))
    growths = _list_growths(view)
    ratios = [w.volume_ratio for w in view.report.windows if w.volume_ratio is not None]
    if len(growths) < 2 and not ratios:
        return checks
    growth = _find_lasting(v for _, v in growths) if len(growths) > 1 else max(ratios) ** (1 / 3)
    amounts = [e.amount.value for e in asked if e.amount and e.amount.unit == "factor"]
    stretched = [e.strength for e in asked if e.kind is MotionKind.STRETCH]
    highest = [tolerances.pick_band(tolerances.STRETCH, s, "").high + 1 for s in stretched]
    limit = _SIZE * max([1.0, *amounts, *highest])
    if any(e.kind is MotionKind.SQUEEZE for e in asked):
        limit *= 1.4  # it bulges
    if shattered:
        limit *= _SCATTERED
    blamed = _blame(view, _find_onset([(t, v - 1.0) for t, v in growths], limit - 1.0))
    figures, sigma = {"most": limit, "growth": growth}, view.sigma("stretch")
    return [*checks, check_limit(blamed, "size", max(growth - 1.0, 0.0), limit - 1.0, sigma, 0.5, **figures)]


def _gives_way(view: View) -> bool:
    """Return whether its shape is lost on purpose: it breaks, crumbles or melts, or a part comes off."""
    return _comes_apart(view) or _SHATTERS.search(view.sentence.lower()) is not None


def _comes_apart(view: View) -> bool:
    """Return whether a part is to come off, or a half, which goes its own way from then on."""
    return any(each.manner in ("detach", "split") for each in view.expectations)


def _list_taken_off(view: View) -> set[int]:
    """The parts that a sentence moves and that nothing joins to the rest: a lid may come off."""
    limbs = {each.limb for each in view.expectations if each.limb is not None}
    return {limb for limb in limbs if view.brief.parts[limb].moved.rigid}


def _list_growths(view: View) -> Signal:
    """Diagonal of the box over that of the first box, or of the same box turned as it is seen to, frame by frame."""
    boxes = [(t, subtract(box.high, box.low)) for t, box in enumerate(view.report.box) if box is not None]
    if not boxes:
        return []
    first, turns = boxes[0][1], dict(view.turns(boxes[0][0], view.last))
    growths, turn = [], _ZERO
    for t, sides in boxes:
        turn = turns.get(t, turn)  # as it was last seen
        axes = [rotate(axis, turn) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
        turned = [sum(abs(axis[k]) * side for axis, side in zip(axes, first)) for k in range(3)]
        growths.append((t, norm(sides) / max(math.hypot(*turned), norm(first), 1e-6)))
    return growths


def _check_picture(view: View, asked: list[ExpectedMotion]) -> list[Check]:
    """Leaving the picture; what is blown away violently may do so at the end."""
    leaves = view.report.quality.leaves_frame
    places = view.report.centroid
    if leaves == 0 or all(place is None for place in places):
        return []  # it is cut off by the camera, not by its motion; or nobody knows
    if places[-1] is not None and _SHATTERS.search(view.sentence.lower()):
        return []  # splinters fly out of it
    far = any(e.strength >= _VIOLENT and e.kind in _TRAVELS for e in asked)
    limit = max((_LATE if far else _END) * view.last, 1.0)
    until = f"until frame {limit:.0f} at least" if far else "to the end"
    value, seen = float(view.last + 1), "it does"
    if leaves is not None:
        value, seen = float(leaves), f"it leaves it at frame {leaves}"
    blamed = _blame(view, leaves, _TRAVELS)
    return [check_limit(blamed, "picture", value, limit, 1.0, 0.6, until=until, seen=seen)]


def _check_observed(view: View) -> list[Check]:
    """No success for a clip of which a lasting part is not observable; where it leaves the picture is judged there."""
    unseen = [t for t, place in enumerate(view.report.centroid) if place is None]
    if view.report.quality.leaves_frame or len(unseen) < _LASTING:
        return []
    why = f"its place is not known in {len(unseen)} of {view.report.frame_count} frames, first in frame {unseen[0]}"
    return [make_unseen_check(_blame(view, unseen[0]), why, "is it seen throughout?")]


def _check_early(view: View) -> list[Check]:
    """Motion before the first that is asked for."""
    begin = min(view.span(e)[0] for e in view.expectations)
    waits = [view.span(e)[1] for e in view.expectations if e.kind is MotionKind.STILL]
    if begin < 4 or waits and min(waits) <= begin:
        return []
    value = _find_lasting(norm(p) for _, p in view.course(0, begin)) / _EARLY
    value = max(value, _find_lasting(norm(v) for _, v in view.turns(0, begin)) / (100.0 * _EARLY))
    sigma = view.sigma("displacement") / _EARLY
    return [check_limit(_blame(view, begin), "waits", value, 1.0, sigma, frame=begin)]


def _blame(view: View, begun: int | None = None, kinds: Sequence[MotionKind] = ()) -> Asked:
    """The motion that a check is filed under: the strongest cause has most to do with it.

    ``begun`` is the frame at which it shows: only motions of the last stage that has begun by then are blamed. Stages
    with a motion of one of the ``kinds`` that cause it go first.
    """
    motions = view.expectations
    members: Sequence[int] = range(len(motions))
    if begun is not None:
        stages = [stage for stage in group_stages(motions) if _is_active(stage, view, begun)]
        causing = [stage for stage in stages if any(motions[i].kind in kinds for i in stage)]
        members = (causing or stages or [members])[-1]
    strengths = {i: motions[i].strength if motions[i].kind is not MotionKind.STILL else 0.0 for i in members}
    index = max(strengths, key=lambda i: strengths[i])
    return Asked(index, motions[index], view)


def _is_active(stage: Sequence[int], view: View, frame: int) -> bool:
    """Return whether a stage has begun by a frame, and not only by being still."""
    motions = [view.expectations[i] for i in stage]
    moves = any(motion.kind is not MotionKind.STILL for motion in motions)
    return moves and min(view.span(motion)[0] for motion in motions) <= frame


def _find_onset(values: Iterable[tuple[int, float]], limit: float) -> int | None:
    """The first frame at which a value has come half the way to its limit; None if it never does."""
    return next((frame for frame, value in values if value >= 0.5 * limit), None)
