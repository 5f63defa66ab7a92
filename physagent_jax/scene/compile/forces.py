"""Compile the agents' force field and the scene's own terms into those of the simulator."""

from __future__ import annotations

import dataclasses

import jax.numpy as jnp
import numpy as np
from jax.core import Tracer

from physagent_jax.core.errors import UserError
from physagent_jax.forces import terms
from physagent_jax.forces.compilation import compile_force_field
from physagent_jax.forces.envelope import Envelope, EnvelopeKind
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.forces.scaling import make_closed_form_scaling
from physagent_jax.mpm.constraints import PrescribedMotion
from physagent_jax.mpm.fields import PER_HELD, find_fields
from physagent_jax.mpm.protocols import Constraint
from physagent_jax.scene import config as c
from physagent_jax.scene.body import Body
from physagent_jax.scene.compile import buckets
from physagent_jax.scene.compile.select import DTYPE, to_array


def compile_forces(
    config: c.SceneConfig, body: Body, rest: np.ndarray, volume: np.ndarray
) -> tuple[tuple, tuple]:
    """Terms for `Model.forces`, and the force field's constraints for `Model.constraints`.

    Args:
        config: The scene.
        body: Its object.
        rest: Rest positions of the model's particles [m], shape (n, 3).
        volume: Their rest volumes [m^3], shape (n,).

    Raises:
        UserError: A region selects nothing, or a window lies outside the clip.
    """
    skills, constraints = compile_skills(config, body, rest, volume)
    return (*skills, *compile_force_terms(config, rest)), constraints


def compile_force_terms(config: c.SceneConfig, rest: np.ndarray) -> tuple:
    """The scene's own terms (`SceneConfig.forces`); arguments and errors as for `compile_forces`."""
    clip = config.timing.duration
    compiled = []
    for index, term in enumerate(config.forces):
        place = f"forces[{index}]"
        if term.envelope.start >= clip:
            raise UserError(
                f"`{place}.envelope.start` lies after the clip's end at {clip:g} s",
                got=term.envelope.start,
                do="Give seconds inside the clip",
            )
        weight = None
        if term.region is not None:
            weight = to_array(make_region_mask(term.region, rest, f"{place}.region"))
        compiled.append(_compile_term(term, _compile_envelope(term.envelope), weight))
    return tuple(compiled)


def _compile_term(term: c.ForceTerm, envelope: Envelope, weight):
    match term:
        case c.Wind():
            return terms.Wind(
                direction=to_array(term.direction or (1.0, 0.0, 0.0)),  # of still air, any
                speed=to_array(term.speed),
                linear_drag=to_array(term.linear_drag),
                quadratic_drag=to_array(term.quadratic_drag),
                envelope=envelope,
                center=None if term.center is None else to_array(term.center),
                radius=None if term.radius is None else to_array(term.radius),
                weight=weight,
            )
        case c.Attractor():
            place = to_array(term.point), to_array(term.strength)
            return terms.Attractor(*place, to_array(term.power), to_array(term.softening), envelope, weight)
        case c.Vortex():
            return terms.Vortex(
                point=to_array(term.point),
                axis=to_array(term.axis),
                swirl=to_array(term.swirl),
                inward=to_array(term.inward),
                axial=to_array(term.axial),
                core=to_array(term.core),
                power=to_array(term.power),
                envelope=envelope,
                weight=weight,
            )
        case c.Turbulence():
            return terms.Turbulence.from_seed(
                term.seed,
                strength=to_array(term.strength),
                length_scale=to_array(term.length_scale),
                time_scale=to_array(term.time_scale),
                envelope=envelope,
                modes=term.modes,
                weight=weight,
                dtype=DTYPE,
            )
        case c.Uniform():
            return terms.UniformField(to_array(term.acceleration), envelope, weight)


def _compile_envelope(envelope: c.Envelope) -> Envelope:
    values = envelope.model_dump(exclude={"kind"})
    return Envelope(EnvelopeKind(envelope.kind), **{name: to_array(value) for name, value in values.items()})


def compile_skills(
    config: c.SceneConfig,
    body: Body,
    rest: np.ndarray,
    volume: np.ndarray,
    parameters: ForceFieldParameters | None = None,
) -> tuple[tuple, tuple]:
    """The force field alone; as `compile_forces`, with ``parameters`` as for `compile_force_field`."""
    timing = config.timing
    scaling = config.scaling or make_closed_form_scaling(
        extent=body.extent,
        youngs_modulus=config.material.youngs_modulus,
        density=config.material.density,
        duration=timing.duration,
    )
    skills, grips = compile_force_field(
        config.force_field,
        scaling,
        rest,
        volume,
        frame_dt=timing.frame_dt,
        frame_count=timing.frame_count,
        parameters=parameters,
    )
    return skills, tuple(_fill_bucket(grip, len(rest)) for grip in grips)


def _fill_bucket(grip: Constraint, count: int) -> Constraint:
    if not isinstance(grip, PrescribedMotion):
        return grip
    particles = buckets.pad_indices(np.asarray(grip.particles), count)
    missing, fields = len(particles) - len(grip.particles), {"particles": particles}
    for name in find_fields(grip, **PER_HELD):
        values = getattr(grip, name)
        if name != "particles" and values is not None and values.ndim:
            traced = isinstance(values, Tracer)
            fields[name] = (
                jnp.pad(values, (0, missing))
                if traced
                else to_array(np.pad(np.asarray(values), (0, missing)))
            )
    return dataclasses.replace(grip, **fields)
