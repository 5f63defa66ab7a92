"""`SceneConfig`: one JSON file that holds everything a simulation needs; replayable, versioned, strict.

SI units (m, s, kg, Pa). The world is z-up and the domain is [0, domain.size]^3; the object is rotated so
that its own up axis points along +z, scaled so that its longest side is ``source.extent`` and centred.
Regions of constraints are absolute [m] and select particles by their rest position.
"""

from __future__ import annotations

import enum
import json
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, ValidationError, field_validator, model_validator

from physagent_jax.errors import UserError
from physagent_jax.forces.schema import ForceField, SkillScaling, unit_vector
from physagent_jax.strict import Strict, Vector

FOREVER = 1e9  # [s]; the end of a window that never closes
SignedAxis = Literal["+x", "-x", "+y", "-y", "+z", "-z"]
Positive = Annotated[float, Field(gt=0)]
NonNegative = Annotated[float, Field(ge=0)]


class MaterialModel(enum.StrEnum):
    """Constitutive models."""

    NEO_HOOKEAN = "neo_hookean"
    FIXED_COROTATED = "fixed_corotated"


class Surface(enum.StrEnum):
    """What a half-space does to grid velocities inside it."""

    STICKY = "sticky"  # no motion at all
    SLIP = "slip"  # no normal motion, either way (bilateral)
    SEPARATE = "separate"  # no motion into it (unilateral), Coulomb friction on contact


class Source(Strict):
    """The object's file and how it is brought into the domain.

    Attributes:
        path: 3DGS PLY or mesh (.obj, .ply with faces, .glb, .stl), absolute or relative to the scene file.
        sha256: Hash of the file; checked on replay if present.
        name: What the object is called; from the file name if empty.
        kind: Class with a physical prior ("plant", "food", "robot", ...); see `scene.priors`.
        up: The file's own up axis; rotated onto +z.
        opacity_threshold: Gaussians with a lower opacity are dropped.
        crop: Keep only (xmin, xmax, ymin, ymax, zmin, zmax) in file units, before anything else but
            ``rotation_degrees``.
        rotation_degrees, rotation_axes: Extra rotations about file axes (0, 1, 2), applied in order
            (PhysGaussian's pre-rotation), before ``up``.
        extent: Longest side in the domain [m].
        center: Centre of the bounding box in the domain [m]; None = the domain's centre.
        surface_samples: Gaussians sampled on a mesh's surface (meshes only).
    """

    path: str
    sha256: str | None = None
    name: str = ""
    kind: str = "object"
    up: SignedAxis = "+z"
    opacity_threshold: float = Field(default=0.02, ge=0, lt=1)
    crop: tuple[float, float, float, float, float, float] | None = None
    rotation_degrees: tuple[float, ...] = ()
    rotation_axes: tuple[int, ...] = ()
    extent: Positive = 1.0
    center: Vector | None = None
    surface_samples: int = Field(default=20_000, gt=0)

    @model_validator(mode="after")
    def _paired(self) -> Source:
        if len(self.rotation_degrees) != len(self.rotation_axes) or any(
            a not in (0, 1, 2) for a in self.rotation_axes
        ):
            raise ValueError(
                "`rotation_degrees` and `rotation_axes` must have equal length, axes in {0, 1, 2}"
            )
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
        max_particles: Hard cap on all particles, surface and filled.
        smooth: Whether to smooth the density field before thresholding.
        volumes: "matter" = particles share the object's volume; "cells" = PhysGaussian's rule, the volume of the
            simulation cell over the particles in it, which overestimates (imported scenes).
        seed: Seed of every random choice.
    """

    enabled: bool = True
    cells: int | None = Field(default=None, ge=4, le=512)
    density_unit: Literal["coverage", "overlap"] = "coverage"
    density_threshold: Positive = 5.0
    search_threshold: Positive = 3.0
    exclude_direction: int | None = Field(default=5, ge=0, le=5)
    ray_cast_direction: int = Field(default=4, ge=0, le=5)
    particles_per_cell: int = Field(default=1, ge=1, le=64)
    max_particles: int = Field(default=20_000, ge=8)
    smooth: bool = False
    volumes: Literal["matter", "cells"] = "matter"
    seed: int = 0


class Material(Strict):
    """A homogeneous material.

    Attributes:
        model: Constitutive model.
        youngs_modulus: E [Pa].
        poissons_ratio: nu, in [0, 0.5).
        density: Mass density [kg/m^3].
        reason: Where these values come from, for the report.
    """

    model: MaterialModel = MaterialModel.NEO_HOOKEAN
    youngs_modulus: Positive = 1e5
    poissons_ratio: float = Field(default=0.3, ge=0, lt=0.499)
    density: Positive = 200.0
    reason: str = ""


class MaterialRegion(Strict):
    """Another material inside an absolute box.

    Attributes:
        point: Centre [m].
        half_size: Half extents [m].
        material: The material there.
    """

    point: Vector
    half_size: Vector
    material: Material


class Domain(Strict):
    """The cubic domain [0, size]^3 and its resolution.

    Attributes:
        size: Side [m].
        cells: Cells along a side; dx = size / cells.
    """

    size: Positive = 4.0
    cells: int = Field(default=96, ge=8, le=1024)

    @property
    def dx(self) -> float:
        """Grid spacing [m]."""
        return self.size / self.cells


class Timing(Strict):
    """Frames and substeps.

    Attributes:
        frame_count: Pictures in all; frame 0 is the rest pose, so frame_count - 1 intervals are simulated.
        frame_dt: Seconds per frame [s].
        substep_dt: Substep [s], or "auto" = ``safety`` times the stable bound, fitted to the frame.
        safety: Fraction of the bound that "auto" uses.
    """

    frame_count: int = Field(default=50, ge=2, le=10_000)
    frame_dt: Positive = 0.04
    substep_dt: Positive | Literal["auto"] = "auto"
    safety: float = Field(default=0.7, gt=0, le=1)


class Transfer(Strict):
    """Particle-grid transfers and damping.

    Attributes:
        scheme: "apic" or "pic".
        rpic_damping: 0 = APIC, 1 = only the rotational part of C (RPIC).
        damping_rate: Global velocity damping [1/s]: grid velocities decay by exp(-rate dt) per substep.
    """

    scheme: Literal["apic", "pic"] = "apic"
    rpic_damping: float = Field(default=0.0, ge=0, le=1)
    damping_rate: NonNegative = 0.0


class _Windowed(Strict):
    start: NonNegative = 0.0
    end: float = FOREVER

    @model_validator(mode="after")
    def _ordered(self):
        if self.end <= self.start:
            raise ValueError(f"`end` must exceed `start` (got start={self.start}, end={self.end})")
        return self


class DomainBox(Strict):
    """Separating slip walls around the domain, ``padding`` cells thick; particles are stopped there."""

    kind: Literal["domain_box"] = "domain_box"
    padding: int = Field(default=3, ge=2, le=16)


class HalfSpace(_Windowed):
    """A plane; ``normal`` points out of the solid. Acts on grid nodes behind it within [start, end) [s]."""

    kind: Literal["half_space"] = "half_space"
    point: Vector
    normal: Vector
    surface: Surface = Surface.SEPARATE
    friction: NonNegative = 0.0

    @field_validator("normal")
    @classmethod
    def _unit(cls, value: Vector) -> Vector:
        return unit_vector(value)


class Cuboid(_Windowed):
    """A box that moves with ``velocity`` and imposes it on the grid nodes inside, within [start, end) [s]."""

    kind: Literal["cuboid"] = "cuboid"
    point: Vector
    half_size: Vector
    velocity: Vector = (0.0, 0.0, 0.0)


Boundary = Annotated[DomainBox | HalfSpace | Cuboid, Field(discriminator="kind")]


class ParticleTranslation(_Windowed):
    """Particles that rest in a box move with ``velocity`` [m/s] within [start, end) [s]."""

    kind: Literal["particle_translation"] = "particle_translation"
    point: Vector
    half_size: Vector
    velocity: Vector


class ParticleRotation(_Windowed):
    """Particles that rest in a cylinder turn about its axis and slide along it within [start, end) [s].

    Attributes:
        point: Centre [m].
        normal: Axis (right-hand rule).
        half_height, radius: Cylinder [m].
        angular_velocity: [rad/s].
        axial_velocity: [m/s].
    """

    kind: Literal["particle_rotation"] = "particle_rotation"
    point: Vector
    normal: Vector
    half_height: Positive
    radius: Positive
    angular_velocity: float = 0.0
    axial_velocity: float = 0.0

    @field_validator("normal")
    @classmethod
    def _unit(cls, value: Vector) -> Vector:
        return unit_vector(value)


class ParticleImpulse(Strict):
    """A velocity change of the particles that rest in a box, spread over [start, start + duration] [s].

    Give ``delta_velocity`` [m/s] (independent of particle mass), or ``force`` [N per particle] as
    PhysGaussian does (then delta v = force * duration / particle mass).
    """

    kind: Literal["particle_impulse"] = "particle_impulse"
    point: Vector
    half_size: Vector
    delta_velocity: Vector | None = None
    force: Vector | None = None
    start: NonNegative = 0.0
    duration: Positive = 1e-4

    @model_validator(mode="after")
    def _one(self) -> ParticleImpulse:
        if (self.delta_velocity is None) == (self.force is None):
            raise ValueError("give exactly one of `delta_velocity` and `force`")
        return self


Constraint = Annotated[ParticleTranslation | ParticleRotation | ParticleImpulse, Field(discriminator="kind")]


class Anchor(Strict):
    """What is held fixed for the whole clip.

    Attributes:
        kind: "none", "base" / "top" (the slab of ``fraction`` of the height at the foot / head), "box"
            (absolute ``point`` +- ``half_size`` [m]) or "mask" (Gaussian indices in ``mask_path``, .npy).
        fraction: Thickness of the slab over the object's height.
        point, half_size: The box.
        mask_path: ``.npy`` of bool per loaded Gaussian, shape (n,).
        reason: Why, for the report.
    """

    kind: Literal["none", "base", "top", "box", "mask"] = "none"
    fraction: float = Field(default=0.12, gt=0, le=1)
    point: Vector | None = None
    half_size: Vector | None = None
    mask_path: str | None = None
    reason: str = ""

    @model_validator(mode="after")
    def _complete(self) -> Anchor:
        if self.kind == "box" and (self.point is None or self.half_size is None):
            raise ValueError('anchor kind "box" needs `point` and `half_size`')
        if self.kind == "mask" and self.mask_path is None:
            raise ValueError('anchor kind "mask" needs `mask_path`')
        return self


class CameraConfig(Strict):
    """The reference camera: looks at ``target`` from a sphere around it.

    Attributes:
        target: [m]; None = the domain's centre.
        azimuth_degrees: About +z from -y (0 = in front, looking along +y; 90 = from +x looking along -x).
        elevation_degrees: Above the horizon.
        distance: [m].
        fov_degrees: Vertical field of view.
    """

    target: Vector | None = None
    azimuth_degrees: float = 0.0
    elevation_degrees: float = Field(default=10.0, gt=-89, lt=89)
    distance: Positive = 4.0
    fov_degrees: float = Field(default=40.0, gt=1, lt=150)


class Rendering(Strict):
    """Pictures.

    Attributes:
        width, height: [px].
        background: RGB in [0, 1].
    """

    width: int = Field(default=320, ge=16, le=4096)
    height: int = Field(default=320, ge=16, le=4096)
    background: Vector = (1.0, 1.0, 1.0)


class SceneConfig(Strict):
    """The fused configuration (the paper's Theta): the object, its matter, its surroundings, the forces.

    Attributes:
        version: Format version.
        prompt: The sentence, for the record.
        preset: Name of the preset that gave the defaults, for the record.
        gravity: [m/s^2]; acts only if ``force_field.default_drop``, or ``always_gravity``.
        always_gravity: Whether gravity acts regardless of the force field (imported scenes).
        scaling: None = the closed forms of `forces.skills`, evaluated when the scene is compiled.
    """

    version: Literal[1] = 1
    prompt: str = ""
    preset: str = "fast"
    source: Source
    filling: Filling = Filling()
    material: Material = Material()
    material_regions: tuple[MaterialRegion, ...] = ()
    domain: Domain = Domain()
    timing: Timing = Timing()
    transfer: Transfer = Transfer()
    gravity: Vector = (0.0, 0.0, -9.8)
    always_gravity: bool = False
    boundaries: tuple[Boundary, ...] = (DomainBox(),)
    constraints: tuple[Constraint, ...] = ()
    anchor: Anchor = Anchor()
    force_field: ForceField = ForceField()
    scaling: SkillScaling | None = None
    camera: CameraConfig = CameraConfig()
    rendering: Rendering = Rendering()


def load_scene(path: str | Path) -> SceneConfig:
    """Reads and validates a scene file.

    Raises:
        UserError: The file is missing, not JSON, or breaks the schema (the message names the field).
    """
    return parse_scene(load_json(path), origin=str(path))


def load_json(path: str | Path) -> object:
    """Decodes a JSON file.

    Raises:
        UserError: The file is missing or not JSON (NaN and Infinity are not).
    """
    path = Path(path)

    def refuse(constant: str):
        raise UserError(
            f"{path} holds {constant}, which is not a number", do="Replace it with a finite number"
        )

    try:
        return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)
    except OSError as error:
        raise UserError(f"cannot read {path}", got=error.strerror, do="Check the path") from None
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise UserError(f"{path} is not valid JSON", got=error, do="Mend the file or make it anew") from None


def parse_scene(data: object, *, origin: str = "scene") -> SceneConfig:
    """Validates decoded JSON as a scene; ``origin`` names it in messages."""
    try:
        return SceneConfig.model_validate(data)
    except ValidationError as error:
        raise validation_message(error, origin) from None


def validation_message(error: ValidationError, origin: str) -> UserError:
    """The first of pydantic's complaints as one line that names the field, what was got, what to do."""
    first = error.errors()[0]
    field = ".".join(str(part) for part in first["loc"]) or "(top level)"
    message = first["msg"].removeprefix("Value error, ")
    more = error.error_count() - 1
    extra = f" ({more} more problem{'s' if more > 1 else ''} in the file)" if more else ""
    got = first["input"]
    shown = (
        repr(got) if isinstance(got, (str, int, float, bool, type(None), list, tuple)) else type(got).__name__
    )
    return UserError(
        f"{origin}: field `{field}`: {message}{extra}",
        got=shown if len(shown) < 80 else shown[:77] + "...",
        do="`physagent schema` prints the schema",
    )


def dump_scene(config: SceneConfig) -> str:
    """Canonical JSON text: the same config gives the same bytes."""
    return json.dumps(config.model_dump(mode="json"), indent=2, ensure_ascii=False) + "\n"
