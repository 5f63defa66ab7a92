"""Structures of force fields: combinations of skills, ranked by superposed responses without simulating them.

Each gets the numbers that are best for it by the superposed paths. What is promised is no more than a good start: of
stretches along other lines and on the ground it is a guess, which a search that simulates corrects.

Windows are those between which the target's clauses change, regions are the ends that it speaks of: an oracle may read
both.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator, Sequence

import numpy as np

from baselines.evaluation import Evaluator
from baselines.fitting import MOST, Begun, Fitter
from baselines.responses import (
    END_SKILLS,
    SKILLS,
    Slot,
    Structure,
    find_loss,
    fit_slot,
    list_changes,
    list_places,
    measure_responses,
)
from physagent_jax.forces.calibration import MAGNITUDE_MIN
from physagent_jax.forces.schema import ForceField

FAINT = 0.05
"""Loss that an action more has to be worth, and below which no more of them are tried."""

WEAKER = 0.7
"""By which |M| is multiplied."""

_WEAKENINGS = 3


class Ranking:
    """All structures with their numbers, the likeliest first; what has been taken is not taken again."""

    def __init__(self, evaluator: Evaluator):
        """Charged one simulation for each skill and axis, as far as `SHARE` of the budget goes.

        Of the whole, and of each end that the target or the task's own first force field speaks of.
        """
        self.evaluator = evaluator
        self.responses = responses = measure_responses(evaluator)
        self.fitter = Fitter(evaluator, responses)
        self.structures = [
            each
            for each in dict.fromkeys(list_structures(evaluator))
            if all((skill, slot.place) in responses.steps for skill, slot in each)
        ]
        rest = [] if responses.rest is None else [Begun(ForceField(), (), responses.rest)]
        ranked: list[tuple[float, ForceField]] = []
        for size in range(1, MOST + 1):
            enough = min((loss for loss, _ in ranked), default=np.inf) <= FAINT
            mine = [each for each in self.structures if len(each) == size]
            for begun in (None, *rest):
                ranked += zip(*self.fitter.fit(mine, begun)) if mine else ()
            if enough:
                break
        if responses.drop:
            fall = ForceField(default_drop=True)
            ranked.append((evaluator.score(fall, "start").loss, fall))
        ranked.sort(key=lambda pair: round(pair[0] + FAINT * _count(pair[1]), 2))
        self.fields = [field for _, field in ranked]
        self.idle = 0.5 * find_loss(evaluator, responses.base.x, responses.mass)

    def take(self, count: int) -> list[ForceField]:
        """The next ``count``, charged what it takes to weaken them.

        Half of them at most are of as many actions: what one action does by superposition may be out of proportion in
        truth, and take two. Those that miss by more than no action does are made weaker (`weaken`).
        """
        taken = pick(self.fields, count)
        self.fields = [field for field in self.fields if field not in taken]
        return [weaken(self.evaluator, field, self.idle) for field in taken]


def find_starts(evaluator: Evaluator, count: int) -> list[ForceField]:
    """The ``count`` best force fields by superposed responses, all their structures different: `Ranking.take`."""
    return Ranking(evaluator).take(count)


def pick(ranked: Sequence[ForceField], count: int) -> list[ForceField]:
    """The first ``count``, half of them at most of as many actions where there are others, the likeliest first."""
    taken: list[ForceField] = []
    for field in ranked:
        alike = sum(_count(each) == _count(field) for each in taken)
        if len(taken) < count and alike < (count + 1) // 2:
            taken.append(field)
    taken += [field for field in ranked if field not in taken][: count - len(taken)]
    return sorted(taken, key=ranked.index)


def weaken(evaluator: Evaluator, field: ForceField, idle: float) -> ForceField:
    """The force field, `WEAKER` as often as it misses by more than ``idle``, the loss without any action.

    Superposition knows nothing of what tears: pulled hard, an object gives way and leaves no slope to come back by.
    """
    for _ in range(_WEAKENINGS):
        if not (field.actions or field.constraints) or evaluator.score(field, "start").loss <= idle:
            return field
        field = field.model_copy(
            update=dict(
                actions=tuple(map(_make_weaker, field.actions)),
                constraints=tuple(map(_make_weaker, field.constraints)),
            )
        )
    return field


def list_structures(evaluator: Evaluator) -> Iterator[Structure]:
    """Combinations of skills that may be what is asked for.

    The task's own windows and regions with all skills; one action between any two changes, of the whole or of an end;
    the same at two ends; two skills after each other; the same skill three times.
    """
    end, changes = evaluator.task.frame_count - 1, list_changes(evaluator)
    own = [
        Slot(*round_window(action.active_time or (0, end)), action.region)
        for action in evaluator.task.start.actions
    ]
    for skills in itertools.product(SKILLS, repeat=len(own) if len(own) <= MOST else 0):
        yield tuple((skill, fit_slot(skill, slot, evaluator)) for skill, slot in zip(skills, own))
    windows = list(itertools.combinations((0, *changes, end), 2))
    ends: list[Slot] = []
    for slot, skills in list_places(evaluator):
        for (first, last), skill in itertools.product(windows, skills):
            timed = dataclasses.replace(slot, first=first, last=last)
            yield ((skill, fit_slot(skill, timed, evaluator)),)
        ends += [slot] if slot.region is not None and slot.against is None else []
    for pair, skill in itertools.product(itertools.combinations(ends, 2), END_SKILLS):
        yield tuple((skill, fit_slot(skill, slot, evaluator)) for slot in pair)
    for change, skills in itertools.product(changes, itertools.product(SKILLS, repeat=2)):
        parts = (Slot(0, change), Slot(change, end))
        yield tuple((skill, fit_slot(skill, slot, evaluator)) for skill, slot in zip(skills, parts))
    for (one, two), skill in itertools.product(itertools.combinations(changes, 2), SKILLS):
        parts = (Slot(0, one), Slot(one, two), Slot(two, end))
        yield tuple((skill, fit_slot(skill, slot, evaluator)) for slot in parts)


def _count(field: ForceField) -> int:
    return len(field.actions) + len(field.constraints)


def _make_weaker(item):
    size = max(MAGNITUDE_MIN, WEAKER * abs(item.magnitude))
    return item.model_copy(update=dict(magnitude=np.copysign(size, item.magnitude).item()))


def round_window(window: tuple[float, float]) -> tuple[int, int]:
    """To whole frames."""
    return round(window[0]), round(window[1])
