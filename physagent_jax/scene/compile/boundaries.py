"""Walls and obstacles of a scene, as the simulator has them."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import check_regular
from physagent_jax.mpm import Contact, boundaries
from physagent_jax.mpm.limits import THINNEST
from physagent_jax.scene import config as c
from physagent_jax.scene.compile.select import to_array
from physagent_jax.scene.config.source import MOST_MESH_BYTES
from physagent_jax.scene.placement import find_extra_rotation


def compile_boundaries(config: c.SceneConfig, base_dir: str | Path) -> tuple:
    """The simulator's boundaries, in the scene's order.

    Args:
        config: The scene.
        base_dir: Folder that relative paths of meshes start from.

    Raises:
        UserError: A mesh cannot be read, is not closed, or is out of reach; the message names its field.
    """
    return tuple(
        _compile_one(boundary, config.domain, f"boundaries[{index}]", base_dir)
        for index, boundary in enumerate(config.boundaries)
    )


def _compile_one(boundary: c.Boundary, domain: c.Domain, place: str, base_dir: str | Path):
    match boundary:
        case c.DomainBox():
            return boundaries.DomainBox(boundary.padding)
        case c.HalfSpace():
            return boundaries.HalfSpace(
                point=to_array(boundary.point), normal=to_array(boundary.normal), **_read_contact(boundary)
            )
        case c.Sphere():
            return boundaries.Sphere(
                point=to_array(boundary.point),
                radius=to_array(boundary.radius),
                container=boundary.container,
                **_read_contact(boundary),
            )
        case c.Box():
            return boundaries.Box(
                point=to_array(boundary.point),
                half_size=to_array(boundary.half_size),
                container=boundary.container,
                **_read_contact(boundary),
            )
        case c.Mesh():
            values, origin, thickness = _sample(boundary, domain, place, base_dir)
            return boundaries.SignedDistance(
                values=to_array(values),
                origin=to_array(origin),
                spacing=domain.dx,
                thickness=thickness,
                **_read_contact(boundary),
            )
        case c.Cuboid():
            return boundaries.Cuboid(
                point=to_array(boundary.point),
                half_size=to_array(boundary.half_size),
                velocity=to_array(boundary.velocity),
                start=to_array(boundary.start),
                end=to_array(boundary.end),
            )


def _read_contact(obstacle: c.HalfSpace | c.Sphere | c.Box | c.Mesh) -> dict[str, Any]:
    return dict(
        friction=to_array(obstacle.friction),
        start=to_array(obstacle.start),
        end=to_array(obstacle.end),
        contact=Contact(obstacle.surface.value),
        velocity=to_array(obstacle.velocity) if any(obstacle.velocity) else None,
    )


def _sample(mesh: c.Mesh, domain: c.Domain, place: str, base_dir: str | Path):
    """A mesh on a grid like the simulation's: all of it if it moves, else what lies in the domain."""
    path = Path(base_dir) / mesh.path
    try:
        check_regular(path, most=MOST_MESH_BYTES, what="the mesh file")
    except UserError as error:
        raise UserError(f"`{place}.path`: {error.what}", got=error.got, do=error.do) from None
    reach = (-np.inf, np.inf) if any(mesh.velocity) else (0.0, domain.size)
    placed = mesh.scale, mesh.position, mesh.rotation_degrees, mesh.rotation_axes
    return _sample_once(path.resolve(), path.stat().st_mtime_ns, place, placed, domain.dx, *reach)


@lru_cache(maxsize=8)  # a run compiles its scene anew for every force field that it tries
def _sample_once(path: Path, stamp: int, place: str, placed: tuple, dx: float, low: float, high: float):
    from physagent_jax.scene.signed_distance import (
        load_solid,
        measure_thickness,
        sample,
    )  # trimesh takes long to import

    del stamp  # part of the key: the file may have changed
    scale, position, degrees, axes = placed
    triangles = load_solid(path, f"{place}.path") @ (scale * find_extra_rotation(degrees, axes)).T
    triangles = triangles + np.asarray(position)
    values, origin = sample(triangles, dx, low, high, place)
    return values, origin, measure_thickness(triangles, values, origin, dx, THINNEST * dx)
