"""Published experts' force fields for such a sentence, simulated as they are."""

from __future__ import annotations

import dataclasses

from baselines.evaluation import Evaluator
from baselines.protocol import Method
from baselines.starts import find_expert


@dataclasses.dataclass(frozen=True)
class Expert(Method):
    """The task's transcribed force field: one simulation, no search."""

    @property
    def name(self) -> str:
        """As in the registry."""
        return "expert"

    def search(self, evaluator: Evaluator) -> None:
        """Plays it."""
        evaluator.play(find_expert(evaluator.task), "published")
