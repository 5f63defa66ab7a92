"""A pull on the two sides of an object: the skill `scale`."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.forces.calibration import STRETCH_FADES
from physagent_jax.forces.terms.rigid import mass_centre, remove_rigid_part
from physagent_jax.mpm.edges import window_fraction
from physagent_jax.mpm.fields import EDGE, END, PER_PARTICLE, START
from physagent_jax.mpm.reductions import sum_particles


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Stretch:
    """Pulls the two sides of the mass centre's plane apart (or together, if negative).

    The field is k sgn((x - x_c) . axis) axis (paper, skill 2) less its rigid part: an object whose halves differ
    would otherwise drift and spin, which a stretch does not ask for. Its momentum and angular
    momentum stay unchanged. The pull grows linearly over ``ramp`` seconds, so that the object follows
    without ringing; it ends at once. Soft matter strains more than linearly, and what is pulled on would tear at its
    weakest section: from a mean strain of `STRETCH_FADES` on the pull fades.

    Attributes:
        axis: Unit vector, shape (3,).
        magnitude: Acceleration on either side [m/s^2], scalar.
        start, end: Window [s], scalars.
        ramp: [s], scalar.
        weight: 1 inside the region, 0 outside, shape (n,); None = everywhere.
        edge: Width of the window's smooth edges [s], scalar; None = hard.
        reach: Mean distance of its mass from the plane at rest [m], scalar; None = the pull never fades.
    """

    axis: jax.Array
    magnitude: jax.Array
    start: jax.Array = dataclasses.field(metadata=START)
    end: jax.Array = dataclasses.field(metadata=END)
    ramp: jax.Array
    weight: jax.Array | None = dataclasses.field(default=None, metadata=PER_PARTICLE)
    edge: jax.Array | None = dataclasses.field(default=None, metadata=EDGE)
    reach: jax.Array | None = None

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        del v
        mass = mass if self.weight is None else mass * self.weight
        growth = jnp.clip((time + 0.5 * dt - self.start) / self.ramp, 0.0, 1.0)
        strength = self.magnitude * growth * window_fraction(time, dt, self.start, self.end, self.edge)
        arm = x - mass_centre(x, mass)
        height = (arm * self.axis).sum(-1)
        side = jnp.sign(height)
        if self.reach is not None:
            strength = strength * jnp.where(
                self.magnitude > 0, self._find_share_left(self.reach, height, mass), 1.0
            )
        field = strength * remove_rigid_part(side[:, None] * self.axis, arm, mass)
        return field if self.weight is None else self.weight[:, None] * field

    @staticmethod
    def _find_share_left(reach: jax.Array, height: jax.Array, mass: jax.Array) -> jax.Array:
        """Share of the pull that is left, from the mean strain that ``height`` [m] above the plane tells, scalar."""
        first, last = STRETCH_FADES
        mean = sum_particles((mass * jnp.abs(height)).sum()) / sum_particles(mass.sum())
        return jnp.clip((last + 1 - mean / reach) / (last - first), 0.0, 1.0)

    def gradient(self, x, time, dt):
        """None: uniform on either side, but for the small rigid part."""
        del x, time, dt
