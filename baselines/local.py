"""Shared parts of methods that minimise the distance to the target, and local ones that descend from starts."""

from __future__ import annotations

import dataclasses
from functools import partial

from baselines.evaluation import Evaluator
from baselines.misses import GOOD
from baselines.parametrisation import Parametrisation
from baselines.protocol import Method
from baselines.pursuit import pursue
from baselines.starts import (
    HOP,
    SOLVED,
    Descent,
    Numbers,
    Types,
    choose_numbers,
    choose_templates,
    draw_numbers,
    exhaust,
    share,
)
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField


@dataclasses.dataclass(frozen=True)
class OracleMethod(Method):
    """A search that minimises the distance to the target.

    Attributes:
        windows: Whether windows are sought too.
        actions: How many, one after another in equal parts of the clip; None = as many as the task's own.
    """

    windows: bool = False
    actions: int | None = None

    @property
    def oracle(self) -> bool:
        """It reads true particles."""
        return True

    @property
    def stochastic(self) -> bool:
        """Always, unless a method says otherwise."""
        return True

    def __post_init__(self):
        if self.actions is not None and not 1 <= self.actions <= 3:
            raise UserError(
                "`actions` must be 1 to 3: nobody can try all combinations of more", got=self.actions
            )

    def make_unknowns(self, evaluator: Evaluator, template: ForceField) -> Parametrisation:
        """The unknowns of force fields like ``template``."""
        return Parametrisation(template, evaluator.task.frame_count, self.windows)

    def draw(self, evaluator: Evaluator, template: ForceField) -> ForceField:
        """The template with numbers at random, windows too where they are sought."""
        return draw_numbers(evaluator.rng, template, evaluator.task.frame_count if self.windows else None)


@dataclasses.dataclass(frozen=True)
class LocalMethod(OracleMethod):
    """A local optimiser from one start or from several, of one type or of all.

    With several, each is scored, the best half goes on again and again (successive halving, Jamieson & Talwalkar 2016),
    and what is left of the budget is the last one's; when it has converged the others go on, then new ones begin. What
    has converged short of a success, as at a kink (a greatest value that changes its frame), which small steps do not
    leave, begins again beside the best (basin hopping, Wales & Doye 1997).

    Attributes:
        types: Who says what the actions are.
        numbers: Who says where they begin.
        starts: Starts of each type, all but the first drawn at random; how many types, where responses say which.
        hops: How often a search that got stuck begins again beside its best, at most.
    """

    types: Types = "task"
    numbers: Numbers = "task"
    starts: int = 1
    hops: int = 4

    @property
    def stochastic(self) -> bool:
        """Return whether anything may be drawn."""
        return self.hops > 0 or self._draws

    @property
    def _draws(self) -> bool:
        """Return whether there are ever new starts."""
        return self.starts > 1 or self.numbers == "random" or self.types in ("enumerated", "responses")

    def __post_init__(self):
        super().__post_init__()
        if self.starts < 1 or self.hops < 0:
            raise UserError("`starts` must be at least 1, `hops` at least 0", got=(self.starts, self.hops))
        if self.numbers == "responses" and self.types != "responses":
            raise UserError("responses give numbers for their own types only", do="Say types=responses too")

    def descend(self, evaluator: Evaluator, start: ForceField, budget: float) -> Descent:
        """Search from ``start``; ``budget`` are the forward-equivalents to plan with."""
        raise NotImplementedError

    def find_cost(self, start: ForceField) -> float:
        """Forward-equivalents from ``start`` until it is known what a step has gained."""
        raise NotImplementedError

    def count_unknowns(self, start: ForceField) -> int:
        """The number of unknowns from ``start``."""
        return (5 if self.windows else 3) * (len(start.actions) + len(start.constraints))

    def search(self, evaluator: Evaluator) -> None:
        """From all starts, then from new ones while the budget lasts."""
        if self.types == self.numbers == "responses":
            retime = dataclasses.replace(self, windows=True).descend
            pursue(evaluator, self.starts, self.descend, self.find_cost, retime, self._hop)
            return
        repeats = 1 if self.types == "responses" else self.starts
        templates = choose_templates(evaluator, self.types, self.actions, self.starts)
        draw = partial(self.draw, evaluator)
        found = choose_numbers(evaluator, templates, self.types, self.numbers, draw)
        found += [draw(template) for template in templates for _ in range(repeats - 1)]
        sought = any(template.actions or template.constraints for template in templates)
        while True:
            best = share(evaluator, list(dict.fromkeys(found)), self.descend, self.find_cost)
            for _ in range(self.hops if sought else 0):
                if best <= GOOD:
                    break
                hop = self._hop(evaluator)
                best = min(best, exhaust(self.descend(evaluator, hop, evaluator.remaining)))
            if best <= SOLVED or not (sought and self._draws):
                return
            found = [draw(template) for template in templates for _ in range(repeats)]

    def _hop(self, evaluator: Evaluator) -> ForceField:
        """Beside the best that has been tried and has numbers."""
        best = evaluator.find_best() or evaluator.task.start
        unknowns = self.make_unknowns(evaluator, best)
        return unknowns.decode(unknowns.encode(best) + HOP * evaluator.rng.normal(size=unknowns.size))
