"""Fixed-corotated solid."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.mpm.linalg import determinant, matmul, polar_rotation, transpose
from physagent_jax.mpm.materials.base import History, Hyperelastic, principal_stretches_squared
from physagent_jax.pytree import register_dataclass


@register_dataclass
@dataclasses.dataclass(frozen=True)
class FixedCorotated(Hyperelastic):
    """psi = mu |F - R|^2 + lam/2 (J - 1)^2  (Stomakhin et al. 2012, "Energetically consistent invertible elasticity").

    tau = 2 mu (F - R) F^T + lam J (J - 1) I, with R the polar rotation. The "jelly" of PhysGaussian.

    Attributes:
        mu, lam: Lame parameters [Pa], shape (n,).
    """

    mu: jax.Array
    lam: jax.Array

    def energy(self, F: jax.Array, history: History = ()) -> jax.Array:
        """Strain energy per rest volume [J/m^3], shape (n,)."""
        deviation = F - polar_rotation(F)
        return self.mu * (deviation**2).sum((-1, -2)) + 0.5 * self.lam * (determinant(F) - 1) ** 2

    def stress(self, F: jax.Array, history: History = ()) -> jax.Array:
        """Kirchhoff stress [Pa], shape (n, 3, 3)."""
        J = determinant(F)
        shear = matmul(F - polar_rotation(F), transpose(F))
        pressure = self.lam * J * (J - 1)
        return 2 * self.mu[:, None, None] * shear + pressure[:, None, None] * jnp.eye(3, dtype=F.dtype)

    def stiffness(self, F: jax.Array, history: History = ()) -> jax.Array:
        """Since d tau_i / d ln s_j = 2 mu (2 s_i^2 - s_i) delta_ij + lam (2 J^2 - J), bounded by its largest terms."""
        squared = principal_stretches_squared(F)
        s = jnp.sqrt(squared)
        J = s.prod(-1)
        shear = (2 * squared - s).max(-1)
        return 2 * self.mu * jnp.maximum(shear, 0) + 3 * self.lam * jnp.maximum(2 * J**2 - J, 0)
