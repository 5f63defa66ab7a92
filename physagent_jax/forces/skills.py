"""The Force Field Skill Library: from dimensionless JSON to terms with units (paper, appendix A.2).

With L the object's longest extent, E and rho its mean stiffness and density and T the clip's duration, a
magnitude of M = 1 gives what `forces.calibration` says:

| skill       | field at x                            | k              | unopposed, with                       |
|-------------|---------------------------------------|----------------|---------------------------------------|
| translation | a = k M v                             | 2 s L / T^2    | s = `TRAVEL` by the clip's end        |
| scale       | a = k M sgn(d) v, d = (x - x_c) . v   | 4 E e/(rho L)  | e = `STRAIN`, linear mean strain      |
| impulse     | velocity change k M v over its window | s L / T        | s = `TRAVEL` by the clip's end        |
| torque      | a = k M (v x r), r = x - x_c          | 2 theta / T^2  | theta = `TURN` by the clip's end      |

and `enforce_particle_translation` the velocity k M v, k = `PRESCRIBED_TRAVEL` L / T.

They are forces per unit mass: filling density and particle count do not change the motion (the paper's
impulse divides by particle mass). x_c is the present mass centre. For `scale`, k is divided by the shape's
stress concentration along the axis where that exceeds 1, so that M = 1 strains no section more than the middle of
a uniform bar of length L.

The numbers of a force field may be given apart from it and traced (`forces.parameters`): the terms are then functions
of them that JAX differentiates. What is known is computed on the host in double precision, traced or not the same law.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from pydantic import ValidationError

from physagent_jax.core.arrays import to_device
from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import format_validation_error
from physagent_jax.forces.calibration import PRESCRIBED_TRAVEL, STRAIN, STRETCH_RAMP, TRAVEL, TURN
from physagent_jax.forces.parameters import ActionParameters, Array, ForceFieldParameters, check_entries
from physagent_jax.forces.regions import make_region_mask
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

SECTIONS, SECTION_WIDTH = 32, 0.1  # cross-sections looked at, and half their thickness in body lengths
_TINY = float(np.finfo(np.float32).tiny)


def make_closed_form_scaling(
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
            translation=2 * TRAVEL * extent / duration**2,
            scale=4 * youngs_modulus * STRAIN / (density * extent),
            impulse=TRAVEL * extent / duration,
            torque=2 * TURN / duration**2,
            velocity=PRESCRIBED_TRAVEL * extent / duration,
            reason=reason,
        )
    except ValidationError as error:
        do = "Use a longer clip or a softer, denser material"
        raise format_validation_error(error, f"forces in {reason}", do=do) from None


def compile_force_field(
    field: ForceField,
    scaling: SkillScaling,
    rest: np.ndarray,
    volume: np.ndarray,
    *,
    frame_dt: float,
    frame_count: int,
    parameters: ForceFieldParameters | None = None,
) -> tuple[tuple, tuple[PrescribedMotion, ...]]:
    """Turns a force field into terms for `Model.forces` and constraints for `Model.constraints`.

    Args:
        field: The agents' force field.
        scaling: What M = 1 means.
        rest: Rest positions of the particles [m], shape (n, 3); its dtype is the terms'.
        volume: Rest volumes [m^3], shape (n,).
        frame_dt: Seconds per frame [s].
        frame_count: Frames of the clip; the last has index frame_count - 1.
        parameters: Numbers in place of the field's own, traced or not. Traced ones are not checked: a window must begin
            inside the clip and end after it begins. Every number of every skill and constraint has a derivative, with
            one exception: `enforce_particle_translation` begins and ends between two substeps; its window's is zero.

    Raises:
        UserError: A region selects nothing, a window lies outside the clip, an object id is unknown, or the parameters
            are not this field's.
    """
    if parameters is None:
        parameters = ForceFieldParameters.of(field, frame_count)
    check_entries(parameters, field)
    forces, constraints = [], []
    for index, (action, values) in enumerate(zip(field.actions, parameters.actions)):
        place = f"force_field.actions[{index}]"
        bound = _Bound(action, values, place, rest, volume, frame_dt, frame_count)
        forces.append(_skill(action, scaling, bound))
    for index, (constraint, values) in enumerate(zip(field.constraints, parameters.constraints)):
        place = f"force_field.constraints[{index}]"
        bound = _Bound(constraint, values, place, rest, volume, frame_dt, frame_count)
        if constraint.constraint_type is ConstraintType.PARTICLE_IMPULSE:
            forces.append(bound.apply_impulse(scaling.impulse))
        else:
            constraints.append(bound.hold(scaling.velocity))
    return tuple(forces), tuple(constraints)


def compute_free_path(
    field: ForceField, scaling: SkillScaling, *, frame_dt: float, frame_count: int
) -> np.ndarray:
    """Displacement of a free body that the field's pushes and blows act on whole, and nothing else does.

    Velocities are those at the ends of the frames, so that the path runs a little ahead of the exact one.

    Args:
        field: The force field; regions, constraints, stretches and turns are left out.
        scaling: What M = 1 means.
        frame_dt: Seconds per frame [s].
        frame_count: Frames of the clip.

    Returns:
        Displacements at the frames [m], shape (frame_count, 3).
    """
    gained = np.zeros((frame_count - 1, 3))  # change of velocity in each interval [m/s]
    begin = np.arange(frame_count - 1)
    for action in field.actions:
        values = ActionParameters.of(action, frame_count)
        first, last = values.window
        frames = np.maximum(0.0, np.minimum(begin + 1, last) - np.maximum(begin, first))
        match action.action_type:
            case ActionType.TRANSLATION:
                gained += _directed(scaling.translation, values) * frame_dt * frames[:, None]
            case ActionType.IMPULSE:
                gained += _directed(scaling.impulse, values) * (frames / (last - first))[:, None]
    steps = np.cumsum(gained, axis=0) * frame_dt
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


def _directed(k: float, values: ActionParameters) -> Array:
    """K M v, shape (3,)."""
    return k * values.magnitude * values.vector


def _skill(action: Action, scaling: SkillScaling, bound: _Bound):
    axis, (start, end), weight = bound.leaf(bound.values.vector), bound.window, bound.weight
    magnitude = bound.values.magnitude
    match action.action_type:
        case ActionType.TRANSLATION:
            return UniformAcceleration(bound.vector(scaling.translation), start, end, weight)
        case ActionType.IMPULSE:
            return bound.apply_impulse(scaling.impulse)
        case ActionType.TORQUE:
            return Torque(axis, bound.leaf(scaling.torque * magnitude), start, end, weight)
        case ActionType.SCALE:
            strength = bound.leaf(scaling.scale * magnitude / bound.stress_concentration())
            return Stretch(axis, strength, start, end, STRETCH_RAMP * (end - start), weight)


class _Bound:
    """An action or constraint, with its numbers, bound to particles and seconds."""

    def __init__(
        self,
        timed: Action | VelocityConstraint,
        values: ActionParameters,
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
        self.values = values = jax.tree.map(_known, values)
        if not _is_traced(values.window) and values.window[0] >= frame_count - 1:
            raise UserError(
                f"`{place}.active_time` begins after the clip's last frame {frame_count - 1}",
                got=values.window.tolist(),
                do="Give frames inside the clip",
            )
        self._dtype, self._rest, self._volume = rest.dtype, rest, volume
        self._mask = np.ones(len(rest), bool)
        if timed.region is not None:
            self._mask = make_region_mask(timed.region, rest, f"{place}.region")
        first, last = values.window
        self.window = self.leaf(first * frame_dt), self.leaf(last * frame_dt)
        self.weight = None if timed.region is None else self.leaf(self._mask)

    def leaf(self, value) -> jax.Array:
        """``value`` as an array of the particles' dtype."""
        return value.astype(self._dtype) if _is_traced(value) else to_device(value, self._dtype)

    def vector(self, k: float) -> jax.Array:
        """k M v, shape (3,)."""
        return self.leaf(_directed(k, self.values))

    def stress_concentration(self) -> Array | float:
        """How much more a `scale` strains the weakest section than it strains a uniform bar's middle; at least 1.

        A pull grows along the object and is carried by its cross-section: a thin neck with much behind it
        would tear where a bar only stretches. Compared are the pull beyond a section over the section's
        area, largest over sections across the axis, and L / 2 of the bar.
        """
        inside, axis = self._mask, self.values.vector
        extent = np.ptp(self._rest, axis=0).max()
        if extent == 0:  # all particles in one place
            return 1.0
        xp = jnp if _is_traced(axis) else np
        length = xp.linalg.norm(axis)
        # A direction of the schema has unit length but for round-off, which is left as it is: it may decide on which
        # side of the middle a particle lies.
        if _is_traced(axis) or abs(length - 1) > 1e-12:
            axis = axis / length
        volume = self._volume[inside].astype(xp.result_type(float))
        height = self._rest[inside] @ axis
        side = xp.sign(height - xp.average(height, weights=volume))
        pull = volume * (side - xp.average(side, weights=volume))

        def stress(section):
            # A tent of width 2 w instead of a sharp cut, so that layers of particles do not alias.
            distance = (height - section) / (SECTION_WIDTH * extent)
            area = (volume * xp.maximum(1 - xp.abs(distance), 0)).sum() / (SECTION_WIDTH * extent)
            return xp.abs((pull * xp.clip(0.5 + 0.5 * distance, 0, 1)).sum()) / xp.maximum(area, _TINY)

        sections = xp.linspace(height.min(), height.max(), SECTIONS)
        largest = max(map(stress, sections)) if xp is np else jax.lax.map(stress, sections).max()
        return xp.maximum(1.0, largest / (0.5 * extent))

    def apply_impulse(self, k: float) -> UniformAcceleration:
        """The velocity change k M v, spread evenly over the window."""
        start, end = self.window
        return UniformAcceleration(self.vector(k) / (end - start), start, end, self.weight)

    def hold(self, k: float) -> PrescribedMotion:
        """The particles move with k M v during the window."""
        with jax.ensure_compile_time_eval():  # places are known, also where numbers are traced
            particles = to_device(np.flatnonzero(self._mask), np.int32)
        zero = self.leaf(np.zeros(3))
        return PrescribedMotion(particles, self.vector(k), zero, zero, *self.window)


def _is_traced(value) -> bool:
    return isinstance(value, Tracer)


def _known(value) -> Array:
    """``value`` in double precision on the host, unless it is traced."""
    return value if _is_traced(value) else np.asarray(value, np.float64)
