"""Brittle matter, which is elastic until it breaks and grains without cohesion from then on."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.materials.base import History
from physagent_jax.mpm.materials.drucker_prager import DruckerPrager
from physagent_jax.mpm.materials.hencky import deviator

_WHOLE = -1.0  # history of what has not broken; that of grains is no less than 0


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Brittle(DruckerPrager):
    """Hencky elasticity that fails for good where the stress leaves a Drucker-Prager cone with cohesion.

    The cone is that of `DruckerPrager`: uniaxial tension fails at 6 c cos(phi) / (3 + sin(phi)), and compression at
    2 c cos(phi) / (1 - sin(phi)). What has failed has the friction and no cohesion, so that it bears pressure and
    no tension, and its history is the volume correction of `DruckerPrager`. What is whole has a history below 0.

    Attributes:
        mu, lam: Lame parameters [Pa], shape (n,).
        friction_angle: phi in [0, pi/2) [rad], shape (n,).
        cohesion: c >= 0 of what is whole [Pa], shape (n,).
    """

    def initial_history(self) -> History:
        """All is whole."""
        return jnp.full_like(self.friction_angle, _WHOLE)

    def flow(self, eps: jax.Array, history: Any, dt: jax.Array) -> tuple[jax.Array, Any]:
        """No flow while it is whole, that of grains afterwards."""
        alpha, k = self.find_cone()
        norm, bulk = deviator(eps)[1], 3 * self.lam + 2 * self.mu
        holds = (history < 0) & (2 * self.mu * norm + alpha * bulk * eps.sum(0) <= k)
        grains = DruckerPrager(self.mu, self.lam, self.friction_angle, jnp.zeros_like(self.cohesion))
        change, gap = grains.flow(eps, jnp.maximum(history, 0), dt)
        return jnp.where(holds, 0, change), jnp.where(holds, history, gap)
