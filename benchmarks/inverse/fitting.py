"""The two optimisers: Levenberg-Marquardt and Adam, both by the gradient through the simulation.

Levenberg-Marquardt takes J^T J from a Jacobian by differences, p simulations, and the slope from the adjoint: where it
ends the gradient is zero, whatever the differences are off by. Its damping is Levenberg's with Nielsen's update
(Madsen, Nielsen & Tingleff 2004, "Methods for non-linear least squares problems", 3.2). Adam (Kingma & Ba 2015, from
optax) has the field's first rate of 0.1 (GIC's for the logarithms of moduli), which a cosine lowers to a hundredth. Its
memories are short: gradients are exact, and on 36 random quadratics in three unknowns, up to 100 times as curved along
one as along another, (0.5, 0.9) ends nearer than (0.9, 0.999) by a factor of a million in 100 steps.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from typing import Protocol

import jax.numpy as jnp
import numpy as np
import optax

LM_STEPS, ADAM_STEPS = 15, 100  # reference values allow Adam 200: two stages
RATE, MEMORIES = 0.1, (0.5, 0.9)
SHORTEST = 1e-4  # step of a coordinate, in its scale, at which Levenberg-Marquardt has converged
SOLVED = (
    0.01  # root mean square of the residuals: a hundredth of a tracker's noise; exact tracks alone get there
)
_DAMPING = 1e-3  # of the first step, in shares of the greatest element of J^T J's diagonal


class Failed(Exception):
    """A guess cannot be simulated."""


class Fit(Protocol):
    """Function that is fitted: residuals r, and the gradient of |r|^2 / 2, by coordinates u of shape (p,)."""

    def compute_residuals(self, u: np.ndarray) -> np.ndarray:
        """Shape (m,); raises `Failed`."""
        ...

    def compute_gradient(self, u: np.ndarray) -> tuple[float, np.ndarray]:
        """The loss, and its gradient, shape (p,); raises `Failed`."""
        ...

    def compute_jacobian(
        self, u: np.ndarray, residuals: np.ndarray, columns: tuple[int, ...] | None = None
    ) -> np.ndarray:
        """Shape (m, p), or only some of its columns; raises `Failed`."""
        ...


@dataclasses.dataclass(frozen=True)
class Best:
    """The best guess after a step.

    Attributes:
        u: Coordinates, shape (p,).
        loss: There.
    """

    u: np.ndarray
    loss: float


class Part:
    """A fit by some of the coordinates, the others as they are."""

    def __init__(self, fit: Fit, u: np.ndarray, sought: np.ndarray):
        self._fit, self._u, self._sought = fit, u, sought

    def fill(self, part: np.ndarray) -> np.ndarray:
        """All coordinates, shape (p,), of those that are sought."""
        u = np.array(self._u)
        u[self._sought] = part
        return u

    def compute_residuals(self, u: np.ndarray) -> np.ndarray:
        """As of the whole."""
        return self._fit.compute_residuals(self.fill(u))

    def compute_gradient(self, u: np.ndarray) -> tuple[float, np.ndarray]:
        """The loss, and its gradient by what is sought."""
        loss, gradient = self._fit.compute_gradient(self.fill(u))
        return loss, gradient[self._sought]

    def compute_jacobian(
        self, u: np.ndarray, residuals: np.ndarray, columns: tuple[int, ...] | None = None
    ) -> np.ndarray:
        """The columns of what is sought."""
        own = np.flatnonzero(self._sought)
        chosen = own if columns is None else own[list(columns)]
        return self._fit.compute_jacobian(self.fill(u), residuals, tuple(chosen.tolist()))


def descend_in_stages(
    fit: Fit,
    start: np.ndarray,
    stages: Sequence[np.ndarray],
    search: Callable[[Fit, np.ndarray, np.ndarray], Iterator[Best]],
) -> Iterator[Best]:
    """A search for some of the coordinates, then from there for others.

    Args:
        fit: What is fitted.
        start: Coordinates, shape (p,).
        stages: What is sought in each, shape (p,) of bool.
        search: Search of a fit, from all coordinates of that fit and the mask of those that are sought.
    """
    u = np.array(start)
    for sought in stages:
        part = Part(fit, u, sought)
        for best in search(part, u[sought], sought):
            reached = Best(part.fill(best.u), best.loss)
            yield reached
            u = reached.u


def is_solved(loss: float, count: int) -> bool:
    """Return whether ``count`` residuals are as small as exact tracks make them."""
    return loss <= 0.5 * count * SOLVED**2


def descend_levenberg_marquardt(
    fit: Fit, start: np.ndarray, scale: np.ndarray, steps: int = LM_STEPS
) -> Iterator[Best]:
    """The start, then one trial a step, until the steps are `SHORTEST` or nothing is left.

    Args:
        fit: What is fitted.
        start: Coordinates, shape (p,).
        scale: Scale of the coordinates, shape (p,): the damping is the same for all in these.
        steps: At most.
    """
    u, damping, growth = np.array(start), None, 2.0
    residuals = fit.compute_residuals(u)
    loss, slope, normal = _linearise(fit, u, residuals, scale)
    yield Best(u, loss)
    for _ in range(steps):
        if is_solved(loss, len(residuals)):
            return
        if damping is None:
            damping = _DAMPING * float(np.diag(normal).max())
        step = -np.linalg.solve(normal + damping * np.eye(len(u)), slope)
        if np.abs(step).max() < SHORTEST:
            return
        trial = u + scale * step
        try:
            found = fit.compute_residuals(trial)
            reached = 0.5 * float(found @ found)
        except Failed:
            found, reached = residuals, np.inf
        expected = -(slope @ step + 0.5 * step @ normal @ step)
        gain = (loss - reached) / expected
        if gain > 1e-3:
            u, residuals, growth = trial, found, 2.0
            damping *= max(1.0 / 3.0, 1.0 - (2.0 * gain - 1.0) ** 3)
            yield Best(u, reached)
            if is_solved(reached, len(residuals)):
                return
            loss, slope, normal = _linearise(fit, u, residuals, scale)
        else:
            damping, growth = damping * growth, 2.0 * growth
            yield Best(u, loss)


def _linearise(
    fit: Fit, u: np.ndarray, residuals: np.ndarray, scale: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:
    """Loss, slope and J^T J, in scaled coordinates."""
    loss, gradient = fit.compute_gradient(u)
    jacobian = fit.compute_jacobian(u, residuals) * scale
    return loss, gradient * scale, jacobian.T @ jacobian


def descend_adam(fit: Fit, start: np.ndarray, count: int, steps: int = ADAM_STEPS) -> Iterator[Best]:
    """The best guess after every gradient; a guess that fails sends the search a good part of the way back.

    Args:
        fit: What is fitted.
        start: Coordinates, shape (p,).
        count: Number of residuals.
        steps: Gradients at most.
    """
    schedule = optax.cosine_decay_schedule(RATE, steps, alpha=0.01)
    optimiser = optax.adam(schedule, *MEMORIES)
    u, moments, best = np.array(start), optimiser.init(jnp.asarray(start)), None
    for _ in range(steps):
        try:
            loss, gradient = fit.compute_gradient(u)
        except Failed:
            if best is None:
                raise
            u = best.u + 0.25 * (u - best.u)
            yield best
            continue
        if best is None or loss < best.loss:
            best = Best(np.array(u), loss)
        yield best
        if is_solved(best.loss, count):
            return
        change, moments = optimiser.update(jnp.asarray(gradient), moments)
        u = u + np.asarray(change, np.float64)
