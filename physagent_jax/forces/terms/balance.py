"""The balance that what jumps, is carried or slides keeps by itself, or the hand that moves it: it stays upright.

The attitude is fed back, as a gymnast's or a gyroscope's is: with e the turn back to the attitude at rest, by the mean
moment of both positions about the mass centre (sin e for a rigid body), and s the spin,

    angular acceleration = w^2 e - 2 w s,   w = `RATE`, critically damped,

of no more than a few times what weight can turn it by. It is a field of a rigid body, and mean turn and spin are what
it answers: it damps, and leaves alone what bends. What stands may rock within a slack, over which it sets in.
"""

from __future__ import annotations

import dataclasses
import math

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.forces.terms.rigid import find_turn, limit, mass_centre
from physagent_jax.mpm.edges import window_fraction
from physagent_jax.mpm.fields import EDGE, END, PER_PARTICLE, START
from physagent_jax.mpm.linalg import cross
from physagent_jax.mpm.reductions import sum_particles

RATE = 20.0  # [1/s] of the critically damped return: in a sixth of a second
SETTLING = 8.0  # [1/s] the same of what has fallen over
RESTING = 4.0  # [1/s] at which what rolls as it lies comes to rest
NEARLY, SLACK = math.radians(65), math.radians(12)  # turn from which on it lies, and beyond a right angle


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Balance:
    """Keeps the attitude that the object has at rest.

    Attributes:
        rest: Positions at rest [m], shape (n, 3).
        most: Largest angular acceleration [rad/s^2], scalar.
        slack: Turn up to which nothing is done [rad], scalar; at twice that all is. 0 = all is always done.
        start, end: Window [s], scalars.
        edge: Width of the window's smooth edges [s], scalar; None = hard.
    """

    rest: jax.Array = dataclasses.field(metadata=PER_PARTICLE)
    most: jax.Array
    slack: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    edge: jax.Array | None = dataclasses.field(default=None, metadata=EDGE)

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        r, first = x - mass_centre(x, mass), self.rest - mass_centre(self.rest, mass)
        moments = jnp.stack([cross(r, first), cross(r, v)])
        moments = sum_particles((mass[:, None] * moments).sum(1)) / sum_particles(mass.sum())
        off, spin = (find_turn(each, r, mass)[0] for each in moments)
        tiny = jnp.finfo(x.dtype).tiny
        beyond = jnp.sqrt((off**2).sum() + tiny) / jnp.maximum(self.slack, tiny) - 1
        share = jnp.where(self.slack > 0, jnp.clip(beyond, 0.0, 1.0), 1.0)
        turn = limit(share * (RATE**2 * off - 2 * RATE * spin), self.most)
        turn = turn * window_fraction(time, dt, self.start, self.end, self.edge)
        return cross(jnp.broadcast_to(turn, x.shape), r)

    def gradient(self, x, time, dt):
        """None, as of `TurnCompensation`."""
        del x, time, dt


@register_dataclass
@dataclasses.dataclass(frozen=True)
class AxleBalance:
    """Keeps the axle of what rolls on its edge as it is at rest: a coin or a plate rolls on and does not fall over.

    As `Balance`, but for the spin about the axle, which is free.

    Attributes:
        rest: Positions at rest [m], shape (n, 3).
        axes: Unit vectors, shape (3, 3): the axle, and two across it.
        most: Largest angular acceleration [rad/s^2], scalar.
        start, end: Window [s], scalars.
        edge: Width of the window's smooth edges [s], scalar; None = hard.
    """

    rest: jax.Array = dataclasses.field(metadata=PER_PARTICLE)
    axes: jax.Array
    most: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    edge: jax.Array | None = dataclasses.field(default=None, metadata=EDGE)

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        r, first = x - mass_centre(x, mass), self.rest - mass_centre(self.rest, mass)
        axle, *across = self.axes
        # Where the disc's two lines have been turned to: their own moments tell it better than the thin axle's.
        one, other = (sum_particles(((mass * (first @ line))[:, None] * r).sum(0)) for line in across)
        now = cross(one, other)
        off = cross(now, axle) / jnp.sqrt((now**2).sum() + jnp.finfo(x.dtype).tiny)
        moment = sum_particles((mass[:, None] * cross(r, v)).sum(0)) / sum_particles(mass.sum())
        spin, _ = find_turn(moment, r, mass)
        turn = limit(RATE**2 * off - 2 * RATE * (spin - (spin @ axle) * axle), self.most)
        turn = turn * window_fraction(time, dt, self.start, self.end, self.edge)
        return cross(jnp.broadcast_to(turn, x.shape), r)

    def gradient(self, x, time, dt):
        """None, as of `TurnCompensation`."""
        del x, time, dt


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Landing:
    """Lets what was tipped over lie where it falls, and neither bounce nor roll on over its next edge.

    Nothing is done until it is turned by `NEARLY`. At a right angle its spin is damped as critically as the return from
    what is more than `SLACK` beyond, which is as `Balance`'s.

    Attributes:
        rest: Positions of what stood [m], shape (n, 3).
        axis: Unit vector that it is tipped about (right-hand rule), shape (3,).
        most: Largest angular acceleration [rad/s^2], scalar.
        start, end: Window [s], scalars.
        edge: Width of the window's smooth edges [s], scalar; None = hard.
    """

    rest: jax.Array = dataclasses.field(metadata=PER_PARTICLE)
    axis: jax.Array
    most: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    edge: jax.Array | None = dataclasses.field(default=None, metadata=EDGE)

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        r = x - mass_centre(x, mass)
        first = cross(jnp.broadcast_to(self.axis, x.shape), self.rest - mass_centre(self.rest, mass))
        arm = cross(jnp.broadcast_to(self.axis, x.shape), r)
        turned = jnp.arctan2(*(sum_particles((mass * (first * each).sum(1)).sum()) for each in (r, arm)))
        turned = jnp.where(turned < -0.5 * jnp.pi, turned + 2 * jnp.pi, turned)
        moment = sum_particles((mass[:, None] * cross(r, v)).sum(0)) / sum_particles(mass.sum())
        spin, _ = find_turn(moment, r, mass)
        share = jnp.clip((turned - NEARLY) / (0.5 * jnp.pi - NEARLY), 0.0, 1.0)
        beyond = jnp.maximum(turned - 0.5 * jnp.pi - SLACK, 0.0)
        turn = limit(-2 * SETTLING * share * spin - SETTLING**2 * beyond * self.axis, self.most)
        turn = turn * window_fraction(time, dt, self.start, self.end, self.edge)
        return cross(jnp.broadcast_to(turn, x.shape), r)

    def gradient(self, x, time, dt):
        """None, as of `TurnCompensation`."""
        del x, time, dt


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Settling:
    """Slows the spin of what lies and was rolled on, as the ground does that gives way a little under each edge.

    Without it what is tapered rolls and rocks for seconds. The spin falls by `RESTING` of itself, and friction brings
    the centre to rest with it.

    Attributes:
        start, end: Window [s], scalars.
        edge: Width of the window's smooth edges [s], scalar; None = hard.
    """

    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    edge: jax.Array | None = dataclasses.field(default=None, metadata=EDGE)

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        r = x - mass_centre(x, mass)
        moment = sum_particles((mass[:, None] * cross(r, v)).sum(0)) / sum_particles(mass.sum())
        spin, _ = find_turn(moment, r, mass)
        share = window_fraction(time, dt, self.start, self.end, self.edge)
        return cross(jnp.broadcast_to(-RESTING * share * spin, x.shape), r)

    def gradient(self, x, time, dt):
        """None, as of `TurnCompensation`."""
        del x, time, dt
