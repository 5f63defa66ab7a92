"""Compile a scene's constraints into those of the simulator."""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_jax.forces.terms import UniformAcceleration
from physagent_jax.mpm import PrescribedMotion
from physagent_jax.scene import config as c
from physagent_jax.scene.compile import buckets
from physagent_jax.scene.compile.select import DTYPE, check_not_empty, select_box, select_cylinder, to_array

STILL = (0.0, 0.0, 0.0)


def compile_constraints(config: c.SceneConfig, rest: np.ndarray, mass: np.ndarray) -> tuple[tuple, tuple]:
    """Impulses as force terms, prescribed motions as constraints."""
    forces, motions = [], []
    for index, constraint in enumerate(config.constraints):
        place = f"constraints[{index}]"
        match constraint:
            case c.ParticleImpulse():
                inside = select_box(rest, constraint, place).astype(DTYPE)
                change = constraint.delta_velocity or constraint.force
                # A force per particle accelerates by F / m; a velocity change by dv / duration.
                weight = inside / mass if constraint.force else inside / constraint.duration
                window = to_array(constraint.start), to_array(constraint.start + constraint.duration)
                forces.append(UniformAcceleration(to_array(change), *window, to_array(weight)))
            case c.ParticleTranslation():
                inside = select_box(rest, constraint, place)
                motions.append(_make_motion(inside, constraint, constraint.velocity, STILL, constraint.point))
            case c.ParticleRotation():
                axis = np.asarray(constraint.normal)
                inside = select_cylinder(rest, constraint, place)
                motions.append(
                    _make_motion(
                        inside,
                        constraint,
                        constraint.axial_velocity * axis,
                        constraint.angular_velocity * axis,
                        constraint.point,
                    )
                )
            case c.ParticleRelease():
                inside, times = _compute_release_times(rest, constraint, place)
                motion = _make_motion(inside, constraint, STILL, STILL, STILL)
                ends = np.pad(times, (0, len(motion.particles) - len(times)))
                motions.append(dataclasses.replace(motion, end=to_array(ends)))
    return tuple(forces), tuple(motions)


def _make_motion(inside: np.ndarray, constraint, velocity, angular_velocity, center) -> PrescribedMotion:
    return PrescribedMotion(
        particles=buckets.find_places(inside),
        velocity=to_array(velocity),
        angular_velocity=to_array(angular_velocity),
        center=to_array(center),
        start=to_array(constraint.start),
        end=to_array(constraint.end),
    )


def _compute_release_times(
    rest: np.ndarray, release: c.ParticleRelease, place: str
) -> tuple[np.ndarray, np.ndarray]:
    """The held particles, shape (n,), and the time of each one's release [s].

    PhysGaussian holds nested boxes about ``end_position``, the i-th with a share 1 - i/layers of the full
    reach; a particle is free once the last box that contains it is.
    """
    reach = abs(release.start_position - release.end_position)
    height = rest.astype(np.float64) @ np.asarray(release.normal)
    share = np.abs(height - release.end_position) / reach
    inside = check_not_empty(share <= 1, rest, place)
    layer = np.minimum(np.floor(release.layers * (1 - share[inside])), release.layers - 1)
    return inside, release.end * (layer + 1) / release.layers
