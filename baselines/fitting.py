"""The numbers that are best for a combination of actions by superposed responses, without simulating it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from baselines.evaluation import Evaluator
from baselines.responses import Responses, Structure, make_field
from baselines.superposition import HEADER, Base
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import Action, ForceField
from physagent_jax.forces.skills import get_skill
from physagent_jax.metrics.targets import Integrity, Target
from physagent_jax.metrics.task_judge import compute_residuals

MOST = 3
"""Actions of a combination that is tried at first."""

_STEPS = 6  # of each fit
_BATCH = 16  # structures that are fitted side by side


@dataclasses.dataclass(frozen=True)
class Begun:
    """A force field that others are made of by adding to it.

    Attributes:
        field: What acts.
        structure: Structure of its actions.
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
        """Return whether neighbours part is not asked: superposition does not know."""
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
        size, frames = max(MOST, len(old) + len(batch[0])), self.evaluator.task.frame_count
        nothing = np.zeros((3, frames, HEADER + len(self.responses.mass), 3), np.float32)
        filled = [batch[index % len(batch)] for index in range(_BATCH)]
        bank = np.zeros((_BATCH, size, *nothing.shape), np.float32)
        known, free, axial = (np.zeros((_BATCH, size, 3), np.float32) for _ in range(3))
        for row, structure in enumerate(filled):
            for place, (skill, slot) in enumerate((*old, *structure)):
                if (skill, slot.place) not in self.responses.steps:
                    continue
                bank[row, place] = self.responses.superpose(skill, slot)
                free[row, place] = place >= len(old) or not skill.skill.is_two_sided
                axial[row, place] = place >= len(old) and skill.skill.is_two_sided
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
            item if get_skill(item).is_two_sided else _set_number(item, v)
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
