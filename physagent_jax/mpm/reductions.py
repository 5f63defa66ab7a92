"""Sums and extremes over all particles, wherever they are.

Whatever is reduced over particles goes through here, because they may be split over devices: `Model.axis` names the
mesh axis (`mpm.sharding` sets it). Where it is None, nothing is done and nothing compiled.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

import jax
import jax.numpy as jnp

from physagent_jax.core.errors import UserError

_split: ContextVar[str | None] = ContextVar("split", default=None)


@contextmanager
def split_over(axis: str | None) -> Iterator[None]:
    """Let ``axis`` hold for what is traced within, where no `Model` is at hand (`sum_particles`)."""
    token = _split.set(axis)
    try:
        yield
    finally:
        _split.reset(token)


def sum_particles(value: jax.Array) -> jax.Array:
    """The sum over all particles, from that over the particles at hand; for body forces."""
    return sum_devices(value, _split.get())


def sum_devices(value: jax.Array, axis: str | None) -> jax.Array:
    """``value`` summed over the devices along ``axis``; differentiable."""
    return value if _check_axis(axis) is None else jax.lax.psum(value, axis)


def find_mass_centre(x: jax.Array, mass: jax.Array, axis: str | None) -> jax.Array:
    """Centre of ``mass`` (n,) [kg] at ``x`` [m], shape (n, 3), on all devices along ``axis``; zero where none is."""
    sums = sum_devices(jnp.concatenate([mass[:, None] * x, mass[:, None]], axis=1).sum(0), axis)
    return sums[:3] / jnp.where(sums[3] > 0, sums[3], 1)


def min_devices(value: jax.Array, axis: str | None) -> jax.Array:
    """The least ``value`` of the devices along ``axis``, a constant to derivatives."""
    return value if _check_axis(axis) is None else jax.lax.pmin(jax.lax.stop_gradient(value), axis)


def max_devices(value: jax.Array, axis: str | None) -> jax.Array:
    """The greatest ``value`` of the devices along ``axis``, a constant to derivatives."""
    return value if _check_axis(axis) is None else jax.lax.pmax(jax.lax.stop_gradient(value), axis)


def all_devices(value: jax.Array, axis: str | None) -> jax.Array:
    """Return whether the boolean ``value`` is true on all devices along ``axis``."""
    return value if _check_axis(axis) is None else sum_devices((~value).astype(jnp.int32), axis) == 0


def _check_axis(axis: str | None) -> str | None:
    """``axis``, once it is known to exist.

    Raises:
        UserError: There is no such axis where this is traced.
    """
    if axis is not None:
        try:
            jax.lax.axis_size(axis)
        except NameError:
            raise UserError(
                f"`Model.axis` is {axis!r}, but there is no such mesh axis here",
                do="Use `mpm.rollout_sharded`, which sets it, or call within `jax.shard_map`",
            ) from None
    return axis
