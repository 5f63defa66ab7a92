"""Ours: the product's offline agents, which are rules of English; they read the sentence and see pictures."""

from __future__ import annotations

import dataclasses

from baselines.agents import play_rounds, read_sentence
from baselines.evaluation import Evaluator
from baselines.privileged import TrueSight
from baselines.protocol import Method
from physagent_jax.core.errors import UserError


@dataclasses.dataclass(frozen=True)
class Rules(Method):
    """Semantic agent, then rounds of playing, judging and rewriting.

    Attributes:
        rounds: At most; the budget may hold fewer. The product's own limit is 4.
        privileged: Whether true particles and the judge's margins take the place of perception and planner.
    """

    rounds: int = 1000
    privileged: bool = False

    def __post_init__(self):
        if self.rounds < 1:
            raise UserError("`rounds` must be at least 1", got=self.rounds)

    @property
    def name(self) -> str:
        """As in the registry."""
        return "rules"

    @property
    def oracle(self) -> bool:
        """Only with privileges."""
        return self.privileged

    def search(self, evaluator: Evaluator) -> None:
        """Until the planner is satisfied, the executor has nothing left to try, or the budget is spent."""
        reading = read_sentence(evaluator)
        if self.privileged:
            sight = TrueSight(evaluator.task)
            play_rounds(evaluator, reading, rounds=self.rounds, agents=sight.make_agents(), sight=sight)
        else:
            play_rounds(evaluator, reading, rounds=self.rounds)
