"""Conditions on grid velocities: walls and obstacles, which share one contact law."""

from physagent_jax.mpm.boundaries.box import Box as Box
from physagent_jax.mpm.boundaries.contact import Contact as Contact
from physagent_jax.mpm.boundaries.cuboid import Cuboid as Cuboid
from physagent_jax.mpm.boundaries.domain_box import DomainBox as DomainBox
from physagent_jax.mpm.boundaries.half_space import HalfSpace as HalfSpace
from physagent_jax.mpm.boundaries.signed_distance import SignedDistance as SignedDistance
from physagent_jax.mpm.boundaries.sphere import Sphere as Sphere
from physagent_jax.mpm.boundaries.symmetry_plane import SymmetryPlane as SymmetryPlane
