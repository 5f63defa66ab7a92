"""Changes to a force field, each with its reason: what the executor's remedies are made of."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from physagent_jax.agents.matching import Cause
from physagent_jax.agents.rules.parts import bound_to_part, make_part_region
from physagent_jax.agents.rules.tolerances import round_window
from physagent_jax.agents.schema import Check, ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.agents.vectors import add, clamp, cosine, dot, norm, normalise, scale
from physagent_jax.agents.windows import divide_swings
from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import (
    MAGNITUDE_MAX,
    MAGNITUDE_MIN,
    PRESCRIBED_TRAVEL,
    find_reference_time,
)
from physagent_jax.forces.schema import Action, ActionType, ConstraintType, ForceField, VelocityConstraint
from physagent_jax.perception.schema import MotionReport

_BRIEF = 0.15  # of the clip: "briefly", as the lexicon has it
POINTED = 0.95  # cosine from which a vector points where the sentence says
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
        earlier: Force fields of other rounds, each with the factor that their amount of this motion missed by.
    """

    expectation: ExpectedMotion
    expectations: Sequence[ExpectedMotion]
    checks: Sequence[Check]
    force_field: ForceField
    report: MotionReport
    brief: SceneBrief
    earlier: Sequence[tuple[ForceField, float]] = ()

    def seen(self) -> Vector | None:
        """Displacement in the expectation's window, or the rotation as a vector; None if it is not observable."""
        try:
            window = self.report.window(*round_window(self.expectation, self.report.frame_count))
        except KeyError:
            return None
        if self.expectation.kind is not MotionKind.ROTATE:
            return window.peak_displacement if self.expectation.sudden else window.displacement
        if window.rotation_axis is None or window.rotation_degrees is None:
            return None
        return scale(window.rotation_axis, window.rotation_degrees)

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


def travels(cause: Cause) -> bool:
    """Return whether it moves something at a prescribed velocity: what it does is that times how long it lasts."""
    return cause.group == "constraints" and cause.type is not ConstraintType.PARTICLE_IMPULSE


def get_effort(cause: Cause, last: float) -> float:
    """The amount that the response grows with: abs(M), times the frames where a velocity is prescribed."""
    first, end = cause.item.active_time or (0.0, last)
    return abs(cause.item.magnitude) * (end - first if travels(cause) else 1.0)


def _scale(cause: Cause, factor: float, last: float):
    """The entry with ``factor`` times the effort, as far as the range goes."""
    size = clamp(abs(cause.item.magnitude) * factor, MAGNITUDE_MIN, MAGNITUDE_MAX)
    changes: dict = {"magnitude": round(math.copysign(size, cause.item.magnitude), 4)}
    if travels(cause) and cause.item.active_time is not None:
        first, end = cause.item.active_time
        hold_end = getattr(cause.item, "held_until", None)
        rest = factor * abs(cause.item.magnitude) / size
        until = clamp(
            float(round(first + rest * (end - first))), first + 1.0, hold_end or max(last, first + 1.0)
        )
        changes |= {
            "active_time": (first, until),
            "held_until": hold_end if hold_end and hold_end > until else None,
        }
    return cause.item.model_copy(update=changes)


def scale_magnitudes(case: Case, causes: Sequence[Cause], factor: float) -> Change:
    """Multiply the magnitudes, inside their range; what has a prescribed velocity also moves longer or shorter."""
    items = [_scale(cause, factor, case.last) for cause in causes]
    field = replace_items(case.force_field, causes, items)
    sizes = ", ".join(f"{item.magnitude:g}" for item in items)
    why = f"The magnitude of {format_names(causes)} becomes {sizes} (asked for: x {factor:.2g})"
    largest = max(abs(item.magnitude) for item in items)
    if factor > 1 and largest >= MAGNITUDE_MAX - 1e-9:
        why += f"; it cannot be made stronger than {MAGNITUDE_MAX:g}"
    elif factor < 1 and largest <= MAGNITUDE_MIN + 1e-9:
        why += f"; it cannot be made weaker than {MAGNITUDE_MIN:g}"
    return Change(field, why + ".", "magnitude_range")


def remove(case: Case, causes: Sequence[Cause], why: str) -> Change:
    """Remove entries."""
    field = replace_items(case.force_field, causes, [None] * len(causes))
    return Change(field, f"{format_names(causes)} removed: {why}.")


def point(case: Case, causes: Sequence[Cause]) -> Change:
    """Points causes where the sentence says; only the sign of those that go exactly the other way is changed."""
    told = case.expectation.direction
    items = []
    for cause in causes:
        flipped = told is None or case.expectation.kind in AXIAL or cosine(cause.direction, told) < -POINTED
        changes = (
            {"magnitude": -cause.item.magnitude}
            if flipped
            else {"vector": told, "magnitude": abs(cause.item.magnitude)}
        )
        items.append(cause.item.model_copy(update=changes))
    words = case.expectation.words
    why = f"{format_names(causes)} went against '{words}': reversed, or pointed where the sentence says."
    return Change(replace_items(case.force_field, causes, items), why, "sentence_direction")


def counter(case: Case, causes: Sequence[Cause]) -> Change | None:
    """Turn the vector by the angle by which the seen direction misses, the other way; None if nothing is seen.

    The hard rules move it to the nearest sum of base directions.
    """
    told, seen = case.expectation.direction, case.seen()
    if told is None or seen is None or norm(seen) < 0.03 or case.expectation.kind in AXIAL:
        return None
    missed = normalise(add([normalise(seen) or told, scale(told, -dot(normalise(seen) or told, told))]))
    if missed is None:
        return None
    angle = math.acos(clamp(cosine(seen, told), -1.0, 1.0))
    vector = normalise(add([scale(told, math.cos(angle)), scale(missed, -math.sin(angle))]))
    if vector is None or math.degrees(angle) > 100:
        return None
    items = [
        cause.item.model_copy(update={"vector": vector, "magnitude": abs(cause.item.magnitude)})
        for cause in causes
    ]
    beside = f"{math.degrees(angle):.0f} degrees beside '{case.expectation.words}'"
    why = f"It went {beside}: {format_names(causes)} is turned"
    return Change(
        replace_items(case.force_field, causes, items), f"{why} as far the other way.", "directional_rigidity"
    )


def retime(case: Case, causes: Sequence[Cause]) -> Change | None:
    """Move causes into the window in which the motion should be seen; None if that has no length."""
    window = _get_window(case)
    if window is None:
        return None
    items = []
    for cause in causes:
        first, last = cause.item.active_time or (0.0, case.last)
        span = (window[0], window[0] + 1.0) if is_blow(cause) else window
        if travels(cause):
            span = (window[0], min(window[0] + (last - first), window[1]))
        changes: dict = {"active_time": span}
        if travels(cause):
            changes["held_until"] = window[1] if window[1] > span[1] else None
        items.append(cause.item.model_copy(update=changes))
    why = (
        f"{format_names(causes)} acted at the wrong time: it acts from frame {window[0]:g} to {window[1]:g}."
    )
    return Change(replace_items(case.force_field, causes, items), why, "window_in_clip")


def is_blow(cause: Cause) -> bool:
    """Return whether it acts in an instant."""
    return cause.type in (ActionType.IMPULSE, ConstraintType.PARTICLE_IMPULSE)


def is_mistimed(case: Case, cause: Cause) -> bool:
    """Return whether an entry acts mostly outside of the window, or in less than a third of it."""
    window = _get_window(case)
    if window is None or travels(cause):
        return False
    first, last = cause.item.active_time or (0.0, case.last)
    if is_blow(cause):
        return abs(first - window[0]) > 0.2 * (window[1] - window[0]) + 1.0
    if case.brief.anchored is not None and not case.expectation.released and last >= window[1]:
        later = [e.window[0] for e in case.expectations if e.window[0] > case.expectation.window[0] + 0.5]
        if last <= min([*later, case.last]):
            return (
                abs(first - window[0]) > 0.2 * (window[1] - window[0]) + 1.0
            )  # it is kept where it was brought
    shared = max(0.0, min(last, window[1]) - max(first, window[0]))
    return shared < 0.6 * (last - first) or shared < 0.3 * (window[1] - window[0])


def make_actions(case: Case) -> list[Action]:
    """The actions that the fixed mapping gives for an expectation."""
    expectation, table = case.expectation, case.brief.directions
    window = _get_window(case)
    magnitude = -expectation.strength if expectation.kind is MotionKind.SQUEEZE else expectation.strength
    if expectation.kind is MotionKind.SWAY:
        return _alternate(case)
    axes = [expectation.direction] if expectation.direction else [table.right, table.up, table.toward]
    if expectation.kind is MotionKind.FALL:
        axes = [table.down]
    elif expectation.kind not in AXIAL:
        axes = axes[:1]
    kind = ActionType.IMPULSE if expectation.sudden else _TYPES[expectation.kind]
    if expectation.sudden and window:
        window = (window[0], window[0] + 1.0)
    region = make_part_region(expectation)
    return [
        Action(action_type=kind, vector=axis, magnitude=magnitude, active_time=window, region=region)
        for axis in axes
    ]


def _get_window(case: Case) -> tuple[float, float] | None:
    first, last = round_window(case.expectation, case.brief.frame_count)
    return (float(first), float(last)) if last > first else None


def _alternate(case: Case, magnitude: float | None = None) -> list[Action]:
    """Push to and fro, as often as expected."""
    expectation = case.expectation
    direction = expectation.direction or case.brief.directions.left
    window = _get_window(case)
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
        for i, part in enumerate(divide_swings(window, count, case.brief.anchored is not None))
    ]


def alternate(case: Case, causes: Sequence[Cause]) -> Change:
    """Replace whatever acts by as many pushes to and fro as the sentence counts."""
    strength = max(abs(cause.item.magnitude) for cause in causes)
    field = replace_items(case.force_field, causes, [None] * len(causes))
    field = field.model_copy(update={"actions": (*field.actions, *_alternate(case, strength))})
    return Change(
        field, f"{format_names(causes)}: replaced by pushes to and fro, {case.expectation.repeats} times."
    )


def lengthen(case: Case, causes: Sequence[Cause], factor: float) -> Iterator[Change]:
    """A saturated push acts for longer: up to where the next motion begins, and from where its own does."""
    if len(causes) != 1:
        return
    later = [e.window[0] for e in case.expectations if e.window[0] >= case.expectation.window[1] - 0.5]
    limit = min([*later, case.last])
    first, last = causes[0].item.active_time or (0.0, case.last)
    end = max(last, min(float(round(first + factor * (last - first))), limit))
    begin = min(first, max(float(round(end - factor * (last - first))), case.expectation.window[0]))
    yield Change(
        replace_items(
            case.force_field, causes, [causes[0].item.model_copy(update={"active_time": (begin, end)})]
        ),
        f"{format_names(causes)} cannot be made stronger: it acts for longer.",
        "window_in_clip",
    )


def enforce(case: Case, causes: Sequence[Cause], gain: float) -> Change:
    """Prescribe the velocity where no admissible force is enough; for M = 1 see `PRESCRIBED_TRAVEL`.

    What is prescribed goes where it points: not beside it, as forces may have been turned to make up for something.
    """
    first, last = round_window(case.expectation, case.brief.frame_count)
    seen, told = case.seen(), case.expectation.direction
    reached = max(dot(seen, told) if seen and told else 0.0, 0.05)
    reference = find_reference_time(False, case.last * case.brief.frame_dt) / case.brief.frame_dt
    size = gain * reached * reference / (PRESCRIBED_TRAVEL * max(last - first, 1))
    constraints = tuple(
        VelocityConstraint(
            constraint_type=ConstraintType.PARTICLE_TRANSLATION,
            vector=told or c.direction,
            magnitude=round(clamp(size, MAGNITUDE_MIN, MAGNITUDE_MAX), 4),
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
    """End the causes earlier: they keep a fraction ``factor`` of their windows."""
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


def keep(case: Case, causes: Sequence[Cause]) -> Iterator[Change]:
    """Keep an object where it was brought until the next motion: hold it, or push it on."""
    begins = [e.window[0] for e in case.expectations if e.window[0] >= case.expectation.window[1] - 0.5]
    limit = min([*begins, case.last])
    items = []
    for cause in causes:
        first, end = cause.item.active_time or (0.0, case.last)
        if travels(cause):
            items.append(cause.item.model_copy(update={"held_until": limit if limit > end else None}))
        elif is_blow(cause) or case.brief.anchored is None and case.expectation.kind not in AXIAL:
            return  # what is free would only go on
        else:
            items.append(cause.item.model_copy(update={"active_time": (first, max(end, limit))}))
    yield Change(
        replace_items(case.force_field, causes, items),
        f"{format_names(causes)} keeps it where it was brought, until frame {limit:g}.",
        "window_in_clip",
    )


def act_on_part(case: Case, causes: Sequence[Cause]) -> Change:
    """Let causes act on the named part alone."""
    field = replace_items(case.force_field, causes, bound_to_part(case.expectation, causes))
    return Change(field, f"{format_names(causes)} acts on the part of '{case.expectation.words}' alone.")


def soften(case: Case, causes: Sequence[Cause]) -> Change:
    """The weakest blow is too strong: a brief push, which reaches less speed in its time."""
    reach = max(2.0, _BRIEF * case.last)
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
