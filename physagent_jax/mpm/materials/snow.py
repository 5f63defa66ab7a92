"""Snow."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.linalg import Principal, singular_values, spectral
from physagent_jax.mpm.materials.base import History, Hyperelastic
from physagent_jax.mpm.materials.fixed_corotated import FixedCorotated, principal_stress


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Snow(Hyperelastic):
    """Fixed-corotated elasticity that hardens under compaction and breaks when stretched  (Stomakhin et al. 2013).

    psi = h(J_p) (mu |F - R|^2 + lam/2 (J - 1)^2),  h = min(exp(xi (1 - J_p)), cap). `project` clamps the
    singular values of F to [1 - theta_c, 1 + theta_s] and moves what it takes off into the plastic volume
    ratio J_p, the history: J J_p is conserved. Compacted snow (J_p < 1) is stiffer, up to the cap, which
    the source lacks and the time step needs; spread-out snow (J_p > 1) weakens without a lower bound.

    Attributes:
        mu, lam: Lame parameters of fresh snow [Pa], shape (n,).
        critical_compression: theta_c in (0, 1), shape (n,); 0.025 in the source.
        critical_stretch: theta_s >= 0, shape (n,); 0.0075 in the source.
        hardening: xi >= 0, shape (n,); 10 in the source.
        hardening_cap: Greatest h, >= 1, shape (n,).
    """

    mu: jax.Array
    lam: jax.Array
    critical_compression: jax.Array
    critical_stretch: jax.Array
    hardening: jax.Array
    hardening_cap: jax.Array

    def initial_history(self) -> History:
        """J_p = 1: fresh snow."""
        return jnp.ones_like(self.hardening)

    def hardening_factor(self, history: History) -> jax.Array:
        """h(J_p), shape (n,)."""
        exponent = self.hardening * (1 - jnp.asarray(history))
        below = exponent < jnp.log(self.hardening_cap)
        return jnp.where(below, jnp.exp(jnp.where(below, exponent, 0)), self.hardening_cap)

    def energy(self, F: jax.Array, history: History) -> jax.Array:
        """Strain energy per rest volume [J/m^3], shape (n,)."""
        return self._harden(self.hardening_factor(history)).energy(F)

    def stress(self, F: jax.Array, history: History) -> jax.Array:
        """Kirchhoff stress [Pa], shape (n, 3, 3)."""
        return self._harden(self.hardening_factor(history)).stress(F)

    def stiffness(self, F: jax.Array, history: History) -> jax.Array:
        """`FixedCorotated`'s bound with the hardening cap, at the largest stretch that `project` lets pass.

        It holds for the coming steps too, however much the snow is compacted in them.
        """
        stretch = jnp.maximum(singular_values(F), (1 + self.critical_stretch)[:, None])
        return self._harden(self.hardening_cap).stiffness(stretch[..., None] * jnp.eye(3, dtype=F.dtype))

    def project(self, F: jax.Array, history: History, dt: jax.Array) -> tuple[jax.Array, History]:
        """Clamp the singular values; the history is the plastic volume ratio J_p."""
        del dt
        result = spectral(_clamp, F, (self, history))
        return result.change, result.scalar

    def respond(self, F: jax.Array, history: History, dt: jax.Array) -> tuple[jax.Array, History, jax.Array]:
        """`project` and the stress after it, from one SVD."""
        del dt
        result = spectral(_clamp_and_stress, F, (self, history))
        return result.change, result.scalar, result.spatial

    def _harden(self, factor: jax.Array) -> FixedCorotated:
        return FixedCorotated(self.mu * factor, self.lam * factor)


def _clamp(s: jax.Array, parameters: tuple[Snow, jax.Array]) -> Principal:
    material, plastic_ratio = parameters
    low, high = 1 - material.critical_compression, 1 + material.critical_stretch
    # An inversion is not clamped into something plausible: it stays visible as a negative determinant.
    clamped = jnp.where(s > high, high, jnp.where((s < low) & (s > 0), low, s))
    return Principal(change=clamped - s, scalar=plastic_ratio * (s / clamped).prod(0))


def _clamp_and_stress(s: jax.Array, parameters: tuple[Snow, jax.Array]) -> Principal:
    clamped = _clamp(s, parameters)
    change, plastic_ratio = clamped.change, clamped.scalar
    material, stretch = parameters[0], s + change
    factor = material.hardening_factor(plastic_ratio)
    stress = principal_stress(stretch, material.mu * factor, material.lam * factor)
    return Principal(change=change, spatial=stress, scalar=plastic_ratio)
