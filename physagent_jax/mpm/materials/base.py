"""The interface of a constitutive model, and the shared code of all of them."""

from __future__ import annotations

from typing import Protocol

import jax

History = jax.Array | tuple[()]
"""Memory of a material: one number per particle, shape (n,), or () for none."""

TORN = 1.2
"""Expansion J beyond which matter that bears no tension forgets to have expanded.

A particle alone keeps its grad v for ever, so that its J would grow exponentially in free flight, until float32
overflows; and long before, matter that had to be squeezed by as much before it resisted would pass through others.
"""


class Material(Protocol):
    """A constitutive law with per-particle parameters, shape (n,) each.

    Implementations are registered dataclasses; their arrays cover one contiguous block of particles. F is
    the elastic deformation gradient: `project` takes what is plastic out of it, so that `stress` and
    `energy` are plain functions of F and the history.
    """

    @property
    def count(self) -> int:
        """Particles in the block."""
        ...

    def initial_history(self) -> History:
        """The history of matter that nothing has happened to."""
        ...

    def energy(self, F: jax.Array, history: History) -> jax.Array:
        """Strain energy per rest volume psi(F) [J/m^3], shape (n,)."""
        ...

    def stress(self, F: jax.Array, history: History) -> jax.Array:
        """Kirchhoff stress tau = (d psi / d F) F^T [Pa], shape (n, 3, 3), symmetric."""
        ...

    def stiffness(self, F: jax.Array, history: History) -> jax.Array:
        """Largest eigenvalue of the Kirchhoff tangent d tau_i / d ln lambda_j [Pa], shape (n,).

        An upper bound suffices; it governs the stable time step (`mpm.timestep`). At rest it is
        3 lam + 2 mu.
        """
        ...

    def project(self, F: jax.Array, history: History, dt: jax.Array) -> tuple[jax.Array, History]:
        """Return mapping: the elastic part of a trial F, and the history after the step of ``dt`` [s]."""
        ...


def respond(
    material: Material, F: jax.Array, history: History, dt: jax.Array
) -> tuple[jax.Array, History, jax.Array]:
    """`project`, and the Kirchhoff stress after it: what a trial F leads to.

    A material may have a method ``respond`` that does both in one go, such as with one SVD.
    """
    in_one_go = getattr(material, "respond", None)
    if in_one_go is not None:
        return in_one_go(F, history, dt)
    F, history = material.project(F, history, dt)
    return F, history, material.stress(F, history)


class Hyperelastic:
    """Base of the laws that remember nothing: `project` returns what it is given."""

    mu: jax.Array

    @property
    def count(self) -> int:
        """Particles in the block."""
        return self.mu.shape[0]

    def initial_history(self) -> History:
        """None."""
        return ()

    def project(self, F: jax.Array, history: History, dt: jax.Array) -> tuple[jax.Array, History]:
        """All of F is elastic."""
        del dt
        return F, history


def lame_parameters(youngs_modulus, poissons_ratio):
    """Lame parameters (mu, lam) [Pa] from E [Pa] and nu."""
    mu = youngs_modulus / (2 * (1 + poissons_ratio))
    lam = youngs_modulus * poissons_ratio / ((1 + poissons_ratio) * (1 - 2 * poissons_ratio))
    return mu, lam
