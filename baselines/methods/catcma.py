"""CatCMA: types and numbers sought together (Hamano et al. 2024; package `cmaes`).

Each action has a categorical unknown, its kind, beside its three numbers, and whether the object is let fall is one
more: a numeric method that can change types.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from baselines.evaluation import Evaluator
from baselines.methods.cma import WORST, import_cmaes
from baselines.parametrisation import Parametrisation
from baselines.protocol import Method
from baselines.starts import KINDS, SOLVED, check_actions, draw_numbers, fill_actions, turn_into
from physagent_jax.forces.schema import ForceField


@dataclasses.dataclass(frozen=True)
class CatCMA(Method):
    """Begins anew, elsewhere, when it has converged.

    Attributes:
        spread: Standard deviation at first, in |M| v.
        windows: Whether windows are sought too.
        actions: How many, as for `LocalMethod`.
    """

    spread: float = 0.5
    windows: bool = False
    actions: int | None = None

    def __post_init__(self):
        check_actions(self.actions)

    @property
    def name(self) -> str:
        """As in the registry."""
        return "catcma"

    @property
    def oracle(self) -> bool:
        """It minimises the distance to the target."""
        return True

    @property
    def stochastic(self) -> bool:
        """Always."""
        return True

    def search(self, evaluator: Evaluator) -> None:
        """Until it is solved or the budget is spent."""
        library, frames = import_cmaes(), evaluator.task.frame_count
        template = fill_actions(evaluator.task.start, self.actions, frames)
        count = len(template.actions)
        mean = Parametrisation(template, frames, self.windows).encode(template)
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
                    loss = evaluator.score(Parametrisation(chosen, frames, self.windows).decode(u)).loss
                    if loss <= SOLVED:
                        return
                    told.append(((u, choice), min(loss, WORST)))
                search.tell(told)
            unknowns = Parametrisation(template, frames, self.windows)
            mean = unknowns.encode(draw_numbers(evaluator.rng, template, frames if self.windows else None))


def choose_kinds(template: ForceField, choice: np.ndarray) -> ForceField:
    """The template with the kinds of a choice, one row of zeros and a one per action and one for letting it fall."""
    picked = [int(np.argmax(row)) for row in choice]
    kinds = [KINDS[index] for index in picked[:-1]]
    actions = tuple(map(turn_into, template.actions, kinds))
    return template.model_copy(update=dict(actions=actions, default_drop=bool(picked[-1])))
