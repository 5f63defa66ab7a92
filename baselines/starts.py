"""Where local searches begin, and how several of them share a budget: for all optimisers alike.

What a force field is made of (types) and the numbers that it begins with are chosen apart, each by the task, by chance,
by an expert, by the agents, by trying all or by the object's responses: who chooses what can then be compared.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Literal

import numpy as np

from baselines.agents import read_sentence
from baselines.evaluation import Evaluator
from baselines.parametrisation import SHORTEST, Parametrisation
from baselines.protocol import Method
from baselines.structures import find_starts
from physagent_jax.core.errors import UserError
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import Action, ActionType, ForceField

Types = Literal["task", "enumerated", "responses", "agent", "expert"]
Numbers = Literal["task", "random", "responses", "agent", "expert"]

KINDS = (
    (ActionType.TRANSLATION, 1.0),
    (ActionType.SCALE, 1.0),
    (ActionType.SCALE, -1.0),
    (ActionType.IMPULSE, 1.0),
    (ActionType.TORQUE, 1.0),
)
"""What an action can be: the skills, a stretch and a squeeze apart, for no vector turns one into the other."""

BLOW = (0.0, 2.0)
"""[frames] of a blow whose window nobody has said: short, and at once."""

SOLVED = 1e-6
"""Loss at which nothing is left to be gained."""

GOOD = 0.125
"""Loss at which no residual is beyond 0.5, which is a success: `compute_residuals` begins at half a tolerance."""

HOP = 0.15
"""[|M| v] standard deviation by which a search that got stuck begins again beside its best."""

FIRST_SHARE = 0.6
"""Of the budget that is spent on finding out which of several searches is the best."""

Descent = Iterator[float]
"""A local search that can be stopped after every step: yields the best loss so far."""


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
        """What is sought of force fields like ``template``."""
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
        """Whether anything may be drawn."""
        return self.hops > 0 or self._draws

    @property
    def _draws(self) -> bool:
        """Whether there are ever new starts."""
        return self.starts > 1 or self.numbers == "random" or self.types in ("enumerated", "responses")

    def __post_init__(self):
        super().__post_init__()
        if self.starts < 1 or self.hops < 0:
            raise UserError("`starts` must be at least 1, `hops` at least 0", got=(self.starts, self.hops))
        if self.numbers == "responses" and self.types != "responses":
            raise UserError("responses give numbers for their own types only", do="Say types=responses too")

    def descend(self, evaluator: Evaluator, start: ForceField, budget: float) -> Descent:
        """Searches from ``start``; ``budget`` are the forward-equivalents to plan with."""
        raise NotImplementedError

    def find_cost(self, start: ForceField) -> float:
        """Forward-equivalents from ``start`` until it is known what a step has gained."""
        raise NotImplementedError

    def count_unknowns(self, start: ForceField) -> int:
        """How many numbers are sought from ``start``."""
        return (5 if self.windows else 3) * (len(start.actions) + len(start.constraints))

    def search(self, evaluator: Evaluator) -> None:
        """From all starts, then from new ones while the budget lasts."""
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
                best = min(best, _exhaust(self.descend(evaluator, hop, evaluator.remaining)))
            if best <= SOLVED or not (sought and self._draws):
                return
            found = [draw(template) for template in templates for _ in range(repeats)]

    def _hop(self, evaluator: Evaluator) -> ForceField:
        """Beside the best that has been tried and has numbers."""
        best, least = None, math.inf
        for each in evaluator.evaluations:
            numbers = each.force_field.actions or each.force_field.constraints
            if numbers and each.objective is not None and (best is None or each.objective < least):
                best, least = each.force_field, each.objective
        best = evaluator.task.start if best is None else best
        unknowns = self.make_unknowns(evaluator, best)
        return unknowns.decode(unknowns.encode(best) + HOP * evaluator.rng.normal(size=unknowns.size))


def choose_templates(
    evaluator: Evaluator, types: Types, actions: int | None = None, count: int = 1
) -> list[ForceField]:
    """Force fields that say what actions there may be, once per search.

    All types are those with or without a fall, whichever misses less when nothing else acts: two simulations halve the
    number of types.

    Args:
        evaluator: Charged.
        types: Who says.
        actions: How many, as for `OracleMethod`.
        count: How many, of those that responses find.

    Raises:
        UserError: The task has no expert, or its sentence is not understood, where these are asked for.
    """
    task = evaluator.task
    match types:
        case "responses":
            return find_starts(evaluator, count)
        case "task" | "enumerated":
            template = task.start if actions is None else fill_actions(task.start, actions, task.frame_count)
            if types == "task":
                return [template]
            fall = evaluator.score(ForceField(default_drop=True), "fall").loss
            rest = evaluator.score(ForceField(), "rest").loss
            drop = template.default_drop if fall == rest else fall < rest
            return enumerate_types(template.model_copy(update=dict(default_drop=drop)))
    return [_choose(evaluator, types) or task.start]


def choose_numbers(
    evaluator: Evaluator,
    templates: Sequence[ForceField],
    types: Types,
    numbers: Numbers,
    draw: Callable[[ForceField], ForceField],
) -> list[ForceField]:
    """The templates with the numbers of who is named.

    Raises:
        UserError: The task has no expert, or its sentence is not understood, where these are asked for.
    """
    if types == numbers:
        return list(templates)
    whose = _choose(evaluator, numbers)
    return [draw(each) if whose is None else copy_numbers(each, whose) for each in templates]


def share(
    evaluator: Evaluator,
    starts: Sequence[ForceField],
    descend: Callable[[Evaluator, ForceField, float], Descent],
    cost: Callable[[ForceField], float],
) -> float:
    """Searches from ``starts`` with what is left of the budget; the best loss.

    Nobody is judged before a step: a start says little about where a search from it leads. What has been scored is not
    scored again.

    Args:
        evaluator: Charged.
        starts: One or more, the likeliest first.
        descend: As `LocalMethod.descend`.
        cost: As `LocalMethod.find_cost`: no more searches are begun than can take a step each.
    """
    if len(starts) == 1:
        return _exhaust(descend(evaluator, starts[0], evaluator.remaining))
    order = evaluator.rng.permutation(len(starts))[: max(1, int(evaluator.remaining / 2))]
    ranked = []
    known = {each.force_field: each.objective for each in evaluator.evaluations}
    for index in sorted(order):
        loss = known.get(starts[index])
        loss = evaluator.score(starts[index], "start").loss if loss is None else loss
        ranked.append((loss, starts[index]))
        if ranked[-1][0] <= SOLVED:
            return ranked[-1][0]
    ranked.sort(key=lambda pair: pair[0])
    best, left = ranked[0][0], FIRST_SHARE * evaluator.remaining
    ranked = ranked[: max(1, int(left / max(cost(start) for _, start in ranked)))]
    rungs = max(1, math.ceil(math.log2(len(ranked))))
    running = [
        (loss, descend(evaluator, start, evaluator.remaining / 2), cost(start)) for loss, start in ranked
    ]
    waiting: list[tuple[float, Descent, float]] = []
    for _ in range(rungs):
        each = left / rungs / len(running)
        running = [
            (_advance(evaluator, loss, descent, max(each, least)), descent, least)
            for loss, descent, least in running
        ]
        running.sort(key=lambda item: item[0])
        best = min(best, running[0][0])
        if best <= SOLVED:
            return best
        half = math.ceil(len(running) / 2)
        running, waiting = running[:half], [*running[half:], *waiting]
    for _, descent, _ in (*running, *waiting):
        best = min(best, _exhaust(descent))
        if best <= SOLVED:
            break
    return best


def draw_numbers(
    rng: np.random.Generator, template: ForceField, frame_count: int | None = None
) -> ForceField:
    """The template with directions from the sphere and magnitudes from the library's range.

    Windows are kept, or drawn from all within a clip of ``frame_count`` frames.
    """
    return template.model_copy(
        update=dict(
            actions=tuple(_draw_entry(rng, item, frame_count) for item in template.actions),
            constraints=tuple(_draw_entry(rng, item, None) for item in template.constraints),
        )
    )


def copy_numbers(template: ForceField, other: ForceField) -> ForceField:
    """The template with the vectors and magnitudes of ``other``'s actions, as far as there are any, its signs kept."""
    actions = tuple(
        item.model_copy(
            update=dict(vector=its.vector, magnitude=math.copysign(its.magnitude, item.magnitude))
        )
        for item, its in zip(template.actions, other.actions)
    )
    return template.model_copy(update=dict(actions=(*actions, *template.actions[len(actions) :])))


def enumerate_types(template: ForceField) -> list[ForceField]:
    """The template with every combination of kinds; where it lets fall, with nothing else too."""
    template = fill_actions(template)
    same_window = len({action.active_time for action in template.actions}) == 1
    choose = itertools.combinations_with_replacement if same_window else _choose_in_order
    made = [
        template.model_copy(update=dict(actions=tuple(map(turn_into, template.actions, kinds))))
        for kinds in choose(KINDS, len(template.actions))
    ]
    return [*made, ForceField(default_drop=True)] if template.default_drop else made


def fill_actions(
    template: ForceField, count: int | None = None, frame_count: int | None = None
) -> ForceField:
    """The template; with ``count`` actions in equal parts of the clip if it has another number, one if it has none."""
    first = Action(action_type=ActionType.TRANSLATION, vector=(1.0, 0.0, 0.0))
    first = template.actions[0] if template.actions else first
    if count is None or count == len(template.actions) or frame_count is None:
        return template if template.actions else template.model_copy(update=dict(actions=(first,)))
    edges = np.linspace(0, frame_count - 1, count + 1).tolist()
    actions = tuple(first.model_copy(update=dict(active_time=each)) for each in itertools.pairwise(edges))
    return template.model_copy(update=dict(actions=actions))


def turn_into(action: Action, kind: tuple[ActionType, float]) -> Action:
    """The action as another kind; its direction, strength and window stay, but a blow over the whole clip is none."""
    update: dict = dict(action_type=kind[0], magnitude=kind[1] * abs(action.magnitude))
    if kind[0] is ActionType.IMPULSE and action.active_time is None:
        update["active_time"] = BLOW
    return action.model_copy(update=update)


def _choose_in_order(kinds, count):
    return itertools.product(kinds, repeat=count)


def _choose(evaluator: Evaluator, who: str) -> ForceField | None:
    """The force field of who is named; None = chance."""
    match who:
        case "task":
            return evaluator.task.start
        case "agent":
            return read_sentence(evaluator).force_field
        case "expert":
            return find_expert(evaluator.task)
        case "random":
            return None
    raise UserError("there is nobody of this name to choose", got=who)


def find_expert(task) -> ForceField:
    """The published force field for a task.

    Raises:
        UserError: There is none.
    """
    if task.spec.expert is None:
        raise UserError(
            f"nobody has published a force field for task `{task.spec.name}`",
            do="Take another task, or another start",
        )
    return task.spec.expert


def _draw_entry(rng: np.random.Generator, item, frame_count: int | None):
    vector = rng.normal(size=3)
    size = rng.uniform(MAGNITUDE_MIN, MAGNITUDE_MAX)
    x, y, z = (vector / np.linalg.norm(vector)).tolist()
    update: dict = dict(vector=(x, y, z), magnitude=math.copysign(size, item.magnitude))
    if frame_count is not None:
        first, last = np.sort(rng.uniform(0, frame_count - 1, 2)).tolist()
        first = min(first, frame_count - 1 - SHORTEST)
        update["active_time"] = first, max(last, first + SHORTEST)
    return item.model_copy(update=update)


def _advance(evaluator: Evaluator, loss: float, descent: Descent, budget: float) -> float:
    """Steps until ``budget`` is spent, at least one."""
    until = evaluator.spent + budget
    for best in descent:
        loss = min(loss, best)
        if evaluator.spent >= until or loss <= SOLVED:
            break
    return loss


def _exhaust(descent: Descent) -> float:
    best = math.inf
    for best in descent:
        if best <= SOLVED:
            break
    return best
