"""Viscoplastic foam."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.materials.hencky import HenckyPlasticity, deviator, relative_excess

_LONGEST_RELAXATION = 50.0  # relaxation times in a step; exp(-50) is below double precision


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Viscoplastic(HenckyPlasticity):
    """Hencky elasticity with Perzyna overstress  (Simo & Hughes 1998, sec. 2.7; foam of Yue et al. 2015).

    Above the yield surface, |dev tau| = sqrt(2/3) sigma_y, the excess flows off at the rate
    d eps_plastic / dt = excess / eta along dev tau. For a strain that is held, the excess decays exactly as
    exp(-2 mu t / eta); a step applies that decay to the trial state. The volume is elastic.

    eta -> 0 gives the rate-independent return of `VonMises` without hardening, and eta = inf elasticity.
    PhysGaussian's foam has the same sigma_y (it includes the factor sqrt(2/3)) and the same eta, with the
    decay 1 / (1 + 2 mu dt / eta) of a backward Euler step.

    Attributes:
        mu, lam: Lame parameters [Pa], shape (n,).
        yield_stress: Uniaxial yield stress sigma_y >= 0 [Pa], shape (n,).
        plastic_viscosity: eta >= 0 [Pa s], shape (n,).
    """

    mu: jax.Array
    lam: jax.Array
    yield_stress: jax.Array
    plastic_viscosity: jax.Array

    def flow(self, eps: jax.Array, history: Any, dt: jax.Array) -> tuple[jax.Array, Any]:
        """Relaxation of the overstress over ``dt`` [s]."""
        viscosity, rate = self.plastic_viscosity, 2 * self.mu * dt
        viscous = viscosity * _LONGEST_RELAXATION > rate
        relaxed = jnp.where(viscous, -jnp.expm1(-rate / jnp.where(viscous, viscosity, 1)), 1)
        deviation, norm = deviator(eps)
        excess = relative_excess(2 * self.mu * norm, math.sqrt(2 / 3) * self.yield_stress)
        return -deviation * (excess * relaxed), history
