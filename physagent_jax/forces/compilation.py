"""From dimensionless JSON to terms with units (paper, appendix A.2).

Each entry is bound to particles and seconds (`forces.binding`), and its skill (`forces.skills`) makes the forces and
constraints. The numbers of a force field may be given apart from it and traced (`forces.parameters`).
"""

from __future__ import annotations

import numpy as np

from physagent_jax.forces.binding import Binding, Circumstances
from physagent_jax.forces.pairs import find_pairs
from physagent_jax.forces.parameters import ForceFieldParameters, check_entries
from physagent_jax.forces.responses import scale_entry
from physagent_jax.forces.schema import Action, ForceField, SkillScaling
from physagent_jax.forces.skills import get_skill
from physagent_jax.forces.swinging import find_strokes
from physagent_jax.mpm.protocols import Constraint


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
        stroke = strokes.get(index) if group == "actions" else None
        about = Circumstances(scale_entry(scaling, entry), frame_dt, frame_count, stroke, turned)
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
    return tuple(forces), tuple(constraints)


def _is_turned_meanwhile(action: Action, field: ForceField) -> bool:
    """Return whether a skill about an axis acts at the same time."""
    first, last = action.active_time or (0.0, np.inf)
    spans = [a.active_time or (0.0, np.inf) for a in field.actions if get_skill(a).is_axis]
    return any(begin < last and end > first for begin, end in spans)
