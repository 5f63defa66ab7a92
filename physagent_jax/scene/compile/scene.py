"""From a `SceneConfig` and its `Body` to the simulator's `Model` and `State`."""

from __future__ import annotations

import dataclasses
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from physagent_jax.core.arrays import to_device
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.schema import CellsRegion
from physagent_jax.gaussians.binding import Binding
from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.mpm import (
    Grid,
    Lumped,
    Model,
    PrescribedMotion,
    Sharpened,
    State,
    cell_order,
    find_smallest_window,
    stable_dt,
)
from physagent_jax.mpm.constraints import RigidBody
from physagent_jax.mpm.edges import set_edges
from physagent_jax.mpm.limits import warn_of_limits
from physagent_jax.mpm.timestep import divide_frame
from physagent_jax.render.camera import Camera
from physagent_jax.scene import config as c
from physagent_jax.scene.anchor import select_anchored
from physagent_jax.scene.body import Body
from physagent_jax.scene.camera import make_reference_camera
from physagent_jax.scene.compile import buckets
from physagent_jax.scene.compile.boundaries import compile_boundaries
from physagent_jax.scene.compile.constraints import compile_constraints
from physagent_jax.scene.compile.equilibrium import balance_weight
from physagent_jax.scene.compile.forces import compile_forces, compile_skills
from physagent_jax.scene.compile.idle import find_idle
from physagent_jax.scene.compile.materials import ParticleMaterials
from physagent_jax.scene.compile.origins import Origins
from physagent_jax.scene.compile.parameters import keep_balance, put_materials, put_own, put_rest
from physagent_jax.scene.compile.select import DTYPE, to_array
from physagent_jax.scene.damping import compute_drag, find_lowest_mode
from physagent_jax.scene.parameters import SceneParameters, check_parameters

_SLOW = 0.5  # twice the cells of a fall: what hits more slowly does not rebound


@dataclasses.dataclass(frozen=True)
class CompiledScene:
    """A compiled scene.

    Attributes:
        config: What it was compiled from.
        body: The object at rest.
        model, state: For `mpm.rollout`, with ``substeps`` steps per frame: the window is the whole domain, and the step
            is stable for the state. For `mpm.simulate`, which fits both to each frame, take `windowed`.
        substeps: Steps of ``model.dt`` in a frame.
        camera: The reference camera.
        order: Body particle of each model particle, shape (n,): particles are grouped by material, lie cell by
            cell in memory, and some are there twice (`buckets`).
        anchored: Number of particles held by the anchor.
        materials: Which material each particle is of.
        origins: Where the model's forces and constraints came from.
        changed: Whether it has other numbers than ``config`` says (`with_parameters`).
    """

    config: c.SceneConfig
    body: Body
    model: Model
    state: State
    substeps: int
    camera: Camera
    order: np.ndarray
    anchored: int
    materials: ParticleMaterials
    origins: Origins
    changed: bool = False

    def with_parameters(self, parameters: SceneParameters | ForceFieldParameters) -> CompiledScene:
        """The scene with other numbers, traced or not; what they leave out, and all that is no number, is kept.

        What a magnitude of 1 means stays as it was compiled: with another E or density, the force field gives the same
        accelerations. A start in equilibrium stays one where a single material and the length of gravity change: the
        stress follows the weight, and the stretch the law.

        Raises:
            UserError: They are not this scene's, or a known window lies outside the clip.
        """
        if isinstance(parameters, ForceFieldParameters):
            parameters = SceneParameters(force_field=parameters)
        check_parameters(parameters, SceneParameters.of(self))
        materials, model = put_materials(
            self.model, self.state, self.materials, self.origins, parameters, self._rest[1]
        )
        if parameters.force_field is not None:
            rest, volume = self._rest[0].astype(self.state.x.dtype), self._rest[1]
            skills, grips = compile_skills(self.config, self.body, rest, volume, parameters.force_field)
            model = self.origins.replace(model, skills=skills, grips=grips)
        model = put_own(model, self.state, self.origins, self.config, parameters, self.model.mass)
        model, state = put_rest(model, self.state, parameters)
        if self.config.start == "equilibrium" and model.gravity is not None:
            state = keep_balance(self.model, model, state)
        return dataclasses.replace(self, model=model, state=state, materials=materials, changed=True)

    def with_edges(self, edge: Any) -> CompiledScene:
        """The scene with smooth edges of the width ``edge`` [s] in the windows of forces and constraints (`mpm.edges`).

        Obstacles keep their hard windows, and so do ramps and pulses, which have edges of their own.
        """
        skills, terms, impulses = (set_edges(parts, edge) for parts in self.origins.split_forces(self.model))
        grips, motions = (set_edges(parts, edge) for parts in self.origins.split_constraints(self.model)[1:3])
        model = self.origins.replace(
            self.model, skills=skills, terms=terms, impulses=impulses, grips=grips, motions=motions
        )
        return dataclasses.replace(self, model=model, changed=True)

    @cached_property
    def _rest(self) -> tuple[np.ndarray, np.ndarray]:
        return _find_rest(self.body, self.order)

    @property
    def choice(self) -> np.ndarray:
        """The index of each particle's material in the scene, shape (n,)."""
        return self.materials.choice

    @property
    def own_terms(self) -> tuple[Any, ...]:
        """The model's force terms that are the scene's own, in the order of `SceneConfig.forces`."""
        return self.origins.split_forces(self.model)[1]

    @property
    def imposed(self) -> tuple[Any, ...]:
        """The compiled forms of the scene's own constraints, in their order."""
        impulses = iter(self.origins.split_forces(self.model)[2])
        motions = iter(self.origins.split_constraints(self.model)[2])
        return tuple(
            next(impulses if isinstance(each, c.ParticleImpulse) else motions)
            for each in self.config.constraints
        )

    @property
    def windowed(self) -> Model:
        """The model with the least window, which grows to the object in `mpm.simulate`; the whole domain is costly."""
        grid = self.model.grid
        return self.model.replace(grid=find_smallest_window(grid.dx * grid.cells, grid.cells))

    @cached_property
    def back(self) -> np.ndarray:
        """A model particle of each body particle, shape (body particles,)."""
        return np.unique(self.order, return_index=True)[1]

    @cached_property
    def gaussians(self) -> tuple[GaussianCloud, Binding]:
        """The body's Gaussians to be drawn, bound to the model's particles; for their number see `buckets`."""
        binding = self.body.binding
        binding = dataclasses.replace(
            binding, indices=self.back.astype(np.int32)[np.asarray(binding.indices)]
        )
        return buckets.pad_gaussians(self.body.cloud.of_least_degree(), binding)


def compile_scene(config: c.SceneConfig, body: Body, base_dir: str | Path = ".") -> CompiledScene:
    """Bind a scene's parts to its particles, and warn of what the method does badly in it (`mpm.limits`).

    Raises:
        UserError: A region, box or window of the scene selects nothing or makes no sense.
    """
    materials = ParticleMaterials.of(config, body)
    order = cell_order(body.particles.x, config.domain.dx, materials.model)
    order = buckets.add_copies(order, materials.model[order])
    rest, volume = _find_rest(body, order)
    materials, share = materials.permute(order), buckets.split_mass(order)
    whole = materials.density * body.particles.volume[order]  # mass of a particle with all its copies
    anchor_mask = select_anchored(
        config.anchor,
        rest,
        body.particles.gaussian_index[order],
        base_dir,
        gaussian_count=body.cloud.count,
    )
    forces, constraints = compile_forces(config, body, rest, volume)
    imposed, prescribed = compile_constraints(config, rest, whole)
    grips = [each for each in constraints if isinstance(each, PrescribedMotion)]
    if config.anchor.kind == "region":  # what is twisted goes along, though it is of the rest
        anchor_mask &= ~_mark_led(grips, len(rest))
    slow = to_array(np.sqrt(_SLOW * config.domain.dx * np.linalg.norm(config.gravity)))
    choices = materials.choices
    bodies = tuple(
        RigidBody(
            buckets.find_places(mask),
            None if (e := choices[index].restitution) is None else to_array(e),
            slow,
            whole=bool(mask.all()),
        )
        for index, mask in materials.find_rigid_bodies()
    )
    # What slides past what is held must not strain it.
    rigid = any(each.rigid for each in grips)
    rigid |= isinstance(config.anchor.region, CellsRegion) and config.anchor.region.rigid
    if (still := anchor_mask | materials.find_stationary()).any():
        prescribed = (*prescribed, PrescribedMotion.fixed(buckets.find_places(still), rigid=rigid))
    mode = (
        find_lowest_mode(rest, volume, still, config.material, materials.firmness)
        if materials.damped
        else None
    )
    drag = config.transfer.damping_rate
    if mode is not None and mode.held:  # the air's is part of it
        drag = max(
            drag, compute_drag(np.average(materials.get_values("damping_ratio"), weights=volume), mode)
        )
    falling = config.force_field.default_drop or config.always_gravity
    model = Model(
        grid=Grid.whole(config.domain.size, config.domain.cells),
        dt=to_device(config.timing.frame_dt, DTYPE),
        gravity=to_device(config.gravity, DTYPE) if falling and any(config.gravity) else None,
        mass=to_device(share * whole, DTYPE),
        volume=to_device(volume, DTYPE),
        materials=materials.build_materials(),
        forces=(*forces, *imposed),
        boundaries=compile_boundaries(config, base_dir),
        constraints=(*bodies, *constraints, *prescribed),
        viscosity=materials.viscosity(mode),
        transfer=config.transfer.scheme,
        stress_form=config.transfer.stress_form,
        inertia=_choose_inertia(config.transfer),
        rpic_damping=config.transfer.rpic_damping,
        damping_rate=to_device(drag, DTYPE) if drag else None,
    )
    state = State.at_rest(to_device(rest), materials=model.materials)
    warn_of_limits(model, state, (config.timing.frame_count - 1) * config.timing.frame_dt, stacklevel=3)
    balanced = balance_weight(model, state, still, config, body)
    if balanced is not None:
        state = dataclasses.replace(state, F=to_device(balanced.F, DTYPE))
    if (idle := find_idle(config, constraints, still, rest)).any():
        materials = materials.soften(idle)
        model = model.replace(materials=materials.build_materials())
    substeps = _count_substeps(config, model, state)
    model = model.replace(dt=to_device(config.timing.frame_dt / substeps, DTYPE))
    camera = make_reference_camera(config.camera, config.rendering, config.domain)
    anchored = int(anchor_mask @ share + 0.5)
    own, impulses = len(config.forces), len(imposed)
    origins = Origins(
        skills=len(forces) - own,
        terms=own,
        impulses=impulses,
        bodies=len(bodies),
        grips=len(constraints),
        motions=len(config.constraints) - impulses,
    )
    return CompiledScene(config, body, model, state, substeps, camera, order, anchored, materials, origins)


def _choose_inertia(transfer: c.Transfer) -> Lumped | Sharpened:
    if transfer.sharpening:
        return Sharpened(transfer.sharpening, transfer.aggregation)
    return Lumped(transfer.aggregation)


def _find_rest(body: Body, order: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rest positions [m], shape (n, 3), and rest volumes [m^3], shape (n,), of the model's particles."""
    particles = body.particles
    return particles.x[order].astype(DTYPE), buckets.split_mass(order) * particles.volume[order]


def _mark_led(grips: list[PrescribedMotion], count: int) -> np.ndarray:
    """Particles that some motion prescribes, shape (n,)."""
    led = np.zeros(count + 1, bool)  # the last stands for no particle
    for each in grips:
        led[np.asarray(each.particles)] = True
    return led[:-1]


def _count_substeps(config: c.SceneConfig, model: Model, state: State) -> int:
    """Steps per frame that are stable at the start, or as many as the scene asks for."""
    timing = config.timing
    bound = (
        timing.safety * float(stable_dt(model, state)) if timing.substep_dt == "auto" else timing.substep_dt
    )
    return divide_frame(timing.frame_dt, bound) if 0 < bound < timing.frame_dt else 1
