"""Seeded turbulence."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.forces.envelope import Envelope, Scalar
from physagent_jax.forces.regions import confine
from physagent_jax.mpm.fields import DRAWN, PER_PARTICLE

_HIGHEST = jax.lax.Precision.HIGHEST  # phases of many radians do not survive a shortened mantissa


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Turbulence:
    """A random, smooth, divergence-free field: a sum of N Fourier modes (Kraichnan 1970, Phys. Fluids 13:22).

        a = strength sqrt(2 / N) sum_i e_i cos(k_i . x / length_scale + w_i t / time_scale + phase_i)

    Each e_i is a unit vector across k_i, so that every mode is free of divergence. `from_seed` draws the
    modes such that, on average over seeds, the field is isotropic, |a| has the root mean square ``strength``,
    and with q = (distance / length_scale)^2 / 2 the correlation of the component along the line between two
    points is exp(-q), of one across it (1 - q) exp(-q), and in time exp(-(lag / time_scale)^2 / 2).

    A cost of N sines per particle and substep. The phase is taken at the middle of the substep.

    Attributes:
        strength: Root mean square of |a| [m/s^2], scalar.
        length_scale: Correlation length [m], scalar.
        time_scale: Correlation time [s], scalar.
        wave_vectors: k_i, in units of 1 / length_scale, shape (N, 3).
        polarisations: e_i, shape (N, 3).
        frequencies: w_i, in units of 1 / time_scale, shape (N,).
        phases: [rad], shape (N,).
        envelope: Time profile.
        weight: 1 inside the region, 0 outside, shape (n,); None = everywhere.
    """

    strength: Scalar
    length_scale: Scalar
    time_scale: Scalar
    wave_vectors: jax.Array = dataclasses.field(metadata=DRAWN)
    polarisations: jax.Array = dataclasses.field(metadata=DRAWN)
    frequencies: jax.Array = dataclasses.field(metadata=DRAWN)
    phases: jax.Array = dataclasses.field(metadata=DRAWN)
    envelope: Envelope
    weight: jax.Array | None = dataclasses.field(default=None, metadata=PER_PARTICLE)

    @staticmethod
    def from_seed(
        seed: int,
        *,
        strength: Scalar,
        length_scale: Scalar,
        time_scale: Scalar,
        envelope: Envelope,
        modes: int = 32,
        weight: jax.Array | None = None,
        dtype: Any = jnp.float32,
    ) -> Turbulence:
        """The field of a seed; the same seed and number of modes give the same field.

        Args:
            seed: Non-negative.
            strength: Root mean square of the acceleration [m/s^2].
            length_scale: Correlation length [m].
            time_scale: Correlation time [s].
            envelope: Time profile.
            modes: N.
            weight: 1 inside the region, 0 outside, shape (n,); None = everywhere.
            dtype: Type of the modes.
        """
        rng = np.random.default_rng(seed)
        heading = _normalise(rng.standard_normal((modes, 3)))
        # |k| from the energy spectrum k^4 exp(-k^2 / 2): the length of a normal vector in five dimensions.
        number = np.linalg.norm(rng.standard_normal((modes, 5)), axis=1)
        polarisation = _normalise(np.cross(heading, rng.standard_normal((modes, 3))))
        return Turbulence(
            strength,
            length_scale,
            time_scale,
            wave_vectors=jnp.asarray(number[:, None] * heading, dtype),
            polarisations=jnp.asarray(polarisation, dtype),
            frequencies=jnp.asarray(rng.standard_normal(modes), dtype),
            phases=jnp.asarray(rng.uniform(0, 2 * np.pi, modes), dtype),
            envelope=envelope,
            weight=weight,
        )

    def acceleration(self, x, v, mass, time, dt):
        """Mean over the substep [m/s^2], shape (n, 3)."""
        del v, mass
        waves = jnp.cos(self._compute_phase(x, time, dt))
        field = self._compute_amplitude(time, dt) * jnp.matmul(waves, self.polarisations, precision=_HIGHEST)
        return confine(field, self.weight)

    def gradient(self, x, time, dt):
        """d acceleration / d x [1/s^2], shape (n, 3, 3)."""
        slopes = jnp.sin(self._compute_phase(x, time, dt))
        dyads = (self.polarisations[:, :, None] * self.wave_vectors[:, None, :]).reshape(-1, 9)
        tangent = jnp.matmul(slopes, dyads, precision=_HIGHEST).reshape(-1, 3, 3)
        return confine(-self._compute_amplitude(time, dt) / self.length_scale * tangent, self.weight)

    def _compute_phase(self, x: jax.Array, time: jax.Array, dt: jax.Array) -> jax.Array:
        """Of every mode at every particle [rad], shape (n, N)."""
        place = jnp.matmul(x / self.length_scale, self.wave_vectors.T, precision=_HIGHEST)
        return place + ((time + 0.5 * dt) / self.time_scale) * self.frequencies + self.phases

    def _compute_amplitude(self, time: jax.Array, dt: jax.Array) -> jax.Array:
        return self.strength * self.envelope.mean(time, dt) * (2 / len(self.phases)) ** 0.5


def _normalise(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
