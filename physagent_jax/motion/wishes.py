"""One expected motion beside the force field that is to bring it about, and that field with other entries."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from physagent_jax.forces.schema import Action, ActionType, ForceField, is_stop
from physagent_jax.motion.matching import Cause
from physagent_jax.motion.schema import ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.motion.tolerances import round_window


@dataclass(frozen=True)
class Wish:
    """One expected motion and the force field that is to bring it about.

    Attributes:
        force_field: The force field so far.
        expectation: The motion.
        expectations: All motions of the sentence.
        brief: The scene.
    """

    force_field: ForceField
    expectation: ExpectedMotion
    expectations: Sequence[ExpectedMotion]
    brief: SceneBrief

    @property
    def reference(self) -> float:
        """T of the skills, in frames."""
        return self.brief.reference_seconds / self.brief.frame_dt

    @property
    def window(self) -> tuple[float, float] | None:
        """The motion's window in whole frames; None if it has no length."""
        first, last = round_window(self.expectation, self.brief.frame_count)
        return (float(first), float(last)) if last > first else None

    def get_span(self, causes: Sequence[Cause]) -> tuple[float, float]:
        """First and last frame in which any of some causes acts."""
        spans = [cause.item.active_time or (0.0, self.brief.last) for cause in causes]
        return min(first for first, _ in spans), max(end for _, end in spans)

    def list_other_begins(self) -> list[float]:
        """Frames at which the other motions begin."""
        return [e.window[0] for e in self.list_others()]

    def list_others(self) -> list[ExpectedMotion]:
        """The other motions; of what all of it does, no limb's: that goes along with it."""
        others = [e for e in self.expectations if e is not self.expectation]
        if self.expectation.limb is None:
            others = [e for e in others if e.limb is None]
        return [e for e in others if e.kind is not MotionKind.STILL]

    def about(self, expectation: ExpectedMotion) -> Wish:
        """The same with another motion."""
        return replace(self, expectation=expectation)


def replace_items(field: ForceField, causes: Sequence[Cause], items: Sequence) -> ForceField:
    """``field`` with each cause's entry replaced; None removes it. Landings of other blows than these go."""
    groups = {"actions": list(field.actions), "constraints": list(field.constraints)}
    for cause, item in zip(causes, items):
        groups[cause.group][cause.index] = item
    blows = [each.item for each in causes if isinstance(each.item, Action)]
    if any(blow.action_type is ActionType.IMPULSE for blow in blows):
        groups["constraints"] = [each for each in groups["constraints"] if each is None or not is_stop(each)]
    return field.model_copy(update={k: tuple(i for i in v if i is not None) for k, v in groups.items()})
