"""Directions of a sentence alone: pushes of one strength along what the rules read, without typed skills.

It stands where the PhysAgent paper has "PhysSplat-f", a guess of the forces that nothing corrects. PhysSplat (Zhao et
al. 2025, "Sim Anything") has published no code, and leaves forces to its user; no line of it is here.
"""

from __future__ import annotations

import dataclasses

from baselines.agents import play_rounds, read_sentence
from baselines.evaluation import Evaluator
from baselines.protocol import Method
from physagent_jax.forces.schema import Action, ActionType, ForceField


@dataclasses.dataclass(frozen=True)
class DirectionOnly(Method):
    """Pushes of strength 1 on the whole object over the whole clip.

    Attributes:
        feedback: Whether planner and executor go on from there.
        rounds: With feedback, at most.
    """

    feedback: bool = False
    rounds: int = 1000

    @property
    def name(self) -> str:
        """As in the registry."""
        return "direction_only"

    def search(self, evaluator: Evaluator) -> None:
        """One round, or as many as it takes."""
        rounds = self.rounds if self.feedback else 1
        play_rounds(evaluator, read_sentence(evaluator), rounds=rounds, change=forget_skills)


def forget_skills(force_field: ForceField) -> ForceField:
    """Push along the same directions, each of strength 1 on the whole object over the whole clip."""
    pushes = [
        Action(
            action_type=ActionType.TRANSLATION,
            vector=item.vector,
            magnitude=1.0 if item.magnitude > 0 else -1.0,
        )
        for item in (*force_field.actions, *force_field.constraints)
    ]
    unique = tuple(dict.fromkeys(pushes))
    return ForceField(default_drop=force_field.default_drop, actions=unique)
