"""The numbers of a scene that a gradient can move, as a pytree: of what the scene has, and of nothing else.

`SceneParameters.of` reads them from a compiled scene; `CompiledScene.with_parameters` puts them back, traced or not,
and `trajectory` takes them. What is None in them is left as the scene has it, so that a part of them can be given as
well, and what a scene does not have is None from the start: `jax.tree.leaves` of a scene's parameters are what can be
optimised there.
"""

from __future__ import annotations

import dataclasses
from typing import Any, Protocol

import jax
import numpy as np
from jax.core import Tracer

from physagent_jax.core.errors import UserError
from physagent_jax.core.pytree import register_dataclass
from physagent_jax.forces.parameters import Array, ForceFieldParameters
from physagent_jax.mpm import Contact, Model
from physagent_jax.mpm.numbers import read_number, take_numbers
from physagent_jax.scene import config as c

_NO_NUMBERS = ("damping_ratio", "tension")
# Viscosity or drag is made of the first; the second is a yes or no.

_PER_PARTICLE = ("materials", "velocity")  # may be given so


@register_dataclass
@dataclasses.dataclass(frozen=True)
class MaterialParameters:
    """Of one material; names and units are those of `scene.config.Material`.

    Each is a scalar, or has one number per particle of the model, shape (n,), of which those count whose particles are
    of this material.

    Attributes:
        density: [kg/m^3].
        youngs_modulus: E [Pa]; None for what does not depend on it.
        poissons_ratio: nu, as E.
        viscosity: Newtonian or Kelvin-Voigt viscosity [Pa s]; where the material has a damping ratio, what that has
            been made into.
        yield_stress, hardening_modulus, softening_modulus, cohesion, bulk_modulus: [Pa].
        plastic_viscosity: [Pa s].
        friction_angle: [degrees].
        critical_compression, critical_stretch, hardening_coefficient, hardening_cap: Parameters of snow.
        restitution: Coefficient of restitution of a rigid body [1].
    """

    density: Array | None = None
    youngs_modulus: Array | None = None
    poissons_ratio: Array | None = None
    viscosity: Array | None = None
    yield_stress: Array | None = None
    hardening_modulus: Array | None = None
    softening_modulus: Array | None = None
    plastic_viscosity: Array | None = None
    friction_angle: Array | None = None
    cohesion: Array | None = None
    critical_compression: Array | None = None
    critical_stretch: Array | None = None
    hardening_coefficient: Array | None = None
    hardening_cap: Array | None = None
    bulk_modulus: Array | None = None
    restitution: Array | None = None

    @staticmethod
    def of(material: c.Material, viscosity: Array | None = None) -> MaterialParameters:
        """A material's own numbers, in double precision on the host.

        Args:
            material: What to take them from.
            viscosity: What the scene gives it [Pa s]; None = none.
        """
        names = [name for name in c.MODEL_PARAMETERS[material.model] if name not in _NO_NUMBERS]
        if material.model in c.ELASTIC_MODELS:
            names += ["youngs_modulus", "poissons_ratio"]
        values = {name: getattr(material, name) for name in ("density", *names)}
        values["viscosity"] = viscosity
        return MaterialParameters(
            **{name: read_number(value) for name, value in values.items() if value is not None}
        )

    def get_given(self) -> dict[str, Array]:
        """The values that are not None, by name."""
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        return {name: value for name, value in values.items() if value is not None}


class Scene(Protocol):
    """The source of parameters: a `CompiledScene`."""

    @property
    def config(self) -> c.SceneConfig:
        """The configuration that it was compiled from."""
        ...

    @property
    def model(self) -> Model:
        """The simulator's."""
        ...

    @property
    def choice(self) -> np.ndarray:
        """The index of each particle's material in the scene, shape (n,)."""
        ...

    @property
    def own_terms(self) -> tuple[Any, ...]:
        """The model's force terms that are the scene's own."""
        ...

    @property
    def imposed(self) -> tuple[Any, ...]:
        """The compiled forms of the scene's own constraints, in their order."""
        ...


@register_dataclass
@dataclasses.dataclass(frozen=True)
class SceneParameters:
    """Of a whole scene; None, and () for a tuple, is what the scene has not, or keeps.

    Attributes:
        force_field: The vectors, magnitudes and windows of its actions and constraints.
        forces: The terms of `SceneConfig.forces`: each compiled (`forces.terms`) with its numbers alone, its
            envelope's among them.
        constraints: The terms of `SceneConfig.constraints`, likewise (`PrescribedMotion`, `UniformAcceleration`).
        materials: Numbers of the scene's material, then of those of its regions.
        friction: Coulomb's coefficient of each of `SceneConfig.boundaries`; None for one without friction.
        gravity: [m/s^2], shape (3,).
        velocity: Velocity of the object at the start [m/s], shape (3,), or one per particle, shape (n, 3).
        damping_rate: Damping rate of all velocities [1/s]; the form of a damping ratio where the object is held.
    """

    force_field: ForceFieldParameters | None = None
    forces: tuple[Any, ...] = ()
    constraints: tuple[Any, ...] = ()
    materials: tuple[MaterialParameters | None, ...] = ()
    friction: tuple[Array | None, ...] = ()
    gravity: Array | None = None
    velocity: Array | None = None
    damping_rate: Array | None = None

    @staticmethod
    def of(scene: Scene) -> SceneParameters:
        """A scene's own numbers, in double precision on the host.

        Args:
            scene: A `CompiledScene` as `compile_scene` made it.
        """
        config, model, field = scene.config, scene.model, scene.config.force_field
        choices = (config.material, *(region.material for region in config.material_regions))
        frame_count = config.timing.frame_count
        return SceneParameters(
            force_field=ForceFieldParameters.of(field, frame_count)
            if field.actions or field.constraints
            else None,
            forces=tuple(map(take_numbers, scene.own_terms)),
            constraints=tuple(map(take_numbers, scene.imposed)),
            materials=tuple(
                MaterialParameters.of(material, _find_viscosity(model, scene.choice == index))
                for index, material in enumerate(choices)
            ),
            friction=tuple(_find_friction(boundary) for boundary in model.boundaries),
            gravity=None if model.gravity is None else np.asarray(config.gravity, np.float64),
            velocity=np.zeros(3),
            damping_rate=None if model.damping_rate is None else read_number(model.damping_rate),
        )


def check_parameters(parameters: SceneParameters, own: SceneParameters) -> None:
    """Refuse numbers that a scene with the parameters ``own`` does not have.

    Raises:
        UserError: There are such numbers, one is of another shape, or a tuple has not one entry for each of the
            scene's.
    """
    for name in ("forces", "constraints", "materials", "friction"):
        given, wanted = getattr(parameters, name), getattr(own, name)
        if len(given) not in (0, len(wanted)):
            raise UserError(
                f"`parameters.{name}` must have one entry for each that the scene has, {len(wanted)}",
                got=len(given),
            )
        for index, (one, other) in enumerate(zip(given, wanted)):
            if dataclasses.is_dataclass(one) and type(one) is not type(other):
                what = f"the numbers of a {type(other).__name__}"
                raise UserError(f"`parameters.{name}[{index}]` must be {what}", got=type(one).__name__)
    known = dict(jax.tree_util.tree_leaves_with_path(own))
    for path, value in jax.tree_util.tree_leaves_with_path(dataclasses.replace(parameters, force_field=None)):
        place = jax.tree_util.keystr(path)
        if path not in known:
            raise UserError(
                f"`parameters{place}` is a number that the scene does not have",
                do="Begin with `SceneParameters.of(scene)`, and change the numbers that it has",
            )
        if path[0].name not in _PER_PARTICLE and np.shape(value) != np.shape(known[path]):
            raise UserError(
                f"`parameters{place}` must have the shape {np.shape(known[path])}", got=np.shape(value)
            )


def _find_viscosity(model: Model, mask: np.ndarray) -> Array | None:
    if model.viscosity is None or not mask.any():
        return None
    found = read_number(model.viscosity)[np.flatnonzero(mask)[0]]
    return found if isinstance(found, Tracer) or found > 0 else None


def _find_friction(boundary: Any) -> Array | None:
    if getattr(boundary, "contact", None) is not Contact.SEPARATE:
        return None
    return read_number(boundary.friction)
