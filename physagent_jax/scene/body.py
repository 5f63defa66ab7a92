"""The object at rest in the domain: Gaussians, particles, and how they hang together."""

from __future__ import annotations

import dataclasses
import functools
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from physagent_jax.forces.part import Part, PartChoice
from physagent_jax.gaussians.binding import Binding, bind, bind_pieces
from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.gaussians.diagnosis import check_cloud, diagnose_cloud
from physagent_jax.gaussians.formats.packing import SH_C0
from physagent_jax.scene.config import Domain, Filling, SceneConfig, Source
from physagent_jax.scene.filling import Particles, fill
from physagent_jax.scene.load import is_photo, load_named_parts, load_object, load_shells
from physagent_jax.scene.mesh_formats import MeshPart
from physagent_jax.scene.parts import (
    Shells,
    branch_numbered,
    choose_parts,
    find_groups,
    find_parts,
    find_pieces,
    find_shells,
    join_chains,
    join_parts,
    make_parts,
)
from physagent_jax.scene.photo.view import PhotoView, find_view
from physagent_jax.scene.pieces import LoosePiece, explain_loose, join_pieces
from physagent_jax.scene.placement import Placement, place

FEWEST_PER_CELL = 3
SHAPE_CELLS, SHAPE_POINTS = (
    48,
    20_000,
)  # along the longest side, and in all, of the cloud that shows the parts


@dataclasses.dataclass(frozen=True)
class Body:
    """An object at rest. It does not depend on the force field, so all rounds of the loop share it.

    Attributes:
        cloud: Gaussians in the world (SH still in the captured frame).
        placement: From the file's frame to the world.
        particles: The material points, at rest.
        binding: Which particles each Gaussian follows.
        reading: How the object's file was read, in words; "" = it was not read from a file.
        loose: Pieces that nothing joins to the rest.
        plain: The cloud in the colours that people see; None = in its own.
        named: Parts that the object's file names.
        choices: Parts that a person names.
        photo: The view of the photo that it was lifted from; None = it was not.
        surfaces: Shells of its surface in the world: surfaces that share no edge; none = there is but one.
    """

    cloud: GaussianCloud
    placement: Placement
    particles: Particles
    binding: Binding
    reading: str = ""
    loose: tuple[LoosePiece, ...] = ()
    plain: GaussianCloud | None = None
    named: tuple[Part, ...] = ()
    choices: tuple[PartChoice, ...] = ()
    photo: PhotoView | None = None
    surfaces: tuple[MeshPart, ...] = ()

    @property
    def low(self) -> np.ndarray:
        """Low corner of the Gaussians' bounding box [m], shape (3,)."""
        return np.asarray(self.cloud.means).min(0)

    @property
    def high(self) -> np.ndarray:
        """High corner of the Gaussians' bounding box [m], shape (3,)."""
        return np.asarray(self.cloud.means).max(0)

    @property
    def extent(self) -> float:
        """Longest side of the bounding box [m]."""
        return float((self.high - self.low).max())

    @functools.cached_property
    def parts(self) -> tuple[Part, ...]:
        """Parts that the object's file or a person names, and those that stick out of it.

        Raises:
            UserError: What a person names is no part of it.
        """
        points = np.asarray(self.particles.x, np.float64)
        shown = self.shells.snap_parts(find_parts(self.shape))
        found = join_parts(points, self.named, shown)
        return choose_parts(points, found, self.choices, self.placement)

    @functools.cached_property
    def shells(self) -> Shells:
        """The shells of its surface among the points of its shape."""
        return find_shells(self.shape, self.surfaces)

    @functools.cached_property
    def colours(self) -> np.ndarray:
        """Colours of the points of its shape, as people see them, 0 .. 1, shape (n, 3)."""
        cloud = self.plain or self.cloud
        tree: Any = KDTree(np.asarray(cloud.means, np.float64))
        return np.clip(np.asarray(cloud.sh, np.float64)[tree.query(self.shape)[1], 0] * SH_C0 + 0.5, 0.0, 1.0)

    @functools.cached_property
    def shape(self) -> np.ndarray:
        """Points that show its shape, surface and inside, however few particles a run has [m], shape (n, 3)."""
        dx = 2 * self.extent / SHAPE_CELLS
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # they are heeded when its particles are made
            filled = fill(self.cloud, Filling(cells=SHAPE_CELLS, max_particles=SHAPE_POINTS), dx=dx)
        return np.asarray(join_pieces(filled, dx)[0].x, np.float64)


def make_body(source: Source, filling: Filling, domain: Domain, base_dir: str | Path) -> Body:
    """Loads, places, fills and binds an object.

    Args:
        source: The file; relative paths start from ``base_dir``.
        filling: How to make particles of it.
        domain: Where it must fit, and the simulation's cell size.
        base_dir: Folder of the scene file.

    Raises:
        UserError: The file is unreadable, is not the one that was hashed, or leaves no Gaussians.
    """
    loaded = load_object(source, base_dir)
    cloud, placement = place(loaded.cloud, source, domain, loaded.origin)
    check_cloud(cloud)
    plain = None if loaded.plain is None else place(loaded.plain, source, domain, loaded.origin)[0]
    for text in diagnose_cloud(cloud):
        warnings.warn(text, stacklevel=2)
    particles, loose = fill(cloud, filling, dx=domain.dx), ()
    if filling.join:
        particles, loose = join_pieces(particles, domain.dx)
        if (seen := explain_loose(loose)) is not None:
            warnings.warn(seen, stacklevel=2)
    _warn_if_sparse(particles, domain.dx)
    reading = (
        f"{loaded.format_name}: {loaded.encoding}; {cloud.count:,} of {loaded.count_in_file:,} Gaussians kept"
    )
    surfaces = load_named_parts(source, base_dir)
    named, binding = _find_named(cloud, placement, particles, surfaces, source.name)
    photo = find_view(source, placement, base_dir) if is_photo(Path(base_dir) / source.path) else None
    shells = _place(load_shells(source, base_dir), placement)
    return Body(
        cloud, placement, particles, binding, reading, loose, plain, named, source.parts, photo, shells
    )


def _find_named(
    cloud: GaussianCloud, placement: Placement, particles: Particles, surfaces: list[MeshPart], name: str
) -> tuple[tuple[Part, ...], Binding]:
    """The parts that a mesh file names by its surfaces, in its own frame; and Gaussians bound within them."""
    means, points = np.asarray(cloud.means, np.float64), np.asarray(particles.x, np.float64)
    if not surfaces:
        return (), bind(cloud.means, particles.x)
    placed = _place(surfaces, placement)
    w, x, y, z = np.asarray(cloud.quats, np.float64).T
    discs = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)
    index = np.asarray(particles.gaussian_index)
    normals = np.where(index[:, None] >= 0, discs[index], 0.0)
    count = len(points)
    groups = find_groups(np.concatenate([points, means]), np.concatenate([normals, discs]), placed)
    # Few particles may leave a small part none, or no rest that it could hang on.
    groups = [each for each in groups if 0 < each.mask[:count].sum() < count]
    named = make_parts(points, [dataclasses.replace(each, mask=each.mask[:count]) for each in groups])
    pieces = find_pieces(points, named, [each.mask[count:] for each in groups])
    named = join_chains(points, branch_numbered(points, named, name))
    return named, bind_pieces(means, points, pieces[1], pieces[0])


def _place(surfaces: Sequence[MeshPart], placement: Placement) -> tuple[MeshPart, ...]:
    """Surfaces in the world."""
    return tuple(dataclasses.replace(each, vertices=placement.to_world(each.vertices)) for each in surfaces)


def _warn_if_sparse(particles: Particles, dx: float) -> None:
    """Matter with too few particles per cell falls apart when it is stretched, whatever its material."""
    occupied = len(np.unique(np.floor(particles.x / dx).astype(np.int64), axis=0))
    per_cell = particles.count / occupied
    if per_cell < FEWEST_PER_CELL:
        warnings.warn(
            f"the object is thinly filled: {particles.count:,} particles, where some "
            f"{FEWEST_PER_CELL * occupied:,} are advisable; it may tear when stretched: allow more particles or use a "
            "coarser grid",
            stacklevel=3,
        )


def make_scene_body(config: SceneConfig, base_dir: str | Path) -> Body:
    """The body of a complete scene."""
    return make_body(config.source, config.filling, config.domain, base_dir)
