"""Random search: every method has to be better than this."""

from __future__ import annotations

import dataclasses

from baselines.evaluation import Evaluator
from baselines.protocol import Method
from baselines.starts import SOLVED, Types, check_actions, make_starts


@dataclasses.dataclass(frozen=True)
class RandomSearch(Method):
    """Force fields from the library's range, one after another.

    Attributes:
        types: Who says what the actions are; all types take turns by default.
        windows: Whether windows are drawn too.
        actions: How many, as for `LocalMethod`.
    """

    types: Types = "enumerated"
    windows: bool = False
    actions: int | None = None

    def __post_init__(self):
        check_actions(self.actions)

    @property
    def name(self) -> str:
        """As in the registry."""
        return "random"

    @property
    def oracle(self) -> bool:
        """It keeps the one nearest to the target."""
        return True

    @property
    def stochastic(self) -> bool:
        """Always."""
        return True

    def search(self, evaluator: Evaluator) -> None:
        """Until the budget is spent."""
        while True:
            fields = make_starts(evaluator, self.types, "random", windows=self.windows, actions=self.actions)
            for index in evaluator.rng.permutation(len(fields)):
                if evaluator.score(fields[index], "drawn").loss <= SOLVED:
                    return
