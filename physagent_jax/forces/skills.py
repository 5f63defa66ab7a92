"""The Force Field Skill Library: from dimensionless JSON to terms with units (paper, appendix A.2).

With L the object's longest extent, E and rho its mean stiffness and density and T the clip's duration, a
magnitude of M = 1 gives what `forces.calibration` says:

| skill       | field at x                            | k              | unopposed, with                       |
|-------------|---------------------------------------|----------------|---------------------------------------|
| translation | a = k M v                             | 2 s L / T^2    | s = `TRAVEL` by the clip's end        |
| scale       | a = k M sgn(d) v, d = (x - x_c) . v   | 4 E e/(rho L)  | e = `STRAIN`, linear mean strain      |
| impulse     | velocity change k M v over its window | s L / T        | s = `TRAVEL` by the clip's end        |
| torque      | a = k M (v x r), r = x - x_c          | 2 theta / T^2  | theta = `TURN` by the clip's end      |

A translation of a free object that is one of several to and fro has a k of its own (`forces.swinging`), with which
M = 1 goes by `SWING` L to either side.

The other kind of skill prescribes velocities:

| constraint                     | what it does                                   | k                                  |
|--------------------------------|------------------------------------------------|------------------------------------|
| enforce_particle_translation   | v = k M v for the particles, in the window     | s L / T, s = `PRESCRIBED_TRAVEL`   |
| ... of a region; moving_plate  | the same for a part; a plate moves into it     | s W / T, W: extent along v         |
| enforce_particle_rotation      | turns them with k M v about their own centre   | theta / T, theta = `TURN`          |
| particle_impulse               | changes v by k M v in one substep, at its start| s L / T, s = `TRAVEL`              |

What two opposed ends or plates do is a share of the object's extent W between them, however thin it is there: with M
during a time t they change it by 2 s M t / T.

They are forces per unit mass: filling density and particle count do not change the motion (the paper's
impulse divides by particle mass). x_c is the present mass centre. For `scale`, k is divided by the shape's
stress concentration along the axis where that exceeds 1, so that M = 1 strains no section more than the middle of
a uniform bar of length L.

The numbers of a force field may be given apart from it and traced (`forces.parameters`): the terms are then functions
of them that JAX differentiates. What is known is computed on the host in double precision, traced or not the same law.
"""

from __future__ import annotations

import dataclasses
import math

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from pydantic import ValidationError

from physagent_jax.core.arrays import to_device
from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import format_validation_error
from physagent_jax.forces.calibration import PRESCRIBED_TRAVEL, STRAIN, STRETCH_RAMP, SWING, TRAVEL, TURN
from physagent_jax.forces.holding import find_blow_scale, find_push_scale
from physagent_jax.forces.opposition import (
    describe_opposition,
    find_friction,
    find_rubbing,
    oppose_blow,
    oppose_push,
    oppose_swing,
    oppose_turn,
)
from physagent_jax.forces.parameters import ActionParameters, Array, ForceFieldParameters, check_entries
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.forces.schema import (
    Action,
    ActionType,
    ConstraintType,
    ForceField,
    Holding,
    Opposition,
    SkillScaling,
    VelocityConstraint,
)
from physagent_jax.forces.swinging import Stroke, describe_swing, find_strokes
from physagent_jax.forces.terms import (
    PushCompensation,
    Stretch,
    Torque,
    TurnCompensation,
    UniformAcceleration,
    VelocityChange,
)
from physagent_jax.mpm.boundaries import HalfSpace
from physagent_jax.mpm.constraints import MovingPlate, PrescribedMotion

PLATE_FRICTION = (
    0.4  # Coulomb's coefficient of a `moving_plate`: the material may spread under it, but not slip away
)
AFTER = (
    1e-3  # [frames] by which a `particle_impulse` comes after what ends then, whatever the clock's round-off
)
SECTIONS, SECTION_WIDTH = 32, 0.1  # cross-sections looked at, and half their thickness in body lengths
_TINY = float(np.finfo(np.float32).tiny)


def make_closed_form_scaling(
    *,
    extent: float,
    youngs_modulus: float,
    density: float,
    duration: float,
    damping_rate: float = 0.0,
    opposition: Opposition | None = None,
    holding: Holding | None = None,
) -> SkillScaling:
    """The k of the table above for a free object; with damping, those that move it as far.

    Args:
        extent: Longest extent L [m].
        youngs_modulus: Mean E [Pa].
        density: Mean rho [kg/m^3].
        duration: T [s].
        damping_rate: Rate d at which velocities decay [1/s]: a push k then moves by k (d T - 1 + e^(-d T)) / d^2
            instead of k T^2 / 2, a blow k by k (1 - e^(-d T)) / d instead of k T.
        opposition: What else works against the motion.
        holding: How far the object gives way where it is held.

    Raises:
        UserError: These values give accelerations beyond what float32 can compute with.
    """
    reason = (
        f"closed form for L = {extent:.3g} m, E = {youngs_modulus:.3g} Pa, "
        f"rho = {density:.3g} kg/m^3, T = {duration:.3g} s"
    )
    blow_path, push_path = duration, 0.5 * duration**2  # way of a blow and of a push with k = 1
    if (decay := damping_rate * duration) > 1e-6:
        blow_path = -math.expm1(-decay) / damping_rate
        push_path = (decay + math.expm1(-decay)) / damping_rate**2
        reason += f", damping {damping_rate:.3g} /s"
    if opposition is not None:
        reason += f"; {describe_opposition(opposition)}"
    swing = None if holding is not None else SWING * extent
    if swing is not None:
        reason += f"; {describe_swing(swing)}"
    if holding is not None:
        reason += (
            f"; held: a push or blow of 1 is to move its centre by {holding.shift:.3g} m, with {holding.least:.3g} to "
            f"{holding.most:.3g} m/s^2"
        )
    try:
        return SkillScaling(
            translation=TRAVEL * extent / push_path,
            scale=4 * youngs_modulus * STRAIN / (density * extent),
            impulse=TRAVEL * extent / blow_path,
            torque=TURN / push_path,
            velocity=PRESCRIBED_TRAVEL * extent / duration,
            rotation=TURN / duration,
            swing=swing,
            damping_rate=damping_rate,
            opposition=opposition,
            holding=holding,
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
) -> tuple[tuple, tuple[PrescribedMotion | MovingPlate, ...]]:
    """Turn a force field into terms for `Model.forces` and constraints for `Model.constraints`.

    Args:
        field: The agents' force field.
        scaling: What M = 1 means.
        rest: Rest positions of the particles [m], shape (n, 3); its dtype is the terms'.
        volume: Rest volumes [m^3], shape (n,).
        frame_dt: Seconds per frame [s].
        frame_count: Frames of the clip; the last has index frame_count - 1.
        parameters: Numbers in place of the field's own, traced or not. Traced ones are not checked: a window must begin
            inside the clip and end after it begins. Every number of every skill and constraint has a derivative, with
            one exception: velocity constraints begin and end between two substeps; their windows' is zero (but for the
            way that what is held afterwards has gone).

    Raises:
        UserError: A region selects nothing, a window lies outside the clip, an object id is unknown, or the parameters
            are not this field's.
    """
    if parameters is None:
        parameters = ForceFieldParameters.of(field, frame_count)
    check_entries(parameters, field)
    forces, constraints = [], []
    strokes = find_strokes(field, parameters.actions, scaling, frame_dt)
    for index, (action, values) in enumerate(zip(field.actions, parameters.actions)):
        place = f"force_field.actions[{index}]"
        bound = _Bound(action, values, place, rest, volume, frame_dt, frame_count)
        stroke, turns = strokes.get(index), _is_turned_meanwhile(action, field)
        forces += [
            _get_skill(action, scaling, bound, stroke),
            *_overcome_friction(action, scaling, bound, stroke, not turns),
        ]
    for index, (constraint, values) in enumerate(zip(field.constraints, parameters.constraints)):
        place = f"force_field.constraints[{index}]"
        bound = _Bound(constraint, values, place, rest, volume, frame_dt, frame_count)
        match constraint.constraint_type:
            case ConstraintType.PARTICLE_IMPULSE:
                opposition = scaling.opposition if constraint.region is None else None
                k = find_blow_scale(scaling.holding, scaling.impulse, bound.values.vector)
                blow = oppose_blow(opposition, k, *bound.directed)
                forces.append(bound.change_velocity(blow))
            case ConstraintType.PARTICLE_TRANSLATION:
                k = scaling.velocity * (1.0 if constraint.region is None else bound.width())
                constraints += bound.hold(bound.vector(k), bound.leaf(np.zeros(3)))
            case ConstraintType.PARTICLE_ROTATION:
                constraints += bound.hold(bound.leaf(np.zeros(3)), bound.vector(scaling.rotation))
            case ConstraintType.MOVING_PLATE:
                constraints += bound.press(scaling.velocity * bound.width())
    return tuple(forces), tuple(constraints)


def compute_free_path(
    field: ForceField, scaling: SkillScaling, *, frame_dt: float, frame_count: int
) -> np.ndarray:
    """Displacement of a free body that the field's pushes and blows of either kind act on, and nothing else does.

    Velocities are those at the ends of the frames, so that the path runs a little ahead of the exact one.

    Args:
        field: The force field; regions are left out of account, and so are stretches, turns, and what moves an end.
        scaling: What M = 1 means.
        frame_dt: Seconds per frame [s].
        frame_count: Frames of the clip.

    Returns:
        Displacements at the frames [m], shape (frame_count, 3).
    """
    gained = np.zeros((frame_count - 1, 3))  # change of velocity in each interval [m/s]
    begin = np.arange(frame_count - 1)
    numbers = [ActionParameters.of(action, frame_count) for action in field.actions]
    strokes = find_strokes(field, numbers, scaling, frame_dt)
    for index, (action, values) in enumerate(zip(field.actions, numbers)):
        first, last = values.window
        frames = np.maximum(0.0, np.minimum(begin + 1, last) - np.maximum(begin, first))
        match action.action_type:
            case ActionType.TRANSLATION:
                k = strokes[index].k if index in strokes else scaling.translation
                gained += _direct(k, values) * frame_dt * frames[:, None]
            case ActionType.IMPULSE:
                gained += _direct(scaling.impulse, values) * (frames / (last - first))[:, None]
    for constraint in field.constraints:
        values = ActionParameters.of(constraint, frame_count)
        first, last = values.window
        match constraint.constraint_type:
            case ConstraintType.PARTICLE_IMPULSE:
                at = np.floor(first) == begin
                gained += _direct(scaling.impulse, values) * at[:, None]
            case ConstraintType.PARTICLE_TRANSLATION if constraint.region is None:
                speed = np.cumsum(gained, axis=0)
                inside = (begin + 1 > first) & (begin < last)
                speed[inside] = _direct(scaling.velocity, values)
                gained = np.diff(speed, axis=0, prepend=0)
    steps = np.cumsum(gained, axis=0) * frame_dt
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


def _direct(k: float | Array, values: ActionParameters) -> Array:
    """K M v, shape (3,)."""
    return k * values.magnitude * values.vector


def _get_skill(action: Action, scaling: SkillScaling, bound: _Bound, stroke: Stroke | None):
    axis, (start, end), weight = bound.leaf(bound.values.vector), bound.window, bound.weight
    magnitude = bound.values.magnitude
    opposition = scaling.opposition if action.region is None else None
    match action.action_type:
        case ActionType.TRANSLATION if stroke is not None and stroke.swings:
            push = oppose_swing(opposition, stroke.k, *bound.directed)
            return UniformAcceleration(bound.along(push), start, end, weight)
        case ActionType.TRANSLATION:
            k = find_push_scale(scaling.holding, scaling.translation, bound.values.vector)
            push = oppose_push(opposition, k, *bound.directed)
            return UniformAcceleration(bound.along(push), start, end, weight)
        case ActionType.IMPULSE:
            k = find_blow_scale(scaling.holding, scaling.impulse, bound.values.vector)
            return bound.apply_impulse(oppose_blow(opposition, k, *bound.directed))
        case ActionType.TORQUE:
            turn = oppose_turn(opposition, scaling.torque, *bound.directed)
            return Torque(axis, bound.leaf(turn), start, end, weight)
        case ActionType.SCALE:
            strength = bound.leaf(scaling.scale * magnitude / bound.stress_concentration())
            return Stretch(axis, strength, start, end, STRETCH_RAMP * (end - start), weight)


def _is_turned_meanwhile(action: Action, field: ForceField) -> bool:
    """Return whether a torque acts at the same time."""
    first, last = action.active_time or (0.0, np.inf)
    spans = [a.active_time or (0.0, np.inf) for a in field.actions if a.action_type is ActionType.TORQUE]
    return any(begin < last and end > first for begin, end in spans)


def _overcome_friction(
    action: Action, scaling: SkillScaling, bound: _Bound, stroke: Stroke | None, held_upright: bool
) -> list[PushCompensation | TurnCompensation]:
    """The acceleration that overcomes ground friction for a push or a turn of the whole object."""
    opposition, vector, magnitude = scaling.opposition, bound.values.vector, bound.values.magnitude
    if opposition is None or action.region is not None:
        return []
    xp = jnp if _is_traced(magnitude) else np
    size, way = xp.abs(magnitude), xp.sign(magnitude) * vector
    drag, before = bound.leaf(opposition.damping_rate), bound.leaf(np.zeros(()))
    k = scaling.translation
    if stroke is not None:
        k, before = stroke.k, bound.leaf(stroke.speed)
    match action.action_type:
        case ActionType.TRANSLATION if opposition.friction:
            friction = bound.leaf(find_friction(opposition, way))
            push, lever = bound.leaf(k * size), bound.leaf(opposition.lever if held_upright else 0.0)
            return [PushCompensation(bound.leaf(way), friction, push, before, lever, drag, *bound.window)]
        case ActionType.TORQUE if opposition.turning:
            friction, turn = bound.leaf(find_rubbing(opposition, way)), bound.leaf(scaling.torque * size)
            return [TurnCompensation(bound.leaf(way), friction, turn, drag, *bound.window)]
    return []


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
        self.values = values = _normalise(jax.tree.map(_check_known, values))
        if not _is_traced(values.window) and values.window[0] >= frame_count - 1:
            raise UserError(
                f"`{place}.active_time` begins after the clip's last frame {frame_count - 1}",
                got=values.window.tolist(),
                do="Give frames inside the clip",
            )
        self._frame_dt, self._dtype, self._rest, self._volume = frame_dt, rest.dtype, rest, volume
        self._mask = np.ones(len(rest), bool)
        if timed.region is not None:
            self._mask = make_region_mask(timed.region, rest, f"{place}.region")
        first, last = values.window
        self.window = self.leaf(first * frame_dt), self.leaf(last * frame_dt)
        hold_end = getattr(timed, "held_until", None)
        self._held_until = None if hold_end is None else self.leaf(hold_end * frame_dt)
        self.weight = None if timed.region is None else self.leaf(self._mask)

    def leaf(self, value) -> jax.Array:
        """``value`` as an array of the particles' dtype."""
        return value.astype(self._dtype) if _is_traced(value) else to_device(value, self._dtype)

    @property
    def directed(self) -> tuple[Array, Array]:
        """Magnitude and vector."""
        return self.values.magnitude, self.values.vector

    def along(self, size: float | Array) -> jax.Array:
        """``size`` times the vector, shape (3,)."""
        return self.leaf(size * self.values.vector)

    def vector(self, k: float | Array) -> jax.Array:
        """k M v, shape (3,)."""
        return self.leaf(_direct(k, self.values))

    def stress_concentration(self) -> Array | float:
        """The strain of a `scale` in the weakest section over that in a uniform bar's middle; at least 1.

        A pull grows along the object and is carried by its cross-section: a thin neck with much behind it
        would tear where a bar only stretches. Compared are the pull beyond a section over the section's
        area, largest over sections across the axis, and L / 2 of the bar.
        """
        inside, axis = self._mask, self.values.vector
        extent = np.ptp(self._rest, axis=0).max()
        if extent == 0:  # all particles in one place
            return 1.0
        xp = jnp if _is_traced(axis) else np
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

    def apply_impulse(self, speed: float | Array) -> UniformAcceleration:
        """The velocity change ``speed`` [m/s] along the vector, spread evenly over the window."""
        start, end = self.window
        return UniformAcceleration(self.along(speed) / (end - start), start, end, self.weight)

    def change_velocity(self, speed: float | Array) -> VelocityChange:
        """The velocity change ``speed`` [m/s] along the vector at the window's start."""
        start = self.leaf((self.values.window[0] + AFTER) * self._frame_dt)
        return VelocityChange(self.along(speed), start, start, self.weight)

    def width(self) -> Array:
        """The object's extent along the vector, over its longest [1]."""
        axis = self.values.vector
        xp = jnp if _is_traced(axis) else np
        extent = np.ptp(self._rest, axis=0).max()
        if extent == 0:  # all particles in one place
            return np.asarray(1.0)
        return xp.ptp(self._rest.astype(xp.result_type(float)) @ (axis / xp.linalg.norm(axis))) / extent

    def hold(self, velocity: jax.Array, angular_velocity: jax.Array) -> list[PrescribedMotion]:
        """The particles move so during the window, about their own centre, and then stay if they are to be held."""
        with jax.ensure_compile_time_eval():  # places are known, also where numbers are traced
            particles = to_device(np.flatnonzero(self._mask), np.int32)
        still = self.leaf(np.zeros(3))
        motions = [PrescribedMotion(particles, velocity, angular_velocity, None, *self.window)]
        if self._held_until is not None:
            motions.append(PrescribedMotion(particles, still, still, still, self.window[1], self._held_until))
        return motions

    def press(self, k: float | Array) -> list[MovingPlate]:
        """A plate that starts at the object's side, moves with k M v, and then stays if it is to be held."""
        velocity, (start, end) = self.vector(k), self.window
        normal = velocity / jnp.linalg.norm(velocity)
        behind = (self.leaf(self._rest) @ normal).min()
        middle = self.leaf(self._rest.mean(0))
        point = middle + (behind - middle @ normal) * normal
        friction = self.leaf(PLATE_FRICTION)
        plates = [MovingPlate(HalfSpace(point, normal, friction, start, end, velocity=velocity))]
        if self._held_until is not None:
            stop = point + velocity * (end - start)
            plates.append(MovingPlate(HalfSpace(stop, normal, friction, end, self._held_until)))
        return plates


def _normalise(values: ActionParameters) -> ActionParameters:
    """The vector's length as a part of the magnitude: what is made up for goes by directions.

    A direction of the schema has unit length but for round-off, which is left as it is: it may decide on which side of
    the middle a particle lies.
    """
    squared = values.vector @ values.vector
    if not _is_traced(squared) and abs(squared - 1) < 1e-12:
        return values
    xp = jnp if _is_traced(squared) else np
    size = xp.sqrt(xp.maximum(squared, 1e-30))
    return dataclasses.replace(values, vector=values.vector / size, magnitude=size * values.magnitude)


def _is_traced(value) -> bool:
    return isinstance(value, Tracer)


def _check_known(value) -> Array:
    """``value`` in double precision on the host, unless it is traced."""
    return value if _is_traced(value) else np.asarray(value, np.float64)
