"""Drucker-Prager sand."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.materials.base import TORN, History
from physagent_jax.mpm.materials.hencky import HenckyPlasticity, deviator, relative_excess


@register_dataclass
@dataclasses.dataclass(frozen=True)
class DruckerPrager(HenckyPlasticity):
    """Hencky elasticity in a Drucker-Prager cone  (Klar et al. 2016), with cohesion and volume correction.

    Yields when |dev tau| + alpha tr(tau) exceeds k, where

        alpha = sqrt(2/3) 2 sin(phi) / (3 - sin(phi)),    k = sqrt(2/3) 6 c cos(phi) / (3 - sin(phi))

    make the cone pass through Mohr-Coulomb's triaxial compression, p1 (1 - sin phi) = p3 (1 + sin phi) +
    2 c cos(phi): put tau = -diag(p1, p3, p3) into the yield function. Flow keeps the volume (non-associated,
    no dilation). Beyond the apex tr(tau) = k / alpha the stress stays there: cohesionless sand is free of
    stress under tension.

    The volume gained at the apex would come back as pressure on recompression. The history v_c remembers it
    and is used up before pressure builds (Tampubolon et al. 2017): tr(eps) + v_c is conserved by the return.
    It never adds tension, which with cohesion would create energy; expansion beyond `base.TORN` is forgotten.

    phi = 0 with cohesion has no apex (Tresca's circumscribed circle, |dev tau| <= 2 sqrt(2/3) c); without
    cohesion either, only pressure is left.

    Attributes:
        mu, lam: Lame parameters [Pa], shape (n,).
        friction_angle: phi in [0, pi/2) [rad], shape (n,).
        cohesion: c >= 0 [Pa], shape (n,).
    """

    mu: jax.Array
    lam: jax.Array
    friction_angle: jax.Array
    cohesion: jax.Array

    def initial_history(self) -> History:
        """No volume to give back."""
        return jnp.zeros_like(self.friction_angle)

    def find_cone(self) -> tuple[jax.Array, jax.Array]:
        """Slope alpha [1] and strength k [Pa] of the cone, shape (n,) each."""
        sine = jnp.sin(self.friction_angle)
        k = math.sqrt(2 / 3) * 6 * self.cohesion * jnp.cos(self.friction_angle) / (3 - sine)
        return math.sqrt(2 / 3) * 2 * sine / (3 - sine), k

    def flow(self, eps: jax.Array, history: Any, dt: jax.Array) -> tuple[jax.Array, Any]:
        """Return to the cone along the deviator, or to its apex; the history is the volume correction v_c."""
        del dt
        mu, bulk = self.mu, 3 * self.lam + 2 * self.mu  # tr(tau) = bulk tr(eps)
        alpha, k = self.find_cone()
        deviation, norm = deviator(eps)
        trace = eps.sum(0)

        beyond_apex = (k < alpha * bulk * trace) | ((k <= 0) & (trace > 0))
        has_apex = alpha > 0
        apex = jnp.where(has_apex, k / jnp.where(has_apex, alpha * bulk, 1), 0)
        compression = jnp.where(trace < 0, -trace, 0)
        closing = jnp.where(compression < history, compression, history)
        opening = jnp.where(beyond_apex, trace - apex, -closing)

        strength = jnp.where(beyond_apex, 0, k - alpha * bulk * (trace - opening))
        change = -deviation * relative_excess(2 * mu * norm, strength)
        gap = history + opening
        return change - opening / 3, jnp.where(gap < math.log(TORN), gap, math.log(TORN))
