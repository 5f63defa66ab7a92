"""Time envelopes: the strength of a term over time.

A substep needs the mean of the profile over [time, time + dt], not its value at one instant: then the
impulses of consecutive substeps add up to the integral of the profile, whatever dt is. All four profiles
have a closed-form mean, so the only error is round-off.
"""

from __future__ import annotations

import dataclasses
import enum
import math

import jax
import jax.numpy as jnp

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm.edges import cut_to_window, window_fraction
from physagent_jax.mpm.fields import EDGE, END, FOREVER, START

Scalar = jax.Array | float


class EnvelopeKind(enum.StrEnum):
    """The shape of a time profile."""

    CONSTANT = "constant"  # 1
    RAMP = "ramp"  # 0 to 1 over `rise`, 1 to 0 over `fall`, straight lines
    PULSE = "pulse"  # sin^2(pi s / T), a bump over the window of length T; its integral is T / 2
    SINE = "sine"  # sin(2 pi frequency s + phase)


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Envelope:
    """A profile of time; 0 outside the window [start, end), in [0, 1] inside it (sine: [-1, 1]).

    The formulas of `EnvelopeKind` count s from ``start``. Make one with `constant`, `ramp`, `pulse` or `sine`.

    Attributes:
        kind: The shape, static.
        start, end: Window [s], scalars.
        rise, fall: Rise and fall of a ramp [s], scalars; 0 = at once. If they do not fit into the window, the
            lines meet
            below 1.
        frequency: Frequency of a sine [Hz], scalar.
        phase: Phase of a sine at ``start`` [rad], scalar.
        edge: Width of the smooth edges of a constant or a sine [s], scalar; None = hard. A ramp and a pulse have none
            but their own.
    """

    kind: EnvelopeKind = dataclasses.field(metadata=dict(static=True))
    start: Scalar = dataclasses.field(metadata=START)
    end: Scalar = dataclasses.field(metadata=END)
    rise: Scalar = 0.0
    fall: Scalar = 0.0
    frequency: Scalar = 0.0
    phase: Scalar = 0.0
    edge: jax.Array | None = dataclasses.field(default=None, metadata=EDGE)

    @property
    def idle_fields(self) -> tuple[str, ...]:
        """Fields that play no part in this kind of profile."""
        used = {
            EnvelopeKind.RAMP: ("rise", "fall"),
            EnvelopeKind.SINE: ("frequency", "phase"),
        }.get(self.kind, ())
        return tuple(name for name in ("rise", "fall", "frequency", "phase") if name not in used)

    @staticmethod
    def constant(start: Scalar = 0.0, end: Scalar = FOREVER) -> Envelope:
        """1 within the window [s]."""
        return Envelope(EnvelopeKind.CONSTANT, start, end)

    @staticmethod
    def ramp(rise: Scalar, fall: Scalar = 0.0, start: Scalar = 0.0, end: Scalar = FOREVER) -> Envelope:
        """Rises linearly over ``rise``, falls linearly over the last ``fall`` of the window; all in [s]."""
        return Envelope(EnvelopeKind.RAMP, start, end, rise=rise, fall=fall)

    @staticmethod
    def pulse(start: Scalar, end: Scalar) -> Envelope:
        """A smooth bump over the window [s]; its integral is half the window's length."""
        return Envelope(EnvelopeKind.PULSE, start, end)

    @staticmethod
    def sine(frequency: Scalar, phase: Scalar = 0.0, start: Scalar = 0.0, end: Scalar = FOREVER) -> Envelope:
        """Swings with ``frequency`` [Hz] from ``phase`` [rad] within the window [s]."""
        return Envelope(EnvelopeKind.SINE, start, end, frequency=frequency, phase=phase)

    def active(self, time: jax.Array, dt: jax.Array) -> jax.Array:
        """The share of the substep [time, time + dt] that lies in the window, scalar."""
        return window_fraction(time, dt, jnp.asarray(self.start), jnp.asarray(self.end), self._own_edge)

    def mean(self, time: jax.Array, dt: jax.Array) -> jax.Array:
        """Mean of the profile over [time, time + dt], scalar; what lies outside the window counts as 0."""
        return self.active(time, dt) * self.mean_while_active(time, dt)

    def mean_while_active(self, time: jax.Array, dt: jax.Array) -> jax.Array:
        """Mean of the profile over the part of [time, time + dt] inside the window, scalar.

        Finite, but without meaning, if no part is.
        """
        begin, stop = time, time + dt
        if self._own_edge is None:
            begin, stop = cut_to_window(time, dt, jnp.asarray(self.start), jnp.asarray(self.end))
        length = jnp.maximum(stop - begin, 0.0)
        middle = 0.5 * (begin + stop) - self.start
        match self.kind:
            case EnvelopeKind.CONSTANT:
                return jnp.ones_like(length)
            case EnvelopeKind.RAMP:
                return self._average_ramp(begin, stop, length)
            case EnvelopeKind.PULSE:
                # sin^2 = (1 - cos) / 2, and the mean of a cosine is that at the middle times a sinc.
                period = self.end - self.start
                return 0.5 - 0.5 * jnp.cos(2 * math.pi * middle / period) * jnp.sinc(length / period)
            case EnvelopeKind.SINE:
                angle = 2 * math.pi * self.frequency * middle + self.phase
                return jnp.sin(angle) * jnp.sinc(self.frequency * length)

    @property
    def _own_edge(self) -> jax.Array | None:
        return self.edge if self.kind in (EnvelopeKind.CONSTANT, EnvelopeKind.SINE) else None

    def _average_ramp(self, begin: jax.Array, stop: jax.Array, length: jax.Array) -> jax.Array:
        """Exact: on each straight piece the mean is the value at the middle of the overlap."""
        sides = self.rise + self.fall
        share = self.rise / jnp.where(sides > 0, sides, 1.0)
        meeting = self.start + share * (self.end - self.start)  # where the two lines would cross
        top = jnp.minimum(self.start + self.rise, meeting)
        edge = jnp.maximum(self.end - self.fall, meeting)

        def overlap(low, high):
            low, high = jnp.clip(begin, low, high), jnp.clip(stop, low, high)
            return high - low, 0.5 * (low + high)

        rising, rising_middle = overlap(self.start, top)
        flat, _ = overlap(top, edge)
        falling, falling_middle = overlap(edge, self.end)
        integral = (
            flat
            + rising * _divide_ramp(rising_middle - self.start, self.rise)
            + falling * _divide_ramp(self.end - falling_middle, self.fall)
        )
        return _divide_ramp(integral, length)


def _divide_ramp(numerator: jax.Array, denominator: Scalar) -> jax.Array:
    """The quotient, and 0 for a denominator of 0, with finite derivatives."""
    positive = jnp.asarray(denominator) > 0
    return jnp.where(positive, numerator / jnp.where(positive, denominator, 1.0), 0.0)
