"""Wind: drag towards the velocity of the air."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.forces.envelope import Envelope, Scalar
from physagent_jax.forces.regions import confine
from physagent_jax.mpm.fields import PER_PARTICLE, UNIT


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Wind:
    """Drags particles towards the air's velocity u = speed * profile(t) * direction.

    With the relative velocity w = u - v, dv/dt = k1 w + k2 |w| w: k1 is the rate of viscous drag, and
    k2 = rho_air C_d A / (2 m) that of a bluff body of frontal area A and mass m. The drag acts within the
    envelope's window; the envelope also scales the air's speed, so that a gust dies into still air.

    A stiff drag taken explicitly would throw v past u. While u is constant w keeps its direction and
    s = |w| obeys ds/dt = -(k1 s + k2 s^2), a Bernoulli equation with the solution over a time h

        s(h) = s exp(-k1 h) / (1 + k2 s p),   p = (1 - exp(-k1 h)) / k1,

    so the velocity changes by exactly p (k1 + k2 s) / (1 + k2 s p) w, a share of w between 0 and 1 for any
    k1 h and k2 s h. u is its mean over the substep, an error of order dt^2 in a gust. Other forces are
    added at the same v: a terminal velocity under g comes out larger by g dt / 2, and several winds on the
    same particles keep their stability only if their k dt sum to less than 2.

    Every particle is dragged, inner ones too: there is no shelter. Within a cell the air is uniform, so
    only the mean motion of the matter there is dragged, not its spin.

    Attributes:
        direction: Unit vector, shape (3,).
        speed: Speed of the air where the envelope is 1 [m/s], scalar.
        linear_drag: k1 [1/s], scalar.
        quadratic_drag: k2 [1/m], scalar.
        envelope: Gusts.
        center, radius: The wind blows only within ``radius`` [m] of the line through ``center`` [m], shape
            (3,), along ``direction``; both None = everywhere.
        weight: 1 inside the region, 0 outside, shape (n,); None = everywhere.
    """

    direction: jax.Array = dataclasses.field(metadata=UNIT)
    speed: Scalar
    linear_drag: Scalar
    quadratic_drag: Scalar
    envelope: Envelope
    center: jax.Array | None = None
    radius: Scalar | None = None
    weight: jax.Array | None = dataclasses.field(default=None, metadata=PER_PARTICLE)

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        del mass
        air = self.speed * self.envelope.mean_while_active(time, dt) * self.direction
        w = air - v
        s = _measure_length(w)
        h = dt * self.envelope.active(time, dt)
        p = h * _average_decay(self.linear_drag * h)
        share = p * (self.linear_drag + self.quadratic_drag * s) / (1 + self.quadratic_drag * s * p)
        field = (share / dt)[:, None] * w
        if self.center is not None and self.radius is not None:
            arm = x - self.center
            across = arm - (arm * self.direction).sum(-1, keepdims=True) * self.direction
            blown = (across**2).sum(-1) <= self.radius**2
            field = jnp.where(blown[:, None], field, 0.0)
        return confine(field, self.weight)

    def gradient(self, x, time, dt):
        """None: the air is uniform."""
        del x, time, dt


def make_still_air(
    linear_drag: Scalar, quadratic_drag: Scalar, envelope: Envelope, weight: jax.Array | None = None
) -> Wind:
    """The drag of air at rest: a `Wind` of speed 0.

    Args:
        linear_drag: k1 [1/s].
        quadratic_drag: k2 [1/m].
        envelope: Only its window matters.
        weight: 1 inside the region, 0 outside, shape (n,); None = everywhere.
    """
    # Any direction will do; its values are exact in float32, which never widens what it is combined with.
    anywhere = jnp.array([1, 0, 0], jnp.float32)
    return Wind(anywhere, 0.0, linear_drag, quadratic_drag, envelope, weight=weight)


def _measure_length(w: jax.Array) -> jax.Array:
    """|w|, shape (n,), with a zero derivative at w = 0."""
    squared = (w**2).sum(-1)
    moving = squared > 0
    return jnp.where(moving, jnp.sqrt(jnp.where(moving, squared, 1.0)), 0.0)


def _average_decay(z: Scalar) -> jax.Array:
    """(1 - exp(-z)) / z: the mean of exp(-t) over [0, z]; 1 at z = 0."""
    z = jnp.asarray(z)
    small = jnp.abs(z) < 0.03  # where the quotient's derivative would cancel
    large = jnp.where(small, 1.0, z)
    series = jnp.ones_like(z)
    for n in range(8, 1, -1):  # the remainder is below 1e-17
        series = 1 - z / n * series
    return jnp.where(small, series, -jnp.expm1(-large) / large)
