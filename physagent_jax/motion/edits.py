"""Changes to a force field, each with its reason: what the executor's remedies are made of."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from physagent_jax.core.strict import Vector
from physagent_jax.forces.calibration import (
    GAIN_MAX,
    GAIN_MIN,
    MAGNITUDE_MAX,
    MAGNITUDE_MIN,
    PRESCRIBED_TRAVEL,
)
from physagent_jax.forces.schema import Action, ForceField
from physagent_jax.motion.matching import AXIAL, Cause, find_action_type, make_part_region, redirect
from physagent_jax.motion.schema import Check, MotionKind
from physagent_jax.motion.tolerances import round_window
from physagent_jax.motion.vectors import add, clamp, cosine, dot, norm, normalise, reject, scale
from physagent_jax.motion.windows import divide_swings
from physagent_jax.motion.wishes import Wish, replace_items
from physagent_jax.perception.schema import MotionReport, WindowMotion

_BRIEF = 0.15  # of the clip: "briefly", as the lexicon has it
_FURTHER = 1.5  # factor by which a part may be led farther
_SAME_GAIN = 0.03  # relative change of k that is not worth a word: windows go by whole frames


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

    def adding(self, **entries: Sequence) -> Change:
        """The same with more entries of some groups."""
        more = {group: (*getattr(self.force_field, group), *new) for group, new in entries.items()}
        return replace(self, force_field=self.force_field.model_copy(update=more))


@dataclass(frozen=True)
class Case(Wish):
    """One expectation that was not met.

    Attributes:
        checks: Its failed checks.
        report: The motion that was seen.
        earlier: Force fields of other rounds, each with the factor that their amount of this motion missed by.
    """

    checks: Sequence[Check]
    report: MotionReport
    earlier: Sequence[tuple[ForceField, float]] = ()

    @property
    def seen_window(self) -> WindowMotion | None:
        """The report of the expectation's window; None if there is none."""
        frames = round_window(self.expectation, self.report.frame_count)
        return next((w for w in self.report.windows if (w.first, w.last) == frames), None)

    def seen(self) -> Vector | None:
        """Displacement in the expectation's window, or the rotation as a vector; None if it is not observable."""
        window = self.seen_window
        if window is not None and self.expectation.kind is not MotionKind.ROTATE:
            return window.peak_displacement if self.expectation.sudden else window.displacement
        if window is None or window.rotation_axis is None or window.rotation_degrees is None:
            return None
        return scale(window.rotation_axis, window.rotation_degrees)

    @property
    def next_begin(self) -> float:
        """Frame at which the next motion begins, or the clip's last."""
        end = self.expectation.window[1] - 0.5
        return min([*(e.window[0] for e in self.expectations if e.window[0] >= end), self.brief.last])

    def failed(self, aspect: str) -> Check | None:
        """The failed check of one aspect."""
        return next((check for check in self.checks if check.aspect == aspect), None)


def change_items(
    case: Case, causes: Sequence[Cause], updates: Sequence[dict | None], why: str, rule: str = ""
) -> Change:
    """A change of some fields of each cause; None removes it. ``why`` goes on after the causes' names."""
    items = [None if new is None else c.item.model_copy(update=new) for c, new in zip(causes, updates)]
    return Change(replace_items(case.force_field, causes, items), f"{format_names(causes)}{why}", rule)


def format_names(causes: Sequence[Cause]) -> str:
    """The causes' places in the JSON, for people."""
    return ", ".join(cause.name for cause in causes)


def _scale(cause: Cause, factor: float, latest: float) -> dict:
    """Changes that give the entry ``factor`` times the effort: by M in its range, then by time, and k for the rest.

    ``latest`` is the frame up to which what has a prescribed velocity may go on.
    """
    if cause.turns_limb or cause.leads_part:  # farther, it would be folded or torn off
        factor = min(factor, _FURTHER)
    wanted = abs(cause.item.magnitude) * cause.item.gain * factor  # M times the gain
    size = round(clamp(wanted / cause.item.gain, MAGNITUDE_MIN, MAGNITUDE_MAX), 4)
    changes: dict = {"magnitude": math.copysign(size, cause.item.magnitude)}
    if cause.skill.prescribes and cause.item.active_time is not None:
        first, end = cause.item.active_time
        kept = getattr(cause.item, "held_until", None)
        rest = wanted / (cause.item.gain * size)
        latest = max(kept - 1.0, end) if kept else max(latest, end)  # what is kept in its place stays so
        until = clamp(float(round(first + rest * (end - first))), first + 1.0, latest)
        changes |= {"active_time": (first, until), "held_until": kept if kept and kept > until else None}
        wanted *= (end - first) / (until - first)
    if abs(wanted / (cause.item.gain * size) - 1.0) > _SAME_GAIN:
        changes["gain"] = round(clamp(wanted / size, GAIN_MIN, GAIN_MAX), 4)
    return changes


def scale_magnitudes(case: Case, causes: Sequence[Cause], factor: float) -> Change:
    """Multiply what acts: M inside its range, and beyond it k, which is calibrated again for this entry.

    What has a prescribed velocity moves for longer or shorter before its k is changed.
    """
    begins = [cause.item.active_time[0] for cause in causes if cause.item.active_time]  # of swings back
    ends = [min([case.next_begin, *(b for b in begins if b > case.get_span([c])[0])]) for c in causes]
    updates = [_scale(cause, factor, end) for cause, end in zip(causes, ends)]
    sizes = ", ".join(f"{new['magnitude']:g}" for new in updates)
    why = f": the magnitude becomes {sizes} (asked for: x {factor:.2g})"
    gains = [new["gain"] for new in updates if "gain" in new]
    if gains:
        why += f"; as M stays in its range, k is calibrated again: x {', '.join(f'{g:.3g}' for g in gains)}"
    if any(gain in (GAIN_MIN, GAIN_MAX) for gain in gains):
        why += f"; it cannot be made {'stronger' if factor > 1 else 'weaker'} than that"
    return change_items(case, causes, updates, f"{why}.", "magnitude_range")


def remove(case: Case, causes: Sequence[Cause], why: str) -> Change:
    """Remove entries."""
    return change_items(case, causes, [None] * len(causes), f" removed: {why}.")


def point(case: Case, causes: Sequence[Cause]) -> Change:
    """Point causes where the sentence says; only the sign of those that go exactly the other way is changed."""
    updates = [redirect(cause, case.expectation) for cause in causes]
    why = f" went against '{case.expectation.words}': reversed, or pointed where the sentence says."
    return change_items(case, causes, updates, why, "sentence_direction")


def counter(case: Case, causes: Sequence[Cause]) -> Change | None:
    """Turn the vector by the angle by which the seen direction misses, the other way; None if nothing is seen.

    The hard rules move it to the nearest sum of base directions.
    """
    told, seen = case.expectation.direction, case.seen()
    if told is None or seen is None or norm(seen) < 0.03 or case.expectation.kind in AXIAL:
        return None
    way = normalise(seen) or told
    missed = normalise(reject(way, told))
    angle = math.acos(clamp(cosine(seen, told), -1.0, 1.0))
    if missed is None or math.degrees(angle) > 100:
        return None
    vector = add([scale(told, math.cos(angle)), scale(missed, -math.sin(angle))])
    updates = [{"vector": vector, "magnitude": abs(cause.item.magnitude)} for cause in causes]
    far = f"{math.degrees(angle):.0f} degrees"
    why = f" is turned {far} the other way: it went so far beside '{case.expectation.words}'."
    return change_items(case, causes, updates, why, "directional_rigidity")


def retime(case: Case, causes: Sequence[Cause]) -> Change | None:
    """Move causes into the window in which the motion should be seen; None if that has no length."""
    window, updates = case.window, []
    if window is None:
        return None
    for cause in causes:
        first, last = case.get_span([cause])
        length = 1.0 if cause.skill.is_sudden else last - first if cause.skill.prescribes else math.inf
        span = (window[0], min(window[0] + length, max(window[1], window[0] + 1.0)))
        held = {"held_until": window[1] if window[1] > span[1] else None} if cause.skill.prescribes else {}
        updates.append({"active_time": span} | held)
    why = f" acted at the wrong time: it acts from frame {window[0]:g} to {window[1]:g}."
    return change_items(case, causes, updates, why, "window_in_clip")


def is_mistimed(case: Case, cause: Cause) -> bool:
    """Return whether an entry acts mostly outside of the window, or in less than a third of it."""
    if case.window is None or cause.skill.prescribes:
        return False
    (first, last), (begin, end) = case.get_span([cause]), case.window
    later = [e.window[0] for e in case.expectations if e.window[0] > case.expectation.window[0] + 0.5]
    held = case.brief.anchored is not None and not case.expectation.released
    kept = held and end <= last <= min([*later, case.brief.last])  # where it was brought
    if cause.skill.is_sudden or kept:
        return abs(first - begin) > 0.2 * (end - begin) + 1.0
    shared = max(0.0, min(last, end) - max(first, begin))
    return shared < 0.6 * (last - first) or shared < 0.3 * (end - begin)


def make_actions(case: Case) -> list[Action]:
    """The actions that the fixed mapping gives for an expectation."""
    expectation, table = case.expectation, case.brief.directions
    if expectation.kind is MotionKind.SWAY:
        return _alternate(case)
    window, magnitude = case.window, expectation.strength
    if expectation.kind is MotionKind.SQUEEZE:
        magnitude = -magnitude
    axes = [expectation.direction] if expectation.direction else [table.right, table.up, table.toward]
    if expectation.kind is MotionKind.FALL:
        axes = [table.down]
    elif expectation.kind not in AXIAL:
        axes = axes[:1]
    kind = find_action_type(expectation.kind, expectation.sudden)
    if expectation.sudden and window:
        window = (window[0], window[0] + 1.0)
    region = make_part_region(expectation)
    how = {"magnitude": magnitude, "active_time": window, "region": region}
    return [Action(action_type=kind, vector=axis, **how) for axis in axes]


def _alternate(case: Case, magnitude: float | None = None) -> list[Action]:
    """Push to and fro, as often as expected."""
    expectation = case.expectation
    direction = expectation.direction or case.brief.directions.left
    window, kind = case.window, find_action_type(MotionKind.SWAY)
    if window is None:
        return [Action(action_type=kind, vector=direction, magnitude=expectation.strength)]
    count = max(1, min(expectation.repeats, int((window[1] - window[0]) / 4.0)))
    size, ways = magnitude or expectation.strength, (direction, scale(direction, -1.0))
    swings = divide_swings(window, count, case.brief.anchored is not None)
    return [
        Action(action_type=kind, vector=ways[i % 2], magnitude=size, active_time=part)
        for i, part in enumerate(swings)
    ]


def alternates(case: Case, causes: Sequence[Cause]) -> bool:
    """Return whether pushes go to and fro already, as often as the sentence counts."""
    ordered = sorted(causes, key=lambda cause: cause.item.active_time or (0.0, 0.0))
    turns = sum(cosine(a.direction, b.direction) < 0 for a, b in zip(ordered, ordered[1:]))
    return turns + 1 >= case.expectation.repeats and turns + 1 == len(causes)


def alternate(case: Case, causes: Sequence[Cause]) -> Change:
    """Replace whatever acts by as many pushes to and fro as the sentence counts."""
    strength = max(abs(cause.item.magnitude) for cause in causes)
    why = f": replaced by pushes to and fro, {case.expectation.repeats} times."
    return change_items(case, causes, [None] * len(causes), why).adding(actions=_alternate(case, strength))


def lengthen(case: Case, causes: Sequence[Cause], factor: float) -> Iterator[Change]:
    """A saturated push acts for longer: up to where the next motion begins, and from where its own does."""
    if len(causes) != 1:
        return
    first, last = case.get_span(causes)
    end = max(last, min(float(round(first + factor * (last - first))), case.next_begin))
    begin = min(first, max(float(round(end - factor * (last - first))), case.expectation.window[0]))
    why = " cannot be made stronger: it acts for longer."
    yield change_items(case, causes, [{"active_time": (begin, end)}], why, "window_in_clip")


def enforce(case: Case, causes: Sequence[Cause], gain: float) -> Change:
    """Prescribe the velocity where no admissible force is enough; for M = 1 see `PRESCRIBED_TRAVEL`.

    What is prescribed goes where it points: not beside it, as forces may have been turned to make up for something.
    """
    first, last = round_window(case.expectation, case.brief.frame_count)
    seen, told = case.seen(), case.expectation.direction
    reached = max(dot(seen, told) if seen and told else 0.0, 0.05)
    size = gain * reached * case.reference / (PRESCRIBED_TRAVEL * max(last - first, 1))
    size = round(clamp(size, MAGNITUDE_MIN, MAGNITUDE_MAX), 4)
    where = causes[0].item.model_dump(include={"active_time", "region", "object"})
    hand = causes[0].prescribe(vector=told or causes[0].direction, magnitude=size, **where)
    why = ": no admissible force is enough, its velocity is prescribed."
    return change_items(case, causes, [None] * len(causes), why, "known_skills").adding(constraints=[hand])


def shorten(case: Case, causes: Sequence[Cause], factor: float, why: str) -> Change:
    """End the causes earlier: they keep a fraction ``factor`` of their windows."""
    updates = []
    for cause in causes:
        first, last = case.get_span([cause])
        end = (
            min(max(round(first + factor * (last - first)), first + 1.0), last)
            if case.brief.last >= 1
            else last
        )
        updates.append({"active_time": (first, end)} if end > first else {})
    return change_items(case, causes, updates, f" acts for a shorter time: {why}.", "window_in_clip")


def keep(case: Case, causes: Sequence[Cause]) -> Iterator[Change]:
    """Keep an object where it was brought until the next motion: hold it, or push it on."""
    limit, updates = case.next_begin, []
    for cause in causes:
        first, end = case.get_span([cause])
        if cause.skill.prescribes:
            updates.append({"held_until": limit if limit > end else None})
        elif cause.skill.is_sudden or case.brief.anchored is None and case.expectation.kind not in AXIAL:
            return  # what is free would only go on
        else:
            updates.append({"active_time": (first, max(end, limit))})
    why = f" keeps it where it was brought, until frame {limit:g}."
    yield change_items(case, causes, updates, why, "window_in_clip")


def act_on_part(case: Case, causes: Sequence[Cause]) -> Change:
    """Let causes act on the named part alone."""
    region = make_part_region(case.expectation)
    updates = [{} if region is None or cause.item.region else {"region": region} for cause in causes]
    return change_items(case, causes, updates, f" acts on the part of '{case.expectation.words}' alone.")


def soften(case: Case, causes: Sequence[Cause]) -> Change:
    """The weakest blow is too strong: a brief push, which reaches less speed in its time."""
    kind, reach = find_action_type(case.expectation.kind), max(2.0, _BRIEF * case.brief.last)
    updates = []
    for cause in causes:
        first, _ = case.get_span([cause])
        brief = {"action_type": kind, "active_time": (first, min(first + reach, case.brief.last))}
        updates.append(brief if cause.item.active_time else {})
    return change_items(case, causes, updates, ": the weakest blow is too strong, a brief push instead.")
