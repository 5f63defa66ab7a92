"""Hencky (logarithmic strain) solid, and what the plastic laws built on it share."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.linalg import Principal, spectral
from physagent_jax.mpm.materials.base import History, Hyperelastic


class HenckyElasticity(Hyperelastic):
    """psi = mu sum eps_i^2 + lam/2 (sum eps_i)^2 with eps = ln s, the logarithmic principal stretches.

    tau = U diag(2 mu eps + lam tr(eps)) U^T. The elastic part of `Hencky` and of the plastic laws.
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
        """Since d tau_i / d eps_j = 2 mu delta_ij + lam at every strain: 2 mu + 3 lam, or 2 mu for lam < 0."""
        return 2 * self.mu + 3 * jnp.maximum(self.lam, 0)


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Hencky(HenckyElasticity):
    """StVK-Hencky solid: psi = mu sum (ln s_i)^2 + lam/2 (ln J)^2  (Hencky 1928; Klar et al. 2016, eq. 26).

    tau = U diag(2 mu ln s + lam ln J) U^T. Its tangent in the logarithmic strain is constant, so that the
    stable time step does not depend on the deformation. For J <= 0 energy and stress are not finite.

    Attributes:
        mu, lam: Lame parameters [Pa], shape (n,).
    """

    mu: jax.Array
    lam: jax.Array


class HenckyPlasticity(HenckyElasticity):
    """Hencky elasticity with a return mapping along the principal logarithmic strains: a law states its `flow`."""

    def flow(self, eps: jax.Array, history: Any, dt: jax.Array) -> tuple[jax.Array, Any]:
        """The reduction of a trial F's logarithmic strains by plastic flow, negative, and the history after it.

        Args:
            eps: Trial strains, shape (3, n). The result must be symmetric in them.
            history: Before the step.
            dt: [s].
        """
        raise NotImplementedError

    def principal_stress(self, eps: jax.Array, history: Any) -> jax.Array:
        """Principal Kirchhoff stresses [Pa], shape (3, n)."""
        del history
        return 2 * self.mu * eps + self.lam * eps.sum(0)

    def project(self, F: jax.Array, history: History, dt: jax.Array) -> tuple[jax.Array, History]:
        """Return mapping by `flow`. Not finite where det F <= 0."""
        result = spectral(_flow, F, (self, history, dt))
        return result.change, result.scalar

    def respond(self, F: jax.Array, history: History, dt: jax.Array) -> tuple[jax.Array, History, jax.Array]:
        """`project` and the stress after it, from one SVD."""
        result = spectral(_flow_and_stress, F, (self, history, dt))
        return result.change, result.scalar, result.spatial


def _flow(s: jax.Array, parameters: tuple[HenckyPlasticity, History, jax.Array]) -> Principal:
    material, history, dt = parameters
    change, history = material.flow(jnp.log(s), history, dt)
    # F + U diag(s (exp(d eps) - 1)) V^T rather than U diag(s exp(d eps)) V^T: where nothing flows F is returned to
    # the last bit, and where little does the round-off is small in proportion.
    return Principal(change=s * jnp.expm1(change), scalar=history)


def _flow_and_stress(s: jax.Array, parameters: tuple[HenckyPlasticity, History, jax.Array]) -> Principal:
    material, history, dt = parameters
    eps = jnp.log(s)
    change, history = material.flow(eps, history, dt)
    stress = material.principal_stress(eps + change, history)
    return Principal(change=s * jnp.expm1(change), spatial=stress, scalar=history)


def deviator(eps: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Deviator eps - tr(eps)/3 and its norm, shapes (3, n) and (n,); the norm's derivative at zero is zero."""
    deviation = eps - eps.sum(0) / 3
    square = (deviation**2).sum(0)
    positive = square > 0
    return deviation, jnp.where(positive, jnp.sqrt(jnp.where(positive, square, 1)), 0)


def relative_excess(norm: jax.Array, bound: jax.Array) -> jax.Array:
    """(norm - bound) / norm where positive, else 0, shape (n,); 1 at norm = bound = 0, as at any other norm."""
    beyond = (norm > bound) & (norm > 0)
    excess = jnp.where(beyond, norm - bound, 0) / jnp.where(beyond, norm, 1)
    return jnp.where((norm > 0) | (bound > 0), excess, 1)


def _energy(s: jax.Array, parameters: tuple[jax.Array, jax.Array]) -> Principal:
    mu, lam = parameters
    eps = jnp.log(s)
    return Principal(scalar=mu * (eps**2).sum(0) + 0.5 * lam * eps.sum(0) ** 2)


def _stress(s: jax.Array, parameters: tuple[jax.Array, jax.Array]) -> Principal:
    mu, lam = parameters
    eps = jnp.log(s)
    return Principal(spatial=2 * mu * eps + lam * eps.sum(0))
