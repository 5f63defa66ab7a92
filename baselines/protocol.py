"""The protocol of a method: its budget, and all that it tried, so that any stopping point can be read off.

Cost is counted in forward-equivalents: one plain simulation of the task is 1, whatever it is used for.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from baselines.tasks import Task
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField

if TYPE_CHECKING:
    from baselines.evaluation import Evaluator


class BudgetSpent(Exception):
    """Raised by `Evaluator` where a method asks for more than it has; what was recorded until then stands."""


class MethodFailedError(UserError):
    """A method of one's own that has an error, which says nothing of the task."""


@dataclasses.dataclass(frozen=True)
class Budget:
    """The budget of a method on a task.

    Attributes:
        forward_equivalents: Simulations, a gradient counted as `evaluation.GRADIENT_COST` of them. The evaluation that
            spends the last of it is still made.
        seconds: Wall time [s]; None = any.
    """

    forward_equivalents: float
    seconds: float | None = None

    def __post_init__(self):
        for name in ("forward_equivalents", "seconds"):
            value = getattr(self, name)
            if value is not None and not value > 0:
                raise UserError(f"`{name}` of a budget must be above 0", got=value)


@dataclasses.dataclass(frozen=True)
class Evaluation:
    """One force field that a method has tried.

    Attributes:
        force_field: What acted.
        spent: Forward-equivalents of the whole fit up to and with this one.
        seconds: Wall time at the same points [s].
        objective: What the method itself thinks of it, less is better; infinite where the simulation failed, None where
            the method has no opinion.
        note: What it was made for.
    """

    force_field: ForceField
    spent: float
    seconds: float
    objective: float | None
    note: str = ""


@dataclasses.dataclass(frozen=True)
class FitResult:
    """All that a method did on a task.

    Attributes:
        method, task, seed: Names.
        start: The task's own force field: what there is before anything has been tried.
        evaluations: In order.
        oracle: Whether the method read true particles.
        spent: Forward-equivalents.
        seconds: Wall time, with what had to be compiled [s].
        model_calls, tokens: Calls and tokens of language or video models.
    """

    method: str
    task: str
    seed: int
    start: ForceField
    evaluations: tuple[Evaluation, ...]
    oracle: bool
    spent: float
    seconds: float
    model_calls: int = 0
    tokens: int = 0

    def find_incumbent(self, spent: float = math.inf) -> Evaluation | None:
        """The best evaluation by the method's own objective within ``spent`` forward-equivalents.

        The latest that could be simulated where the method has no objective, the first of equals; None where nothing is
        evaluated by then.
        """
        made = [each for each in self.evaluations if each.spent <= spent]
        worked = [each for each in made if each.objective is None or math.isfinite(each.objective)]
        rated = [(each.objective, each) for each in worked if each.objective is not None]
        if rated:
            return min(rated, key=lambda pair: pair[0])[1]
        return (worked or made or [None])[-1]

    def incumbent_at(self, spent: float = math.inf) -> ForceField:
        """The force field of `find_incumbent`; the start where there is none."""
        best = self.find_incumbent(spent)
        return self.start if best is None else best.force_field


@dataclasses.dataclass(frozen=True)
class Method:
    """A way to find a force field for a task. Fields of a method are its options.

    A method implements `search`; it is given the only door to the simulator and ends when it is done or the budget is.
    """

    @property
    def name(self) -> str:
        """As in the registry."""
        raise NotImplementedError

    @property
    def oracle(self) -> bool:
        """Return whether it reads true particles, which nothing but a simulator can know."""
        return False

    @property
    def stochastic(self) -> bool:
        """Return whether another seed may give another result."""
        return False

    def search(self, evaluator: Evaluator) -> None:
        """Try force fields until it is done.

        Raises:
            BudgetSpent: By way of ``evaluator``.
        """
        raise NotImplementedError

    def fit(
        self,
        task: Task,
        budget: Budget,
        seed: int = 0,
        options: Mapping[str, Any] | None = None,
        *,
        on_evaluation: Callable[[Evaluation], None] = lambda evaluation: None,
    ) -> FitResult:
        """Search within ``budget``.

        Args:
            task: What to solve.
            budget: What may be spent.
            seed: Seed of all random numbers.
            options: Fields of this method in place of its own.
            on_evaluation: Told of every evaluation as it is made.

        Raises:
            UserError: The task cannot be solved by this method at all, or there is no such option.
        """
        from baselines.evaluation import Evaluator

        method = self.with_options(options or {})
        return method.finish(Evaluator(task, budget, seed, oracle=method.oracle, on_evaluation=on_evaluation))

    def list_options(self) -> dict[str, Any]:
        """The options by name."""
        return dataclasses.asdict(self)

    def with_options(self, options: Mapping[str, Any]) -> Method:
        """The method with other options.

        Raises:
            UserError: It has no such option.
        """
        known = [field.name for field in dataclasses.fields(self)]
        if unknown := [name for name in options if name not in known]:
            raise UserError(
                f"method `{self.name}` does not take these options",
                got=", ".join(unknown),
                do=f"It takes {', '.join(known) or 'none'}",
            )
        return dataclasses.replace(self, **options)

    def finish(self, evaluator: Evaluator) -> FitResult:
        """`search` until its end, and what it leaves."""
        try:
            self.search(evaluator)
        except BudgetSpent:
            pass
        return FitResult(
            method=self.name,
            task=evaluator.task.spec.name,
            seed=evaluator.seed,
            start=evaluator.task.start,
            evaluations=tuple(evaluator.evaluations),
            oracle=self.oracle,
            spent=evaluator.spent,
            seconds=evaluator.seconds,
            model_calls=evaluator.model_calls,
            tokens=evaluator.tokens,
        )
