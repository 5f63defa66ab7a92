"""Starts of local searches, and the division of a budget among them: the same for all optimisers.

What a force field is made of (types) and the numbers that it begins with are chosen apart, each by the task, by chance,
by an expert, by the agents, by trying all or by the object's responses: who chooses what can then be compared.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Literal

import numpy as np

from baselines.agents import read_sentence
from baselines.evaluation import Evaluator
from baselines.parametrisation import SHORTEST
from baselines.structures import find_starts
from physagent_jax.core.errors import UserError
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import Action, ActionType, ForceField
from physagent_jax.forces.skills import list_skills

Types = Literal["task", "enumerated", "responses", "agent", "expert"]
Numbers = Literal["task", "random", "responses", "agent", "expert"]

KINDS = tuple(
    (ActionType(skill.name), sign)
    for skill in list_skills("actions")
    for sign in ((1.0, -1.0) if skill.is_two_sided else (1.0,))
)
"""Skills of an action; a stretch and a squeeze are two, for no vector turns one into the other."""

BLOW = (0.0, 2.0)
"""[frames] of a blow whose window nobody has said: short, and at once."""

SOLVED = 1e-6
"""Loss at which nothing is left to be gained."""

HOP = 0.15
"""[|M| v] standard deviation by which a search that got stuck begins again beside its best."""

FIRST_SHARE = 0.6
"""Share of the budget that is spent on finding the best of several searches."""

Descent = Iterator[float]
"""A local search that can be stopped after every step: yields the best loss so far."""


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
    """Search from ``starts`` with what is left of the budget, as `compare`; the best loss."""
    if len(starts) == 1:
        return exhaust(descend(evaluator, starts[0], evaluator.remaining))
    best, searches = compare(evaluator, starts, descend, cost)
    for search in searches:
        if best <= SOLVED:
            break
        best = min(best, exhaust(search))
    return best


def compare(
    evaluator: Evaluator,
    starts: Sequence[ForceField],
    descend: Callable[[Evaluator, ForceField, float], Descent],
    cost: Callable[[ForceField], float],
    rounds: float = math.inf,
) -> tuple[float, list[Descent]]:
    """Begin searches from ``starts``; the best loss, and the searches to be gone on with, the likeliest first.

    Nobody is judged before a step: a start says little about where a search from it leads. What has been scored is not
    scored again.

    Args:
        evaluator: Charged.
        starts: One or more, the likeliest first.
        descend: As `LocalMethod.descend`.
        cost: As `LocalMethod.find_cost`: no more searches are begun than can take a step each.
        rounds: How often all of them may have their cost, at most.
    """
    order = evaluator.rng.permutation(len(starts))[: max(1, int(evaluator.remaining / 2))]
    ranked = []
    known = {each.force_field: each.objective for each in evaluator.evaluations}
    for index in sorted(order):
        loss = known.get(starts[index])
        loss = evaluator.score(starts[index], "start").loss if loss is None else loss
        ranked.append((loss, starts[index]))
        if ranked[-1][0] <= SOLVED:
            return ranked[-1][0], []
    ranked.sort(key=lambda pair: pair[0])
    best, left = ranked[0][0], FIRST_SHARE * evaluator.remaining
    ranked = ranked[: max(1, int(left / max(cost(start) for _, start in ranked)))]
    rungs = max(1, math.ceil(math.log2(len(ranked))))
    left = min(left, rounds * sum(cost(start) for _, start in ranked))
    running = [
        (loss, descend(evaluator, start, evaluator.remaining / 2), cost(start)) for loss, start in ranked
    ]
    waiting: list[tuple[float, Descent, float]] = []
    for _ in range(rungs):
        each = left / rungs / len(running)
        running = [
            (advance(evaluator, loss, descent, max(each, least)), descent, least)
            for loss, descent, least in running
        ]
        running.sort(key=lambda item: item[0])
        best = min(best, running[0][0])
        if best <= SOLVED:
            return best, []
        half = math.ceil(len(running) / 2)
        running, waiting = running[:half], [*running[half:], *waiting]
    return best, [descent for _, descent, _ in (*running, *waiting)]


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
    first = Action(action_type=KINDS[0][0], vector=(1.0, 0.0, 0.0))
    first = template.actions[0] if template.actions else first
    if count is None or count == len(template.actions) or frame_count is None:
        return template if template.actions else template.model_copy(update=dict(actions=(first,)))
    edges = np.linspace(0, frame_count - 1, count + 1).tolist()
    actions = tuple(first.model_copy(update=dict(active_time=each)) for each in itertools.pairwise(edges))
    return template.model_copy(update=dict(actions=actions))


def turn_into(action: Action, kind: tuple[ActionType, float]) -> Action:
    """The action as another kind; its direction, strength and window stay, but a blow over the whole clip is none."""
    update: dict = dict(action_type=kind[0], magnitude=kind[1] * abs(action.magnitude))
    if kind[0].skill.is_sudden and action.active_time is None:
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


def advance(evaluator: Evaluator, loss: float, descent: Descent, budget: float) -> float:
    """Steps until ``budget`` is spent, at least one."""
    until = evaluator.spent + budget
    for best in descent:
        loss = min(loss, best)
        if evaluator.spent >= until or loss <= SOLVED:
            break
    return loss


def exhaust(descent: Descent) -> float:
    """Steps until it ends; the best loss."""
    best = math.inf
    for best in descent:
        if best <= SOLVED:
            break
    return best
