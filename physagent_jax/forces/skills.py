"""The Force Field Skill Library: from dimensionless JSON to terms with units (paper, appendix A.2).

With L the object's longest extent, E and rho its mean stiffness and density and T the clip's duration, a
magnitude of M = 1 means

| skill       | field at x                                    | k            | so that, unopposed,              |
|-------------|-----------------------------------------------|--------------|----------------------------------|
| translation | a = k M v                                     | 2 L / T^2    | one body length by the clip's end |
| scale       | a = k M sgn(d) v, d = (x - x_c) . v           | 4 E e/(rho L) | linear mean strain e = 0.15      |
| impulse     | velocity change k M v over its window         | L / T        | one body length by the clip's end |
| torque      | a = k M (v x r), r = x - x_c                  | pi / T^2     | a quarter turn by the clip's end  |

They are forces per unit mass: filling density and particle count do not change the motion (the paper's
impulse divides by particle mass). x_c is the present mass centre. For `scale`, k is divided by the shape's
stress concentration along the axis where that exceeds 1, so that M = 1 strains no section more than the middle of
a uniform bar of length L.
"""

from __future__ import annotations

import math

import jax.numpy as jnp
import numpy as np
from pydantic import ValidationError

from physagent_jax.core.arrays import on_device
from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import validation_message
from physagent_jax.forces.regions import region_mask
from physagent_jax.forces.schema import (
    Action,
    ActionType,
    ConstraintType,
    ForceField,
    SkillScaling,
    VelocityConstraint,
)
from physagent_jax.forces.terms import Stretch, Torque, UniformAcceleration
from physagent_jax.mpm.constraints import PrescribedMotion

# Mean strain of a free linear bar under `scale` with M = 1. Soft solids stretch more than linearly: a
# neo-Hookean bar shows nearly twice as much at M = 1.6, and with 0.3 here it would tear.
STATIC_STRAIN = 0.15
SECTIONS, SECTION_WIDTH = 32, 0.1  # cross-sections looked at, and half their thickness in body lengths
_TINY = float(np.finfo(np.float32).tiny)
RAMP = 0.4  # share of a `scale` window over which the pull grows


def closed_form_scaling(
    *, extent: float, youngs_modulus: float, density: float, duration: float
) -> SkillScaling:
    """The k of the table above for a free object.

    Args:
        extent: Longest extent L [m].
        youngs_modulus: Mean E [Pa].
        density: Mean rho [kg/m^3].
        duration: The clip's duration T [s].

    Raises:
        UserError: These values give accelerations beyond what float32 can compute with.
    """
    reason = (
        f"closed form for L = {extent:.3g} m, E = {youngs_modulus:.3g} Pa, "
        f"rho = {density:.3g} kg/m^3, T = {duration:.3g} s"
    )
    try:
        return SkillScaling(
            translation=2 * extent / duration**2,
            scale=4 * youngs_modulus * STATIC_STRAIN / (density * extent),
            impulse=extent / duration,
            torque=math.pi / duration**2,
            velocity=0.5 * extent / duration,
            reason=reason,
        )
    except ValidationError as error:
        do = "Use a longer clip or a softer, denser material"
        raise validation_message(error, f"forces in {reason}", do=do) from None


def compile_force_field(
    field: ForceField,
    scaling: SkillScaling,
    rest: np.ndarray,
    volume: np.ndarray,
    *,
    frame_dt: float,
    frame_count: int,
) -> tuple[tuple, tuple[PrescribedMotion, ...]]:
    """Turns a force field into terms for `Model.forces` and constraints for `Model.constraints`.

    Args:
        field: The agents' force field.
        scaling: What M = 1 means.
        rest: Rest positions of the particles [m], shape (n, 3); its dtype is the terms'.
        volume: Rest volumes [m^3], shape (n,).
        frame_dt: Seconds per frame [s].
        frame_count: Frames of the clip; the last has index frame_count - 1.

    Raises:
        UserError: A region selects nothing, a window lies outside the clip, or an object id is unknown.
    """
    forces, constraints = [], []
    for index, action in enumerate(field.actions):
        bound = _Bound(action, f"force_field.actions[{index}]", rest, volume, frame_dt, frame_count)
        forces.append(_skill(action, scaling, bound))
    for index, constraint in enumerate(field.constraints):
        bound = _Bound(constraint, f"force_field.constraints[{index}]", rest, volume, frame_dt, frame_count)
        if constraint.constraint_type is ConstraintType.PARTICLE_IMPULSE:
            forces.append(bound.blow(scaling.impulse))
        else:
            constraints.append(bound.held(scaling.velocity))
    return tuple(forces), tuple(constraints)


def _skill(action: Action, scaling: SkillScaling, bound: _Bound):
    axis, (start, end), weight = bound.leaf(action.vector), bound.window, bound.weight
    match action.action_type:
        case ActionType.TRANSLATION:
            return UniformAcceleration(bound.vector(scaling.translation), start, end, weight)
        case ActionType.IMPULSE:
            return bound.blow(scaling.impulse)
        case ActionType.TORQUE:
            return Torque(axis, bound.leaf(scaling.torque * action.magnitude), start, end, weight)
        case ActionType.SCALE:
            strength = bound.leaf(scaling.scale * action.magnitude / bound.stress_concentration())
            return Stretch(axis, strength, start, end, RAMP * (end - start), weight)


class _Bound:
    """An action or constraint bound to particles and seconds."""

    def __init__(
        self,
        timed: Action | VelocityConstraint,
        place: str,
        rest: np.ndarray,
        volume: np.ndarray,
        frame_dt: float,
        frame_count: int,
    ):
        if timed.object is not None:
            raise UserError(
                f"`{place}.object` names an object, but the scene holds a single one",
                got=repr(timed.object),
                do="Leave `object` out",
            )
        first, last = timed.active_time or (0, frame_count - 1)
        if first >= frame_count - 1:
            raise UserError(
                f"`{place}.active_time` begins after the clip's last frame {frame_count - 1}",
                got=[first, last],
                do="Give frames inside the clip",
            )
        self._timed, self._dtype, self._rest, self._volume = timed, rest.dtype, rest, volume
        self._mask = np.ones(len(rest), bool)
        if timed.region is not None:
            self._mask = region_mask(timed.region, rest, f"{place}.region")
        self.window = self.leaf(first * frame_dt), self.leaf(last * frame_dt)
        self.weight = None if timed.region is None else self.leaf(self._mask)

    def leaf(self, value) -> jnp.ndarray:
        """``value`` as an array of the particles' dtype."""
        return on_device(value, self._dtype)

    def vector(self, k: float) -> jnp.ndarray:
        """k M v, shape (3,)."""
        return self.leaf(k * self._timed.magnitude * np.asarray(self._timed.vector))

    def stress_concentration(self) -> float:
        """How much more a `scale` strains the weakest section than it strains a uniform bar's middle; at least 1.

        A pull grows along the object and is carried by its cross-section: a thin neck with much behind it
        would tear where a bar only stretches. Compared are the pull beyond a section over the section's
        area, largest over sections across the axis, and L / 2 of the bar.
        """
        inside, axis = self._mask, np.asarray(self._timed.vector)
        height, volume = self._rest[inside] @ axis, self._volume[inside].astype(np.float64)
        extent = np.ptp(self._rest, axis=0).max()
        if extent == 0:  # all particles in one place
            return 1.0
        side = np.sign(height - np.average(height, weights=volume))
        pull = volume * (side - np.average(side, weights=volume))
        stress = []
        for section in np.linspace(height.min(), height.max(), SECTIONS):
            # A tent of width 2 w instead of a sharp cut, so that layers of particles do not alias.
            distance = (height - section) / (SECTION_WIDTH * extent)
            area = (volume * np.maximum(1 - np.abs(distance), 0)).sum() / (SECTION_WIDTH * extent)
            stress.append(abs((pull * np.clip(0.5 + 0.5 * distance, 0, 1)).sum()) / max(area, _TINY))
        return max(1.0, max(stress) / (0.5 * extent))

    def blow(self, k: float) -> UniformAcceleration:
        """The velocity change k M v, spread evenly over the window."""
        start, end = self.window
        return UniformAcceleration(self.vector(k) / (end - start), start, end, self.weight)

    def held(self, k: float) -> PrescribedMotion:
        """The particles move with k M v during the window."""
        particles = on_device(np.flatnonzero(self._mask), np.int32)
        zero = self.leaf(np.zeros(3))
        return PrescribedMotion(particles, self.vector(k), zero, zero, *self.window)
