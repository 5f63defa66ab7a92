"""The burden of an object's own weight: the strain that bears it, and whether the pose that bears it is stable.

A pose can be in balance and not last: a thin stem that carries a heavy head buckles, however well its stress balances
the weight. So the stress of linear elasticity under the weight is found on a coarse grid, and with it the largest
factor by which it exceeds what the pose can bear. That is linear buckling: with K the stiffness of the matter and G
that of the stress (Zienkiewicz & Taylor 2005, The Finite Element Method for Solid and Structural Mechanics, chapter
11),

    -G u = b K u,    u^T G u = sum_p V_p tr(grad u sigma grad u^T),

the pose is stable if no b reaches 1. Weight does not change with stiffness: strains, displacements and b go with 1 / E.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.linalg import eigvalsh_tridiagonal

from physagent_jax.core.recent import Recent
from physagent_jax.forces import calibration
from physagent_jax.mpm.boundaries.contact import TOUCH
from physagent_jax.scene.anchor import select_anchored
from physagent_jax.scene.body import Body
from physagent_jax.scene.config import Anchor, Material
from physagent_jax.scene.elasticity import GridElasticity

MOST_PARTICLES = 12_000
MOST_CELLS = 600  # that are full; the probe's grid is no finer than the simulation's
STRAINED = 95  # [%] of the particles have less than the strain that counts
_SHARE = 1e-3  # of the residual that is left
_TIE = 2e-4  # in place of `elasticity.TIE`: the simulation has none, and it would prop up what is thin
_STEPS = 48  # in which b is found
_SETTLED, _DIGITS = 6, 0.02  # steps in which it grows by so small a share of itself
_UNIT = 1e5  # Young's modulus [Pa] for which it is measured


@dataclasses.dataclass(frozen=True)
class Burden:
    """The first-order effects of an object's weight; all are proportional to 1 / E.

    Attributes:
        strain: Norm of the strain, which 5 % of the particles exceed [1].
        sag: Largest displacement [L].
        buckling: Share of the stress that the pose bears before it gives way; from 1 on it does [1].
    """

    strain: float
    sag: float
    buckling: float

    def scaled(self, factor: float) -> Burden:
        """The burden of matter that is ``factor`` times as compliant."""
        return Burden(factor * self.strain, factor * self.sag, factor * self.buckling)


NONE = Burden(0.0, 0.0, 0.0)
_recent: Recent[Burden] = Recent(6)  # scenes of an object differ in what acts, and there may be hundreds


def find_burden(body: Body, material: Material, anchor: Anchor, *, ground: float | None, dx: float) -> Burden:
    """`measure_burden`, remembered from one round to the next, whatever the stiffness."""
    unit = material.changed(youngs_modulus=_UNIT, reason="")
    key = (unit.density, unit.poissons_ratio, anchor.model_dump_json(), ground, dx)
    found = _recent.find(body, key, lambda: measure_burden(body, unit, anchor, ground=ground, dx=dx))
    return found.scaled(_UNIT / material.youngs_modulus)


def measure_burden(
    body: Body, material: Material, anchor: Anchor, *, ground: float | None, dx: float
) -> Burden:
    """The burden of a body that hangs on its anchor, or stands on the ground.

    Args:
        body: The object at rest.
        material: With a Young's modulus; other laws than linear elasticity count as it.
        anchor: What is held; a mask's path is absolute.
        ground: Height of the ground [m], to which what touches it sticks; None = there is none.
        dx: Cells of the simulation [m].
    """
    particles = body.particles
    every = -(-particles.count // MOST_PARTICLES)
    x, volume = particles.x[::every].astype(np.float64), particles.volume[::every].astype(np.float64) * every
    coarse = float((volume.sum() / MOST_CELLS) ** (1 / 3))
    if coarse > dx:
        dx = coarse
        if ground is not None:  # nodes lie in the ground's plane, or a coarse foot would be a soft one
            lift = -ground % dx
            x[:, 2], ground = x[:, 2] + lift, ground + lift
    E, nu = material.youngs_modulus, material.poissons_ratio
    mu, lam = (np.full(len(x), each) for each in (E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))))
    mass = material.density * volume
    grid = GridElasticity(x, volume, mass, mu, lam, dx=dx, form="mls", share=_SHARE, tie=_TIE)
    held = select_anchored(
        anchor, particles.x, particles.gaussian_index, ".", gaussian_count=body.cloud.count
    )[::every]
    fixed = grid.spread @ (mass * held) > 0.5 * grid.mass
    if ground is not None:
        fixed |= grid.height <= ground + TOUCH * dx
    moves = ~(fixed | grid.light) & grid.find_borne(fixed & ~grid.light)
    if not moves.any():
        return NONE
    free = np.repeat(moves[:, None], 3, axis=1)
    weight = (grid.spread @ np.where(held, 0, mass))[:, None] * np.array([0.0, 0.0, -calibration.GRAVITY])
    grid.factorise(free)
    u, _ = grid.solve(np.where(free, weight, 0.0), free)
    slopes = grid.find_gradient(u)
    strain = np.linalg.norm(slopes + slopes.transpose(0, 2, 1), axis=(1, 2)) / 2
    sag = np.linalg.norm(grid.weight @ u, axis=1).max() / body.extent
    buckling = _find_buckling(grid, free, volume[:, None, None] * grid.compute_stress(u))
    return Burden(float(np.percentile(strain, STRAINED)), float(sag), buckling)


def _find_buckling(grid: GridElasticity, free: np.ndarray, stress: np.ndarray) -> float:
    """The largest b of the module's equation, 0 where stress only stiffens; ``stress`` is times volume [J]."""
    solve = grid.factors
    assert solve is not None
    size, index = free.size, np.flatnonzero(free.ravel())

    def spread(values):
        out = np.zeros(size)
        out[index] = values
        return out.reshape(free.shape)

    def soften(values):
        slopes = (grid.gradient @ spread(values)).reshape(-1, 3, 3)
        return -(grid.divergence @ (stress @ slopes).reshape(-1, 3)).ravel()[index]

    K = grid.matrix.tocsr()[index][:, index]
    q = np.random.default_rng(0).normal(size=len(index))
    Kq = K @ q
    basis, image, diagonal, beside, found = [], [], [], [], [0.0]
    for _ in range(_STEPS):  # of Lanczos, orthogonal in K
        length = np.sqrt(q @ Kq)
        if basis:
            beside.append(length)
        basis.append(q / length)
        image.append(Kq / length)
        Kq = soften(basis[-1])
        q = solve(spread(Kq)).ravel()[index]
        diagonal.append(basis[-1] @ Kq)
        for _ in range(2):
            shares = np.array(image) @ q
            q, Kq = q - shares @ np.array(basis), Kq - shares @ np.array(image)
        found.append(float(eigvalsh_tridiagonal(diagonal, beside)[-1]))
        if len(found) > _SETTLED and found[-1] - found[-1 - _SETTLED] <= _DIGITS * abs(found[-1]):
            break
    return max(0.0, found[-1])
