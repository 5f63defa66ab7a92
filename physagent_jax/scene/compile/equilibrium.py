"""The captured pose at rest under its own weight: a sag-free start.

An object is captured as gravity had already bent it. Started without stress it would sag, quiver and spread; what the
capture lacks is not another pose but the stress that bears the weight. That stress is found where the simulation
itself would balance it, on the grid nodes under the captured particles (cf. Hsu et al. 2022, "A General Two-Stage
Initialization for Sag-Free Deformable Simulations", who do so for MPM too):

    sum_p V_p tau_p g_ip = m_i g   for every node i that is free,

g_ip as stress acts on nodes (`mpm.transfer`). Of all stresses that do, those of linear elasticity are taken, by
conjugate gradients: the equations are linear in the stress, whatever the law. Each particle is then given the stretch
with which its own law has that stress. These stretches fit no displacement, and need not: no particle is moved, and
nothing turns. Nodes in the ground bear pressure only, and drag up to Coulomb's share of it.
"""

from __future__ import annotations

import dataclasses
import warnings
from typing import Any

import jax
import numpy as np

from physagent_jax.core.arrays import to_device
from physagent_jax.core.recent import Recent
from physagent_jax.mpm import Model, State
from physagent_jax.mpm.boundaries.contact import TOUCH
from physagent_jax.mpm.materials import FixedCorotated, Hencky, NeoHookean
from physagent_jax.mpm.step import kirchhoff_stress
from physagent_jax.scene import config as c
from physagent_jax.scene.body import Body
from physagent_jax.scene.elasticity import INNER_ROUNDS, GridElasticity

GOOD_ENOUGH = 4e-3  # of gravity: what the acceleration of nearly all particles may be that is left
POOR = 0.06  # of gravity, beyond which the pose is not said to be in equilibrium
ROUNDS = 20  # in which nodes lift off the ground, slide on it, and the rest is balanced
ALL_ROUNDS = 2000  # of conjugate gradients in all: seconds with 20,000 particles that stand on thin legs
LAW_ROUNDS = 30  # in which stretches are found that have the stresses
ENOUGH_STRESS = 1e-5  # of the largest, which may be missed
MOST_STRAIN = 0.2  # by which such a round may change any stretch
CRUSHED, MOST_CRUSHED = (
    1.0,
    0.01,
)  # largest strain, beyond which matter is crushed; share of it, with which none starts


@dataclasses.dataclass(frozen=True)
class Equilibrium:
    """The residual of the balance between weight and stress.

    Attributes:
        F: Elastic deformation gradients, shape (n, 3, 3), float32.
        residual: Acceleration that the simulation starts with, root mean square by mass, over gravity. What the tie
            (`scene.elasticity`) bears is part of it: the simulation has none.
        largest_strain: Largest entry of F - I.
        crushed: Share of the particles that have one beyond `CRUSHED`.
    """

    F: np.ndarray
    residual: float
    largest_strain: float
    crushed: float = 0.0


_recent: Recent[Equilibrium] = Recent(4)  # rounds of a run differ in what acts, not in how the object stands


def balance_weight(
    model: Model, state: State, held: np.ndarray, config: c.SceneConfig, body: Body
) -> Equilibrium | None:
    """`find_equilibrium` for a scene that asks for it, remembered from one round to the next; None = there is none.

    Only for matter that keeps its shape by elasticity alone: what flows starts as it is.
    """
    if config.start != "equilibrium" or model.gravity is None:
        return None
    if not all(isinstance(law, NeoHookean | FixedCorotated | Hencky) for law in model.materials):
        return None
    same = {"force_field", "scaling", "forces", "camera", "rendering", "timing", "prompt", "preset", "ledger"}
    key = config.model_dump_json(exclude=same)
    return _recent.find(body, key, lambda: find_or_warn(model, state, held, config))


def find_or_warn(model: Model, state: State, held: np.ndarray, config: c.SceneConfig) -> Equilibrium:
    """`find_equilibrium`, with a word if it is a poor one."""
    found = find_equilibrium(model, state, held, config)
    if found.crushed > MOST_CRUSHED:  # such a start would burst: it sags from the captured pose instead
        found = Equilibrium(np.asarray(state.F), 1.0, 0.0)
    if found.residual > POOR:
        warnings.warn(
            "the object's own weight could not be balanced as it was captured: it will sag or collapse at first; a "
            "stiffer (`material.youngs_modulus`) or lighter (`material.density`) material, or a held base "
            "(`anchor.kind` base), helps",
            UserWarning,
            stacklevel=2,
        )
    return found


def find_equilibrium(model: Model, state: State, held: np.ndarray, config: c.SceneConfig) -> Equilibrium:
    """Stress that lets the particles of ``state`` stay where they are.

    Args:
        model: With gravity and elastic materials.
        state: At rest; only its positions are used.
        held: Particles that something holds, shape (n,).
        config: For its ground.
    """
    return _Balance(model, state, held, config).solve()


class _Balance:
    """The balance of forces at the nodes."""

    def __init__(self, model: Model, state: State, held: np.ndarray, config: c.SceneConfig):
        assert model.gravity is not None
        self._model, self._state = model, state
        mass = np.asarray(model.mass, np.float64)
        dx = float(model.grid.dx)
        mu, lam = _compute_lame(model)
        self._grid = grid = GridElasticity(
            state.x, model.volume, mass, mu, lam, dx=dx, form=model.stress_form
        )
        gravity = np.asarray(model.gravity, np.float64)
        # What is held is given its velocity after forces have acted: its weight does not reach the nodes.
        self._load = (grid.spread @ np.where(held, 0, mass))[:, None] * gravity
        self._g = float(np.linalg.norm(gravity))
        fixed = grid.spread @ (mass * held) > 0.5 * grid.mass
        ground = np.zeros(len(grid.mass), bool)
        self._friction = 0.0
        for boundary in config.boundaries:
            if isinstance(boundary, c.HalfSpace) and boundary.normal[2] > 0.999:
                ground |= grid.height <= boundary.point[2] + TOUCH * dx
                self._friction = boundary.friction
        # Pieces that nothing holds up have no equilibrium: they keep no stress and fall.
        borne = grid.find_borne(fixed | ground)
        self._light = (grid.light | ~borne) & ~fixed
        self._fixed, self._ground = fixed, ground & ~fixed

    def solve(self) -> Equilibrium:
        """The stresses that balance the weight, and deformation gradients that have them."""
        grid = self._grid
        u = np.zeros((len(grid.mass), 3))
        pressed = self._ground.copy()  # nodes that the ground bears
        left = ALL_ROUNDS
        for _ in range(ROUNDS):
            # The tie helps to find u but bears nothing itself: what it took is left over, and found in the next round.
            out = (
                grid.compute_force(grid.compute_stress(u)) - self._load
            )  # what ground or hand would have to add
            rest, free = self._find_free(out, pressed)
            lifted = pressed & (out[:, 2] < 0)
            if left <= 0 or (max(self._measure_errors(rest)) < GOOD_ENOUGH and not lifted.any()):
                break
            pressed = (pressed & ~lifted) | (self._ground & ~pressed & (u[:, 2] < 0))
            rest, free = self._find_free(out, pressed)
            step, spent = grid.solve(-rest, free, min(left, INNER_ROUNDS))
            left -= max(spent, 1)
            u = u + step
        F, tau = self._invert_law(grid.compute_stress(u))
        rest, _ = self._find_free(grid.compute_force(tau) - self._load, pressed)
        strain = _find_largest(F - np.eye(3))
        return Equilibrium(
            F.astype(np.float32),
            self._measure_errors(rest)[0],
            float(strain.max()),
            float((strain > CRUSHED).mean()),
        )

    def _invert_law(self, stress) -> tuple[np.ndarray, np.ndarray]:
        """Stretches whose Kirchhoff stress is ``stress``, and what it is; all (n, 3, 3).

        By the compliance of the unstrained material: laws are isotropic, so that all stays coaxial. Where a step brings
        a particle no nearer, half of it is tried next: what is pressed together beyond any stretch of its law keeps the
        nearest that was found.
        """
        F = np.broadcast_to(np.eye(3), stress.shape)
        tau, share = np.zeros_like(stress), np.ones((len(stress), 1, 1))
        for _ in range(LAW_ROUNDS):
            miss = stress - tau
            if np.abs(miss).max() < ENOUGH_STRESS * np.abs(stress).max():
                break
            change = self._grid.find_strain(miss)
            largest = np.abs(change).max(axis=(1, 2), keepdims=True)
            step = share * np.minimum(1.0, MOST_STRAIN / np.maximum(largest, 1e-12))
            trial = F + (step * change) @ F
            found = self._compute_stress(trial)
            nearer = _find_largest(stress - found) < _find_largest(miss)  # not so where it is not a number
            F, tau = np.where(nearer, trial, F), np.where(nearer, found, tau)
            share = np.where(nearer, np.minimum(1.0, 2.0 * share), 0.5 * share)
        return F, tau

    def _measure_errors(self, rest) -> tuple[float, float]:
        mean, most = self._grid.measure_accelerations(rest)
        return mean / self._g, most / self._g

    def _find_free(self, out, pressed) -> tuple[np.ndarray, np.ndarray]:
        """Forces that nothing balances, and which components can move, shapes (nodes, 3)."""
        free = np.repeat(~(self._fixed | self._light)[:, None], 3, axis=1)
        tangential = np.linalg.norm(out[:, :2], axis=1, keepdims=True)
        most = self._friction * np.maximum(out[:, 2:], 0)
        sliding = pressed & (tangential > most)[:, 0]
        free[pressed, 2] = False
        free[pressed & ~sliding, :2] = False
        rest = out.copy()
        left = out[:, :2] * np.maximum(0, 1 - most / np.maximum(tangential, 1e-30))
        rest[sliding, :2] = left[sliding]
        return np.where(free, rest, 0.0), free

    def _compute_stress(self, F) -> np.ndarray:
        state = dataclasses.replace(self._state, F=to_device(F, np.float32))
        return np.asarray(jax.jit(kirchhoff_stress)(self._model, state), np.float64)


def _find_largest(stress: np.ndarray) -> np.ndarray:
    """The largest entry of each, shape (n, 1, 1)."""
    return np.abs(stress).max(axis=(1, 2), keepdims=True)


def _compute_lame(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Lame parameters of the particles [Pa], shapes (n,)."""
    blocks: list[Any] = list(model.materials)
    mu, lam = (np.concatenate([getattr(law, name) for law in blocks]) for name in ("mu", "lam"))
    return mu.astype(np.float64), lam.astype(np.float64)
