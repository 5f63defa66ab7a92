"""Fixed-corotated solid."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.linalg import Principal, singular_values, spectral
from physagent_jax.mpm.materials.base import History, Hyperelastic


@register_dataclass
@dataclasses.dataclass(frozen=True)
class FixedCorotated(Hyperelastic):
    """psi = mu |F - R|^2 + lam/2 (J - 1)^2  (Stomakhin et al. 2012, "Energetically consistent invertible elasticity").

    tau = 2 mu (F - R) F^T + lam J (J - 1) I = U diag(2 mu (s_i - 1) s_i + lam J (J - 1)) U^T. The "jelly" of
    PhysGaussian. As in the source, the smallest singular value carries the sign of J. The energy of matter of no volume
    is finite: a blow above 3 mu + lam/2 per volume crushes it, and since tau vanishes there, for good.

    Attributes:
        mu, lam: Lame parameters [Pa], shape (n,).
    """

    mu: jax.Array
    lam: jax.Array

    def energy(self, F: jax.Array, history: History = ()) -> jax.Array:
        """Strain energy per rest volume [J/m^3], shape (n,)."""
        return spectral(_energy, F, (self.mu, self.lam)).scalar

    def stress(self, F: jax.Array, history: History = ()) -> jax.Array:
        """Kirchhoff stress [Pa], shape (n, 3, 3)."""
        return spectral(_stress, F, (self.mu, self.lam)).spatial

    def stiffness(self, F: jax.Array, history: History = ()) -> jax.Array:
        """Since d tau_i / d ln s_j = 2 mu (2 s_i^2 - s_i) delta_ij + lam (2 J^2 - J), bounded by its largest terms."""
        s = singular_values(F)
        J = s.prod(-1)
        shear = (2 * s**2 - s).max(-1)
        return 2 * self.mu * jnp.maximum(shear, 0) + 3 * self.lam * jnp.maximum(2 * J**2 - J, 0)


def principal_stress(s: jax.Array, mu: jax.Array, lam: jax.Array) -> jax.Array:
    """Principal Kirchhoff stresses [Pa] at the singular values s, shape (3, n)."""
    J = s.prod(0)
    return 2 * mu * (s - 1) * s + lam * J * (J - 1)


def _energy(s: jax.Array, parameters: tuple[jax.Array, jax.Array]) -> Principal:
    mu, lam = parameters
    return Principal(scalar=mu * ((s - 1) ** 2).sum(0) + 0.5 * lam * (s.prod(0) - 1) ** 2)


def _stress(s: jax.Array, parameters: tuple[jax.Array, jax.Array]) -> Principal:
    return Principal(spatial=principal_stress(s, *parameters))
