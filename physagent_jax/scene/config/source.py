"""The object: where it comes from, how it is placed and filled."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from physagent_jax.core.strict import Number, Seed, Strict
from physagent_jax.forces.part import PartChoice
from physagent_jax.scene.config.common import (
    Degrees,
    Length,
    Path,
    Point,
    RotationAxes,
    Rotations,
    SignedAxis,
    SplatEncoding,
)
from physagent_jax.scene.config.photo import Photo

MESH_SUFFIXES = (".obj", ".glb", ".gltf", ".stl", ".off")
MOST_MESH_BYTES = 512 * 2**20
_Threshold = Annotated[float, Field(ge=1e-6, le=1e6)]


class Source(Strict):
    """The object's file and how it is brought into the domain.

    Attributes:
        path: 3D Gaussians (`gaussians.formats`), a mesh or a photo, absolute or relative to the scene file.
        sha256: Hash of the file; checked on replay if present.
        name: What the object is called; from the file name if empty.
        kind: Class with a physical prior ("plant", "food", "robot", ...); see `scene.priors`.
        up: The file's own up axis; rotated onto +z.
        tilt: Rotation after that about the world's x and y axes together, a rotation vector [degrees], with which the
            object stands level (`scene.level`).
        attitude: The same after that, with which it begins as the sentence says: upside down, on its side [degrees].
        opacity_threshold: Gaussians with a lower opacity are dropped.
        splat_encoding: How the file stores scales and opacities (`gaussians.formats.encoding`); None = found from
            its content.
        crop: Keep only (xmin, xmax, ymin, ymax, zmin, zmax) in file units, before anything else but
            ``rotation_degrees``.
        rotation_degrees, rotation_axes: Extra rotations about file axes (0, 1, 2), applied in order
            (PhysGaussian's pre-rotation), before ``up``.
        extent: Longest side in the domain [m].
        center: Centre of the bounding box in the domain [m]; None = the domain's centre.
        parts: Parts that a person names.
        photo: How a photo is lifted; None = as what stands out in it (photos only).
        surface_samples: Gaussians sampled on a mesh's surface (meshes only).
    """

    path: Path
    sha256: str | None = None
    name: str = ""
    kind: str = "object"
    up: SignedAxis = "+z"
    tilt: tuple[Degrees, Degrees] = (0.0, 0.0)
    attitude: tuple[Degrees, Degrees] = (0.0, 0.0)
    opacity_threshold: float = Field(default=0.02, ge=0, lt=1)
    splat_encoding: SplatEncoding | None = None
    crop: tuple[Number, Number, Number, Number, Number, Number] | None = None
    rotation_degrees: Rotations = ()
    rotation_axes: RotationAxes = ()
    extent: Length = 1.0
    center: Point | None = None
    parts: Annotated[tuple[PartChoice, ...], Field(max_length=64)] = ()
    photo: Photo | None = None
    surface_samples: int = Field(default=20_000, ge=8, le=10_000_000)

    @model_validator(mode="after")
    def _check_paired(self) -> Source:
        if len(self.rotation_degrees) != len(self.rotation_axes):
            raise ValueError("`rotation_degrees` and `rotation_axes` must have equal length")
        if self.crop is not None and any(high <= low for low, high in zip(self.crop[0::2], self.crop[1::2])):
            raise ValueError("`crop` must be (xmin, xmax, ymin, ymax, zmin, zmax), each min below its max")
        return self


class Filling(Strict):
    """Interior filling and particle sampling.

    Attributes:
        enabled: Whether to fill the inside.
        cells: Cells of the filling grid along the object's longest side; None = twice the simulation's.
        density_unit: What the thresholds are measured in: "coverage" = 10 (1 - exp(-overlap)), which does not
            depend on how densely the object was sampled; "overlap" = PhysGaussian's plain sum of Gaussians.
        density_threshold: Cells whose density field exceeds it hold matter.
        search_threshold: Density that counts as a wall for the inside test.
        exclude_direction: Direction (0..5 = +x, -x, +y, -y, +z, -z) not required to hit a wall; None = all six.
        ray_cast_direction: Direction (0..5) along which crossings are counted for parity.
        particles_per_cell: Particles placed per inside cell of the filling grid.
        max_particles: Hard cap on all particles, surface and filled; joints between pieces come on top.
        smooth: Whether to smooth the density field before thresholding.
        volumes: "matter" = particles share the object's volume; "cells" = PhysGaussian's rule, the volume of the
            simulation cell over the particles in it, which overestimates (imported scenes).
        join: Whether pieces that the capture left loose are joined to the rest (`scene.pieces`).
        seed: Seed of every random choice.
    """

    enabled: bool = True
    cells: int | None = Field(default=None, ge=4, le=512)
    density_unit: Literal["coverage", "overlap"] = "coverage"
    density_threshold: _Threshold = 5.0
    search_threshold: _Threshold = 3.0
    exclude_direction: int | None = Field(default=5, ge=0, le=5)
    ray_cast_direction: int = Field(default=4, ge=0, le=5)
    particles_per_cell: int = Field(default=1, ge=1, le=64)
    max_particles: int = Field(default=20_000, ge=8, le=100_000_000)
    smooth: bool = False
    volumes: Literal["matter", "cells"] = "matter"
    join: bool = False
    seed: Seed = 0
