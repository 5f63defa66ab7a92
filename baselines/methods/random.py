"""Random search: every method has to be better than this."""

from __future__ import annotations

import dataclasses

from baselines.evaluation import Evaluator
from baselines.local import OracleMethod
from baselines.starts import SOLVED, Types, choose_templates


@dataclasses.dataclass(frozen=True)
class RandomSearch(OracleMethod):
    """Force fields from the library's range, one after another; keeps the one nearest to the target.

    Options are those of `OracleMethod`, and these.

    Attributes:
        types: Who says what the actions are; all types take turns by default.
    """

    types: Types = "enumerated"

    @property
    def name(self) -> str:
        """As in the registry."""
        return "random"

    def search(self, evaluator: Evaluator) -> None:
        """Until the budget is spent."""
        templates = choose_templates(evaluator, self.types, self.actions)
        while True:
            for index in evaluator.rng.permutation(len(templates)):
                if evaluator.score(self.draw(evaluator, templates[index]), "drawn").loss <= SOLVED:
                    return
