"""Searches that begin where responses say, and go on where these have not said enough.

What is found first is taken apart again: its true paths say what is left, and by superposition on them each further
action says how much of that it would explain (matching pursuit, Mallat & Zhang 1993, with all numbers fitted again).
Where nothing is left but a clause or two that are nearly met, these are made to count more than the rest.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable

import numpy as np

from baselines.evaluation import Evaluator
from baselines.misses import GOOD
from baselines.responses import Slot, Structure, fit_slot
from baselines.starts import Descent, advance, compare, exhaust
from baselines.structures import Begun, Ranking, round_window
from baselines.superposition import Base
from physagent_jax.forces.schema import ForceField
from physagent_jax.metrics.targets import Path
from physagent_jax.metrics.task_judge import compute_residuals

ROUNDS = 2.0
"""How often the first searches may have their cost before the best goes on alone: the rest is for what comes after."""

PROMISE = 0.7
"""Of the loss: an action that would leave more is not added."""

TRIED = 2
"""Additions that are tried at once."""

MOST = 6
"""Actions."""

NEARLY = 1.5
"""Residual up to which the worst clause is made to count more."""

POWER = 3
"""By which it counts (`misses.sharpen`)."""

FOLLOWED = 0.05
"""Loss, in place of `GOOD`, at which stored paths are followed everywhere: their residual is a mean over frames."""

PART = 0.35
"""Of what is left of the budget that a search may spend before others have their turn."""


def pursue(
    evaluator: Evaluator,
    count: int,
    descend: Callable[[Evaluator, ForceField, float], Descent],
    cost: Callable[[ForceField], float],
    hop: Callable[[Evaluator], ForceField],
) -> None:
    """Searches until there is a success, or the budget is spent.

    From the ``count`` likeliest starts; then, in turn and as long as it helps, from the best with the worst clause
    counting more, from the best with an action more, from what was begun and left, from the next ``count`` starts, and
    beside the best.

    Args:
        evaluator: Charged.
        count: Starts at a time.
        descend: As for `compare`.
        cost: As for `compare`.
        hop: Gives a start beside the best.
    """
    ranking, seen = Ranking(evaluator), set[ForceField]()
    stored = any(isinstance(clause, Path) for clause in evaluator.task.target.clauses)
    good = FOLLOWED if stored else GOOD
    opened: list[Descent] = []

    def begin(starts: list[ForceField]) -> None:
        _, searches = compare(evaluator, starts, descend, cost, ROUNDS)
        if searches:
            go_on(searches[0])
            opened[:0] = searches

    def go_on(search: Descent) -> None:
        advance(evaluator, np.inf, search, PART * evaluator.remaining)

    begin(ranking.take(count))
    while find_least(evaluator) > good:
        best = evaluator.find_best()
        if best is not None and best not in seen:
            seen.add(best)
            x = evaluator.watch(best, "what is left")
            worst = np.inf if x is None else find_worst(evaluator, x)
            if not stored and worst <= NEARLY:
                with evaluator.sharpened(POWER):
                    descend_until(evaluator, descend(evaluator, best, PART * evaluator.remaining), good)
                if find_least(evaluator) <= good:
                    return
            more = [] if x is None else extend(evaluator, ranking, best, x)
            if more:
                begin(more)
                continue
        if opened:
            go_on(opened.pop(0))
        elif ranking.fields:
            begin(ranking.take(count))
        else:
            exhaust(descend(evaluator, hop(evaluator), evaluator.remaining))
    for search in opened[:1]:
        exhaust(search)


def find_least(evaluator: Evaluator) -> float:
    """The least objective so far."""
    return min(
        (each.objective for each in evaluator.evaluations if each.objective is not None), default=np.inf
    )


def find_worst(evaluator: Evaluator, x: np.ndarray) -> float:
    """The largest residual on paths of all particles."""
    task = evaluator.task
    return float(np.abs(np.asarray(compute_residuals(task.target, x, task.mass, task.frame_dt))).max())


def descend_until(evaluator: Evaluator, search: Descent, good: float) -> None:
    """Steps until something has been good, the search ends, or half of the budget is spent."""
    until = evaluator.spent + PART * evaluator.remaining
    for _ in search:
        if evaluator.spent >= until or find_least(evaluator) <= good:
            break


def extend(evaluator: Evaluator, ranking: Ranking, field: ForceField, x: np.ndarray) -> list[ForceField]:
    """The force field with an action more, the likeliest first; none where none would explain enough of what is left.

    Args:
        evaluator: Not charged.
        ranking: Of the task.
        field: What acts.
        x: Paths of all particles under it [m], shape (T, n, 3).
    """
    responses = ranking.responses
    end = evaluator.task.frame_count - 1
    structure = tuple(
        (item.action_type, Slot(*round_window(item.active_time or (0, end)), item.region))
        for item in field.actions
    )
    if len(structure) + len(field.constraints) >= MOST:
        return []
    begun = Begun(field, structure, Base.of(x[:, :: responses.stride], responses.mass))
    more = list_additions(evaluator, ranking, structure)
    if not more:
        return []
    losses, fields = ranking.fitter.fit(more, begun)
    left = ranking.fitter.miss(begun.base.x)
    order = sorted(range(len(more)), key=losses.__getitem__)
    return [fields[index] for index in order if losses[index] <= PROMISE * left][:TRIED]


def list_additions(evaluator: Evaluator, ranking: Ranking, structure: Structure) -> list[Structure]:
    """One action between any two changes of the target, and each action once more in a part of its own window."""
    singles = [each for each in ranking.structures if len(each) == 1]
    if not structure:
        return singles
    parts: list[Structure] = []
    for skill, slot in structure:
        middle = (slot.first + slot.last) // 2
        for first, last in itertools.pairwise((slot.first, middle, slot.last)):
            if last > first:
                part = fit_slot(skill, dataclasses.replace(slot, first=first, last=last), evaluator)
                parts.append(((skill, part),))
    return list(dict.fromkeys([*singles, *(each for each in parts if each not in singles)]))
