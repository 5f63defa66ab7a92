"""Changes to a force field, each with its reason: what the executor's remedies are made of."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from physagent_jax.agents.matching import Cause
from physagent_jax.agents.rules.language.events import make_end_region
from physagent_jax.agents.rules.language.schedule import divide
from physagent_jax.agents.rules.language.timing import BRIEF
from physagent_jax.agents.rules.tolerances import expect_move, expect_strain, round_window
from physagent_jax.agents.schema import Check, ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.agents.vectors import clamp, scale
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN, PRESCRIBED_TRAVEL
from physagent_jax.forces.schema import Action, ActionType, ConstraintType, ForceField, VelocityConstraint
from physagent_jax.perception.schema import MotionReport

_SLAB = 0.85  # where an end slab begins, as a fraction of the extent
_TYPES = {
    MotionKind.MOVE: ActionType.TRANSLATION,
    MotionKind.SWAY: ActionType.TRANSLATION,
    MotionKind.FALL: ActionType.TRANSLATION,
    MotionKind.STRETCH: ActionType.SCALE,
    MotionKind.SQUEEZE: ActionType.SCALE,
    MotionKind.ROTATE: ActionType.TORQUE,
}
AXIAL = (MotionKind.STRETCH, MotionKind.SQUEEZE)


@dataclass(frozen=True)
class Change:
    """A remedy carried out.

    Attributes:
        force_field: The result.
        why: What was changed and why, a sentence.
        rule: The hard rule that it applies, if any.
    """

    force_field: ForceField
    why: str
    rule: str = ""


@dataclass(frozen=True)
class Case:
    """One expectation that was not met.

    Attributes:
        expectation, expectations: It, and all.
        checks: Its failed checks.
        force_field: What was tried.
        report, brief: What was seen, and where.
    """

    expectation: ExpectedMotion
    expectations: Sequence[ExpectedMotion]
    checks: Sequence[Check]
    force_field: ForceField
    report: MotionReport
    brief: SceneBrief

    @property
    def last(self) -> float:
        """Index of the clip's last frame."""
        return float(self.brief.frame_count - 1)

    def failed(self, aspect: str) -> Check | None:
        """The failed check of one aspect."""
        return next((check for check in self.checks if check.aspect == aspect), None)


def replace_items(field: ForceField, causes: Sequence[Cause], items: Sequence) -> ForceField:
    """``field`` with each cause's entry replaced; None removes it."""
    groups = {"actions": list(field.actions), "constraints": list(field.constraints)}
    for cause, item in zip(causes, items):
        groups[cause.group][cause.index] = item
    return field.model_copy(update={k: tuple(i for i in v if i is not None) for k, v in groups.items()})


def format_names(causes: Sequence[Cause]) -> str:
    """The causes' places in the JSON, for people."""
    return ", ".join(cause.name for cause in causes)


def _scaled_magnitude(item, factor: float):
    size = clamp(abs(item.magnitude) * factor, MAGNITUDE_MIN, MAGNITUDE_MAX)
    return item.model_copy(update={"magnitude": round(math.copysign(size, item.magnitude), 4)})


def scale_magnitudes(case: Case, causes: Sequence[Cause], factor: float) -> Change:
    """Multiplies the magnitudes, inside their range."""
    items = [_scaled_magnitude(cause.item, factor) for cause in causes]
    field = replace_items(case.force_field, causes, items)
    sizes = ", ".join(f"{item.magnitude:g}" for item in items)
    return Change(
        field,
        f"The magnitude of {format_names(causes)} becomes {sizes} (asked for: x {factor:.2g}).",
        "magnitude_range",
    )


def make_actions(case: Case) -> list[Action]:
    """The actions that the fixed mapping gives for an expectation."""
    expectation, table = case.expectation, case.brief.directions
    window = _window(case)
    magnitude = -expectation.strength if expectation.kind is MotionKind.SQUEEZE else expectation.strength
    if expectation.kind is MotionKind.SWAY:
        return _alternating(case)
    axes = [expectation.direction] if expectation.direction else [table.right, table.up, table.toward]
    if expectation.kind is MotionKind.FALL:
        axes, magnitude = [table.down], MAGNITUDE_MAX
    elif expectation.kind not in AXIAL:
        axes = axes[:1]
    kind = ActionType.IMPULSE if expectation.sudden else _TYPES[expectation.kind]
    if expectation.sudden and window:
        window = (window[0], window[0] + 1.0)
    return [Action(action_type=kind, vector=axis, magnitude=magnitude, active_time=window) for axis in axes]


def _window(case: Case) -> tuple[float, float] | None:
    first, last = round_window(case.expectation, case.brief.frame_count)
    return (float(first), float(last)) if last > first else None


def _alternating(case: Case, magnitude: float | None = None) -> list[Action]:
    """Pushes to and fro, half a period each, as often as expected."""
    expectation = case.expectation
    direction = expectation.direction or case.brief.directions.left
    window = _window(case)
    if window is None:
        return [Action(action_type=ActionType.TRANSLATION, vector=direction, magnitude=expectation.strength)]
    count = max(1, min(expectation.repeats, int((window[1] - window[0]) / 4.0)))
    return [
        Action(
            action_type=ActionType.TRANSLATION,
            vector=scale(direction, -1.0 if i % 2 else 1.0),
            magnitude=magnitude or expectation.strength,
            active_time=part,
        )
        for i, part in enumerate(divide(window, [1.0] * (2 * count)))
    ]


def alternate(case: Case, causes: Sequence[Cause]) -> Change:
    """Replaces whatever acts by as many pushes to and fro as the sentence counts."""
    strength = max(abs(cause.item.magnitude) for cause in causes)
    field = replace_items(case.force_field, causes, [None] * len(causes))
    field = field.model_copy(update={"actions": (*field.actions, *_alternating(case, strength))})
    return Change(
        field, f"{format_names(causes)}: replaced by pushes to and fro, {case.expectation.repeats} times."
    )


def pull_ends(case: Case, causes: Sequence[Cause]) -> Change:
    """A saturated scale becomes exactly two opposed constraints that move the end slabs apart or together.

    Two slabs that move apart with M during a fraction f of the clip change the length by 2 M f times what M = 1
    moves one of them in a clip (`calibration.PRESCRIBED_TRAVEL`).
    """
    expectation = case.expectation
    axis = expectation.direction or causes[0].item.vector
    window = causes[0].item.active_time
    fraction = (window[1] - window[0]) / max(case.last, 1.0) if window else 1.0
    target = expect_strain(expectation, expectation.kind is MotionKind.SQUEEZE).target
    size = round(
        clamp(target / (2 * PRESCRIBED_TRAVEL * max(fraction, 1e-3)), MAGNITUDE_MIN, MAGNITUDE_MAX), 4
    )
    outward = 1.0 if expectation.kind is MotionKind.STRETCH else -1.0
    pair = tuple(
        VelocityConstraint(
            constraint_type=ConstraintType.PARTICLE_TRANSLATION,
            vector=scale(axis, side * outward),
            magnitude=size,
            active_time=window,
            region=make_end_region(scale(axis, side), _SLAB),
        )
        for side in (1.0, -1.0)
    )
    field = replace_items(case.force_field, causes, [None] * len(causes))
    field = field.model_copy(update={"constraints": (*field.constraints, *pair)})
    return Change(
        field,
        f"{format_names(causes)} cannot be made stronger: two opposed translations of the end slabs instead.",
        "paired_translation",
    )


def make_particle_impulse(case: Case, causes: Sequence[Cause], gain: float) -> Change:
    """A saturated blow becomes velocity constraints of the same kind, as many as the gain needs (at most two)."""
    wanted = gain * abs(causes[0].item.magnitude)
    sizes = [MAGNITUDE_MAX] + (
        [clamp(wanted - MAGNITUDE_MAX, MAGNITUDE_MIN, MAGNITUDE_MAX)] if wanted > MAGNITUDE_MAX else []
    )
    impulses = tuple(
        VelocityConstraint(
            constraint_type=ConstraintType.PARTICLE_IMPULSE,
            vector=cause.item.vector,
            magnitude=round(math.copysign(size, cause.item.magnitude), 4),
            active_time=cause.item.active_time,
            region=cause.item.region,
            object=cause.item.object,
        )
        for cause in causes
        for size in sizes
    )
    field = replace_items(case.force_field, causes, [None] * len(causes))
    field = field.model_copy(update={"constraints": (*field.constraints, *impulses)})
    return Change(
        field,
        f"{format_names(causes)} cannot be made stronger: {len(impulses)} particle impulses instead.",
        "brief_impulse",
    )


def lengthen(case: Case, causes: Sequence[Cause], factor: float) -> Iterator[Change]:
    """A saturated push acts for longer: up to where the next motion begins."""
    later = [e.window[0] for e in case.expectations if e.window[0] >= case.expectation.window[1] - 0.5]
    limit = min([*later, case.last])
    items = []
    for cause in causes:
        first, last = cause.item.active_time or (0.0, case.last)
        items.append(
            cause.item.model_copy(
                update={
                    "active_time": (
                        first,
                        max(last, min(float(round(first + factor * (last - first))), limit)),
                    )
                }
            )
        )
    if len(causes) == 1:
        yield Change(
            replace_items(case.force_field, causes, items),
            f"{format_names(causes)} cannot be made stronger: it acts for longer.",
            "window_in_clip",
        )


def double(case: Case, causes: Sequence[Cause], gain: float) -> Change:
    """A second, parallel action carries what one may not."""
    twins = {"actions": [], "constraints": []}
    for cause in causes:
        rest = clamp(abs(cause.item.magnitude) * (gain - 1.0), MAGNITUDE_MIN, MAGNITUDE_MAX)
        twins[cause.group].append(
            cause.item.model_copy(update={"magnitude": round(math.copysign(rest, cause.item.magnitude), 4)})
        )
    field = case.force_field
    field = field.model_copy(update={k: (*getattr(field, k), *v) for k, v in twins.items()})
    return Change(
        field,
        f"{format_names(causes)} cannot be made stronger: a parallel action carries the rest.",
        "magnitude_range",
    )


def lighten_gravity(case: Case, causes: Sequence[Cause]) -> Change:
    """A throw that gravity swallows: a push downwards instead, as strong as the blow.

    A blow M against a push M rises for half a clip, by a quarter of a body length, and falls back in the
    other half.
    """
    size = max(abs(cause.item.magnitude) for cause in causes)
    first = case.expectation.window[0]
    fall = Action(
        action_type=ActionType.TRANSLATION,
        vector=case.brief.directions.down,
        magnitude=size,
        active_time=(first, case.last) if case.last > first else None,
    )
    field = case.force_field
    field = field.model_copy(update={"default_drop": False, "actions": (*field.actions, fall)})
    return Change(
        field, f"Gravity overcomes {format_names(causes)} at once: a gentler push downwards takes its place."
    )


def is_doubled(case: Case, causes: Sequence[Cause]) -> bool:
    """Whether the causes already come in parallel pairs."""
    keys = [(cause.type, cause.item.vector, cause.item.active_time) for cause in causes]
    return len(set(keys)) < len(keys)


def enforce(case: Case, causes: Sequence[Cause]) -> Change:
    """Prescribes the velocity where no admissible force is enough; for M = 1 see `PRESCRIBED_TRAVEL`."""
    first, last = round_window(case.expectation, case.brief.frame_count)
    target = expect_move(case.expectation, case.brief.frame_count, case.brief.anchored is not None).target
    size = clamp(
        target * case.last / (PRESCRIBED_TRAVEL * max(last - first, 1)), MAGNITUDE_MIN, MAGNITUDE_MAX
    )
    constraints = tuple(
        VelocityConstraint(
            constraint_type=ConstraintType.PARTICLE_TRANSLATION,
            vector=c.item.vector,
            magnitude=round(math.copysign(size, c.item.magnitude), 4),
            active_time=c.item.active_time,
            region=c.item.region,
            object=c.item.object,
        )
        for c in causes[:1]
    )
    field = replace_items(case.force_field, causes, [None] * len(causes))
    field = field.model_copy(update={"constraints": (*field.constraints, *constraints)})
    return Change(
        field,
        f"{format_names(causes)}: no admissible force is enough, its velocity is prescribed.",
        "known_skills",
    )


def shorten(case: Case, causes: Sequence[Cause], factor: float, why: str) -> Change:
    """Ends the causes earlier: they keep a fraction ``factor`` of their windows."""
    items = []
    for cause in causes:
        first, last = cause.item.active_time or (0.0, case.last)
        end = min(max(round(first + factor * (last - first)), first + 1.0), last) if case.last >= 1 else last
        items.append(
            cause.item.model_copy(update={"active_time": (first, end)}) if end > first else cause.item
        )
    return Change(
        replace_items(case.force_field, causes, items),
        f"{format_names(causes)} acts for a shorter time: {why}.",
        "window_in_clip",
    )


def remove_last(case: Case, causes: Sequence[Cause]) -> Change:
    """Removes the last of several causes."""
    field = replace_items(case.force_field, causes[-1:], [None])
    return Change(field, f"{causes[-1].name} is removed: the others do too much already.")


def soften(case: Case, causes: Sequence[Cause]) -> Change:
    """The weakest blow is too strong: a brief push, which reaches less speed in its time."""
    reach = max(2.0, BRIEF * case.last)
    items = [
        cause.item.model_copy(
            update={
                "action_type": ActionType.TRANSLATION,
                "active_time": (cause.item.active_time[0], min(cause.item.active_time[0] + reach, case.last)),
            }
        )
        if cause.item.active_time
        else cause.item
        for cause in causes
    ]
    return Change(
        replace_items(case.force_field, causes, items),
        f"{format_names(causes)}: the weakest blow is too strong, a brief push instead.",
    )
