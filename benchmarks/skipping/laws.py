"""Skips of a material's law: singular values, return mappings, trips through memory."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp

from benchmarks.skipping.base import Pair, Sizes, Skip
from benchmarks.skipping.scene import YOUNGS_MODULUS, both, cube
from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm import Hencky, NeoHookean, Snow, VonMises
from physagent_jax.mpm import State as Particles
from physagent_jax.mpm.linalg import Principal, spectral
from physagent_jax.mpm.materials import History, Material

_UNREACHABLE = 1e30  # a yield stress [Pa]
STRESS_ROUND_OFF = "kernel and XLA round the stress, a difference from 1, each in its own way"
_SVD_ROUND_OFF = (
    "singular values are good to a few units of round-off, and the stress is their difference from 1"
)


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Plain:
    """A law without its shortcuts: no `respond` of its own, and not known to any kernel by its class.

    Attributes:
        law: What it is in truth.
    """

    law: Any

    @property
    def count(self) -> int:
        """Particles in the block."""
        return self.law.count

    def initial_history(self) -> History:
        """The law's own."""
        return self.law.initial_history()

    def energy(self, F: jax.Array, history: History) -> jax.Array:
        """Strain energy per rest volume [J/m^3], shape (n,)."""
        return self.law.energy(F, history)

    def stress(self, F: jax.Array, history: History) -> jax.Array:
        """Kirchhoff stress [Pa], shape (n, 3, 3)."""
        return self.law.stress(F, history)

    def stiffness(self, F: jax.Array, history: History) -> jax.Array:
        """Largest eigenvalue of the Kirchhoff tangent [Pa], shape (n,)."""
        return self.law.stiffness(F, history)

    def project(self, F: jax.Array, history: History, dt: jax.Array) -> tuple[jax.Array, History]:
        """The law's own return mapping."""
        return self.law.project(F, history, dt)


@register_dataclass
@dataclasses.dataclass(frozen=True)
class ByPrincipalStretches(Plain):
    """The same with the stress from an SVD, as isotropic laws have it in general.

    Attributes:
        principal: A function for `spectral` that gives the stress; static.
    """

    principal: Callable[..., jax.Array] = dataclasses.field(metadata=dict(static=True))

    def stress(self, F: jax.Array, history: History) -> jax.Array:
        """Kirchhoff stress [Pa], shape (n, 3, 3)."""
        return spectral(self.principal, F, (self.law.mu, self.law.lam)).spatial


def _compute_neo_hookean(s: jax.Array, lame: tuple[jax.Array, jax.Array]) -> Principal:
    mu, lam = lame
    return Principal(spatial=mu * (s**2 - 1) + lam * jnp.log(s.prod(0)))


Law = Callable[[jax.Array, jax.Array], Material]


def _compare_laws(lean: Law, full: Law) -> Callable[[Sizes], Pair]:
    """The cube of one law, against the same cube of another; each starts with its own history."""

    def build(sizes: Sizes) -> Pair:
        model, state = cube(sizes, lean)
        law: Any = model.materials[0]
        other = full(law.mu, law.lam)
        start: Particles = dataclasses.replace(state, history=(other.initial_history(),))
        return both(model, model.replace(materials=(other,)), state, sizes, start)

    return build


def _make_metal(yield_stress: float) -> Callable[[jax.Array, jax.Array], VonMises]:
    def law(mu: jax.Array, lam: jax.Array) -> VonMises:
        return VonMises(mu, lam, jnp.full_like(mu, yield_stress), jnp.zeros_like(mu))

    return law


def _make_snow(mu: jax.Array, lam: jax.Array) -> Snow:
    return Snow(mu, lam, *(jnp.full_like(mu, value) for value in (0.025, 0.0075, 10.0, 4.0)))


# The cube's strains are several times those at which it yields.
_yielding = _make_metal(0.01 * YOUNGS_MODULUS)

SKIPS = (
    Skip(
        "singular values: neo-Hookean",
        "the SVD, where the stress has a closed form without it",
        "the same law through its principal stretches",
        _compare_laws(
            NeoHookean, lambda mu, lam: ByPrincipalStretches(NeoHookean(mu, lam), _compute_neo_hookean)
        ),
        tolerance=2e-5,
        reason=_SVD_ROUND_OFF,
    ),
    Skip(
        "stress inside P2G",
        "the trip of the stress through memory, where all matter is neo-Hookean and the kernels make it on the way",
        "the same law by a class that the kernels do not know",
        _compare_laws(NeoHookean, lambda mu, lam: Plain(NeoHookean(mu, lam))),
        tolerance=1e-5,
        reason=STRESS_ROUND_OFF,
    ),
    Skip(
        "return mapping",
        "the return mapping, where matter is elastic (Hencky)",
        f"von Mises metal of the same elasticity with a yield stress of {_UNREACHABLE:g} Pa",
        _compare_laws(Hencky, _make_metal(_UNREACHABLE)),
    ),
    Skip(
        "second SVD: metal",
        "the SVD of the stress, which shares that of the return mapping (`materials.respond`)",
        "`project`, then `stress`",
        _compare_laws(_yielding, lambda mu, lam: Plain(_yielding(mu, lam))),
        tolerance=2e-5,
        reason=_SVD_ROUND_OFF,
    ),
    Skip(
        "second SVD: snow",
        "the same for snow, whose stress alone would take a polar rotation",
        "`project`, then `stress`",
        _compare_laws(_make_snow, lambda mu, lam: Plain(_make_snow(mu, lam))),
        tolerance=2e-5,
        reason=_SVD_ROUND_OFF,
    ),
)
