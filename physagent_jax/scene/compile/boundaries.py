"""Walls and obstacles of a scene, as the simulator has them."""

from __future__ import annotations

from physagent_jax.mpm import Contact, boundaries
from physagent_jax.scene import config as c
from physagent_jax.scene.compile.select import leaf


def compile_boundary(boundary: c.Boundary):
    """The simulator's boundary."""
    match boundary:
        case c.DomainBox():
            return boundaries.DomainBox(boundary.padding)
        case c.HalfSpace():
            return boundaries.HalfSpace(
                point=leaf(boundary.point),
                normal=leaf(boundary.normal),
                friction=leaf(boundary.friction),
                start=leaf(boundary.start),
                end=leaf(boundary.end),
                contact=Contact(boundary.surface.value),
            )
        case c.Cuboid():
            return boundaries.Cuboid(
                point=leaf(boundary.point),
                half_size=leaf(boundary.half_size),
                velocity=leaf(boundary.velocity),
                start=leaf(boundary.start),
                end=leaf(boundary.end),
            )
