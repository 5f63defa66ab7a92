"""Ours: the product's agents, who see pictures and read the sentence."""

from __future__ import annotations

import dataclasses

from baselines.agents import play_rounds, read_sentence
from baselines.evaluation import Evaluator
from baselines.protocol import Method
from physagent_jax.core.errors import UserError


@dataclasses.dataclass(frozen=True)
class PhysAgent(Method):
    """Semantic agent, then rounds of playing, judging and rewriting.

    Attributes:
        rounds: At most; the budget may hold fewer. The product's own limit is 4.
    """

    rounds: int = 1000

    def __post_init__(self):
        if self.rounds < 1:
            raise UserError("`rounds` must be at least 1", got=self.rounds)

    @property
    def name(self) -> str:
        """As in the registry."""
        return "physagent"

    def search(self, evaluator: Evaluator) -> None:
        """Until the planner is satisfied, the executor has nothing left to try, or the budget is spent."""
        play_rounds(evaluator, read_sentence(evaluator), rounds=self.rounds)
