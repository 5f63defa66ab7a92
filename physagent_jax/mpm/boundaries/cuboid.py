"""A box that moves and takes along the material inside it."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.boundaries.box import Box
from physagent_jax.mpm.boundaries.contact import Contact
from physagent_jax.mpm.fields import END, START
from physagent_jax.mpm.protocols import Boundary
from physagent_jax.mpm.state import Grid


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Cuboid(Boundary):
    """Imposes ``velocity`` on the nodes inside a box, for start <= time < end.

    This is sticky contact with a moving box. It starts at ``point`` at time ``start`` and moves with
    ``velocity`` until ``end`` (PhysGaussian's "cuboid", without its reset of the whole grid outside the
    window). Derivatives by its speed and place are those between the nodes that it takes one after the other: at large
    they are too small (`contact`).

    Attributes:
        point: Centre at ``start`` [m], shape (3,).
        half_size: Half extents [m], shape (3,).
        velocity: [m/s], shape (3,).
        start, end: Window of activity [s], scalars.
    """

    acts_on_points: ClassVar[bool] = True

    point: jax.Array
    half_size: jax.Array
    velocity: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)

    @property
    def thickness(self) -> float:
        """Its shortest side [m]."""
        return 2 * float(np.min(self.half_size))

    def apply(self, velocity: jax.Array, grid: Grid, time: jax.Array) -> jax.Array:
        """Overwrite the velocities inside the box."""
        frictionless = jnp.zeros((), velocity.dtype)  # sticky contact has no use for it
        box = Box(
            self.point,
            self.half_size,
            frictionless,
            self.start,
            self.end,
            Contact.STICKY,
            velocity=self.velocity,
        )
        return box.apply(velocity, grid, time)
