"""Compressible neo-Hookean solid."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.linalg import cofactor, determinant, greatest_stretch_squared, matmul, transpose
from physagent_jax.mpm.materials.base import History, Hyperelastic


@register_dataclass
@dataclasses.dataclass(frozen=True)
class NeoHookean(Hyperelastic):
    """psi = mu/2 (tr(F^T F) - 3) - mu ln J + lam/2 (ln J)^2  (Bonet & Wood 2008, eq. 6.27).

    tau = mu (F F^T - I) + lam ln J I. Needs no SVD. Undefined for J <= 0 (not finite: the rollout's
    check catches it).

    Attributes:
        mu, lam: Lame parameters [Pa], shape (n,).
    """

    mu: jax.Array
    lam: jax.Array

    def energy(self, F: jax.Array, history: History = ()) -> jax.Array:
        """Strain energy per rest volume [J/m^3], shape (n,).

        With H = F - I and J - 1 = tr H + rest, the first two terms are mu (|H|^2/2 - rest + (J - 1) - ln J): what
        is left to cancel is small where H is, and a strain of 1e-4 keeps its energy in single precision.
        """
        H = F - jnp.eye(3, dtype=F.dtype)
        trace = H[..., 0, 0] + H[..., 1, 1] + H[..., 2, 2]
        K = cofactor(H)
        rest = K[..., 0, 0] + K[..., 1, 1] + K[..., 2, 2] + determinant(H)
        change = trace + rest  # J - 1
        near = jnp.abs(change) < 0.5
        log_J = jnp.where(
            near, jnp.log1p(jnp.where(near, change, 0)), jnp.log(jnp.where(near, 1, determinant(F)))
        )
        shape = 0.5 * (H**2).sum((-1, -2)) - rest + (change - log_J)
        return self.mu * shape + 0.5 * self.lam * log_J**2

    def stress(self, F: jax.Array, history: History = ()) -> jax.Array:
        """Kirchhoff stress [Pa], shape (n, 3, 3)."""
        b = matmul(F, transpose(F))
        identity = jnp.eye(3, dtype=F.dtype)
        pressure = self.lam * jnp.log(determinant(F))
        return self.mu[:, None, None] * (b - identity) + pressure[:, None, None] * identity

    def stiffness(self, F: jax.Array, history: History = ()) -> jax.Array:
        """Since d tau_i / d ln lambda_j = 2 mu lambda_i^2 delta_ij + lam, so at most 2 mu max(lambda^2) + 3 lam."""
        return 2 * self.mu * greatest_stretch_squared(F) + 3 * self.lam
