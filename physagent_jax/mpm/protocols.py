"""Protocols of the parts of `Model`: body forces, boundaries and constraints; registered dataclasses (pytrees).

What there is one of per particle, and when a part acts, its fields say in their metadata (`mpm.fields`): `mpm.simulate`
leaves out of a frame what does not act in it (`mpm.plan`), and sorts particles; `mpm.sharding` splits them.
"""

from __future__ import annotations

from typing import ClassVar, Protocol

import jax
import jax.numpy as jnp

from physagent_jax.mpm.state import Grid, Model, State
from physagent_jax.mpm.transfer import Stencil


class BodyForce(Protocol):
    """An external acceleration field; forces per unit mass, so particle count does not change the motion.

    For runs on several devices (`mpm.sharding`) sums over particles go through `mpm.reductions.sum_particles`.
    """

    def acceleration(
        self, x: jax.Array, v: jax.Array, mass: jax.Array, time: jax.Array, dt: jax.Array
    ) -> jax.Array:
        """Mean acceleration over [time, time + dt] at the particles [m/s^2], shape (n, 3)."""
        ...

    def gradient(self, x: jax.Array, time: jax.Array, dt: jax.Array) -> jax.Array | None:
        """d acceleration / d x [1/s^2], shape (n, 3, 3) or (3, 3); None = uniform across a cell.

        P2G carries it like C. A torque needs it: APIC particles have a moment of inertia of their own
        (m dx^2 / 2 about each axis), which forces at their centres alone would leave unturned.
        """
        ...


class Boundary(Protocol):
    """A condition on the grid.

    Attributes:
        acts_on_points: Whether `apply` also takes scattered places (`boundaries.contact.Points`) in a grid's place.
    """

    acts_on_points: ClassVar[bool] = False

    @property
    def thickness(self) -> float | None:
        """Least thickness of a solid that matter may meet from either side [m]; None = it has none, as a half-space."""
        return None

    def fold(self, nodes: jax.Array, grid: Grid) -> jax.Array:
        """Momentum and mass with what the boundary adds, such as an image, shape (nx, ny, nz, 4); here nothing."""
        del grid
        return nodes

    def unfold(self, nodes: jax.Array, grid: Grid) -> jax.Array:
        """Folded momentum and mass with the images themselves in place, for what looks at a node's neighbours."""
        del grid
        return nodes

    def apply(self, velocity: jax.Array, grid: Grid, time: jax.Array) -> jax.Array:
        """Velocities after the boundary [m/s], shape (nx, ny, nz, 3)."""
        ...


class Constraint(Protocol):
    """A constraint within a substep, on chosen particles or on the grid alone. Later ones win over earlier ones."""

    def before_p2g(self, model: Model, state: State) -> State:
        """Give the constrained particles the v and C that P2G is to see; here nothing."""
        del model
        return state

    def on_grid(
        self,
        model: Model,
        free: jax.Array,
        velocity: jax.Array,
        node_mass: jax.Array,
        s: Stencil,
        time: jax.Array,
    ) -> jax.Array:
        """Grid velocities after the constraint [m/s], shape (nx, ny, nz, 3).

        Args:
            model: Its ``boundaries`` have acted.
            free: Node velocities before the boundaries [m/s], shape (nx, ny, nz, 3).
            velocity: The same after them, and after earlier constraints.
            node_mass: [kg], shape (nx, ny, nz).
            s: Stencils of all particles.
            time: At the start of the substep [s].
        """
        ...

    def after_g2p(self, model: Model, before: State, after: State) -> State:
        """Put the constrained particles where they belong; here nothing.

        Args:
            model: Its ``dt`` lies between the two states.
            before: At the start of the substep.
            after: As G2P and the return mapping left it.
        """
        del model, before
        return after

    def prescribe(self, model: Model, x: jax.Array) -> jax.Array:
        """Velocities that it gives to what is at rest when it begins [m/s], for places (n, 3) [m]; here none."""
        del model
        return jnp.zeros_like(x)
