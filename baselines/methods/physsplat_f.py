"""The semantic agent's force field played open loop; with its options, the ablations of the closed one.

PhysSplat (Zhao et al. 2025, "Sim Anything") has no public code, and leaves forces to its user: this stands for its
place in the comparison of the PhysAgent paper, a guess of the forces by a language model that nothing corrects.
"""

from __future__ import annotations

import dataclasses

from baselines.agents import keep_as_it_is, play_rounds, read_sentence
from baselines.evaluation import Evaluator
from baselines.protocol import Method
from physagent_jax.forces.schema import Action, ActionType, ForceField


@dataclasses.dataclass(frozen=True)
class PhysSplatF(Method):
    """One guess, without typed skills.

    Attributes:
        skills: Whether actions keep their type, region, strength and window; else each is a push of strength 1 over the
            whole clip.
        feedback: Whether planner and executor go on from there; with ``skills`` this is `physagent`.
        rounds: With feedback, at most.
    """

    skills: bool = False
    feedback: bool = False
    rounds: int = 1000

    @property
    def name(self) -> str:
        """As in the registry."""
        return "physsplat_f"

    def search(self, evaluator: Evaluator) -> None:
        """One round, or as many as it takes."""
        play_rounds(
            evaluator,
            read_sentence(evaluator),
            rounds=self.rounds if self.feedback else 1,
            change=keep_as_it_is if self.skills else forget_skills,
        )


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
