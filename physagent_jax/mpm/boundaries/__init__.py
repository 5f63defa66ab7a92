"""Conditions on grid velocities."""

from physagent_jax.mpm.boundaries.cuboid import Cuboid as Cuboid
from physagent_jax.mpm.boundaries.domain_box import DomainBox as DomainBox
from physagent_jax.mpm.boundaries.half_space import Contact as Contact
from physagent_jax.mpm.boundaries.half_space import HalfSpace as HalfSpace
