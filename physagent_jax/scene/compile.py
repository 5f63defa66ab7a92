"""From a `SceneConfig` and its `Body` to the simulator's `Model` and `State`."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import jax.numpy as jnp
import numpy as np

from physagent_jax.errors import UserError
from physagent_jax.forces.skills import closed_form_scaling, compile_force_field
from physagent_jax.forces.terms import UniformAcceleration
from physagent_jax.mpm import (
    Contact,
    FixedCorotated,
    Model,
    NeoHookean,
    PrescribedMotion,
    State,
    boundaries,
    lame_parameters,
    smallest_window,
)
from physagent_jax.render.camera import Camera
from physagent_jax.scene import config as c
from physagent_jax.scene.anchor import anchored_particles
from physagent_jax.scene.body import Body
from physagent_jax.scene.camera import reference_camera

_MODELS = {c.MaterialModel.NEO_HOOKEAN: NeoHookean, c.MaterialModel.FIXED_COROTATED: FixedCorotated}
_DTYPE = np.float32


@dataclasses.dataclass(frozen=True)
class Scene:
    """A compiled scene.

    Attributes:
        config: What it was compiled from.
        body: The object at rest.
        model, state: For `mpm.simulate`.
        camera: The reference camera.
        order: Body particle of each model particle, shape (n,): particles are grouped by material.
        anchored: Number of particles held by the anchor.
    """

    config: c.SceneConfig
    body: Body
    model: Model
    state: State
    camera: Camera
    order: np.ndarray
    anchored: int


def compile_scene(config: c.SceneConfig, body: Body, base_dir: str | Path = ".") -> Scene:
    """Binds a scene's parts to its particles.

    Raises:
        UserError: A region, box or window of the scene selects nothing or makes no sense.
    """
    matter = _Matter.of(config, body)
    order = np.argsort(matter.model, kind="stable")
    rest, matter = body.particles.x[order].astype(_DTYPE), matter.take(order)
    mass = matter.density * body.particles.volume[order]
    held = anchored_particles(
        config.anchor,
        rest,
        body.particles.gaussian_index[order],
        base_dir,
        gaussian_count=body.cloud.count,
    )
    forces, constraints = _force_field(config, body, rest, body.particles.volume[order])
    imposed, prescribed = _constraints(config, rest, mass)
    if held.any():
        prescribed = (*prescribed, PrescribedMotion.fixed(jnp.asarray(np.flatnonzero(held), jnp.int32)))
    falling = config.force_field.default_drop or config.always_gravity
    model = Model(
        grid=smallest_window(config.domain.size, config.domain.cells),
        dt=jnp.asarray(config.timing.frame_dt, _DTYPE),
        gravity=jnp.asarray(config.gravity, _DTYPE) if falling and any(config.gravity) else None,
        mass=jnp.asarray(mass, _DTYPE),
        volume=jnp.asarray(body.particles.volume[order], _DTYPE),
        materials=matter.materials(),
        forces=(*forces, *imposed),
        boundaries=tuple(_boundary(b) for b in config.boundaries),
        constraints=(*constraints, *prescribed),
        transfer=config.transfer.scheme,
        rpic_damping=config.transfer.rpic_damping,
        damping_rate=config.transfer.damping_rate,
    )
    state = State.at_rest(jnp.asarray(rest))
    camera = reference_camera(config.camera, config.rendering, config.domain)
    return Scene(config, body, model, state, camera, order, int(held.sum()))


@dataclasses.dataclass(frozen=True)
class _Matter:
    """Material parameters per particle."""

    model: np.ndarray
    youngs_modulus: np.ndarray
    poissons_ratio: np.ndarray
    density: np.ndarray

    @staticmethod
    def of(config: c.SceneConfig, body: Body) -> _Matter:
        names = list(_MODELS)
        count, rest = body.particles.count, body.particles.x

        def spread(material: c.Material):
            return (
                names.index(material.model),
                material.youngs_modulus,
                material.poissons_ratio,
                material.density,
            )

        columns = [np.full(count, value) for value in spread(config.material)]
        for index, region in enumerate(config.material_regions):
            inside = _in_box(rest, region, f"material_regions[{index}]")
            for column, value in zip(columns, spread(region.material)):
                column[inside] = value
        return _Matter(*columns)

    def take(self, order: np.ndarray) -> _Matter:
        return _Matter(*(getattr(self, f.name)[order] for f in dataclasses.fields(self)))

    def materials(self) -> tuple:
        """One material per block of equal model; the particles must be in order."""
        blocks = []
        for index, solid in enumerate(_MODELS.values()):
            block = self.model == index
            if block.any():
                mu, lam = lame_parameters(self.youngs_modulus[block], self.poissons_ratio[block])
                blocks.append(solid(jnp.asarray(mu, _DTYPE), jnp.asarray(lam, _DTYPE)))
        return tuple(blocks)


def _force_field(config: c.SceneConfig, body: Body, rest: np.ndarray, volume: np.ndarray):
    timing = config.timing
    scaling = config.scaling or closed_form_scaling(
        extent=body.extent,
        youngs_modulus=config.material.youngs_modulus,
        density=config.material.density,
        duration=(timing.frame_count - 1) * timing.frame_dt,
    )
    return compile_force_field(
        config.force_field, scaling, rest, volume, frame_dt=timing.frame_dt, frame_count=timing.frame_count
    )


def _boundary(boundary: c.Boundary):
    match boundary:
        case c.DomainBox():
            return boundaries.DomainBox(boundary.padding)
        case c.HalfSpace():
            return boundaries.HalfSpace(
                point=_leaf(boundary.point),
                normal=_leaf(boundary.normal),
                friction=_leaf(boundary.friction),
                start=_leaf(boundary.start),
                end=_leaf(boundary.end),
                contact=Contact(boundary.surface.value),
            )
        case c.Cuboid():
            return boundaries.Cuboid(
                point=_leaf(boundary.point),
                half_size=_leaf(boundary.half_size),
                velocity=_leaf(boundary.velocity),
                start=_leaf(boundary.start),
                end=_leaf(boundary.end),
            )


def _constraints(config: c.SceneConfig, rest: np.ndarray, mass: np.ndarray) -> tuple[tuple, tuple]:
    """Impulses as force terms, prescribed motions as constraints."""
    forces, motions = [], []
    for index, constraint in enumerate(config.constraints):
        place = f"constraints[{index}]"
        match constraint:
            case c.ParticleImpulse():
                inside = _in_box(rest, constraint, place).astype(_DTYPE)
                change = constraint.delta_velocity or constraint.force
                # A force per particle accelerates by F / m; a velocity change by dv / duration.
                weight = inside / mass if constraint.force else inside / constraint.duration
                window = _leaf(constraint.start), _leaf(constraint.start + constraint.duration)
                forces.append(UniformAcceleration(_leaf(change), *window, _leaf(weight)))
            case c.ParticleTranslation():
                inside = _in_box(rest, constraint, place)
                motions.append(_motion(inside, constraint, constraint.velocity, (0, 0, 0)))
            case c.ParticleRotation():
                axis = np.asarray(constraint.normal)
                inside = _in_cylinder(rest, constraint, place)
                motions.append(
                    _motion(
                        inside,
                        constraint,
                        constraint.axial_velocity * axis,
                        constraint.angular_velocity * axis,
                    )
                )
    return tuple(forces), tuple(motions)


def _motion(inside: np.ndarray, constraint, velocity, angular_velocity) -> PrescribedMotion:
    return PrescribedMotion(
        particles=jnp.asarray(np.flatnonzero(inside), jnp.int32),
        velocity=_leaf(velocity),
        angular_velocity=_leaf(angular_velocity),
        center=_leaf(constraint.point),
        start=_leaf(constraint.start),
        end=_leaf(constraint.end),
    )


def _leaf(value) -> jnp.ndarray:
    return jnp.asarray(value, _DTYPE)


def _in_box(rest: np.ndarray, box, place: str) -> np.ndarray:
    inside = np.all(np.abs(rest - np.asarray(box.point)) <= np.asarray(box.half_size), axis=1)
    return _not_empty(inside, rest, place)


def _in_cylinder(rest: np.ndarray, cylinder: c.ParticleRotation, place: str) -> np.ndarray:
    arm = rest - np.asarray(cylinder.point)
    height = arm @ np.asarray(cylinder.normal)
    radius = np.linalg.norm(arm - height[:, None] * np.asarray(cylinder.normal), axis=1)
    return _not_empty((np.abs(height) <= cylinder.half_height) & (radius <= cylinder.radius), rest, place)


def _not_empty(inside: np.ndarray, rest: np.ndarray, place: str) -> np.ndarray:
    if not inside.any():
        low, high = np.round(rest.min(0), 3).tolist(), np.round(rest.max(0), 3).tolist()
        raise UserError(
            f"`{place}` selects no particle; the object spans {low} to {high} m", do="Move it there"
        )
    return inside
