"""A push or turn that overcomes friction as a hand does: as much as it takes, while it takes it.

Friction compensation as servo drives have it: the friction to be expected is fed forward, and the velocity that is
lacking, or in excess, is fed back,

    a = clip(a_f + (v_ref - v) / TAU, 0, 2 a_f),   v_ref = v_0 exp(-d s) + a_0 (1 - exp(-d s)) / d after a time s,

v the velocity of the mass centre along the way and v_ref what the push a_0 alone gives a body with drag d that sets out
with v_0. Where v_ref is contrary (a push to and fro stops it first) friction is overcome that way: the signs change.
Feeding forward alone does not do: friction is many times the push that is to be left, so that an error of a few per
cent of it doubles the way; it reaches the middle of a soft object only once a shear wave has come up from the ground;
and what rolls meets hardly any. Force and velocity are conjugate (the same for all particles, and its mean), so that
the feedback damps and cannot excite the object's own modes.

Friction acts at the feet: overcome at the mass centre alone, it would trip the object up. A push over the ground is
therefore helped at the feet, by their own velocity (conjugate again), and the object is held upright by feedback of its
spin, as a hand would, with at most twice friction's moment: a field of a rigid body. That field alone could give back
the moment too, but it lifts one outstretched arm and lowers the other. Not what rolls or is to turn meanwhile.

When such a push ends, friction would stop the feet and the rest would go on. So it is led to rest at a rate at which it
does not trip (`binding.Binding.overcome_friction`).

A turn about a level axis has its weight to overcome where it stands, in the same way: until the mass centre is over the
edge of its foot. Then weight turns it faster than was asked, and where it comes to lie nothing is overcome any more.
"""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.forces.terms.rigid import find_turn, limit, mass_centre
from physagent_jax.mpm.edges import window_fraction
from physagent_jax.mpm.fields import EDGE, END, PER_PARTICLE, START
from physagent_jax.mpm.linalg import cross
from physagent_jax.mpm.reductions import sum_particles

TAU = 0.01  # [s] in which a velocity that is lacking is made up for
SLOWEST = 4.0  # [substeps] that this takes at least


@register_dataclass
@dataclasses.dataclass(frozen=True)
class PushCompensation:
    """Overcomes friction along a direction.

    Attributes:
        direction: Unit vector, shape (3,).
        friction: To be expected [m/s^2], scalar.
        push: Acceleration that is to be left [m/s^2], scalar.
        speed: Velocity along the way that it is to begin with [m/s], scalar.
        lever: Height of the mass centre over where friction acts [m], scalar; 0 = the object may turn.
        damping_rate: Damping rate of the velocity [1/s], scalar.
        start, end: Window [s], scalars.
        edge: Width of the window's smooth edges [s], scalar; None = hard.
        feet: Where it is overcome: weights with a mean of 1 by mass, shape (n,); None = everywhere alike.
        pulse: Whether the push rises and falls over its window as 1 - cos, with ``push`` its mean; static.
        brake: Deceleration with which it is led to rest from the end of the push on [m/s^2], scalar; None = it is
            left to friction. What is tall would trip.
        pushed: End of the push [s], scalar; with ``brake``, before ``end``.
    """

    direction: jax.Array
    friction: jax.Array
    push: jax.Array
    speed: jax.Array
    lever: jax.Array
    damping_rate: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    edge: jax.Array | None = dataclasses.field(default=None, metadata=EDGE)
    feet: jax.Array | None = dataclasses.field(default=None, metadata=PER_PARTICLE)
    pulse: bool = dataclasses.field(default=False, metadata=dict(static=True))
    brake: jax.Array | None = None
    pushed: jax.Array | None = None

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        borne = mass if self.feet is None else self.feet * mass
        velocity = mass_centre(v, borne) @ self.direction
        wanted, slowing = self._find_wanted(time)
        way = jnp.where(wanted < 0, -1.0, 1.0).astype(x.dtype)
        size = way * _compensate(self.friction, way * (wanted - velocity), dt, slowing)
        size = size * window_fraction(time, dt, self.start, self.end, self.edge)
        centre = mass_centre(x, mass)
        turn = self._steady(x - centre, v, mass, size, mass_centre(x, borne) - centre, dt)
        push = size * self.direction
        push = push if self.feet is None else self.feet[:, None] * push
        return push + cross(jnp.broadcast_to(turn, x.shape), x - centre)

    def _find_wanted(self, time):
        """Velocity along the way that is wanted [m/s], and how fast it is to fall [m/s^2]."""
        end = self.end if self.pushed is None else self.pushed
        since = jnp.minimum(time, end) - self.start
        wanted = _find_velocity(self.push, self.damping_rate, since, self.speed)
        if self.pulse:
            wanted = wanted - self.push * _find_wave(self.damping_rate, since, end - self.start)
        if self.brake is None:
            return wanted, 0.0
        late = jnp.maximum(time - end, 0.0)
        left = jnp.maximum(jnp.abs(wanted) - self.brake * late, 0.0)
        # What has come to rest gets no help: friction holds it.
        slowing = jnp.where(late > 0, jnp.where(left > 0, self.brake, self.friction), 0.0)
        return jnp.sign(wanted) * left, slowing

    def _steady(self, r, v, mass, size, at, dt):
        """Angular acceleration that keeps it upright [rad/s^2], shape (3,); the push acts ``at``, from the centre."""
        spin = sum_particles((mass[:, None] * cross(r, v)).sum(0)) / sum_particles(mass.sum())  # [m^2/s]
        down = jnp.zeros(3, r.dtype).at[2].set(-self.lever)
        moment = cross((down - at)[None], self.direction[None])[0] * size
        wanted, spread = find_turn(moment - spin / jnp.maximum(TAU, SLOWEST * dt), r, mass)
        return limit(wanted, 2.0 * self.friction * self.lever / jnp.maximum(spread, jnp.finfo(r.dtype).tiny))

    def gradient(self, x, time, dt):
        """None, as of `TurnCompensation`."""
        del x, time, dt


@register_dataclass
@dataclasses.dataclass(frozen=True)
class TurnCompensation:
    """Overcomes what opposes a turn about an axis through the mass centre: friction, or the weight of what stands.

    Attributes:
        axis: Unit vector (right-hand rule), shape (3,).
        friction: Angular deceleration to be expected of either [rad/s^2], scalar.
        turn: Angular acceleration that is to be left [rad/s^2], scalar.
        damping_rate: Damping rate of velocities [1/s], scalar.
        start, end: Window [s], scalars.
        edge: Width of the window's smooth edges [s], scalar; None = hard.
        balance: Turn from ``rest`` beyond which nothing is overcome [rad], scalar; None = there is none.
        rest: Positions of what stands [m], shape (n, 3); with ``balance``.
    """

    axis: jax.Array
    friction: jax.Array
    turn: jax.Array
    damping_rate: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    edge: jax.Array | None = dataclasses.field(default=None, metadata=EDGE)
    balance: jax.Array | None = None
    rest: jax.Array | None = dataclasses.field(default=None, metadata=PER_PARTICLE)

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        arm = cross(jnp.broadcast_to(self.axis, x.shape), x - mass_centre(x, mass))
        inertia = sum_particles((mass * (arm**2).sum(1)).sum())
        # All mass on the axis has no inertia, and no spin either: the floor only avoids 0/0.
        spin = sum_particles((mass * (arm * v).sum(1)).sum()) / jnp.maximum(inertia, jnp.finfo(x.dtype).tiny)
        wanted = _find_velocity(self.turn, self.damping_rate, time - self.start)
        size = _compensate(self.friction, wanted - spin, dt)
        if self.balance is not None and self.rest is not None:
            first = cross(jnp.broadcast_to(self.axis, x.shape), self.rest - mass_centre(self.rest, mass))
            turned = [sum_particles((mass * (first * each).sum(1)).sum()) for each in (x, arm)]
            size = jnp.where(jnp.arctan2(*turned) < self.balance, size, 0.0)
        return size * window_fraction(time, dt, self.start, self.end, self.edge) * arm

    def gradient(self, x, time, dt):
        """None: the turn within particles, (dx / size)^2 of the torque, is left to the feedback."""
        del x, time, dt


def _find_velocity(
    acceleration: jax.Array, damping_rate: jax.Array, time: jax.Array, speed: jax.Array | float = 0.0
) -> jax.Array:
    """The speed after ``time`` [s] of a steady ``acceleration`` against drag, from ``speed``."""
    time = jnp.maximum(time, 0.0)
    decay = damping_rate * time
    # (1 - exp(-x)) / x, also at x = 0
    share = jnp.where(decay > 1e-4, -jnp.expm1(-decay) / jnp.maximum(decay, 1e-4), 1.0 - 0.5 * decay)
    return speed * jnp.exp(-decay) + acceleration * time * share


def _find_wave(damping_rate: jax.Array, time: jax.Array, length: jax.Array) -> jax.Array:
    """The speed after ``time`` of an acceleration cos(w t) against drag, with one period in ``length`` [s]."""
    time, w, d = jnp.maximum(time, 0.0), 2 * jnp.pi / length, damping_rate
    wave = d * (jnp.cos(w * time) - jnp.exp(-d * time)) + w * jnp.sin(w * time)
    return wave / (d**2 + w**2)


def _compensate(
    friction: jax.Array, lacking: jax.Array, dt: jax.Array, slowing: jax.Array | float = 0.0
) -> jax.Array:
    return jnp.clip(friction - slowing + lacking / jnp.maximum(TAU, SLOWEST * dt), 0.0, 2.0 * friction)
