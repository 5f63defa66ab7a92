"""Entries of a force field bound to particles and seconds: what skills make their terms of.

The numbers of an entry may be traced (`forces.parameters`): what is made of them is then a function that JAX
differentiates. What is known is computed on the host in double precision, traced or not the same law.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from scipy.spatial.transform import Rotation

from physagent_jax.core.arrays import to_device
from physagent_jax.core.errors import UserError
from physagent_jax.forces.calibration import GAIN_MIN, MAGNITUDE_MIN, RETREAT
from physagent_jax.forces.opposition import RISES, find_balance, find_resistance, find_righting
from physagent_jax.forces.parameters import ActionParameters, Array
from physagent_jax.forces.regions import grade_part, make_region_mask
from physagent_jax.forces.schema import (
    Action,
    Bend,
    CellsRegion,
    ConstraintType,
    Opposition,
    SkillScaling,
    VelocityConstraint,
    is_carried,
    is_stop,
)
from physagent_jax.forces.sections import find_stress_concentration
from physagent_jax.forces.terms import (
    AxleBalance,
    Balance,
    Landing,
    PushCompensation,
    Settling,
    Touchdown,
    TurnCompensation,
)
from physagent_jax.forces.twisting import Twist, find_twist
from physagent_jax.mpm.boundaries import HalfSpace
from physagent_jax.mpm.constraints import (
    GradedRotation,
    GradedTranslation,
    MovingPlate,
    PrescribedMotion,
    Shatter,
)
from physagent_jax.mpm.fields import FOREVER

PLATE_FRICTION = (
    0.4  # Coulomb's coefficient of a `moving_plate`: the material may spread under it, but not slip away
)
PLATE_DEPTH = 0.1  # [body lengths] that a plate on a part is thick: deeper than it is sunk in a step, by far
PLATE_SIZE = 1.15  # sides of such a plate over those of the part
_THINNEST = 0.02  # half of such a plate's side [body lengths], at least
AFTER = (
    1e-3  # [frames] by which a `particle_impulse` comes after what ends then, whatever the clock's round-off
)
_FEET = 0.05  # of the height, over which the feet fade out
_UPRIGHT = 0.7  # cosine to the vertical
STEADY = 0.7  # of the deceleration that tips it, with which what slides is led to rest
BRAKING = 0.7  # [s] in which it comes to rest at the latest: a hand steadies it then
RUBS = 0.9  # of friction's deceleration, at most: it is help against friction, and no brake
BALANCING = 3.0  # times what its weight turns it by when it lies, up to which it is kept upright
_TALL = 1.2  # height over breadth from which on what leaps has an upper end
ROCKS = math.radians(2)  # by which what slides may rock
TILTED = math.radians(20)  # at which what is led over its foot stands on its edge, or by less
_ROLLING = math.radians(70)  # turn from which on it goes over one edge after another
_LAID = math.radians(100)  # the same up to which it then lies on a side
_PARTS = 36  # of a turn, in which its middle goes as it rests on the ground
_SLIGHT = math.radians(5)  # of which it is seen where that is
FALLING = math.radians(40)  # from which on what is led over it and let go falls over
RISES_BY = 0.35  # [m/s] at which what has come down gets up again, for the least M
_CARRIERS = 1024  # particles at most, whose mean motion a limb is carried by
_EDGE = 0.02  # [L] around that point, in which particles tell where the edge is
HELD_END = 0.25  # of the length, whose middle is where what is held turns about when it is wrung
PAST = math.radians(5)  # beyond the balance up to which what tips over is driven
_THIN, _ROUND = 0.5, 0.8  # thickness over breadth of a disc, below; shorter over longer breadth, above
_LEVEL = 0.7  # vertical component of an axis below which a turn tips
_TINY = float(np.finfo(np.float32).tiny)


@dataclasses.dataclass(frozen=True)
class Stroke:
    """One of several pushes along a line that follow each other (`forces.swinging`).

    Attributes:
        k: Acceleration for M = 1 [m/s^2].
        speed: That the pushes before have left the object with, along this one's own way [m/s].
        swings: Whether it is one of a train to and fro.
    """

    k: Array | float
    speed: Array | float
    swings: bool


@dataclasses.dataclass(frozen=True)
class Tilt:
    """The turn about a level axis by which a constraint leads what stands.

    Attributes:
        axis: Unit vector (right-hand rule), shape (3,).
        first, last: Its turn from upright before and after [rad].
    """

    axis: np.ndarray
    first: float
    last: float

    def turn(self, x: np.ndarray, share: float) -> np.ndarray:
        """Places ``x`` relative to its line, shape (n, 3) [m], after a share of the turn."""
        return Rotation.from_rotvec((self.first + share * (self.last - self.first)) * self.axis).apply(x)


@dataclasses.dataclass(frozen=True)
class Circumstances:
    """Circumstances of an entry, besides its own numbers.

    Attributes:
        scaling: What M = 1 means.
        frame_dt: Seconds per frame [s].
        frame_count: Frames of the clip.
        stroke: Its part in a series of pushes; None = it is a push of its own.
        turned: Whether something turns the object at the same time.
        until: Frame at which the next entry begins.
        tilt: Turn by which it leads what stands; None = it is none.
        moved: Whether it has gone elsewhere before that.
        again: Whether the whole object fell, or a blow threw it up, before it.
        lies: Whether the whole object was turned over before it, and not back.
        turns: Turns of what carries it (`PrescribedMotion.turns`); None = nothing that turns does.
    """

    scaling: SkillScaling
    frame_dt: float
    frame_count: int
    stroke: Stroke | None = None
    turned: bool = False
    until: float = math.inf
    tilt: Tilt | None = None
    moved: bool = False
    again: bool = False
    lies: bool = False
    turns: np.ndarray | None = None


@dataclasses.dataclass(frozen=True)
class FreeEntry:
    """An entry on the path of a free body (`forces.free_path`).

    Attributes:
        values: Its numbers.
        whole: Whether it acts on the whole object.
        scaling: What M = 1 means.
        frame_dt: Seconds per frame [s].
        begin: Frame at which each interval begins, shape (frames - 1,).
        stroke: Its part in a series of pushes.
    """

    values: ActionParameters
    whole: bool
    scaling: SkillScaling
    frame_dt: float
    begin: np.ndarray
    stroke: Stroke | None = None

    @property
    def frames(self) -> np.ndarray:
        """The part of each interval that lies in the window [frames], shape (frames - 1,)."""
        first, last = self.values.window
        return np.maximum(0.0, np.minimum(self.begin + 1, last) - np.maximum(self.begin, first))

    def direct(self, k: float | Array) -> Array:
        """K M v, shape (3,)."""
        return _direct(k, self.values)


class Binding:
    """An action or constraint, with its numbers, bound to particles and seconds.

    Attributes:
        values: Its numbers; the vector is a unit vector.
        scaling: What M = 1 means.
        stroke: Its part in a series of pushes.
        window: Start and end [s], scalars.
        instant: The moment of what acts at once: just after its window begins [s].
        weight: 1 inside the region, 0 outside, shape (n,); None = everywhere.
        whole: Whether it acts on the whole object.
        upwards: Vertical component of its own way, whatever numbers stand in its place.
        again: Whether the whole object fell, or a blow threw it up, before it.
        lies: Whether the whole object was turned over before it, and not back.
    """

    def __init__(
        self,
        timed: Action | VelocityConstraint,
        values: ActionParameters,
        place: str,
        rest: np.ndarray,
        volume: np.ndarray,
        about: Circumstances,
    ):
        """Bind an entry.

        Args:
            timed: The entry.
            values: Its numbers, traced or not.
            place: Its place in the force field, for messages.
            rest: Rest positions of the particles [m], shape (n, 3).
            volume: Rest volumes [m^3], shape (n,).
            about: Everything else.

        Raises:
            UserError: A region selects nothing, a window lies outside the clip, or an object id is unknown.
        """
        if timed.object is not None:
            raise UserError(
                f"`{place}.object` names an object, but the scene holds a single one",
                got=repr(timed.object),
                do="Leave `object` out",
            )
        self.values = values = _normalise(jax.tree.map(_check_known, values))
        if not _is_traced(values.window) and values.window[0] >= about.frame_count - 1:
            raise UserError(
                f"`{place}.active_time` begins after the clip's last frame {about.frame_count - 1}",
                got=values.window.tolist(),
                do="Give frames inside the clip",
            )
        self.scaling, self.stroke, self._turned = about.scaling, about.stroke, about.turned
        self.again, self._lies = about.again, about.lies
        self._dtype, self._rest, self._volume, frame_dt = rest.dtype, rest, volume, about.frame_dt
        self._mask = np.ones(len(rest), bool)
        if timed.region is not None:
            self._mask = make_region_mask(timed.region, rest, f"{place}.region")
        first, last = values.window
        self.window = self.leaf(first * frame_dt), self.leaf(last * frame_dt)
        self.instant = self.leaf((first + AFTER) * frame_dt)
        self._until = min(about.until * frame_dt, FOREVER)
        pivot = getattr(timed, "pivot", None)
        self._pivot = None if pivot is None else rest.min(0) + np.asarray(pivot) * np.ptp(rest, axis=0)
        self._led, self._share, self._about, wrung = np.flatnonzero(self._mask), None, None, False
        if (bend := getattr(timed, "bend", None)) is not None:
            part, share, middle = grade_part(bend, rest)
            self._led, self._share = np.flatnonzero(part), self.leaf(share)
            self._pivot = None if pivot is None else middle
            twist = None if pivot is None else self._find_twist(timed, bend, frame_dt, about.frame_count)
            if twist is not None:
                self._led, self._pivot, wrung = twist.led, twist.pivot, twist.share is None
                self._share = None if twist.share is None else self.leaf(twist.share)
        self._carriers, self._turns = self._find_carriers() if is_carried(timed) else None, about.turns
        self._tilt = 0.0  # [rad] by which it is led over the edge of its foot
        self._steps: np.ndarray | None = None  # [m] by which its middle goes in equal parts of the turn
        if about.tilt is not None and self._pivot is None and self._stands:
            self._tilt = abs(about.tilt.last - about.tilt.first)
            self._pivot, edge = self._find_foot_edge(about.tilt.axis)
            if about.moved:  # the edge is where its particles have gone
                self._pivot = edge
                near = np.linalg.norm(rest - self._pivot, axis=1) < _EDGE * np.ptp(rest, axis=0).max()
                self._about, self._pivot = self.leaf(near), None
            if max(about.tilt.first, about.tilt.last) > _ROLLING or self._sinks(about.tilt, edge):
                self._steps, self._pivot, self._about = self._find_steps(about.tilt), None, None
        hold_end = getattr(timed, "held_until", None)
        self._held_until = None if hold_end is None else self.leaf(hold_end * frame_dt)
        self._rigid = wrung or (isinstance(timed.region, CellsRegion) and timed.region.rigid)
        self.whole = timed.region is None
        self.stops = is_stop(timed)
        self._way = np.copysign(1.0, timed.magnitude) * np.asarray(timed.vector)
        self.upwards = float(self._way[2])
        self.weight = None if self.whole else self.leaf(self._mask)

    def _find_carriers(self) -> np.ndarray:
        """Indices of some particles all over the rest, which carries what is led.

        Those beside the joint alone would go along with what is led, which would then drive itself.
        """
        if self._pivot is None:
            self._pivot = self._rest[self._led].mean(0)
        others = np.setdiff1d(np.arange(len(self._rest)), self._led)
        return others[:: -(-len(others) // _CARRIERS)]

    def _find_twist(self, timed, bend: Bend, frame_dt: float, frame_count: int) -> Twist | None:
        """The twist of a part that turns in place (`find_twist`)."""
        if timed.constraint_type is not ConstraintType.PARTICLE_ROTATION:
            return None
        first, last = timed.active_time or (0.0, frame_count - 1)
        angle = abs(timed.magnitude) * timed.gain * self.scaling.rotation * (last - first) * frame_dt
        return find_twist(bend, self._rest, np.asarray(timed.vector, float), float(angle))

    def leaf(self, value) -> jax.Array:
        """``value`` as an array of the particles' dtype."""
        return value.astype(self._dtype) if _is_traced(value) else to_device(value, self._dtype)

    @property
    def opposition(self) -> Opposition | None:
        """The opposition that is made up for; None for a part that moves against the rest of the object."""
        return self.scaling.opposition if self.whole or self.scaling.share is not None else None

    @property
    def known_opposition(self) -> Opposition | None:
        """The opposition that a push makes up for beforehand: the weight of what it lifts from the ground is felt."""
        felt = self._stands and self.upwards >= RISES
        opposition = self.opposition
        return opposition.model_copy(update=dict(weight=0.0)) if felt and opposition else opposition

    @property
    def _opposition_of_the_whole(self) -> Opposition | None:
        """The opposition that each particle of the whole feels; a part that leads it bears more (`scale_entry`)."""
        opposition = self.opposition
        return opposition and opposition.model_copy(update=dict(weight=self.share * opposition.weight))

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
        """The strain of a `scale` in the weakest section over that in the middle of a bar along the longest side."""
        inside = self._mask
        return find_stress_concentration(
            self._rest[inside], self._volume[inside], self.values.vector, np.ptp(self._rest, axis=0).max()
        )

    def reach(self) -> Array:
        """Mean distance of the chosen matter from the plane through its centre across the vector [m]."""
        axis, arm = self.values.vector, self._rest[self._mask].astype(float) - self.centre
        xp = jnp if _is_traced(axis) else np
        return xp.maximum(xp.average(xp.abs(arm @ axis), weights=self._volume[self._mask]), _TINY)

    def overcome_friction(
        self, k: float | Array, before: Array | float | None = None, *, pulse: bool = False
    ) -> list:
        """The force that overcomes friction for a push of the whole object.

        Args:
            k: The push for M = 1; the mean over its window where it rises and falls [m/s^2].
            before: Speed that it begins with [m/s].
            pulse: Whether it rises and falls as 1 - cos over its window.
        """
        opposition = self._opposition_of_the_whole
        if opposition is None or not opposition.friction:
            return []
        size, way = self._split()
        push, start = self.leaf(k * self.share * size), self.leaf(np.zeros(()) if before is None else before)
        resistance = self.leaf(find_resistance(opposition, way))
        grounded = bool(opposition.lever) and not self._turned and self.upwards < RISES
        lever = self.leaf(opposition.lever if grounded else 0.0)
        drag = self.leaf(opposition.damping_rate)
        numbers = (self.leaf(way), resistance, push, start, lever, drag)
        if not grounded:
            return [PushCompensation(*numbers, *self.window, pulse=pulse)]
        (begin, end), most = self.window, self.leaf(RUBS * resistance)
        speed = jnp.abs(start + push * (end - begin))
        safe = 0.0 if self._lies else self._find_safe_rate()
        brake = jnp.minimum(jnp.maximum(self.leaf(safe), speed / BRAKING), most)
        rest = jnp.maximum(jnp.minimum(end + speed / brake, self._until), end)
        feet = None if self._lies else self._find_feet()  # what has been turned over lies on other matter
        return [PushCompensation(*numbers, begin, rest, feet=feet, pulse=pulse, brake=brake, pushed=end)]

    def _find_safe_rate(self) -> float:
        """Deceleration at which what slides along its own way does not trip [m/s^2]."""
        opposition = self._opposition_of_the_whole
        assert opposition is not None
        axis = np.cross([0.0, 0.0, 1.0], self._way)
        axis = axis / max(float(np.linalg.norm(axis)), _TINY)
        balance, _ = find_balance(self._rest.astype(float), self._volume.astype(float), axis)
        return STEADY * opposition.weight * math.tan(min(balance, 1.0))

    def keep_balance(self, *, released: bool = False) -> list:
        """The force that keeps upright what stood and is pushed, lifted or thrown up, until something else acts.

        What is pushed to and fro may rock until it is let go. What turns meanwhile, or rolls, is left alone; what is
        tall and leaps comes down upright, however round its foot.

        Args:
            released: Whether it is only kept upright once the entry lets it go: what was out of shape until then.
        """
        opposition = self._opposition_of_the_whole
        most = self._find_most_balance(leaps=self.upwards >= RISES)
        if opposition is None or most is None or self._turned or self._lies:
            return []
        swings = self.stroke is not None and self.stroke.swings
        slack = 0.0 if self.upwards >= RISES else ROCKS
        start, end = self.window[1 if swings or released else 0], self.leaf(self._until)
        start = start if self._held_until is None else self._held_until
        return [Balance(self.leaf(self._rest), self.leaf(most), self.leaf(slack), start, end)]

    def limit_rebound(self) -> list:
        """The forces that let the whole come up but slowly, against the entry's way, and stand, until it is let go.

        What stood on a tip, or comes down aslant from a somersault, has no balance of its own.
        """
        speed = self.leaf(self._split()[0] * (RISES_BY / (MAGNITUDE_MIN * GAIN_MIN)))
        end = self.window[1] if self._held_until is None else self._held_until
        made: list = [Touchdown(speed, self.leaf(-self._way), self.window[0], end)]
        if (most := self._find_most_balance()) is not None and not self._lies:
            made.append(Balance(self.leaf(self._rest), self.leaf(most), self.leaf(0.0), self.window[0], end))
        return made

    def let_land(self) -> list:
        """The force that lets what is led over the edge of its foot, and then let go, lie where it falls."""
        most = self._find_most_balance()
        if not FALLING <= self._tilt <= _LAID or most is None or self._held_until is not None:
            return []
        rest, way, most = map(self.leaf, (self._rest, self._way, most))
        return [Landing(rest, way, most, self.window[1], self.leaf(self._until))]

    def keep_axle(self) -> list:
        """The force that keeps up what rolls on its edge, until something else acts."""
        opposition, axle = self._opposition_of_the_whole, self._way
        if opposition is None or not self.whole or self._lies or abs(axle[2]) > _LEVEL:
            return []
        x, volume = self._rest.astype(float), self._volume.astype(float)
        level = np.array([axle[0], axle[1], 0.0]) / math.hypot(axle[0], axle[1])
        axes = np.stack([level, np.cross([0.0, 0.0, 1.0], level), [0.0, 0.0, 1.0]])
        thickness, *breadths = np.ptp(x @ axes.T, axis=0)
        if thickness > _THIN * min(breadths) or min(breadths) < _ROUND * max(breadths):
            return []
        arm = x - np.average(x, axis=0, weights=volume)
        spread = max(float(np.average((arm**2).sum(1), weights=volume)), _TINY)
        most = BALANCING * opposition.weight * -float(arm[:, 2].min()) / spread
        rest, axes, most = map(self.leaf, (self._rest, axes, most))
        return [AxleBalance(rest, axes, most, self.window[0], self.leaf(self._until))]

    def let_settle(self) -> list:
        """The force that brings to rest what lies and was rolled on, until something else acts."""
        if not self._lies or not self.whole or self._opposition_of_the_whole is None:
            return []
        return [Settling(self.window[1], self.leaf(self._until))] if abs(self._way[2]) < _LEVEL else []

    def _find_most_balance(self, *, leaps: bool = False) -> float | None:
        """The largest angular acceleration that keeps or brings it where it is to be [rad/s^2]; None = none does."""
        opposition = self._opposition_of_the_whole
        x, volume = self._rest.astype(float), self._volume.astype(float)
        arm = x - np.average(x, axis=0, weights=volume)
        lever = opposition.lever if opposition else 0.0
        if leaps and np.ptp(arm[:, 2]) > _TALL * np.ptp(arm[:, :2], axis=0).max():
            lever = max(lever, -float(arm[:, 2].min()))
        if opposition is None or not lever:
            return None
        spread = max(float(np.average((arm**2).sum(1), weights=volume)), _TINY)
        return BALANCING * opposition.weight * lever / spread

    def _find_foot_edge(self, axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The place on the ground about which it tilts, and the particle on which it then stands [m], shapes (3,).

        What overhangs, as a car's bumper does, comes down as it tilts: about its wheels it would go into the ground,
        about itself it would hang over it. The place is the one about which it just meets the ground in the end.
        """
        x, way = self._rest.astype(float), np.cross(axis, [0.0, 0.0, 1.0])
        slope = math.tan(min(max(self._tilt, _SLIGHT), TILTED))
        stands = (x[:, 2] - slope * (x @ way)).argmin()
        down = x[stands, 2] - x[:, 2].min()
        return x[stands] - down * (way / slope + np.array([0.0, 0.0, 1.0])), x[stands]

    def _sinks(self, tilt: Tilt, edge: np.ndarray) -> bool:
        """Return whether it would go into the ground as it is tilted about an edge, as a barrel does about its hoop."""
        arm = self._rest.astype(float) - edge
        height = dataclasses.replace(tilt, first=0.0, last=self._tilt).turn(arm, 1.0)[:, 2]
        return bool(arm[:, 2].min() - height.min() > _EDGE * np.ptp(self._rest, axis=0).max())

    def _find_steps(self, tilt: Tilt) -> np.ndarray:
        """The ways of its middle in the equal parts of a turn, in which it rests on the ground, shape (parts, 3) [m].

        What is laid onto its side rolls over one edge after another: a pan goes over its foot and then over its rim.
        What is turned over stays where it is, and goes up and down.
        """
        x, steps = self._rest.astype(float), []
        arm = x - np.average(x, axis=0, weights=self._volume)
        rolls = max(tilt.first, tilt.last) <= _LAID
        for share in np.arange(_PARTS) / _PARTS:
            before, after = (tilt.turn(arm, each) for each in (share, share + 1 / _PARTS))
            lowest = tilt.turn(arm, share + 0.5 / _PARTS)[:, 2].argmin()
            way = before[lowest] - after[lowest]
            rise = before[:, 2].min() - after[:, 2].min()
            steps.append([*(rolls * way[:2]), rise])
        return np.array(steps)

    def _find_feet(self) -> jax.Array:
        """Weights of the particles that fade with their height over the lowest, with a mean of 1 by mass."""
        height = self._rest[:, 2].astype(float) - float(self._rest[:, 2].min())
        weights = np.exp(-height / max(_FEET * height.max(), _TINY))
        return self.leaf(weights / np.average(weights, weights=self._volume))

    def overcome_righting(self, k: float | Array) -> list:
        """The force that overcomes what opposes a turn of the whole object with k."""
        opposition = self.opposition
        if opposition is None or not (opposition.turning or opposition.tipping):
            return []
        size, way = self._split()
        friction, turn = self.leaf(find_righting(opposition, way)), self.leaf(k * self.share * size)
        drag, limits = self.leaf(opposition.damping_rate), {}
        if opposition.tipping and abs(self._way[2]) < _LEVEL:
            balance, arm = find_balance(self._rest.astype(float), self._volume.astype(float), self._way)
            friction = jnp.maximum(friction, self.leaf(opposition.weight * arm))
            if not self._lies:  # what lies is rolled over one edge after another
                limits = dict(balance=self.leaf(balance + PAST), rest=self.leaf(self._rest))
        return [TurnCompensation(self.leaf(way), friction, turn, drag, *self.window, **limits)]

    @property
    def share(self) -> float:
        """Share of the entry's acceleration that the whole object gains."""
        return 1.0 if self.scaling.share is None else self.scaling.share

    @property
    def _stands(self) -> bool:
        """Return whether the object is on the ground."""
        return self.scaling.opposition is not None and self.scaling.opposition.friction > 0

    def _split(self) -> tuple[Array, Array]:
        """abs(M), and the vector with its sign."""
        xp = jnp if _is_traced(self.values.magnitude) else np
        return xp.abs(self.values.magnitude), xp.sign(self.values.magnitude) * self.values.vector

    @property
    def extent(self) -> float:
        """The object's longest extent [m]."""
        return float(np.ptp(self._rest, axis=0).max())

    @property
    def centre(self) -> np.ndarray:
        """The centre of the particles at rest [m], shape (3,)."""
        return np.average(self._rest[self._mask].astype(float), axis=0, weights=self._volume[self._mask])

    def concentrate(self, peak: float, depth: float, width: float) -> jax.Array:
        """Weights of the particles of the whole that are largest on the side from which the vector comes.

        Their mean by mass is 1 and they give no spin, so that the whole moves as if they were even.

        Args:
            peak: Largest weight.
            depth: Share of the extent along the vector in which they fall to 1 / e of their excess.
            width: The same across, in body lengths, of a Gaussian.
        """
        way = self._split()[1]
        xp = jnp if _is_traced(way) else np
        x, volume = self._rest.astype(float), self._volume.astype(float)
        arm = x - np.average(x, axis=0, weights=volume)
        along = arm @ way
        across = arm - along[:, None] * way
        reach = xp.maximum(xp.ptp(along), _TINY)
        excess = xp.exp(-(along - along.min()) / (depth * reach))
        excess = excess * xp.exp(-0.5 * (across**2).sum(1) / max(width * self.extent, _TINY) ** 2)
        moments = xp.concatenate([xp.ones((len(x), 1)), across], axis=1)
        weighted = moments * volume[:, None]
        # Across has rank 2: the way itself is added, so that the matrix can be inverted.
        axis = xp.concatenate([xp.zeros(1), way])
        matrix = weighted.T @ moments + volume.sum() * reach**2 * (axis[:, None] * axis)
        matrix = matrix + 1e-9 * xp.trace(matrix) * xp.eye(4)
        excess = excess - moments @ xp.linalg.solve(matrix, weighted.T @ excess)
        return self.leaf(1 + (peak - 1) * excess / xp.maximum(excess.max(), _TINY))

    def average_turn(self, profile: Callable[[Array], Array]) -> Array:
        """Angular acceleration of a rigid body to which a field gives its profile of them around the axis.

        Args:
            profile: Function from squared distances to the axis [m^2], shape (n,), to angular accelerations there.
        """
        axis, arm = self.values.vector, self._rest[self._mask].astype(float) - self.centre
        xp = jnp if _is_traced(axis) else np
        squared = (arm**2).sum(1) - (arm @ axis) ** 2
        inertia = self._volume[self._mask] * xp.maximum(squared, 0.0)
        total = inertia.sum()  # 0 where all lie on the axis: nothing turns there
        whole = xp.maximum(total, _TINY)
        return xp.where(total > _TINY, (inertia * profile(squared)).sum() / whole, 1.0)

    def width(self, *, chosen: bool = False) -> Array:
        """The extent along the vector of the object, or of the chosen matter, over the object's longest [1]."""
        axis = self.values.vector
        xp = jnp if _is_traced(axis) else np
        extent = np.ptp(self._rest, axis=0).max()
        if extent == 0:  # all particles in one place
            return np.asarray(1.0)
        places = self._rest[self._mask] if chosen else self._rest
        return xp.ptp(places.astype(xp.result_type(float)) @ (axis / xp.linalg.norm(axis))) / extent

    def hold(self, velocity: jax.Array, angular_velocity: jax.Array) -> list[PrescribedMotion]:
        """The particles move so during the window, about pivot or own centre, and then stay if they are to be held.

        Those of a part that bends beside its joint go with their share of it.
        """
        with jax.ensure_compile_time_eval():  # places are known, also where numbers are traced
            particles = to_device(self._led, np.int32)
        still = self.leaf(np.zeros(3))
        pivot = None if self._pivot is None else self.leaf(self._pivot)
        if self._carriers is not None:
            return self._hold_carried(self._carriers, velocity, angular_velocity)
        start, end = self.window
        if self._steps is not None:
            velocity = velocity + self.leaf(self._steps * len(self._steps)) / (end - start)
        fields, windows = [(velocity, angular_velocity, pivot)], [(start, end)]
        if self._held_until is not None:
            fields.append((still, still, still))
            windows.append((end, self._held_until))
        lead = partial(
            PrescribedMotion,
            particles,
            share=self._share,
            about=self._about,
            rigid=self._rigid,
            whole=len(self._led) == len(self._rest),
        )
        return [lead(*field, start=start, end=end) for field, (start, end) in zip(fields, windows)]

    def _hold_carried(
        self, carriers: np.ndarray, velocity: jax.Array, angular_velocity: jax.Array
    ) -> list[PrescribedMotion]:
        """As `hold`, on top of the mean motion of the rest, which is not held itself."""
        led = self._led
        with jax.ensure_compile_time_eval():
            particles = to_device(np.concatenate([led, carriers]), np.int32)
        own = np.arange(len(particles)) < len(led)
        share = self._share
        if share is not None:
            share = self.leaf(np.pad(np.asarray(share), (0, len(carriers))))
        mean = np.average(self._rest[carriers], axis=0, weights=self._volume[carriers])
        hold = partial(
            PrescribedMotion,
            particles,
            center=self.leaf(self._pivot - mean),
            share=share,
            about=self.leaf(~own),
            turns=None if self._turns is None else self.leaf(self._turns),
            rigid=self._rigid,
            carried=True,
        )
        start, end = self.window
        made = [hold(velocity, angular_velocity, start=start, end=jnp.where(own, end, start))]
        if self._held_until is not None:
            still = self.leaf(np.zeros(3))
            made.append(hold(still, still, start=end, end=jnp.where(own, self._held_until, end)))
        return made

    def press(self, k: float | Array) -> list[MovingPlate]:
        """A plate that starts at the object's side, moves with k M v, stays if it is to be held, and then goes back.

        On a region it is no larger than that. What is pressed follows the plate back in `RETREAT`: let go at once, it
        would leap off the ground. A finger goes back as fast as it came.
        """
        velocity, (start, end) = self.vector(k), self.window
        normal = velocity / jnp.linalg.norm(velocity)
        chosen = self.leaf(self._rest[self._mask])
        behind = (chosen @ normal).min()
        middle = self.leaf(self._rest[self._mask].mean(0))
        point = middle + (behind - middle @ normal) * normal
        edges = depth = None
        if not self.whole:
            aside = jnp.cross(normal, jnp.where(jnp.abs(normal[2]) < 0.9, *self.leaf(np.eye(3)[[2, 0]])))
            aside = aside / jnp.linalg.norm(aside)
            axes = jnp.stack([aside, jnp.cross(normal, aside)])
            across = chosen @ axes.T
            low, high = across.min(0), across.max(0)
            point = point + (0.5 * (low + high) - point @ axes.T) @ axes
            half = jnp.maximum(0.5 * PLATE_SIZE * (high - low), _THINNEST * self.extent)
            edges, depth = axes / half[:, None], self.leaf(PLATE_DEPTH * self.extent)
        friction = self.leaf(PLATE_FRICTION)
        faces = [HalfSpace(point, normal, friction, start, end, velocity=velocity)]
        stop, until = point + velocity * (end - start), end
        if self._held_until is not None:
            until = self._held_until
            faces.append(HalfSpace(stop, normal, friction, end, until))
        time = self.leaf(RETREAT) if self.whole else jnp.minimum(RETREAT, end - start)
        back = velocity * ((start - end) / time)
        faces.append(HalfSpace(stop, normal, friction, until, until + time, velocity=back))
        return [MovingPlate(face, edges, depth) for face in faces]

    def shatter(self, k: float | Array, pieces: int) -> list[Shatter]:
        """So many fragments, which fly apart with k M from the window's start on."""
        speed = jnp.linalg.norm(self.vector(k))
        return [Shatter.of(self._rest, pieces, self._way, speed, self.window[0])]

    def change_length(
        self, other: Binding | None, k: float | Array, sign: float, *, retreats: bool = False
    ) -> list[GradedTranslation]:
        """The object gets longer or shorter evenly along the vector, as its two ends say, and then stays if held.

        What presses and then retreats lets it come back no faster than that, until something else acts: what is soft
        would throw itself off the ground.

        Args:
            other: The other end; None = it rests on the ground or is held. What stands gets longer upwards.
            k: Speed of both ends [m/s].
            sign: 1 if the vector points out of the object at this end, -1 if into it.
            retreats: Whether the ends go back in `RETREAT`.
        """
        size, way = self._split()
        axis = self.leaf(way)
        speed = self.leaf(sign * k * (size + (0.0 if other is None else other._split()[0])))
        along = self.leaf(self._rest) @ axis
        length = along.max() - along.min()
        point = None
        if other is None:  # the far end, towards which the plate moves
            middle = self.leaf(self._rest.mean(0))
            point = middle + (along.max() - middle @ axis) * axis
        elif self._stands and abs(self.upwards) > _UPRIGHT:  # the ground bears the lower end, which stays
            point = self.leaf(self._rest[self._rest[:, 2].argmin()])
        start, end = self.window
        lead = partial(GradedTranslation, axis=axis, point=point)
        motions = [lead(speed=speed, length=length, start=start, end=end)]
        change, still = speed * (end - start), self.leaf(np.zeros(()))
        if self._held_until is not None:
            motions.append(lead(speed=still, length=length + change, start=end, end=self._held_until))
        if retreats:
            begin, speed = motions[-1].end, -change / self.leaf(RETREAT)
            back = jnp.minimum(begin + RETREAT, self.leaf(self._until))
            motions.append(lead(speed=speed, length=length + change, start=begin, end=back, limits=True))
        return motions

    def wring(self, other: Binding | None, k: float | Array, sign: float) -> list[GradedRotation]:
        """The two ends turn against each other about the vector, what lies between them in proportion.

        The particles of each end turn at the given rate on average. A held end stays, and the other turns by all of it.

        Args:
            other: The other end; None = it is held.
            k: Rate of both ends [rad/s].
            sign: 1 if this end lies in the vector's direction, -1 if the other does.
        """
        size, way = self._split()
        axis, rest, weight = self.leaf(way), self._rest.astype(float), self.leaf(self._volume)
        along, point = self.leaf(self._rest) @ axis, None
        reach = jnp.average(along[self._mask], weights=weight[self._mask])
        length = along.max() - along.min()
        if other is None:
            heights = sign * rest @ self._way
            still = heights <= heights.min() + HELD_END * np.ptp(heights)
            fixed = np.average(rest[still], axis=0, weights=self._volume[still])
            fixed = fixed + sign * (heights.min() - heights[still].mean()) * self._way
            point, offset = self.leaf(fixed), self.leaf(np.stack([0 * fixed, self.centre - fixed]))
            rate = self.leaf(sign * k * size) * length / jnp.abs(reach - point @ axis)
        else:
            parting = jnp.abs(reach - jnp.average(along[other._mask], weights=weight[other._mask]))
            rate = self.leaf(sign * 0.5 * k * (size + other._split()[0])) * length / parting
            middle = np.average(rest, axis=0, weights=self._volume)
            ends = (other, self) if sign > 0 else (self, other)
            offset = self.leaf(np.stack([end.centre - middle for end in ends]))
        start, end = self.window
        turn = GradedRotation(
            axis=axis, length=length, offset=offset, point=point, rate=rate, start=start, end=end
        )
        if self._held_until is None:
            return [turn]
        rest = self.leaf(np.zeros(()))
        return [turn, dataclasses.replace(turn, rate=rest, start=end, end=self._held_until)]


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


def _direct(k: float | Array, values: ActionParameters) -> Array:
    """K M v, shape (3,)."""
    return k * values.magnitude * values.vector
