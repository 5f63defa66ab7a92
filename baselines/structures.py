"""Which actions, when and where: combinations of skills, ranked by superposed responses without simulating them.

Each gets the numbers that are best for it by the superposed paths. What is promised is no more than a good start: of
stretches along other lines and on the ground it is a guess, which a search that simulates corrects.

Windows are those between which the target's clauses change, regions are the ends that it speaks of: an oracle may read
both.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator, Sequence
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from baselines.evaluation import Evaluator
from baselines.responses import (
    END_SKILLS,
    SKILLS,
    Responses,
    Slot,
    Structure,
    find_loss,
    fit_slot,
    list_changes,
    list_places,
    make_field,
    measure_responses,
)
from baselines.superposition import HEADER, Base
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import Action, ActionType, ForceField
from physagent_jax.metrics.targets import Integrity, Target
from physagent_jax.metrics.task_judge import compute_residuals

FAINT = 0.05
"""Loss that an action more has to be worth, and below which no more of them are tried."""

WEAKER = 0.7
"""By which |M| is multiplied."""

_WEAKENINGS = 3
_STEPS = 6  # of each fit
_MOST = 3  # actions
_BATCH = 16  # structures that are fitted side by side


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
        ranked: list[tuple[float, ForceField]] = []
        for size in range(1, _MOST + 1):
            enough = min((loss for loss, _ in ranked), default=np.inf) <= FAINT
            mine = [each for each in self.structures if len(each) == size]
            ranked += zip(*self.fitter.fit(mine)) if mine else ()
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
    for skills in itertools.product(SKILLS, repeat=len(own) if len(own) <= _MOST else 0):
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


@dataclasses.dataclass(frozen=True)
class Begun:
    """A force field that others are made of by adding to it.

    Attributes:
        field: What acts.
        structure: Of its actions.
        base: The motion that they make.
    """

    field: ForceField
    structure: Structure
    base: Base

    @property
    def numbers(self) -> np.ndarray:
        """M v of the actions, shape (3 actions,)."""
        actions = self.field.actions
        return np.array([each.magnitude * c for each in actions for c in each.vector], np.float32)


class Fitter:
    """Fits numbers of structures to a task's target by superposed responses, sixteen side by side."""

    def __init__(self, evaluator: Evaluator, responses: Responses):
        """Whether neighbours part is not asked: superposition does not know."""
        self.evaluator, self.responses = evaluator, responses
        target = evaluator.task.target
        clauses = tuple(each for each in target.clauses if not isinstance(each, Integrity))
        target, frame_dt = Target(clauses=clauses or target.clauses), evaluator.task.frame_dt

        self._target = target

        def residuals(u, base, known, bank, mass):
            motions = jnp.einsum("ai,aitnc->tnc", (u - known).reshape(-1, 3), bank)
            return compute_residuals(target, base.add(motions), mass, frame_dt)

        @jax.jit
        def fit(base, mass, known, bank, free, start):
            def fit_one(known, bank, free, start):
                return _fit_numbers(
                    partial(residuals, base=base, known=known, bank=bank, mass=mass), free, start
                )

            return jax.vmap(fit_one)(known, bank, free, start)

        self._fit = fit

    def fit(
        self, structures: Sequence[Structure], begun: Begun | None = None
    ) -> tuple[list[float], list[ForceField]]:
        """For each structure the best numbers, and the loss there.

        A stretch takes the axis that it makes most of, for between axes its responses do not add.

        Args:
            structures: All of one size.
            begun: What they are added to; its own pushes, blows and turns change with them, its stretches do not.
        """
        losses: list[float] = []
        fields: list[ForceField] = []
        base = self.responses.base if begun is None else begun.base
        for first in range(0, len(structures), _BATCH):
            batch = list(structures[first : first + _BATCH])
            u, loss = self._fit_batch(batch, base, begun)
            losses += [float(each) if np.isfinite(each) else np.inf for each in loss[: len(batch)]]
            fields += [self._make(structure, v, begun) for structure, v in zip(batch, u)]
        return losses, fields

    def miss(self, x: np.ndarray) -> float:
        """The loss of paths of the particles that responses are of, by what is fitted."""
        r = np.asarray(compute_residuals(self._target, x, self.responses.mass, self.evaluator.task.frame_dt))
        return 0.5 * float(r @ r)

    def _fit_batch(self, batch: list[Structure], base: Base, begun: Begun | None):
        old = () if begun is None else begun.structure
        size, frames = max(_MOST, len(old) + len(batch[0])), self.evaluator.task.frame_count
        nothing = np.zeros((3, frames, HEADER + len(self.responses.mass), 3), np.float32)
        filled = [batch[index % len(batch)] for index in range(_BATCH)]
        bank = np.zeros((_BATCH, size, *nothing.shape), np.float32)
        known, free, axial = (np.zeros((_BATCH, size, 3), np.float32) for _ in range(3))
        for row, structure in enumerate(filled):
            for place, (skill, slot) in enumerate((*old, *structure)):
                if (skill, slot.place) not in self.responses.steps:
                    continue
                bank[row, place] = self.responses.superpose(skill, slot)
                free[row, place] = place >= len(old) or skill is not ActionType.SCALE
                axial[row, place] = place >= len(old) and skill is ActionType.SCALE
        if begun is not None:
            known[:, : len(old)] = begun.numbers.reshape(-1, 3)
        new = np.arange(size)[:, None] >= len(old)
        fit = partial(self._fit, base, self.responses.mass.astype(np.float32), _flatten(known), bank)
        u = np.asarray(fit(_flatten(free), _flatten(np.where(new, 0.05 * free, known)))[0]).reshape(
            known.shape
        )
        sizes = np.abs(u)
        free = np.where((axial > 0) & (sizes < sizes.max(-1, keepdims=True)), 0.0, free).astype(np.float32)
        u, loss = fit(_flatten(free), _flatten(np.where(new, free * u, u)))
        return np.asarray(u).reshape(known.shape), np.asarray(loss)

    def _make(self, structure: Structure, u: np.ndarray, begun: Begun | None) -> ForceField:
        frames = self.evaluator.task.frame_count
        if begun is None:
            return make_field(structure, u[: len(structure)], self.responses.drop, frames)
        count = len(begun.structure)
        more = make_field(structure, u[count : count + len(structure)], False, frames)
        kept = [
            item if item.action_type is ActionType.SCALE else _set_number(item, v)
            for item, v in zip(begun.field.actions, u)
        ]
        update = dict(
            actions=(*kept, *more.actions), constraints=(*begun.field.constraints, *more.constraints)
        )
        return begun.field.model_copy(update=update)


def _fit_numbers(residuals, free, start):
    """Levenberg-Marquardt with a fixed number of steps, then into the library's range; what is not ``free`` stays."""

    def loss(u):
        return 0.5 * jnp.sum(residuals(u) ** 2)

    def step(_, state):
        u, damping, here = state
        r = residuals(u)
        J = jax.jacfwd(residuals)(u) * free
        normal = J.T @ J
        ridge = (damping * jnp.max(jnp.diag(normal)) + 1e-9) * jnp.eye(len(u), dtype=u.dtype)
        trial = u - jnp.linalg.solve(normal + ridge, J.T @ r)
        trial = jnp.clip(trial, -MAGNITUDE_MAX, MAGNITUDE_MAX)
        there = loss(trial)
        good = there < here
        return (
            jnp.where(good, trial, u),
            jnp.where(good, damping / 3, damping * 4),
            jnp.where(good, there, here),
        )

    u, _, _ = jax.lax.fori_loop(0, _STEPS, step, (start, jnp.float32(1e-2), loss(start)))
    sizes = jnp.sqrt(jnp.sum(u.reshape(-1, 3) ** 2, -1) + 1e-12)
    u = u * jnp.repeat(jnp.clip(sizes, MAGNITUDE_MIN, MAGNITUDE_MAX) / sizes, 3)
    return u, loss(u)


def _flatten(u: np.ndarray) -> np.ndarray:
    return u.reshape(len(u), -1)


def _set_number(item: Action, number: np.ndarray) -> Action:
    size = float(np.linalg.norm(number))
    x, y, z = (float(c) / size for c in number)
    return item.model_copy(
        update=dict(vector=(x, y, z), magnitude=min(max(size, MAGNITUDE_MIN), MAGNITUDE_MAX))
    )


def _count(field: ForceField) -> int:
    return len(field.actions) + len(field.constraints)


def _make_weaker(item):
    size = max(MAGNITUDE_MIN, WEAKER * abs(item.magnitude))
    return item.model_copy(update=dict(magnitude=np.copysign(size, item.magnitude).item()))


def round_window(window: tuple[float, float]) -> tuple[int, int]:
    """To whole frames."""
    return round(window[0]), round(window[1])
