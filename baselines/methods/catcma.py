"""CatCMA: types and numbers sought together (Hamano et al. 2024; package `cmaes`).

Each action has a categorical unknown, its kind, beside its three numbers, and whether the object is let fall is one
more: a numeric method that can change types.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from baselines.evaluation import Evaluator
from baselines.local import OracleMethod
from baselines.methods.cma import WORST, import_cmaes
from baselines.starts import KINDS, SOLVED, fill_actions, turn_into
from physagent_jax.forces.schema import ForceField


@dataclasses.dataclass(frozen=True)
class CatCMA(OracleMethod):
    """Begins anew, elsewhere, when it has converged. Options are those of `OracleMethod`, and these.

    Attributes:
        spread: Standard deviation at first, in |M| v.
    """

    spread: float = 0.5

    @property
    def name(self) -> str:
        """As in the registry."""
        return "catcma"

    def search(self, evaluator: Evaluator) -> None:
        """Until it is solved or the budget is spent."""
        library = import_cmaes()
        template = fill_actions(evaluator.task.start, self.actions, evaluator.task.frame_count)
        count = len(template.actions)
        mean = self.make_unknowns(evaluator, template).encode(template)
        while True:
            search = library.CatCMA(
                mean=mean,
                sigma=self.spread,
                cat_num=np.array([len(KINDS)] * count + [2]),
                seed=int(evaluator.rng.integers(2**31)),
            )
            while not search.should_stop():
                told = []
                for _ in range(search.population_size):
                    u, choice = search.ask()
                    chosen = choose_kinds(template, choice)
                    loss = evaluator.score(self.make_unknowns(evaluator, chosen).decode(u)).loss
                    if loss <= SOLVED:
                        return
                    told.append(((u, choice), min(loss, WORST)))
                search.tell(told)
            mean = self.make_unknowns(evaluator, template).encode(self.draw(evaluator, template))


def choose_kinds(template: ForceField, choice: np.ndarray) -> ForceField:
    """The template with the kinds of a choice, one row of zeros and a one per action and one for letting it fall."""
    picked = [int(np.argmax(row)) for row in choice]
    kinds = [KINDS[index] for index in picked[:-1]]
    actions = tuple(map(turn_into, template.actions, kinds))
    return template.model_copy(update=dict(actions=actions, default_drop=bool(picked[-1])))
