"""Numbers of a force field that its motion identifies: eigenvalues of J^T J, J the residuals' derivative."""

from __future__ import annotations

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.strict import Strict

LEAST_CHANGE = 1.0
"""A change of the parameters by their whole scale must change the residuals by this, or it is not identified: for
residuals in tolerances, what is less passes for the same motion."""


class Identifiability(Strict):
    """The spectrum of J^T J.

    Attributes:
        names: Names of the parameters.
        eigenvalues: Eigenvalues of the scaled J^T J, largest first: the square of how far a change by the
            parameters' scale along
            each direction moves the residuals.
        directions: Unit vectors in scaled parameters, row by row as the eigenvalues.
        condition: Largest over smallest singular value; None if the smallest is zero.
        identified: How many directions are identified.
        unidentified: Names of the parameters that have most to do with those that are not, one for each.
    """

    names: tuple[str, ...]
    eigenvalues: tuple[float, ...]
    directions: tuple[tuple[float, ...], ...]
    condition: float | None
    identified: int
    unidentified: tuple[str, ...]


def find_identifiability(jacobian, names, scale, *, least: float = LEAST_CHANGE) -> Identifiability:
    """Eigenvalues and directions of J^T J in scaled parameters.

    Args:
        jacobian: Derivative of the residuals by the parameters, shape (m, p).
        names: Names of the parameters, p of them.
        scale: A change of each parameter that matters, such as its range, shape (p,).
        least: How far the residuals must move for a direction to be identified.

    Raises:
        UserError: A shape does not fit, or a number is not finite.
    """
    J, scale = np.asarray(jacobian, np.float64), np.asarray(scale, np.float64)
    if J.ndim != 2 or not len(names) == len(scale) == J.shape[1]:
        raise UserError("`jacobian`, `names` and `scale` must be of the same parameters", got=J.shape)
    if not (np.isfinite(J).all() and np.isfinite(scale).all()):
        raise UserError("`jacobian` and `scale` must be finite")
    values, vectors = np.linalg.eigh((J * scale).T @ (J * scale))
    values, vectors = np.maximum(values[::-1], 0.0), vectors.T[::-1]
    moved = np.sqrt(values)
    weak = vectors[moved < least]
    return Identifiability(
        names=tuple(names),
        eigenvalues=tuple(values.tolist()),
        directions=tuple(tuple(row) for row in vectors.tolist()),
        condition=float(moved[0] / moved[-1]) if moved[-1] > 1e-9 * moved[0] else None,
        identified=int((moved >= least).sum()),
        unidentified=tuple(names[int(np.argmax(np.abs(row)))] for row in weak),
    )
