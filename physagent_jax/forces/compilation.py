"""From dimensionless JSON to terms with units (paper, appendix A.2).

Each entry is bound to particles and seconds (`forces.binding`), and its skill (`forces.skills`) makes the forces and
constraints. The numbers of a force field may be given apart from it and traced (`forces.parameters`).
"""

from __future__ import annotations

import math

import numpy as np

from physagent_jax.forces.binding import Binding, Circumstances, Tilt
from physagent_jax.forces.pairs import find_pairs
from physagent_jax.forces.parameters import ForceFieldParameters, check_entries
from physagent_jax.forces.responses import scale_entry
from physagent_jax.forces.schema import (
    Action,
    ForceField,
    SkillScaling,
    VelocityConstraint,
    is_carried,
    is_stop,
)
from physagent_jax.forces.skills import STEEP, get_skill
from physagent_jax.forces.swinging import find_strokes
from physagent_jax.forces.upright import Entry, begin_of, end_of, leave_upright
from physagent_jax.mpm.protocols import Constraint

_ASKEW = 1.0  # [rad] from upright, up to which what comes down is set upright
_LEVEL, _PARALLEL = 0.3, 0.99  # vertical component of an axis; cosine of two
_MOST_TILT = np.radians(200)  # turn up to which what stands is led over its edges, and does not roll on


def compile_force_field(
    field: ForceField,
    scaling: SkillScaling,
    rest: np.ndarray,
    volume: np.ndarray,
    *,
    frame_dt: float,
    frame_count: int,
    parameters: ForceFieldParameters | None = None,
) -> tuple[tuple, tuple[Constraint, ...]]:
    """Turn a force field into terms for `Model.forces` and constraints for `Model.constraints`.

    Args:
        field: The agents' force field.
        scaling: What M = 1 means.
        rest: Rest positions of the particles [m], shape (n, 3); its dtype is the terms'.
        volume: Rest volumes [m^3], shape (n,).
        frame_dt: Seconds per frame [s].
        frame_count: Frames of the clip; the last has index frame_count - 1.
        parameters: Numbers in place of the field's own, traced or not. Traced ones are not checked: a window must begin
            inside the clip and end after it begins. Every number of every skill and constraint has a derivative, with
            one exception: velocity constraints begin and end between two substeps; their windows' is zero (but for the
            way that what is held afterwards has gone).

    Raises:
        UserError: A region selects nothing, a window lies outside the clip, an object id is unknown, or the parameters
            are not this field's.
    """
    if parameters is None:
        parameters = ForceFieldParameters.of(field, frame_count)
    check_entries(parameters, field)
    parameters = parameters.with_gains(field)
    forces, constraints = [], []
    strokes = find_strokes(field, parameters.actions, scaling, frame_dt)

    def bind(group: str, index: int) -> Binding:
        entry, values = getattr(field, group)[index], getattr(parameters, group)[index]
        turned = isinstance(entry, Action) and _is_turned_meanwhile(entry, field)
        lies = _is_overturned(entry, field, scaling, frame_dt)
        stroke = strokes.get(index) if group == "actions" else None
        scale, until = scale_entry(scaling, entry), _find_next_begin(entry, field)
        tilt, moved = _find_tilt(entry, field, scaling.rotation * frame_dt)
        again = _is_thrown_before(entry, field)
        turns = _list_turns(entry, field, scaling.rotation, frame_dt)
        about = Circumstances(
            scale, frame_dt, frame_count, stroke, turned, until, tilt, moved, again, lies, turns
        )
        return Binding(entry, values, f"force_field.{group}[{index}]", rest, volume, about)

    pairs = {pair.first: pair for pair in find_pairs(field, scaling, rest)}
    partners = {pair.second for pair in pairs.values()}
    for group in ("actions", "constraints"):
        for index, entry in enumerate(getattr(field, group)):
            bound, skill = bind(group, index), get_skill(entry)
            if group == "actions" or index not in {*pairs, *partners}:
                forces += skill.make_forces(bound)
                constraints += skill.make_constraints(bound)
            elif index in pairs:
                pair = pairs[index]
                other = None if pair.second is None else bind(group, pair.second)
                constraints += skill.make_pair(bound, other, pair.sign)
                forces += bound.keep_balance(released=True)
    return tuple(forces), tuple(constraints)


def _list_turns(
    entry: Action | VelocityConstraint, field: ForceField, rate: float, frame_dt: float
) -> np.ndarray | None:
    """The turns by which the whole is led that carries an entry, as `PrescribedMotion.turns`; None if it is not.

    Args:
        entry: The entry.
        field: All of them.
        rate: Angular velocity of a constraint with M = 1 [rad/s].
        frame_dt: Seconds per frame [s].
    """
    turns = sorted(filter(_turns_whole, field.constraints), key=begin_of) if is_carried(entry) else []
    speeds = [rate * each.magnitude * each.gain * np.asarray(each.vector) for each in turns]
    spans = [(begin_of(each) * frame_dt, end_of(each) * frame_dt) for each in turns]
    return np.asarray([[*speed, *span] for speed, span in zip(speeds, spans)]) if turns else None


def _is_overturned(entry: Entry, field: ForceField, scaling: SkillScaling, frame_dt: float) -> bool:
    """Return whether the whole was turned over before an entry, and not back: nothing keeps it upright then.

    Where the entry is a landing, what was only tilted before the leap lands on its feet, and turns aloft are told by
    their angle: a somersault ends upright.
    """
    others = [each for each in (*field.constraints, *field.actions) if end_of(each) <= begin_of(entry)]
    turns = [each for each in others if get_skill(each).is_axis and abs(each.vector[2]) < _LEVEL]
    whole = [each for each in turns if each.region is None]
    if not is_stop(entry):
        return bool(whole) and not leave_upright(whole, begin_of(entry))
    thrown = max([begin_of(each) for each in _list_throws(field, entry)], default=np.inf)
    tilt, spin, over = np.zeros(3), np.zeros(3), False
    for each in whole:
        size = each.magnitude * each.gain * (end_of(each) - begin_of(each)) * np.asarray(each.vector)
        if get_skill(each).prescribes:
            tilt += scaling.rotation * frame_dt * size
        elif begin_of(each) >= thrown:
            lasts = begin_of(entry) - 0.5 * (begin_of(each) + end_of(each))
            spin += scaling.torque * frame_dt**2 * lasts * size
        else:
            over = True
    aslant = abs(math.remainder(float(np.linalg.norm(spin)), math.tau))
    return over or aslant > _ASKEW or float(np.linalg.norm(tilt)) > _ASKEW


def _find_next_begin(entry: Action | VelocityConstraint, field: ForceField) -> float:
    """Frame at which the next entry after one begins; infinity if none does."""
    begin = (entry.active_time or (0.0,))[0]
    others = [(each.active_time or (0.0,))[0] for each in (*field.actions, *field.constraints)]
    return min((other for other in others if other > begin), default=np.inf)


def _is_thrown_before(entry: Action | VelocityConstraint, field: ForceField) -> bool:
    """Return whether the whole object fell, or a blow threw it up, before an entry."""
    if field.default_drop and begin_of(entry) > 0.5:
        return True
    return bool(_list_throws(field, entry))


def _list_throws(field: ForceField, entry: Entry) -> list[Action]:
    """The blows before an entry that throw all of the object up."""
    blows = [each for each in field.actions if get_skill(each).is_sudden and each.region is None]
    return [
        each
        for each in blows
        if begin_of(each) < begin_of(entry) and np.sign(each.magnitude) * each.vector[2] >= STEEP
    ]


def _find_tilt(
    entry: Action | VelocityConstraint, field: ForceField, rate: float
) -> tuple[Tilt | None, bool]:
    """Turn by which an entry leads the whole, which stood upright before all turns, and whether it has gone elsewhere.

    There is none where something else was done since it stood upright.

    Args:
        entry: The entry.
        field: All of them.
        rate: Turn per frame of a constraint with M = 1 [rad].
    """
    others = [each for each in (*field.constraints, *field.actions) if not is_carried(each)]
    entries = [each for each in others if each is entry or begin_of(each) < end_of(entry) - 0.5]
    entries.sort(key=begin_of)
    starts = [index for index, each in enumerate(entries) if leave_upright(entries[:index], begin_of(each))]
    start = max(starts, default=0)  # there is none for what is carried before all else
    before, turns = entries[:start], entries[start:]
    moved = field.default_drop or not all(get_skill(each).is_axis for each in before)
    if entry not in turns or not all(_turns_whole(each) for each in turns):
        return None, moved
    axes = [np.copysign(1.0, each.magnitude) * np.asarray(each.vector) for each in turns]
    level = all(abs(each[2]) < _LEVEL and abs(axes[0] @ each) > _PARALLEL for each in axes)
    steps = [
        rate * abs(each.magnitude) * each.gain * (end_of(each) - begin_of(each)) * np.sign(axes[0] @ axis)
        for each, axis in zip(turns, axes)
    ]
    tilts = np.cumsum([0.0, *steps])
    first, last = tilts[turns.index(entry) :][:2]
    side = 1.0 if first + last >= 0 else -1.0
    tilt = Tilt(side * axes[0], side * first, side * last)
    return tilt if level and np.abs(tilts).max() <= _MOST_TILT else None, moved


def _turns_whole(entry: Action | VelocityConstraint) -> bool:
    skill = get_skill(entry)
    return skill.is_axis and skill.prescribes and entry.region is None


def _is_turned_meanwhile(action: Action, field: ForceField) -> bool:
    """Return whether a skill about an axis acts at the same time."""
    first, last = action.active_time or (0.0, np.inf)
    spans = [a.active_time or (0.0, np.inf) for a in field.actions if get_skill(a).is_axis]
    return any(begin < last and end > first for begin, end in spans)
