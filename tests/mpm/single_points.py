"""Materials driven directly by a deformation gradient, without a grid."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import numpy as np
from scipy.spatial.transform import Rotation

from physagent_jax.mpm import (
    Brittle,
    DruckerPrager,
    FixedCorotated,
    Fluid,
    Hencky,
    NeoHookean,
    Plasticine,
    Snow,
    Viscoplastic,
    VonMises,
    lame_parameters,
)
from physagent_jax.mpm.materials.base import TORN

E, NU = 1.7e5, 0.31
MU, LAM = lame_parameters(E, NU)
K = LAM + 2 / 3 * MU
DT = 1e-3

PARAMETERS = {
    "neo-Hookean": (NeoHookean, dict(mu=MU, lam=LAM)),
    "fixed corotated": (FixedCorotated, dict(mu=MU, lam=LAM)),
    "Hencky": (Hencky, dict(mu=MU, lam=LAM)),
    "von Mises": (VonMises, dict(mu=MU, lam=LAM, yield_stress=0.1 * E, hardening=0.2 * E)),
    "plasticine": (Plasticine, dict(mu=MU, lam=LAM, yield_stress=0.1 * E, softening=0.1 * E)),
    "sand": (DruckerPrager, dict(mu=MU, lam=LAM, friction_angle=0.6, cohesion=0.0)),
    "cohesive soil": (DruckerPrager, dict(mu=MU, lam=LAM, friction_angle=0.6, cohesion=0.05 * E)),
    "clay": (DruckerPrager, dict(mu=MU, lam=LAM, friction_angle=0.0, cohesion=0.05 * E)),
    "slurry": (DruckerPrager, dict(mu=MU, lam=LAM, friction_angle=0.0, cohesion=0.0)),
    "glass": (Brittle, dict(mu=MU, lam=LAM, friction_angle=0.6, cohesion=0.05 * E)),
    "foam": (Viscoplastic, dict(mu=MU, lam=LAM, yield_stress=0.1 * E, plastic_viscosity=2 * MU * DT)),
    "snow": (
        Snow,
        dict(
            mu=MU, lam=LAM, critical_compression=0.03, critical_stretch=0.01, hardening=9.0, hardening_cap=4.0
        ),
    ),
    "fluid": (Fluid, dict(bulk_modulus=K)),
}
ELASTIC_AT_REST = [name for name in PARAMETERS if name not in ("fluid", "sand", "slurry")]
PLASTIC = [name for name in PARAMETERS if name not in ("neo-Hookean", "fixed corotated", "Hencky")]

COUNT = 32  # one batch size everywhere: the SVD compiles once


# Not jitted: operation by operation they share what is compiled.
def stress(material, F, history) -> Any:
    return material.stress(F, history)


def energy(material, F, history) -> Any:
    return material.energy(F, history)


def project(material, F, history, dt: Any = DT) -> Any:
    return material.project(F, history, dt)


def material(name, count=COUNT, dtype: Any = float, **changes: Any) -> Any:
    """The material called ``name`` with the same parameters at each of ``count`` particles."""
    kind, parameters = PARAMETERS[name]
    static = {key: changes.pop(key) for key in ("tension", "exponent") if key in changes}
    return kind(**{k: jnp.full(count, v, dtype) for k, v in (parameters | changes).items()}, **static)


def histories(law, seed=3):
    """A plausible past for each particle: some plastic strain, gained volume or compaction."""
    initial = law.initial_history()
    if isinstance(initial, tuple):
        return initial
    past = np.random.default_rng(seed).uniform(0, 0.3, initial.shape)
    past[0] = past[-1] = 0.0
    if isinstance(law, Plasticine):
        past[1::4] = 1.5  # its yield stress is used up
    if isinstance(law, DruckerPrager):
        past *= 0.5 * np.log(TORN) / 0.15
    return initial + jnp.asarray(past - (0.15 if isinstance(law, Snow) else 0), initial.dtype)


def rotations(seed=0):
    return Rotation.random(COUNT, rng=np.random.default_rng(seed)).as_matrix()


def random_F(spread=0.3, seed=0):
    """Deformation gradients with det F > 0.1, most of them beyond yield; the last two diag(2, 2, 1) and I."""
    rng = np.random.default_rng(seed)
    F = np.eye(3) + spread * rng.uniform(-1, 1, (4 * COUNT, 3, 3))
    F = F[np.linalg.det(F) > 0.1][:COUNT]
    assert len(F) == COUNT
    F[-1], F[-2] = np.eye(3), np.diag([2.0, 2.0, 1.0])
    return jnp.asarray(F)


def diagonal(*rows):
    """diag(exp(eps)) for each row of logarithmic strains, shape (k, 3, 3)."""
    return jnp.asarray(np.exp(np.asarray(rows, float))[:, :, None] * np.eye(3))


def after_return(law, F, history=None, dt=DT):
    """Kirchhoff stress and history after the return mapping of trial F, as numpy arrays."""
    history = law.initial_history() if history is None else history
    F, history = project(law, jnp.asarray(F), history, dt)
    return np.asarray(stress(law, F, history)), history
