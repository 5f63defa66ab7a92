"""Changes of velocity: a blow at once (`particle_impulse`), one that ends with a told speed, and a rebound's end."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.forces.regions import confine
from physagent_jax.mpm.edges import step_value, window_fraction
from physagent_jax.mpm.fields import EDGE, END, PER_PARTICLE, START
from physagent_jax.mpm.reductions import sum_particles

FALLS = 0.5  # [m/s] at which what comes down has not landed yet


@register_dataclass
@dataclasses.dataclass(frozen=True)
class VelocityChange:
    """Changes the velocity of a region's particles in the one substep in which its moment lies.

    Substeps [time, time + dt) cover the clip without gaps or overlaps, so that exactly one of them delivers the whole
    change, whatever dt is. The moment itself has the derivative zero, unless it has an edge, over which it is spread.

    Attributes:
        value: Change of velocity [m/s], shape (3,).
        start: The moment [s], scalar.
        end: The same moment: until when something is left to be done [s], scalar.
        weight: 1 inside the region, 0 outside, shape (n,); None = everywhere.
        edge: Width of the window's smooth edges [s], scalar; None = hard.
    """

    value: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    weight: jax.Array | None = dataclasses.field(default=None, metadata=PER_PARTICLE)
    edge: jax.Array | None = dataclasses.field(default=None, metadata=EDGE)

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        del v, mass
        if self.edge is None:
            share = (time <= self.start) & (self.start < time + dt)
        else:
            share = step_value(time + dt, self.start, self.edge) - step_value(time, self.start, self.edge)
        return confine(jnp.broadcast_to(share * (self.value / dt), x.shape), self.weight)

    def gradient(self, x, time, dt):
        """None: uniform."""
        del x, time, dt


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Launch:
    """Brings the mean velocity along a way to a value by the end of a window, whatever it was when that began.

    What leaps again and again has landed by then, or comes up or down still: each leap is as high as the one before.
    What springs up by itself as well would go higher, and the next leap would begin in the air: until it is at the top,
    its mean velocity is at most that of free flight.

    Attributes:
        value: The velocity [m/s], shape (3,).
        start, end: Window [s], scalars.
        slows: The deceleration along it in free flight [m/s^2], scalar; None = there is no weight, and no limit.
        edge: Width of the window's smooth edges [s], scalar; None = hard.
    """

    value: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    slows: jax.Array | None = None
    edge: jax.Array | None = dataclasses.field(default=None, metadata=EDGE)

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        mean = sum_particles((mass[:, None] * v).sum(0)) / sum_particles(mass.sum())
        square = jnp.maximum((self.value**2).sum(), jnp.finfo(x.dtype).tiny)
        reached = (mean * self.value).sum() / square  # share of the velocity
        share = window_fraction(time, dt, self.start, self.end, self.edge)
        change = share * (1.0 - reached) / jnp.maximum(self.end - jnp.maximum(time, self.start), dt)
        if self.slows is not None:
            slows = self.slows / jnp.sqrt(square)
            flies = window_fraction(time, dt, self.end, self.end + 1.0 / slows, self.edge)
            change -= flies * jnp.maximum(reached - (1.0 - slows * (time - self.end)), 0.0) / dt
        return jnp.broadcast_to(self.value * change, x.shape)

    def gradient(self, x, time, dt):
        """None: uniform."""
        del x, time, dt


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Touchdown:
    """Takes up a landing, as knees do: what comes down gets up again but slowly, and does not slide on.

    What is soft is pressed together as it comes down, and would leap again; what came down aslant would tip over its
    feet. The mean velocity alone is changed, so that it wobbles. Nothing is done as long as it falls (`FALLS`).

    Attributes:
        value: The greatest velocity along ``way`` [m/s], scalar.
        way: Unit vector up, shape (3,).
        start, end: Window [s], scalars.
        edge: Width of the window's smooth edges [s], scalar; None = hard.
    """

    value: jax.Array
    way: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    edge: jax.Array | None = dataclasses.field(default=None, metadata=EDGE)

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        mean = sum_particles((mass[:, None] * v).sum(0)) / sum_particles(mass.sum())
        speed = mean @ self.way
        landed = jnp.clip(1.0 + speed / FALLS, 0.0, 1.0)
        stopped = jnp.maximum(speed - self.value, 0.0) * self.way + landed * (mean - speed * self.way)
        share = window_fraction(time, dt, self.start, self.end, self.edge)
        return jnp.broadcast_to(-share / dt * stopped, x.shape)

    def gradient(self, x, time, dt):
        """None: uniform."""
        del x, time, dt
