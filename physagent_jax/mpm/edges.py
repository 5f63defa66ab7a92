"""Windows of time, hard ones and such with smooth edges.

What acts within [start, end) is a step function of both bounds. The mean over a substep makes the impulse of a force a
smooth function of them; what is done to particles and nodes, and a blow at a moment, stay steps, with a derivative of
zero. With an edge of width w [s] a window opens and closes by

    S(u) = s^2 (3 - 2 s),   s = clip(u + 1/2, 0, 1),   u = (t - bound) / w

about its bounds instead: everything has a derivative by the window, and as w -> 0 the motion becomes that of the hard
one. The integral over the window is kept. Before the clip there is nothing, so that an edge is no wider than twice the
time that its bound comes after the beginning. A part (a force, a constraint) says in a field marked EDGE how wide its
edges are; None = hard, and nothing of this is computed.
"""

from __future__ import annotations

import dataclasses
from typing import Any, TypeVar

import jax
import jax.numpy as jnp

from physagent_jax.mpm.fields import EDGE, find_fields

_Part = TypeVar("_Part")


def window_fraction(
    time: jax.Array, dt: jax.Array, start: jax.Array, end: jax.Array, edge: jax.Array | None = None
) -> jax.Array:
    """The share of the substep [time, time + dt] that lies in [start, end), by the smooth window if it has an edge.

    Consecutive substeps telescope, so an impulse delivers exactly its total whatever dt is.
    """
    if edge is not None:
        opened, closed = (_integrate_step(time, dt, bound, edge) for bound in (start, end))
        return (opened - closed) / dt
    begin, stop = cut_to_window(time, dt, start, end)
    share = (stop - begin) / dt
    return jnp.where(share > 0, jnp.where(share > 1, 1.0, share), 0.0)


def cut_to_window(
    time: jax.Array, dt: jax.Array, start: jax.Array, end: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Begin and end [s] of the part of [time, time + dt] that lies in [start, end); in reverse order if none does.

    A bound that falls on that of a substep belongs to the one inside the window, so that a window from the clip's
    beginning on has the derivative of one that begins later: earlier there is nothing.
    """
    after = time + dt
    return jnp.where(start >= time, start, time), jnp.where(end <= after, end, after)


def window_value(time: jax.Array, start: jax.Array, end: jax.Array, edge: jax.Array) -> jax.Array:
    """The opening of a smooth window at ``time``, in [0, 1]; of the shape of ``start`` and ``end``."""
    return step_value(time, start, edge) - step_value(time, end, edge)


def step_value(time: jax.Array, bound: jax.Array, edge: jax.Array) -> jax.Array:
    """S at ``time`` [s] of a step about ``bound`` [s]."""
    width, some = _find_width(bound, edge)
    s = jnp.clip((time - bound) / width + 0.5, 0.0, 1.0)
    return jnp.where(some, s * s * (3 - 2 * s), jnp.where(time >= bound, 1.0, 0.0))


def set_edges(parts: tuple[_Part, ...], edge: Any) -> tuple[_Part, ...]:
    """``parts`` with edges of the width ``edge`` [s], scalar, in all of their windows that can have some."""
    return tuple(_set_edge(part, edge) for part in parts)


def _set_edge(part: Any, edge: Any) -> Any:
    changes = {name: edge for name in find_fields(part, **EDGE)}
    for field in dataclasses.fields(part):
        inner = getattr(part, field.name)
        if dataclasses.is_dataclass(inner):
            changes[field.name] = _set_edge(inner, edge)
    return dataclasses.replace(part, **changes) if changes else part


def _find_width(bound: jax.Array, edge: jax.Array) -> tuple[jax.Array, jax.Array]:
    """The edge's width at ``bound`` [s], and whether it has any."""
    width = jnp.minimum(edge, 2 * jnp.maximum(bound, 0.0))
    some = width > 0
    return jnp.where(some, width, 1.0), some


def _integrate_step(time: jax.Array, dt: jax.Array, bound: jax.Array, edge: jax.Array) -> jax.Array:
    """The integral of S over [time, time + dt] [s]."""
    width, some = _find_width(bound, edge)

    def antiderivative(t):
        s = jnp.clip((t - bound) / width + 0.5, 0.0, 1.0)
        return width * s**3 * (1 - 0.5 * s) + jnp.where(t > bound + 0.5 * width, t - bound - 0.5 * width, 0.0)

    begin, stop = cut_to_window(time, dt, bound, jnp.asarray(jnp.inf, bound.dtype))
    hard = jnp.where(stop > begin, stop - begin, 0.0)
    return jnp.where(some, antiderivative(time + dt) - antiderivative(time), hard)
