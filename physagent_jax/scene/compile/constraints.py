"""What is done to chosen particles, as the simulator has it."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from physagent_jax.forces.terms import UniformAcceleration
from physagent_jax.mpm import PrescribedMotion
from physagent_jax.scene import config as c
from physagent_jax.scene.compile.select import DTYPE, in_box, in_cylinder, leaf


def compile_constraints(config: c.SceneConfig, rest: np.ndarray, mass: np.ndarray) -> tuple[tuple, tuple]:
    """Impulses as force terms, prescribed motions as constraints."""
    forces, motions = [], []
    for index, constraint in enumerate(config.constraints):
        place = f"constraints[{index}]"
        match constraint:
            case c.ParticleImpulse():
                inside = in_box(rest, constraint, place).astype(DTYPE)
                change = constraint.delta_velocity or constraint.force
                # A force per particle accelerates by F / m; a velocity change by dv / duration.
                weight = inside / mass if constraint.force else inside / constraint.duration
                window = leaf(constraint.start), leaf(constraint.start + constraint.duration)
                forces.append(UniformAcceleration(leaf(change), *window, leaf(weight)))
            case c.ParticleTranslation():
                inside = in_box(rest, constraint, place)
                motions.append(_motion(inside, constraint, constraint.velocity, (0, 0, 0)))
            case c.ParticleRotation():
                axis = np.asarray(constraint.normal)
                inside = in_cylinder(rest, constraint, place)
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
        velocity=leaf(velocity),
        angular_velocity=leaf(angular_velocity),
        center=leaf(constraint.point),
        start=leaf(constraint.start),
        end=leaf(constraint.end),
    )
