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
from baselines.fitting import Begun
from baselines.misses import GOOD
from baselines.responses import Slot, Structure, fit_slot
from baselines.starts import Descent, compare, exhaust
from baselines.structures import FAINT, Ranking, round_window
from baselines.superposition import Base
from physagent_jax.forces.schema import ForceField
from physagent_jax.metrics.targets import Path
from physagent_jax.metrics.task_judge import compute_residuals

ROUNDS = 1.0
"""Multiple of their cost that the first searches may have before the best goes on alone."""

PROMISE = 0.7
"""Share of the loss; an action that would leave more is not added."""

TRIED = 3
"""Additions that are tried at once, of different kinds, places or axes."""

MOST = 6
"""Actions."""

BROKEN = 2.0
"""Multiple of the loss before; an addition that leaves more is given up."""

NEARLY = 1.5
"""Residual up to which the worst clause is made to count more."""

POWER = 3
"""Power by which it counts (`misses.sharpen`)."""

FOLLOWED = 0.05
"""Loss, in place of `GOOD`, at which stored paths are followed everywhere: their residual is a mean over frames."""

WORTH = 0.9
"""Share of the loss; what leaves more has not gained enough to be gone on with at once, or to be looked at again."""

PATIENCE = 3
"""Steps in which as much has to be gained."""

PART = 0.35
"""Share of the remaining budget that a search may spend before others have their turn."""


def pursue(
    evaluator: Evaluator,
    count: int,
    descend: Callable[[Evaluator, ForceField, float], Descent],
    cost: Callable[[ForceField], float],
    retime: Callable[[Evaluator, ForceField, float], Descent],
    hop: Callable[[Evaluator], ForceField],
) -> None:
    """Search until there is a success, or the budget is spent.

    From the ``count`` likeliest starts and what the best of them grows into; then from the best with an action more, or
    where none promises enough with the worst clause counting more and with windows sought too; then from what was begun
    and left, from the next ``count`` starts, and beside the best.

    Args:
        evaluator: Charged.
        count: Starts at a time.
        descend: As for `compare`.
        cost: As for `compare`.
        retime: As ``descend``, with windows sought too.
        hop: Gives a start beside the best.
    """
    ranking = Ranking(evaluator)
    stored = any(isinstance(clause, Path) for clause in evaluator.task.target.clauses)
    good = FOLLOWED if stored else GOOD
    opened: list[Descent] = []
    stuck: list[Descent] = []
    looked_at = np.inf

    def begin(starts: list[ForceField]) -> None:
        if not starts:  # nothing answers to anything
            return
        _, searches = compare(evaluator, starts, descend, cost, ROUNDS)
        if searches and not go_on(evaluator, searches[0], good):
            searches = searches[1:]
        opened[:0] = searches

    begin(grow(evaluator, ranking, ranking.take(count), good)[:count])
    while find_least(evaluator) > good:
        best, least = evaluator.find_best(), find_least(evaluator)
        if best is not None and least < WORTH * looked_at:
            looked_at = least
            x = evaluator.watch(best, "what is left")
            tried = [] if x is None else try_more(evaluator, extend(evaluator, ranking, best, x), least)
            if not (tried or x is None or stored) and find_worst(evaluator, x) <= NEARLY:
                with evaluator.sharpened(POWER):
                    go_on(evaluator, descend(evaluator, best, PART * evaluator.remaining), good)
            if not tried:
                opened.insert(0, retime(evaluator, best, PART * evaluator.remaining))
            opened[:0] = [descend(evaluator, field, PART * evaluator.remaining) for field in tried]
        elif opened:
            search = opened.pop(0)
            if go_on(evaluator, search, good):
                stuck.append(search)
        elif ranking.fields or stuck:
            opened, stuck = stuck, []
            if ranking.fields:
                begin(ranking.take(count))
        else:
            exhaust(descend(evaluator, hop(evaluator), evaluator.remaining))
    for search in (*opened, *reversed(stuck))[:1]:
        exhaust(search)


def grow(evaluator: Evaluator, ranking: Ranking, starts: list[ForceField], good: float) -> list[ForceField]:
    """The starts and what the best of them grows into before anything has descended, the best first."""
    pool: dict[ForceField, float] = {}
    for each in starts:
        known = evaluator.recall(each)
        pool[each] = evaluator.score(each, "start").loss if known is None else known
    while pool:
        best = min(pool, key=pool.__getitem__)
        x = None if pool[best] <= good else evaluator.watch(best, "what is left")
        if x is None:
            break
        tried = try_more(evaluator, extend(evaluator, ranking, best, x), WORTH * pool[best] / BROKEN)
        if not tried:
            break
        pool |= {each: loss for each in tried if (loss := evaluator.recall(each)) is not None}
    return sorted(pool, key=pool.__getitem__)


def try_more(evaluator: Evaluator, fields: list[ForceField], least: float) -> list[ForceField]:
    """Those that do not miss by far more than ``least``, the best first: what tears does not as it has promised."""
    scored = []
    for field in fields:
        known = evaluator.recall(field)
        scored.append((evaluator.score(field, "an action more").loss if known is None else known, field))
    kept = [pair for pair in scored if pair[0] <= BROKEN * least]
    return [field for _, field in sorted(kept, key=lambda pair: pair[0])]


def go_on(evaluator: Evaluator, search: Descent, good: float) -> bool:
    """Steps while they gain; whether the search can be gone on with.

    It stops where something has been good, and where `PATIENCE` steps have not gained what is `WORTH` it or its part of
    the budget is spent: others have their turn first.
    """
    until, marks = evaluator.spent + PART * evaluator.remaining, []
    for loss in search:
        marks.append(loss)
        stuck = len(marks) > PATIENCE and loss > WORTH * marks[-1 - PATIENCE]
        if stuck or evaluator.spent >= until or find_least(evaluator) <= good:
            return True
    return False


def find_least(evaluator: Evaluator) -> float:
    """The least objective so far."""
    return min(
        (each.objective for each in evaluator.evaluations if each.objective is not None), default=np.inf
    )


def find_worst(evaluator: Evaluator, x: np.ndarray) -> float:
    """The largest residual on paths of all particles."""
    task = evaluator.task
    return float(np.abs(np.asarray(compute_residuals(task.target, x, task.mass, task.frame_dt))).max())


def extend(evaluator: Evaluator, ranking: Ranking, field: ForceField, x: np.ndarray) -> list[ForceField]:
    """The force field with other numbers, and with an action more, the likeliest first, each where it promises enough.

    An action has to explain what other numbers alone would leave.

    Args:
        evaluator: Not charged.
        ranking: Ranking of the task.
        field: What acts.
        x: Paths of all particles under it [m], shape (T, n, 3).
    """
    responses = ranking.responses
    end = evaluator.task.frame_count - 1
    structure = tuple(
        (item.action_type, Slot(*round_window(item.active_time or (0, end)), item.region))
        for item in field.actions
    )
    if not responses.steps or len(structure) + len(field.constraints) >= MOST:
        return []
    begun = Begun(field, structure, Base.of(x[:, :: responses.stride], responses.mass))
    more = list_additions(evaluator, ranking, structure)
    losses, fields = ranking.fitter.fit(more, begun) if more else ([], [])
    (same,), (again,) = ranking.fitter.fit([()], begun)
    enough = min(PROMISE * same, same - FAINT)
    order = sorted((index for index in range(len(more)) if losses[index] <= enough), key=losses.__getitem__)
    unlike = {describe(fields[index]): fields[index] for index in reversed(order)}
    found = sorted(unlike.values(), key=[fields[index] for index in order].index)[:TRIED]
    left = ranking.fitter.miss(begun.base.x)
    return [*([again] if same <= min(PROMISE * left, left - FAINT) else []), *found]


def describe(field: ForceField) -> tuple:
    """Kind, place and nearest axis of the last action, without its window: what pulls too hard does so at any time."""
    if not field.actions:
        return ()
    last = field.actions[-1]
    return last.action_type, last.region, int(np.abs(last.vector).argmax())


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
