"""Agents choose what acts, when and which way; a numeric optimiser then polishes the numbers.

The order is that of SGA (Ma et al. 2024) for laws of materials: a language model outside, gradients inside. With its
options, who chooses types and who chooses numbers can be crossed: `types` and `numbers` of every local method say whom
a search begins with, this one lets the agents play rounds before.
"""

from __future__ import annotations

import dataclasses
from typing import Literal

from baselines.agents import play_rounds, read_sentence
from baselines.evaluation import Evaluator
from baselines.protocol import Method
from baselines.starts import share
from physagent_jax.core.errors import UserError

Polish = Literal["levenberg_marquardt", "adam", "lbfgs", "cma", "smoothed_adam"]


@dataclasses.dataclass(frozen=True)
class Hybrid(Method):
    """The agents' rounds, then a descent from the best of them.

    Attributes:
        polish: Which local method.
        rounds: Rounds of the agents; 1 = the sentence alone is read.
        part: Part of the budget that the rounds may take.
        windows: Whether windows are polished too.
    """

    polish: Polish = "levenberg_marquardt"
    rounds: int = 4
    part: float = 0.5
    windows: bool = False

    def __post_init__(self):
        if self.rounds < 1:
            raise UserError("`rounds` must be at least 1", got=self.rounds)
        if not 0 < self.part <= 1:
            raise UserError("`part` must be above 0 and at most 1", got=self.part)

    @property
    def name(self) -> str:
        """As in the registry."""
        return "hybrid"

    @property
    def oracle(self) -> bool:
        """The polish is."""
        return True

    def search(self, evaluator: Evaluator) -> None:
        """Rounds without an objective of their own: what counts from the polish on is the distance to the target."""
        from baselines.methods import METHODS

        local = METHODS.make((self.polish, dict(windows=self.windows)))
        rounds = max(1, min(self.rounds, int(self.part * evaluator.remaining)))
        field = play_rounds(evaluator, read_sentence(evaluator), rounds=rounds, rate=False)
        share(evaluator, [field], local.descend, local.find_cost)
