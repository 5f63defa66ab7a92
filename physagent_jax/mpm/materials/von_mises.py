"""Von Mises metal with linear isotropic hardening."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.materials.base import History
from physagent_jax.mpm.materials.hencky import HenckyPlasticity, deviator, relative_excess


@register_dataclass
@dataclasses.dataclass(frozen=True)
class VonMises(HenckyPlasticity):
    """Hencky elasticity with J2 flow and linear hardening  (Simo & Hughes 1998, box 3.1, in logarithmic strain).

    Yields when q = sqrt(3/2) |dev tau| exceeds sigma_y + H alpha. The return is radial and in closed form,

        d alpha = (q - sigma_y - H alpha) / (3 mu + H),    q <- q - 3 mu d alpha,

    and leaves det F unchanged. The history alpha is the equivalent plastic strain, so that a bar under
    uniaxial stress yields at sigma_y and then hardens with the slope E H / (E + H).

    ``yield_stress`` is the uniaxial one. Where a source bounds |dev tau| itself, as PhysGaussian does,
    convert with `yield_stress_from_deviator_norm` and `hardening_from_deviator_norm`.

    Attributes:
        mu, lam: Lame parameters [Pa], shape (n,).
        yield_stress: Initial uniaxial yield stress sigma_y >= 0 [Pa], shape (n,).
        hardening: H = d sigma_y / d alpha >= 0 [Pa], shape (n,).
    """

    mu: jax.Array
    lam: jax.Array
    yield_stress: jax.Array
    hardening: jax.Array

    def initial_history(self) -> History:
        """No plastic strain."""
        return jnp.zeros_like(self.yield_stress)

    def flow(self, eps: jax.Array, history: Any, dt: jax.Array) -> tuple[jax.Array, Any]:
        """Radial return; the history is the equivalent plastic strain."""
        del dt
        deviation, norm = deviator(eps)
        q = math.sqrt(1.5) * 2 * self.mu * norm
        excess = relative_excess(q, self.yield_stress + self.hardening * history)
        stiffness = 3 * self.mu + self.hardening
        return -deviation * (excess * 3 * self.mu / stiffness), history + q * excess / stiffness


def yield_stress_from_deviator_norm(bound: ArrayLike) -> jax.Array:
    """The uniaxial yield stress sigma_y [Pa] of a law that yields at |dev tau| = ``bound`` [Pa].

    Uniaxial stress sigma has |dev tau| = sqrt(2/3) sigma, hence sigma_y = sqrt(3/2) bound. PhysGaussian's
    metal and plasticine need this; its foam already compares with sqrt(2/3) of its yield stress.
    """
    return math.sqrt(1.5) * jnp.asarray(bound)


def hardening_from_deviator_norm(mu: ArrayLike, xi: ArrayLike) -> jax.Array:
    """The hardening modulus H [Pa] of PhysGaussian's metal, whose bound Y on |dev tau| grows by 2 mu xi d gamma.

    There d gamma = |d eps_plastic| = sqrt(3/2) d alpha, and sigma_y = sqrt(3/2) Y, so that
    d sigma_y = sqrt(3/2) 2 mu xi sqrt(3/2) d alpha: H = 3 mu xi.
    """
    return 3 * jnp.asarray(mu) * xi
