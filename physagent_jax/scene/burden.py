"""The burden of an object's own weight: the strain that bears it, whether the pose that bears it is stable, and where.

A pose can be in balance and not last: a thin stem that carries a heavy head buckles, however well its stress balances
the weight. So the stress of linear elasticity under the weight is found on a coarse grid, and with it the largest
factors by which it exceeds what the pose can bear. That is linear buckling: with K the stiffness of the matter and G
that of the stress (Zienkiewicz & Taylor 2005, The Finite Element Method for Solid and Structural Mechanics, chapter
11),

    -G u = b K u,    u^T G u = sum_p V_p tr(grad u sigma grad u^T),

the pose is stable if no b reaches 1. Weight does not change with stiffness: strains, displacements and b go with 1 / E.

Only what bears a burden has to be stiffer. A strain asks for more E where it is; a buckling mode where it stores its
energy: with a density r of it, E(x) = E min(c r^p, `_TOP`), and c such that the mode bears as much as with a uniform E,

    int r / min(c r^p, `_TOP`) dV = int r dV.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.linalg import eigh_tridiagonal, eigvalsh_tridiagonal
from scipy.spatial import KDTree

from physagent_jax.core.recent import Recent
from physagent_jax.forces import calibration
from physagent_jax.mpm import lame_parameters
from physagent_jax.mpm.boundaries.contact import TOUCH
from physagent_jax.scene.anchor import select_anchored
from physagent_jax.scene.body import Body
from physagent_jax.scene.config import Anchor, Bearing, Material
from physagent_jax.scene.elasticity import GridElasticity
from physagent_jax.scene.store import Numbers, keep

MOST_STRAIN = 0.25  # by which its weight may strain an object, to first order; beyond, it collapses
MOST_PEAK = 0.5  # of the largest strain over a cell: a thin neck is few of the particles, and tears
MOST_BUCKLING = 0.75  # of the stress under which it gives way; the grid is coarse
MOST_PARTICLES = 6000
MOST_CELLS = 450  # that are full; the probe's grid is no finer than the simulation's
FINER = 2.0  # times as many, where it may buckle: a thin neck is too stiff on a coarse grid
_SUSPECT = 0.2  # of the stress under which it gives way, from which on that is asked of what seems to stand
_NECK = 1.5  # times the buckling on the coarse grid: what makes so much of a difference is thin
STRAINED = 95  # [%] of the particles have less than the strain that counts
_SHARE = 1e-3  # of the residual that is left
_TIE = 2e-4  # in place of `elasticity.TIE`: the simulation has none, and it would prop up what is thin
_STEPS = 48  # in which b is found
_SETTLED, _DIGITS = 6, 0.02  # steps in which it grows by so small a share of itself
_EXHAUSTED = 1e-20  # of a step's length squared: what is left of it is round-off
_MODES, _LEAST = 6, 0.25  # of buckling that are looked at, and over the largest
_POWER = 0.75  # of a mode's energy density to which E goes; between least E in sum and few stiff places
_TOP = 1.3  # times the uniform E that does the same, at most: the stiffest part decides the time step
_UNIT = 1e5  # Young's modulus [Pa] for which it is measured


@dataclasses.dataclass(frozen=True)
class Burden:
    """The first-order effects of an object's weight; all are proportional to 1 / E, but ``needed``.

    Attributes:
        strain: Norm of the strain, which 5 % of the particles exceed [1].
        peak: Largest mean of it over a cell [1].
        sag: Largest displacement [L].
        buckling: Share of the stress that the pose bears before it gives way; from 1 on it does [1].
        needed: Young's modulus with which each particle bears its part within the limits [Pa], shape (n,); None =
            nothing is borne.
        finer: Times as many cells as usual, on which it was measured.
    """

    strain: float
    peak: float
    sag: float
    buckling: float
    needed: Numbers | None = None
    finer: float = 1.0

    @property
    def share(self) -> float:
        """Share of what the limits allow; beyond 1 it collapses."""
        return max(self.strain / MOST_STRAIN, self.peak / MOST_PEAK, self.buckling / MOST_BUCKLING)

    def scaled(self, factor: float) -> Burden:
        """The burden of matter that is ``factor`` times as compliant."""
        names = ("strain", "peak", "sag", "buckling")
        return dataclasses.replace(self, **{name: factor * getattr(self, name) for name in names})


NONE = Burden(0.0, 0.0, 0.0, 0.0)
_recent: Recent[Burden] = Recent(6)  # scenes of an object differ in what acts, and there may be hundreds
_recent_firmness: Recent[np.ndarray] = Recent(6)


def find_burden(body: Body, material: Material, anchor: Anchor, *, ground: float | None, dx: float) -> Burden:
    """`measure_burden`, remembered from one round to the next, whatever the stiffness.

    What seems to stand and is not far from buckling is looked at finely.
    """
    unit = material.changed(youngs_modulus=_UNIT, reason="")

    def look(finer: float) -> Burden:
        key = (unit.density, unit.poissons_ratio, anchor.model_dump_json(), ground, dx, finer)
        found = _recent.find(
            body, key, lambda: measure_burden(body, unit, anchor, ground=ground, dx=dx, finer=finer)
        )
        return found.scaled(_UNIT / material.youngs_modulus)

    found = look(1.0)
    if found.buckling < _SUSPECT or found.share > 1:
        return found
    fine = look(FINER)
    return fine if fine.buckling > _NECK * found.buckling else found


def find_firmness(
    body: Body, material: Material, anchor: Anchor, bearing: Bearing | None, *, dx: float
) -> np.ndarray | None:
    """Factors of E with which each particle bears its part of the weight, shape (n,), at least 1; None = all are.

    Where stiffer parts do not suffice, because others then give way, all become stiffer by what is missing.

    Args:
        body: The object at rest.
        material: What it is made of.
        anchor: What is held.
        bearing: What bears it; None = its material alone.
        dx: Cells of the simulation [m].
    """
    if bearing is None:
        return None

    def measure():
        plain = find_burden(body, material, anchor, ground=bearing.ground, dx=dx)
        ones = np.ones(body.particles.count)
        if bearing.weight * plain.share <= 1 or plain.needed is None:
            return ones
        firmness = np.maximum(ones, bearing.weight * plain.needed / material.youngs_modulus)
        firm = measure_burden(
            body, material, anchor, ground=bearing.ground, dx=dx, firmness=firmness, finer=plain.finer
        )
        return firmness * max(1.0, bearing.weight * firm.share)

    numbers = material.youngs_modulus, material.density, material.poissons_ratio
    key = (*numbers, anchor.model_dump_json(), bearing.ground, bearing.weight, dx)
    return _recent_firmness.find(body, key, measure)


def measure_burden(
    body: Body,
    material: Material,
    anchor: Anchor,
    *,
    ground: float | None,
    dx: float,
    firmness: np.ndarray | None = None,
    finer: float = 1.0,
) -> Burden:
    """The burden of a body that hangs on its anchor, or stands on the ground.

    Args:
        body: The object at rest.
        material: With a Young's modulus; other laws than linear elasticity count as it.
        anchor: What is held; a mask's path is absolute.
        ground: Height of the ground [m], to which what touches it sticks; None = there is none.
        dx: Cells of the simulation [m].
        firmness: Factors of Young's modulus, shape (n,); None = 1.
        finer: Times as many cells as usual.
    """
    particles = body.particles
    held = select_anchored(
        anchor, particles.x, particles.gaussian_index, ".", gaussian_count=body.cloud.count
    )
    E = material.youngs_modulus if firmness is None else material.youngs_modulus * firmness
    matter = material.density, E, material.poissons_ratio
    return _measure(particles.x, particles.volume, body.extent, held, *matter, ground, dx, finer)


@keep
def _measure(
    points: np.ndarray,
    volumes: np.ndarray,
    extent: float,
    held: np.ndarray,
    density: float,
    modulus: float | np.ndarray,
    nu: float,
    ground: float | None,
    dx: float,
    finer: float,
) -> Burden:
    """`measure_burden` of numbers alone."""
    every = -(-len(points) // MOST_PARTICLES)
    x, volume = points[::every].astype(np.float64), volumes[::every].astype(np.float64) * every
    coarse = float((volume.sum() / (finer * MOST_CELLS)) ** (1 / 3))
    if coarse > dx:
        dx = coarse
        if ground is not None:  # nodes lie in the ground's plane, or a coarse foot would be a soft one
            lift = -ground % dx
            x[:, 2], ground = x[:, 2] + lift, ground + lift
    E = np.broadcast_to(modulus, len(points))[::every]
    mass, held = density * volume, held[::every]
    mu, lam = lame_parameters(E, nu)
    grid = GridElasticity(x, volume, mass, mu, lam, dx=dx, form="mls", share=_SHARE, tie=_TIE)
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

    def smooth(values):
        return grid.weight @ ((grid.spread @ (volume * values)) / np.maximum(grid.spread @ volume, 1e-30))

    slopes = grid.find_gradient(u)
    strain = np.linalg.norm(slopes + slopes.transpose(0, 2, 1), axis=(1, 2)) / 2
    sag = np.linalg.norm(grid.weight @ u, axis=1).max() / extent
    modes = _find_buckling(grid, free, volume[:, None, None] * grid.compute_stress(u))
    smoothed = smooth(strain)
    needed = E * smoothed / MOST_STRAIN
    for b, mode in modes:
        energy = smooth((grid.find_gradient(mode) * grid.compute_stress(mode)).sum((1, 2)))
        share = _share_out(np.maximum(energy, 0), volume)
        needed = np.maximum(needed, E * share * b / MOST_BUCKLING)
    nearest = KDTree(points[::every]).query(points)[1]
    buckling = modes[0][0] if modes else 0.0
    often, peak = np.percentile(strain, STRAINED), smoothed.max()
    return Burden(float(often), float(peak), float(sag), buckling, needed[nearest], finer)


def _share_out(density: np.ndarray, volume: np.ndarray) -> np.ndarray:
    """Factors of a uniform E with which a mode bears as much as with it: E(x) of the module, shape (n,)."""
    work, least, most = volume @ density, 0.0, _TOP / max(density.max(), 1e-300) ** _POWER * 1e6
    for _ in range(60):
        middle = 0.5 * (least + most)
        share = np.minimum(middle * density**_POWER, _TOP)
        soft = (volume * density / np.maximum(share, 1e-300)).sum() > work
        least, most = (middle, most) if soft else (least, middle)
    return share


def _find_buckling(
    grid: GridElasticity, free: np.ndarray, stress: np.ndarray
) -> list[tuple[float, np.ndarray]]:
    """The largest b of the module's equation and their displacements u; ``stress`` is times volume [J].

    None where stress only stiffens.
    """
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
        before = q @ Kq
        diagonal.append(basis[-1] @ Kq)
        for _ in range(2):
            shares = np.array(image) @ q
            q, Kq = q - shares @ np.array(basis), Kq - shares @ np.array(image)
        found.append(float(eigvalsh_tridiagonal(diagonal, beside)[-1]))
        if len(found) > _SETTLED and found[-1] - found[-1 - _SETTLED] <= _DIGITS * abs(found[-1]):
            break
        if not q @ Kq > _EXHAUSTED * before:  # few nodes are free: the basis spans all that they can do
            break
    values, vectors = eigh_tridiagonal(diagonal, beside)
    chosen = [i for i in np.argsort(-values)[:_MODES] if values[i] > max(0.0, _LEAST * values.max())]
    return [(float(values[i]), spread(vectors[:, i] @ np.array(basis))) for i in chosen]
