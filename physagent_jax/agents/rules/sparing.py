"""Entries of a force field that brought about the stages that were met: a rewrite leaves them as they are."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from physagent_jax.agents.context import Round
from physagent_jax.forces.schema import Action, ForceField, VelocityConstraint
from physagent_jax.motion.edits import Change
from physagent_jax.motion.matching import Cause, agrees, find_causes
from physagent_jax.motion.schema import ExpectedMotion, MotionKind, StageVerdict

Items = tuple[Action, ...] | tuple[VelocityConstraint, ...]


@dataclass(frozen=True)
class Kept:
    """The causes of the stages that were met.

    Attributes:
        items: Entries of the force field.
        default_drop: The force field's gravity, if one of them was a fall; None = gravity may be changed.
    """

    items: tuple[Action | VelocityConstraint, ...] = ()
    default_drop: bool | None = None

    def spare(self, change: Change, before: ForceField) -> Change | None:
        """The change without what it does to these entries; None if nothing is left of it, or it cannot be divided."""
        after = change.force_field
        actions = self._restore(before.actions, after.actions)
        constraints = self._restore(before.constraints, after.constraints)
        restored = after.model_copy(update={"actions": actions, "constraints": constraints})
        present = [*restored.actions, *restored.constraints]
        missing = [item for item in self.items if item not in present]
        if missing or restored == before or self.default_drop not in (None, restored.default_drop):
            return None
        if restored == after:
            return change
        why = f"{change.why} What served a stage that was met stays as it was."
        return dataclasses.replace(change, force_field=restored, why=why)

    def _restore(self, before: Items, after: Items) -> Items:
        """Entries after a change, with these as they were before; as they are if entries came or went."""
        if len(before) != len(after):
            return after
        return tuple(old if old in self.items else new for old, new in zip(before, after))  # type: ignore[return-value]


def find_kept(base: Round, expectations: Sequence[ExpectedMotion], failed: Collection[int]) -> Kept:
    """The causes of the stages that a round met; ``failed`` are the indices of the motions that failed.

    An entry that acts for longer in the time of a failed motion that it can cause is not among them.
    """
    met = [stage for stage in base.judgement.stages if stage.verdict is StageVerdict.MET]
    motions = [expectations[i] for stage in met for i in stage.expectations if i < len(expectations)]
    field = base.force_field
    unmet = [expectations[i] for i in failed]
    wanted = [(motion, {cause.name for cause in find_causes(motion, field)}) for motion in unmet]
    items = {}
    for motion in motions:
        for cause in find_causes(motion, field):
            shared = _measure_share(cause, motion)
            rivals = [_measure_share(cause, other) for other, names in wanted if cause.name in names]
            if agrees(cause, motion) and all(shared > rival for rival in rivals):
                items[cause.name] = cause.item
    falls = any(motion.kind is MotionKind.FALL for motion in motions)
    return Kept(tuple(items.values()), field.default_drop if falls else None)


def _measure_share(cause: Cause, motion: ExpectedMotion) -> float:
    """Frames in which a cause acts in a motion's window."""
    first, last = cause.item.active_time or motion.window
    return max(0.0, min(last, motion.window[1]) - max(first, motion.window[0]))
