"""Force field JSON: what agents write and people read. Pure data, no arrays.

The four actions and ``default_drop`` are the paper's (PhysAgent, appendix A.1). ``region``,
``object`` and ``constraints`` extend it: where an action acts, and the second kind of skill, velocity
constraints, of which the paper's executor emits two (appendix B.2, "Skill-Specific Constraints").
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import (
    Field,
    SerializerFunctionWrapHandler,
    field_validator,
    model_serializer,
    model_validator,
)

from physagent_jax.core.strict import Direction, Positive, Strict
from physagent_jax.forces.calibration import GAIN_MAX, GAIN_MIN, MAGNITUDE_MAX, MAGNITUDE_MIN, TURN
from physagent_jax.forces.names import ActionType as ActionType
from physagent_jax.forces.names import ConstraintType as ConstraintType

_Fraction = Annotated[float, Field(ge=-1e6, le=1e6)]
_Place = tuple[_Fraction, _Fraction, _Fraction]  # in bounding-box fractions
_Frame = Annotated[float, Field(ge=0, le=1e5)]
NotNegative = Annotated[float, Field(ge=0, le=1e9)]


# --- regions: fractions of the object's rest bounding box, (0,0,0) = low corner, (1,1,1) = high ------


class BoxRegion(Strict):
    """Particles whose rest position lies in an axis-aligned box, in bounding-box fractions."""

    kind: Literal["box"] = "box"
    low: _Place
    high: _Place

    @model_validator(mode="after")
    def _check_order(self) -> BoxRegion:
        if any(h <= l for l, h in zip(self.low, self.high)):
            raise ValueError(f"`high` must exceed `low` on every axis (got low={self.low}, high={self.high})")
        return self


class HalfSpaceRegion(Strict):
    """Particles on the side of a plane that ``normal`` points to, in bounding-box fractions."""

    kind: Literal["half_space"] = "half_space"
    point: _Place
    normal: Direction


class SphereRegion(Strict):
    """Particles within ``radius`` (fraction of the longest extent) of ``center`` (bounding-box fractions)."""

    kind: Literal["sphere"] = "sphere"
    center: _Place
    radius: float = Field(ge=1e-6, le=1e6)


_Seeds = Annotated[tuple[_Place, ...], Field(min_length=1, max_length=256)]


class CellsRegion(Strict):
    """Particles whose nearest seed is one of ``inside`` (bounding-box fractions; distances in metres).

    A part of any shape: the Voronoi cells of its own seeds among those of the whole object. ``label`` tells people
    which part it is, and what told of it; ``rigid`` is a piece of its own, in which nothing bends where it is driven.
    """

    kind: Literal["cells"] = "cells"
    inside: _Seeds
    outside: _Seeds
    label: Annotated[str, Field(max_length=200)] = ""
    rigid: bool = False


class Bend(Strict):
    """The place beside a joint where a driven part bends, so that its skin does not crease.

    Attributes:
        joint: Where the part joins the rest (bounding-box fractions).
        rest: Particles that stay; all others belong to the part.
        reach: Distance from the joint within which the rest borders on the part [body lengths].
        depth: Way into the part over which its motion grows from none to all of it [body lengths].
    """

    joint: _Place
    rest: CellsRegion
    reach: float = Field(gt=0, le=2)
    depth: float = Field(gt=0, le=2)


Region = Annotated[BoxRegion | HalfSpaceRegion | SphereRegion | CellsRegion, Field(discriminator="kind")]


class _Timed(Strict):
    vector: Direction
    magnitude: float = 1.0
    gain: float = Field(default=1.0, ge=GAIN_MIN, le=GAIN_MAX)
    active_time: tuple[_Frame, _Frame] | None = None
    region: Region | None = None
    object: Annotated[str, Field(max_length=200)] | None = None
    touched: bool = False

    @field_validator("magnitude")
    @classmethod
    def _check_range(cls, value: float) -> float:
        if not MAGNITUDE_MIN - 1e-9 <= abs(value) <= MAGNITUDE_MAX + 1e-9:
            raise ValueError(
                f"|magnitude| must lie in [{MAGNITUDE_MIN}, {MAGNITUDE_MAX}] (got {value}); "
                "the sign reverses the action"
            )
        return value

    @model_serializer(mode="wrap")
    def _leave_out_usual(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave a gain of 1 unsaid, and that no hand does it: files and prompts hold only what is not usual."""
        data = write(self)
        for name, usual in (("gain", 1.0), ("touched", False)):
            if data.get(name) == usual:
                del data[name]
        return data

    @field_validator("active_time")
    @classmethod
    def _check_window(cls, value: tuple[float, float] | None) -> tuple[float, float] | None:
        if value is not None and not 0 <= value[0] < value[1]:
            raise ValueError(
                f"`active_time` is [first, last] in frames with 0 <= first < last (got {list(value)})"
            )
        if value is not None and is_too_short(*value):
            raise ValueError(f"`active_time` is too short to be simulated (got {list(value)})")
        return value


class Action(_Timed):
    """One skill, acting along ``vector`` during ``active_time``.

    Attributes:
        action_type: Which skill.
        vector: World direction, stretch axis or rotation axis (right-hand rule), as the skill says; normalised on
            input, zero refused.
        magnitude: Dimensionless M with 0.4 <= abs(M) <= 1.6; the sign reverses (push/stretch > 0,
            pull/squeeze < 0). What M = 1 means: `forces.calibration`; in SI units: `forces.scaling`.
        gain: Factor on k for this entry, calibrated again by the executor where M alone cannot bring about the motion.
        active_time: ``[first, last]`` in frames; None = the whole clip.
        region: Which particles; None = the whole object.
        object: Object id in a scene of several; None = all.
        touched: Whether people are shown the hand that does it.
    """

    action_type: ActionType


class VelocityConstraint(_Timed):
    """A prescribed velocity; `motion.kinds` says when it takes a body force's place.

    Attributes:
        constraint_type: Which skill of those that prescribe velocities.
        held_until: Frame until which particles or plate then stay where they were brought; None = they are let go when
            the window ends. A sudden skill has none.
        pivot: Point that particles turn about, for a rotation (bounding-box fractions): a joint; None = their own
            centre.
        bend: Where the part bends beside its joint, whose own particles then move too; None = nowhere: those of
            ``region`` move as a whole.
        carried: Whether it comes on top of the mean motion of the rest, which something else moves meanwhile.
        vector, magnitude, gain, active_time, region, object, touched: as for `Action`.
    """

    constraint_type: ConstraintType
    held_until: _Frame | None = None
    pivot: _Place | None = None
    bend: Bend | None = None
    carried: bool = False

    @model_validator(mode="after")
    def _check_held(self) -> VelocityConstraint:
        if self.carried and (self.region is None or self.constraint_type is ConstraintType.MOVING_PLATE):
            raise ValueError("`carried` is for the particles of a `region`: the rest carries them")
        if self.held_until is None:
            return self
        if self.constraint_type.skill.is_sudden:
            raise ValueError(f"a `{self.constraint_type}` acts at once: it has no `held_until`")
        if self.active_time is None or self.held_until <= self.active_time[1]:
            raise ValueError("`held_until` must lie after the end of `active_time`")
        return self


class ForceField(Strict):
    """The optimisation variable of the loop: everything extrinsic that moves the object.

    Attributes:
        default_drop: Whether gravity acts (the object falls). False: the object floats, at rest.
        actions: Skills, overlaid or in sequence.
        constraints: Velocity constraints.
    """

    default_drop: bool = False
    actions: Annotated[tuple[Action, ...], Field(max_length=256)] = ()
    constraints: Annotated[tuple[VelocityConstraint, ...], Field(max_length=256)] = ()


class Opposition(Strict):
    """Friction and weight that oppose a motion of the whole object, and are compensated (`forces.opposition`).

    Attributes:
        friction: Deceleration of what slides over the ground [m/s^2].
        weight: Deceleration of what rises [m/s^2].
        turning: Angular deceleration by friction of what spins about the vertical [rad/s^2].
        tipping: Angular acceleration at which the weight holds it upright [rad/s^2].
        lever: Height of the mass centre over the feet [m], where friction acts; 0 for what rolls.
        damping_rate: Damping rate of velocities [1/s].
        travel: Way that a blow with M = 1 goes [m].
        time: In which it does where nothing stops it before [s].
    """

    friction: NotNegative = 0.0
    weight: NotNegative = 0.0
    turning: NotNegative = 0.0
    tipping: NotNegative = 0.0
    lever: NotNegative = 0.0
    damping_rate: NotNegative = 0.0
    travel: Positive
    time: Positive


# [s^2]; rho L^2 / E of the softest matter that can be given is near its bound.
_Compliance = Annotated[float, Field(ge=-1e15, le=1e15)]
_ComplianceRow = tuple[_Compliance, _Compliance, _Compliance]
_Square = Annotated[float, Field(ge=-1e30, le=1e30)]
_SquareRow = tuple[_Square, _Square, _Square]


class Holding(Strict):
    """The compliance of an object that is held somewhere (`scene.compliance`); it scales pushes and blows.

    Attributes:
        compliance: Mean displacement per uniform acceleration [s^2], rows answer the world's axes.
        square: Mean product of these displacements [s^4]: how fast it swings; None = not known.
        damping_ratio: Share of critical damping with which it swings, where somebody chose one; None = that of
            `forces.holding.OVERSHOOT`, whatever its kind's is.
        shift: How far M = 1 is to move its centre [m].
        least, most: Limits of what a push's k may be [m/s^2].
    """

    compliance: tuple[_ComplianceRow, _ComplianceRow, _ComplianceRow]
    square: tuple[_SquareRow, _SquareRow, _SquareRow] | None = None
    damping_ratio: Annotated[float, Field(ge=0, lt=1)] | None = None
    shift: Positive
    least: Positive
    most: Positive


class Response(Strict):
    """The k of a skill on a part, or on what is held, as a coarse probe measured it (`scene.response`).

    Attributes:
        quantity: Field of `SkillScaling` whose place it takes.
        region: Region of the entries that it holds for; None = the whole.
        vector: Their direction or axis.
        k: The skill's k.
        share: Share of its acceleration that the whole gains, where it is too stiff to bend and the whole is led;
            None = it bends.
        answer: Way per steady acceleration of what is held [s^2], for pushes to and fro; None = not known.
        frequency: Angular frequency with which it swings by itself [1/s].
        swing: Way to either side that pushes to and fro are to take it [m].
        note: What M = 1 cannot show, for people; empty where it shows.
    """

    quantity: Literal["translation", "scale", "impulse", "torque"]
    region: Region | None = None
    vector: Direction
    k: Positive
    share: Positive | None = None
    answer: Positive | None = None
    frequency: Positive = 1.0
    swing: Positive = 1.0
    note: str = ""

    @property
    def key(self) -> str:
        """Everything that entries are told by."""
        return self.model_dump_json(exclude={"k", "share", "answer", "frequency", "swing", "note"})


class SkillScaling(Strict):
    """The meaning of a magnitude of 1 in SI units; recorded in a scene, so that it replays exactly.

    Attributes:
        translation: Acceleration [m/s^2].
        scale: Acceleration [m/s^2].
        impulse: Velocity change [m/s].
        torque: Angular acceleration [rad/s^2].
        velocity: Velocity of ``enforce_particle_translation`` and ``moving_plate`` [m/s].
        rotation: Rate of ``enforce_particle_rotation`` [rad/s]; by default a quarter turn in two seconds.
        swing: How far to either side pushes to and fro swing it (`forces.swinging`) [m]; None = each of them is a push
            like any other.
        damping_rate: Damping rate of velocities, where it is made up for [1/s].
        opposition: What works against the motion, which pushes, blows and turns of the whole object make up for;
            None = nothing.
        holding: How far it gives way where it is held, which pushes and blows of either kind go by; None = not known.
        responses: The same for entries on parts, and for turns and stretches of what is held (`scale_entry`).
        measured: Whether these numbers are those of one entry, as a probe measured them.
        share: As `Response.share`, of that entry.
        reason: How they were found.
    """

    translation: Positive
    scale: Positive
    impulse: Positive
    torque: Positive
    velocity: Positive
    rotation: Positive = TURN / 2
    swing: Positive | None = None
    damping_rate: NotNegative = 0.0
    opposition: Opposition | None = None
    holding: Holding | None = None
    responses: Annotated[tuple[Response, ...], Field(max_length=256)] = ()
    measured: bool = False
    share: Positive | None = None
    reason: str = ""


def is_too_short(first: float, last: float) -> bool:
    """Return whether a window of frames is one that single precision hardly tells from none."""
    return last - first < max(1e-3, 1e-6 * last)


def is_carried(entry: Action | VelocityConstraint) -> bool:
    """Return whether an entry comes on top of what the rest of the object does."""
    return isinstance(entry, VelocityConstraint) and entry.carried


def is_stop(entry: Action | VelocityConstraint) -> bool:
    """Return whether an entry only takes up the rebound of what comes down along it (`motion.landing`).

    It asks all of the object for the least gain that there is, and is then held. Its M is of the speed that is left.
    """
    if not isinstance(entry, VelocityConstraint) or entry.region is not None or entry.held_until is None:
        return False
    return entry.constraint_type is ConstraintType.PARTICLE_TRANSLATION and entry.gain == GAIN_MIN
