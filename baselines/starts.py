"""Where local searches begin, and how several of them share a budget: for all optimisers alike.

What a force field is made of (types) and the numbers that it begins with are chosen apart, each by the task, by chance,
by an expert, by the agents or by trying all: who chooses what can then be compared.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Literal

import numpy as np

from baselines.agents import read_sentence
from baselines.evaluation import Evaluator
from baselines.parametrisation import SHORTEST
from baselines.protocol import Method
from physagent_jax.core.errors import UserError
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import Action, ActionType, ForceField

Types = Literal["task", "enumerated", "agent", "expert"]
Numbers = Literal["task", "random", "agent", "expert"]

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

FIRST_SHARE = 0.5
"""Of the budget that is spent on finding out which of several searches is the best."""

Descent = Iterator[float]
"""A local search that can be stopped after every step: yields the best loss so far."""


@dataclasses.dataclass(frozen=True)
class LocalMethod(Method):
    """A local optimiser from one start or from several, of one type or of all.

    With several, each is scored, the best half goes on again and again (successive halving, Jamieson & Talwalkar 2016),
    and what is left of the budget is the last one's; when it has converged the others go on, then new ones begin.

    Attributes:
        types: Who says what the actions are.
        numbers: Who says where they begin.
        starts: Starts of each type; all but the first are drawn at random.
        windows: Whether windows are sought too.
        actions: How many, one after another in equal parts of the clip; None = as many as the task's own.
    """

    types: Types = "task"
    numbers: Numbers = "task"
    starts: int = 1
    windows: bool = False
    actions: int | None = None

    @property
    def oracle(self) -> bool:
        """It minimises the distance to the target."""
        return True

    @property
    def stochastic(self) -> bool:
        """Whether starts are drawn."""
        return self.starts > 1 or self.numbers == "random" or self.types == "enumerated"

    def __post_init__(self):
        if self.starts < 1:
            raise UserError("`starts` must be at least 1", got=self.starts)
        check_actions(self.actions)

    def descend(self, evaluator: Evaluator, start: ForceField, budget: float) -> Descent:
        """Searches from ``start``; ``budget`` are the forward-equivalents to plan with."""
        raise NotImplementedError

    def find_cost(self, start: ForceField) -> float:
        """Forward-equivalents of a step from ``start``."""
        raise NotImplementedError

    def count_unknowns(self, start: ForceField) -> int:
        """How many numbers are sought from ``start``."""
        return (5 if self.windows else 3) * (len(start.actions) + len(start.constraints))

    def search(self, evaluator: Evaluator) -> None:
        """From all starts, then from new ones while the budget lasts."""
        numbers = self.numbers
        while True:
            found = make_starts(
                evaluator,
                self.types,
                numbers,
                self.starts,
                windows=self.windows,
                actions=self.actions,
            )
            best = share(evaluator, found, self.descend, self.find_cost)
            if best <= SOLVED or not self.stochastic:
                return
            numbers = "random"


def make_starts(
    evaluator: Evaluator,
    types: Types,
    numbers: Numbers,
    count: int = 1,
    *,
    windows: bool = False,
    actions: int | None = None,
) -> list[ForceField]:
    """Force fields to begin with, ``count`` of each type; windows are drawn too where they are sought.

    Raises:
        UserError: The task has no expert, or its sentence is not understood, where these are asked for.
    """
    frames = evaluator.task.frame_count if windows else None
    made, templates = [], _choose_templates(evaluator, types, actions)
    whose = templates[0] if types == numbers else _choose(evaluator, numbers)
    for template in templates:
        for index in range(count):
            if index or whose is None:
                made.append(draw_numbers(evaluator.rng, template, frames))
            else:
                made.append(copy_numbers(template, whose))
    return list(dict.fromkeys(made))


def share(
    evaluator: Evaluator,
    starts: Sequence[ForceField],
    descend: Callable[[Evaluator, ForceField, float], Descent],
    cost: Callable[[ForceField], float],
) -> float:
    """Searches from ``starts`` with what is left of the budget; the best loss.

    Args:
        evaluator: Charged.
        starts: One or more.
        descend: As `LocalMethod.descend`.
        cost: As `LocalMethod.find_cost`: no more searches are begun than can take a step each.
    """
    if len(starts) == 1:
        return _exhaust(descend(evaluator, starts[0], evaluator.remaining))
    order = evaluator.rng.permutation(len(starts))[: max(1, int(evaluator.remaining / 2))]
    ranked = [(evaluator.score(starts[index], "start").loss, starts[index]) for index in sorted(order)]
    ranked.sort(key=lambda pair: pair[0])
    best, left = ranked[0][0], FIRST_SHARE * evaluator.remaining
    ranked = ranked[: max(1, int(left / max(cost(start) for _, start in ranked)))]
    rungs = max(1, math.ceil(math.log2(len(ranked))))
    running = [(loss, descend(evaluator, start, evaluator.remaining / 2)) for loss, start in ranked]
    waiting: list[tuple[float, Descent]] = []
    for _ in range(rungs):
        # At least one step each: where the budget is too small for all, the better starts have it.
        each = left / rungs / len(running)
        running = [(_advance(evaluator, loss, descent, each), descent) for loss, descent in running]
        running.sort(key=lambda pair: pair[0])
        best = min(best, running[0][0])
        if best <= SOLVED:
            return best
        half = math.ceil(len(running) / 2)
        running, waiting = running[:half], [*running[half:], *waiting]
    for _, descent in (*running, *waiting):
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
    """The template with every combination of kinds, at rest and let fall, and let fall with nothing else."""
    template = fill_actions(template)
    same_window = len({action.active_time for action in template.actions}) == 1
    choose = itertools.combinations_with_replacement if same_window else _choose_in_order
    made = [
        template.model_copy(update=dict(actions=tuple(map(turn_into, template.actions, kinds))))
        for kinds in choose(KINDS, len(template.actions))
    ]
    both = [
        each.model_copy(update=dict(default_drop=drop))
        for drop in (template.default_drop, not template.default_drop)
        for each in made
    ]
    return [*both, template.model_copy(update=dict(actions=(), default_drop=True))]


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


def check_actions(count: int | None) -> None:
    """Refuses numbers of actions whose combinations nobody can try.

    Raises:
        UserError: There are none, or more than three.
    """
    if count is not None and not 1 <= count <= 3:
        raise UserError("`actions` must be 1 to 3", got=count)


def turn_into(action: Action, kind: tuple[ActionType, float]) -> Action:
    """The action as another kind; its direction, strength and window stay, but a blow over the whole clip is none."""
    update: dict = dict(action_type=kind[0], magnitude=kind[1] * abs(action.magnitude))
    if kind[0] is ActionType.IMPULSE and action.active_time is None:
        update["active_time"] = BLOW
    return action.model_copy(update=update)


def _choose_in_order(kinds, count):
    return itertools.product(kinds, repeat=count)


def _choose_templates(evaluator: Evaluator, types: Types, actions: int | None) -> list[ForceField]:
    task = evaluator.task
    if types in ("task", "enumerated"):
        template = task.start if actions is None else fill_actions(task.start, actions, task.frame_count)
        return enumerate_types(template) if types == "enumerated" else [template]
    return [_choose(evaluator, types) or task.start]


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
