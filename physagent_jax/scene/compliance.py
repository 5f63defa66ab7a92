"""The compliance of a held object: the probe that scales a push of it.

What is held bends as far as its shape and stiffness let it, which no closed form in its length alone tells: a plant
gives way a hundred times more than a block of the same stuff. Linear elasticity on a coarse grid answers in a fraction
of a second, without compiling or simulating anything.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_jax.core.recent import Recent
from physagent_jax.core.strict import Vector
from physagent_jax.mpm import lame_parameters
from physagent_jax.scene.anchor import select_anchored
from physagent_jax.scene.body import Body
from physagent_jax.scene.config import Anchor, Material
from physagent_jax.scene.elasticity import GridElasticity

MOST_PARTICLES = 3000
PER_CELL = 6  # particles in a cell of the probe's grid
SHARE = 0.02  # of the residual that is left
ROUNDS = 400  # of conjugate gradients for a direction

Matrix = tuple[Vector, Vector, Vector]


@dataclasses.dataclass(frozen=True)
class Compliance:
    """The displacements of what is not held, per uniform acceleration; rows answer the three axes.

    Attributes:
        mean: Their mean [s^2]; symmetric.
        square: Mean product of those that answer two axes [s^4]; symmetric. With a along v, Rayleigh's quotient
            v.mean v / v.square v is the square of the lowest mode's angular frequency.
    """

    mean: Matrix
    square: Matrix


_recent: Recent[Compliance | None] = Recent(4)  # rounds of a run differ in what acts only


def find_compliance(
    body: Body, material: Material, anchor: Anchor, firmness: np.ndarray | None = None
) -> Compliance | None:
    """`measure_compliance`, remembered from one round to the next."""
    firm = None if firmness is None else firmness.tobytes()
    key = material.model_dump_json(), anchor.model_dump_json(), firm
    return _recent.find(body, key, lambda: measure_compliance(body, material, anchor, firmness))


def measure_compliance(
    body: Body, material: Material, anchor: Anchor, firmness: np.ndarray | None = None
) -> Compliance | None:
    """The displacements of what is not held, per uniform acceleration.

    Args:
        body: The object at rest.
        material: With a Young's modulus; other laws than linear elasticity count as it.
        anchor: What is held; a mask's path is absolute.
        firmness: Factors of Young's modulus, shape (n,); None = 1.

    Returns:
        Their means, or None where nothing is held, all is, or what is left hangs on nothing.
    """
    particles = body.particles
    held = select_anchored(
        anchor, particles.x, particles.gaussian_index, ".", gaussian_count=body.cloud.count
    )
    if not held.any() or held.all() or not material.youngs_modulus:
        return None
    grid, mass, every = _make_grid(body, material, firmness)
    held = held[::every]
    fixed = grid.spread @ (mass * held) > 0.5 * grid.mass
    moves = ~(fixed | grid.light) & grid.find_borne(fixed)
    if not moves.any():
        return None
    free = np.repeat(moves[:, None], 3, axis=1)
    load = (grid.spread @ np.where(held, 0, mass))[:, None]
    share = np.where(held, 0, mass) / mass[~held].sum()
    answers = np.stack(
        [grid.weight @ grid.solve(np.where(free, load * axis, 0.0), free, ROUNDS)[0] for axis in np.eye(3)]
    )
    mean = np.einsum("n,ank->ak", share, answers)
    square = np.einsum("n,ank,bnk->ab", share, answers, answers)
    return Compliance(_make_rows(0.5 * (mean + mean.T)), _make_rows(square))


def _make_rows(matrix: np.ndarray) -> Matrix:
    return tuple(tuple(float(each) for each in row) for row in matrix)  # type: ignore[return-value]


def _make_grid(
    body: Body, material: Material, firmness: np.ndarray | None
) -> tuple[GridElasticity, np.ndarray, int]:
    """A coarse grid of some of the particles, their masses [kg], and that it holds one in so many."""
    particles = body.particles
    every = -(-particles.count // MOST_PARTICLES)
    x, volume = particles.x[::every], particles.volume[::every].astype(np.float64) * every
    factors = np.ones(len(x)) if firmness is None else firmness[::every]
    mu, lam = lame_parameters(material.youngs_modulus * factors, material.poissons_ratio)
    mass = material.density * volume
    dx = float((PER_CELL * volume.mean()) ** (1 / 3))
    return GridElasticity(x, volume, mass, mu, lam, dx=dx, form="mls", share=SHARE), mass, every
