"""A quiver: the shape of what is soft shakes, and its middle stays where it is."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.edges import window_fraction
from physagent_jax.mpm.fields import EDGE, END, START
from physagent_jax.mpm.reductions import sum_particles

RATE = 25.0  # [rad/s]: four times in a second, as jelly of the size of a hand does
FADES = 0.8  # [s] in which it fades to a third
_FOLLOWS = 0.02  # [s] in which the shape takes up the speed that it is to have
_TALL = 0.5  # height over length from which on it is sheared and not bent


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Quiver:
    """Drives one mode of the shape to and fro, at a rate of its own, less and less: u = phi(x) q(t).

    The mode is a shear along ``velocity`` of what is tall, phi = (z - <z>) / (sqrt(3) std z); what lies is bent
    vertically along its longest side, phi = s^2 - <s^2> with s = 1 at its ends. Both have no momentum. The force makes
    the mode's own speed, <phi u> / <phi^2>, follow |velocity| exp(-t / `FADES`) cos(`RATE` t), and no other
    one is touched.

    Attributes:
        velocity: With which the ends begin [m/s], shape (3,).
        start, end: Window [s], scalars.
        edge: Width of the window's smooth edges [s], scalar; None = hard.
    """

    velocity: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    edge: jax.Array | None = dataclasses.field(default=None, metadata=EDGE)

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        whole = sum_particles(mass.sum())

        def average(values):
            return sum_particles(mass @ values) / whole

        speed = jnp.sqrt(jnp.maximum((self.velocity**2).sum(), jnp.finfo(x.dtype).tiny))
        arm = x - average(x)
        xx, yy, xy, zz = average(jnp.stack([*(arm**2).T[:2], arm[:, 0] * arm[:, 1], arm[:, 2] ** 2], axis=1))
        tiny = jnp.finfo(x.dtype).eps * (xx + yy + zz)
        long = 0.5 * (xx + yy) + jnp.sqrt(0.25 * (xx - yy) ** 2 + xy**2) + tiny
        angle = 0.5 * jnp.arctan2(2 * xy, xx - yy + tiny)
        along = (arm[:, 0] * jnp.cos(angle) + arm[:, 1] * jnp.sin(angle)) ** 2 / (3 * long)
        tall = zz > _TALL**2 * long
        phi = jnp.where(tall, arm[:, 2] / jnp.sqrt(3 * (zz + tiny)), along - average(along))
        way = jnp.where(tall, self.velocity / speed, jnp.asarray([0.0, 0.0, 1.0], x.dtype))
        now = average(phi * (v @ way)) / average(phi**2)
        since = time - self.start
        wanted = speed * jnp.exp(-since / FADES) * jnp.cos(RATE * since)
        share = window_fraction(time, dt, self.start, self.end, self.edge)
        return share * (wanted - now) / jnp.maximum(_FOLLOWS, dt) * phi[:, None] * way

    def gradient(self, x, time, dt):
        """None: hardly any across a cell."""
        del x, time, dt
