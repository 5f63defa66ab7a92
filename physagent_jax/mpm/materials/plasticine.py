"""Plasticine: plastic flow that softens until the matter crumbles."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.linalg import Principal, spectral
from physagent_jax.mpm.materials.base import TORN, History
from physagent_jax.mpm.materials.hencky import HenckyPlasticity, deviator, relative_excess


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Plasticine(HenckyPlasticity):
    """Hencky elasticity with J2 flow and linear softening, sigma_y(alpha) = max(sigma_y - S alpha, 0).

    The return is `VonMises`'s with H = -S, and takes the whole deviator where that would overshoot sigma_y =
    0. For S >= 3 mu the unloading branch is steeper than the elastic one and the first yield breaks the
    bond at once. Matter with no yield stress left is a crumbling paste: no deviator, and no tension either (its
    expansion is forgotten beyond `base.TORN`), psi = (lam/2 + mu/3) min(tr eps, 0)^2 + mu |dev eps|^2.

    Attributes:
        mu, lam: Lame parameters [Pa], shape (n,).
        yield_stress: Initial uniaxial yield stress sigma_y >= 0 [Pa], shape (n,).
        softening: S = -d sigma_y / d alpha >= 0 [Pa], shape (n,); alpha is the equivalent plastic strain.
    """

    mu: jax.Array
    lam: jax.Array
    yield_stress: jax.Array
    softening: jax.Array

    def initial_history(self) -> History:
        """No plastic strain."""
        return jnp.zeros_like(self.yield_stress)

    def energy(self, F: jax.Array, history: History) -> jax.Array:
        """Strain energy per rest volume [J/m^3], shape (n,)."""
        return spectral(_energy, F, (self, history)).scalar

    def stress(self, F: jax.Array, history: History) -> jax.Array:
        """Kirchhoff stress [Pa], shape (n, 3, 3)."""
        return spectral(_stress, F, (self, history)).spatial

    def flow(self, eps: jax.Array, history: Any, dt: jax.Array) -> tuple[jax.Array, Any]:
        """Radial return; the history is the equivalent plastic strain."""
        del dt
        deviation, norm = deviator(eps)
        q = math.sqrt(1.5) * 2 * self.mu * norm
        excess = relative_excess(q, _compute_yield_stress(self, history))
        slope = 3 * self.mu - self.softening
        stable = slope > 0
        fraction = jnp.where(stable, excess * 3 * self.mu / jnp.where(stable, slope, 1), jnp.sign(excess))
        fraction = jnp.where(fraction < 1, fraction, 1)
        after = history + fraction * q / (3 * self.mu)
        trace = eps.sum(0)
        torn = (_compute_yield_stress(self, after) <= 0) & (trace > math.log(TORN))
        forgotten = jnp.where(torn, trace - math.log(TORN), 0) / 3
        return -deviation * fraction - forgotten, after

    def principal_stress(self, eps: jax.Array, history: Any) -> jax.Array:
        """Principal Kirchhoff stresses [Pa], shape (3, n)."""
        bulk = self.lam + 2 / 3 * self.mu
        deviation, _ = deviator(eps)
        pressure = bulk * _cut_tension(eps, self, history)
        return 2 * self.mu * deviation + pressure


def softening_from_deviator_norm(softening: ArrayLike) -> jax.Array:
    """The modulus S [Pa] of PhysGaussian's plasticine, whose bound Y on |dev tau| falls by softening |d eps_plastic|.

    There |d eps_plastic| = sqrt(3/2) d alpha, and sigma_y = sqrt(3/2) Y: S = 3/2 softening. For its yield
    stress see `von_mises.yield_stress_from_deviator_norm`.
    """
    return 1.5 * jnp.asarray(softening)


def _compute_yield_stress(material: Plasticine, alpha: jax.Array) -> jax.Array:
    return jnp.maximum(material.yield_stress - material.softening * alpha, 0)


def _cut_tension(eps: jax.Array, material: Plasticine, alpha: jax.Array) -> jax.Array:
    """tr(eps), without its tensile part where the yield stress is used up."""
    trace = eps.sum(0)
    return jnp.where((_compute_yield_stress(material, alpha) > 0) | (trace < 0), trace, 0)


def _energy(s: jax.Array, parameters: tuple[Plasticine, jax.Array]) -> Principal:
    material, alpha = parameters
    eps = jnp.log(s)
    bulk = material.lam + 2 / 3 * material.mu
    deviation, _ = deviator(eps)
    volumetric = 0.5 * bulk * _cut_tension(eps, material, alpha) ** 2
    return Principal(scalar=volumetric + material.mu * (deviation**2).sum(0))


def _stress(s: jax.Array, parameters: tuple[Plasticine, jax.Array]) -> Principal:
    material, alpha = parameters
    return Principal(spatial=material.principal_stress(jnp.log(s), alpha))
