"""The hard rules: what every force field must satisfy, whoever wrote it (paper, appendix B.2).

A rule is a pure function from the entries of a force field, as plain JSON data, to repaired entries and
the reasons for each repair. `apply_hard_rules` runs all of them in the order of `RULES` and validates;
it accepts a `ForceField` or raw JSON, so that a language model's reply is mended by the same rules.
"""

from __future__ import annotations

import copy
import functools
import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from physagent_jax.core.strict import Vector, normalise_direction, read_numbers
from physagent_jax.forces import schema as forces
from physagent_jax.forces.calibration import GAIN_MAX, GAIN_MIN, MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import ForceField, is_too_short
from physagent_jax.forces.skills import Skill, find_skill
from physagent_jax.forces.slabs import mirror_entry
from physagent_jax.motion.matching import (
    AXIAL,
    Cause,
    agrees,
    find_own_causes,
    list_causes,
    overlaps,
    redirect,
)
from physagent_jax.motion.schema import DirectionTable, ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.motion.stacking import find_room, fits, has_room
from physagent_jax.motion.vectors import add, clamp, cosine, norm, normalise, scale

LONGEST_IMPULSE = 2.0  # frames
_GROUPS = {
    "actions": ("action_type", forces.ActionType, forces.Action),
    "constraints": ("constraint_type", forces.ConstraintType, forces.VelocityConstraint),
}
_SAME_VECTOR = 0.9999
_PARALLEL = 0.9
_AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

Entries = dict[str, Any]  # {"default_drop": bool, "actions": [dict], "constraints": [dict]}
Entry = dict[str, Any]


@dataclass(frozen=True)
class Repair:
    """One change that a rule made.

    Attributes:
        rule: The rule's name.
        why: What was wrong and what was done, in a sentence.
    """

    rule: str
    why: str


@dataclass(frozen=True)
class Context:
    """Facts that the rules may use besides the force field.

    Attributes:
        brief: The scene.
        expectations: What the sentence asks for; empty = unknown, and the rules about it rest.
    """

    brief: SceneBrief
    expectations: tuple[ExpectedMotion, ...] = ()

    @functools.cached_property
    def allowed(self) -> list[Vector]:
        """Directions that entries may have."""
        named = [e.direction for e in self.expectations if e.direction is not None]
        lines = [*_AXES, *named]
        both = [*base_directions(self.brief.directions), *lines, *(scale(v, -1.0) for v in lines)]
        return list(dict.fromkeys(both))


Rule = Callable[[Entries, Context], tuple[Entries, list[str]]]


def apply_hard_rules(
    force_field: ForceField | Mapping[str, Any],
    brief: SceneBrief,
    expectations: Sequence[ExpectedMotion] = (),
) -> tuple[ForceField, tuple[Repair, ...]]:
    """The nearest force field that obeys every rule, and what had to be repaired.

    Args:
        force_field: A force field, or JSON data that should have been one.
        brief: The scene.
        expectations: What the sentence asks for.
    """
    entries = (
        force_field.model_dump(mode="json")
        if isinstance(force_field, ForceField)
        else copy.deepcopy(dict(force_field))
    )
    repairs, context = [], Context(brief, tuple(expectations))
    for name, rule in RULES.items():
        entries, reasons = rule(entries, context)
        repairs += [Repair(name, why) for why in reasons]
    return ForceField.model_validate(entries), tuple(repairs)


def base_directions(table: DirectionTable) -> list[Vector]:
    """The six directions and all their normalised sums: the only ones that actions may use."""
    lines = [(table.right, table.left), (table.up, table.down), (table.toward, table.away)]
    choices = itertools.product(*[((0.0, 0.0, 0.0), *line) for line in lines])
    return [unit for choice in choices if (unit := normalise(add(choice)))]


def _on_each(repair: Callable[[Entry, str, Context], Iterator[str]]) -> Rule:
    """A rule about single entries: it changes one in place, or empties what is to be dropped, and says why."""

    @functools.wraps(repair)
    def rule(entries: Entries, context: Context) -> tuple[Entries, list[str]]:
        reasons = [
            f"{group}[{index}]{why}"
            for group in _GROUPS
            for index, item in enumerate(entries[group])
            for why in repair(item, group, context)
        ]
        return entries | {group: [item for item in entries[group] if item] for group in _GROUPS}, reasons

    return rule


def known_skills(entries: Entries, _context: Context) -> tuple[Entries, list[str]]:
    """Only the library's skills and keys: unknown keys are removed, unknown or malformed entries dropped."""
    drop = entries.get("default_drop", False)
    clean: Entries = {"default_drop": drop if isinstance(drop, bool) else str(drop).lower() == "true"}
    foreign = [key for key in entries if key not in ("default_drop", *_GROUPS)]
    reasons = [f"'{key}' is not part of a force field: removed" for key in foreign]
    for group, (type_key, types, model) in _GROUPS.items():
        clean[group] = []
        items = entries.get(group) or []
        for index, item in enumerate(items if isinstance(items, (list, tuple)) else []):
            if not isinstance(item, Mapping) or item.get(type_key) not in [*types]:
                reasons.append(f"{group}[{index}] is not a known skill: dropped")
                continue
            unknown = [key for key in item if key not in model.model_fields]
            reasons += [f"{group}[{index}].{key} is not a field of a skill: removed" for key in unknown]
            clean[group].append({key: value for key, value in item.items() if key not in unknown})
    return clean, reasons


@_on_each
def unit_vectors(item: Entry, _group: str, _context: Context) -> Iterator[str]:
    """||v|| = 1: vectors are normalised; an entry without a usable direction is dropped."""
    vector = read_numbers(item.get("vector"), 3)
    unit = normalise(vector) if vector else None
    if vector is None or unit is None:
        item.clear()
        yield ".vector is no direction: the entry is dropped"
        return
    item["vector"] = list(normalise_direction(vector))
    if abs(math.dist(unit, vector)) > 1e-6:
        yield ".vector is normalised"


@_on_each
def magnitude_range(item: Entry, _group: str, _context: Context) -> Iterator[str]:
    """0.4 <= |M| <= 1.6 with the sign kept, and the gain inside its range; something that is no number becomes 1."""
    told = item.get("magnitude", 1.0)
    given = read_numbers([told], 1)
    value = given[0] if given else 1.0
    item["magnitude"] = kept = math.copysign(clamp(abs(value), MAGNITUDE_MIN, MAGNITUDE_MAX), value)
    if not given or abs(kept - value) > 1e-9:
        yield f".magnitude {told} becomes {kept:g}"
    if "gain" in item:
        told, numbers = item["gain"], read_numbers([item["gain"]], 1)
        item["gain"] = gain = clamp(numbers[0], GAIN_MIN, GAIN_MAX) if numbers else 1.0
        if gain != told:
            yield f".gain {told} becomes {gain:g}"


@_on_each
def window_in_clip(item: Entry, _group: str, context: Context) -> Iterator[str]:
    """0 <= first < last <= last frame; a window that is no window becomes the whole clip."""
    told, end = item.get("active_time"), context.brief.last
    if told is None:
        return
    window, kept = read_numbers(told, 2), None
    if window and end >= 1:
        first, last = clamp(min(window), 0.0, end), clamp(max(window), 0.0, end)
        begin = min(first, end - 1.0)
        kept = [begin, begin + 1.0] if is_too_short(first, last) else [first, last]
    item["active_time"] = kept
    if kept is None or list(window or ()) != kept:
        yield f".active_time {told} becomes {kept or 'the whole clip'}"


@_on_each
def held_until_in_clip(item: Entry, group: str, context: Context) -> Iterator[str]:
    """Hold what was moved somewhere until a frame after its window and inside the clip, or release it."""
    told, window = item.pop("held_until", None), item.get("active_time")
    if told is None:
        return
    given = read_numbers([told], 1)
    if given and window and not _get_skill(group, item).is_sudden:
        until = min(given[0], context.brief.last)
        item |= {"held_until": until} if until > window[1] else {}
    if given is None or item.get("held_until") != given[0]:
        yield f".held_until becomes {item.get('held_until', 'nothing')}"


@_on_each
def known_regions(item: Entry, group: str, _context: Context) -> Iterator[str]:
    """Regions must be well formed: what cannot be read as one is removed, and the whole object is used."""
    try:
        _GROUPS[group][2].model_validate(item)
    except ValidationError as error:
        wrong = {str(detail["loc"][0]) for detail in error.errors() if detail["loc"]}
        for key in sorted(wrong & {"region", "object"}):
            item[key] = None
            yield f".{key} is malformed: removed"


@_on_each
def brief_impulse(item: Entry, group: str, context: Context) -> Iterator[str]:
    """An impulse is sudden: its window spans at most two frames."""
    first, last = item.get("active_time") or (0.0, context.brief.last)
    if _get_skill(group, item).is_sudden and context.brief.last >= 1 and last - first > LONGEST_IMPULSE:
        item["active_time"] = [first, first + 1.0]
        yield f" is an impulse: its window becomes {item['active_time']}"


@_on_each
def directional_rigidity(item: Entry, _group: str, context: Context) -> Iterator[str]:
    """Base vectors are immutable; composites are their normalised sums.

    World axes and the directions that the sentence names are allowed too; anything else is moved to the
    nearest of these. The axis of a turn about a joint follows from how the part points.
    """
    if item.get("pivot"):
        return
    given = tuple(item["vector"])
    nearest = max(context.allowed, key=lambda v: cosine(v, given))
    if cosine(nearest, given) < _SAME_VECTOR:
        item["vector"] = list(nearest)
        yield f".vector is no sum of base directions: moved to {_format(nearest)}"


def no_stacking(entries: Entries, context: Context) -> tuple[Entries, list[str]]:
    """The range holds for the sum of what acts at once along one line: what is at its limit is not stacked.

    Of entries of one kind that pull the same way on the same particles, the first keep their magnitudes; a later one
    gets what is left of the range, or is removed if that is less than the weakest action. Opposed ones neither
    count nor make room.
    """
    reasons: list[str] = []
    kept: list[Cause] = []
    gone: list[Cause] = []
    for cause in _list_causes(entries):
        room, fellows = find_room(cause, kept, context.brief.last)
        if fits(room, cause.item.magnitude):
            kept.append(cause)
            continue
        if has_room(room):
            item = entries[cause.group][cause.index]
            item["magnitude"] = math.copysign(max(room, MAGNITUDE_MIN), item["magnitude"])
            kept.append(Cause(cause.group, cause.index, _GROUPS[cause.group][2].model_validate(item)))
            change = f"its magnitude becomes {item['magnitude']:g}"
        else:
            gone.append(cause)
            change = "removed"
        names = ", ".join(fellow.name for fellow in fellows)
        why = f"{cause.name} adds to {names} along the same line, which cannot be made stronger"
        reasons.append(f"{why} than {MAGNITUDE_MAX:g} in all: {change}")
    return _drop(entries, gone), reasons


def gravity_makes_it_fall(entries: Entries, context: Context) -> tuple[Entries, list[str]]:
    """Let gravity make an object fall, never a downward push with gravity and ground switched off.

    In a world without gravity a later fall has to be a push: gravity would not wait for it.
    """
    falls = [e for e in context.expectations if e.kind is MotionKind.FALL]
    down = context.brief.directions.down
    pushed = [e.direction for e in context.expectations if e.kind is not MotionKind.FALL and e.direction]
    if all(e.window[0] >= 1 for e in falls) or any(cosine(way, down) > _PARALLEL for way in pushed):
        return entries, []
    lasting = [c for c in _list_causes(entries) if "fall" in c.skill.causes and not c.skill.is_sudden]
    downward = [c for c in lasting if c.item.region is None and cosine(c.direction, down) > _PARALLEL]
    sways = [e for e in context.expectations if e.kind is MotionKind.SWAY]
    lowered = [cause for cause in downward if not any(agrees(cause, e) for e in sways)]
    entries = _drop(entries, lowered)
    reasons = [f"{cause.name} pushes down what is to fall: removed, gravity does it" for cause in lowered]
    if context.brief.world == "free" and not entries["default_drop"]:
        entries["default_drop"] = True
        reasons.append("gravity acts on what is to fall: switched on, with the ground below")
    return entries, reasons


def sentence_direction(entries: Entries, context: Context) -> tuple[Entries, list[str]]:
    """Fallback protocol: the fixed mapping from the sentence takes precedence.

    It acts where every cause of an expected motion goes against the sentence; brakes and alternations
    have a cause that agrees, and stay.
    """
    reasons: list[str] = []
    field = ForceField.model_validate(entries)
    for expectation in context.expectations:
        if expectation.kind in (MotionKind.SWAY, MotionKind.FALL, MotionKind.STILL):
            continue
        causes = find_own_causes(expectation, context.expectations, field)
        if any(agrees(cause, expectation) for cause in causes):
            continue
        for cause in causes:
            new = redirect(cause, expectation)
            entries[cause.group][cause.index] |= new
            change = (
                f"its vector becomes {_format(new['vector'])}" if "vector" in new else "its sign is flipped"
            )
            reasons.append(f"{cause.name} goes against '{expectation.words}': {change}")
        if causes:
            field = ForceField.model_validate(entries)
    return entries, reasons


def paired_translation(entries: Entries, context: Context) -> tuple[Entries, list[str]]:
    """A stretch or squeeze by constraints is exactly two, symmetrically opposed.

    A single `enforce_particle_translation` gets its mirror image; of several that are no such pair, the
    first and its mirror image stay. What is squeezed and then stretched has such a pair for each. A part is pressed
    from one side: what lies behind it holds it.
    """
    reasons: list[str] = []
    for expectation in context.expectations:
        if expectation.kind not in AXIAL or expectation.direction is None:
            continue
        if expectation.kind is MotionKind.SQUEEZE and (expectation.partial or expectation.part is not None):
            continue
        acting = [c for c in _list_causes(entries) if overlaps(c, expectation.window)]
        ends = [c for c in acting if c.skill.deforms == "ends" and c.item.region is not None]
        slabs = [c for c in ends if abs(cosine(c.item.vector, expectation.direction)) > _PARALLEL]
        if not slabs or _is_pair(slabs):
            continue
        mirrored, gone = mirror_entry(entries["constraints"][slabs[0].index]), slabs[1:]
        entries = _drop(entries, gone)
        entries["constraints"].append(mirrored)
        partner = f"{slabs[0].name} is given its symmetrically opposed partner"
        reasons.append(f"{partner}; {len(gone)} others are removed")
    return entries, reasons


def _is_pair(slabs: list[Cause]) -> bool:
    sums = add(scale(slab.item.vector, slab.item.magnitude) for slab in slabs)
    return len(slabs) == 2 and norm(sums) < 1e-6 and slabs[0].item.active_time == slabs[1].item.active_time


def _list_causes(entries: Entries) -> list[Cause]:
    return list_causes(ForceField.model_validate(entries))


def _drop(entries: Entries, causes: Sequence[Cause]) -> Entries:
    """The entries without some."""
    gone = {(cause.group, cause.index) for cause in causes}
    kept = {g: [item for i, item in enumerate(entries[g]) if (g, i) not in gone] for g in _GROUPS}
    return entries | kept


def _get_skill(group: str, item: Mapping[str, Any]) -> Skill:
    return find_skill(item[_GROUPS[group][0]])


def _format(vector: Vector) -> str:
    return "[" + ", ".join(f"{c:.3g}" for c in vector) + "]"


# In order: form before content, so that later rules can rely on valid entries.
_ORDERED: tuple[Rule, ...] = (
    *(known_skills, unit_vectors, magnitude_range, window_in_clip, held_until_in_clip, known_regions),
    *(brief_impulse, directional_rigidity, sentence_direction, paired_translation, gravity_makes_it_fall),
    no_stacking,
)
RULES: dict[str, Rule] = {rule.__name__: rule for rule in _ORDERED}
