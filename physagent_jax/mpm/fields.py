"""Metadata of the fields of models, states and their parts.

Sorting, splitting over devices, and leaving out what does not act go by these marks. A part of one's own carries them
as the built-in ones do: ``weight: jax.Array | None = dataclasses.field(default=None, metadata=PER_PARTICLE)``.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

import jax
import numpy as np

PER_PARTICLE: Mapping[str, Any] = dict(per="particle")
"""One entry per particle of the simulation, along the first axis."""

PER_BLOCK: Mapping[str, Any] = dict(per="block")
"""A tuple with a pytree per material, whose arrays have one entry per particle of that material's block."""

PER_HELD: Mapping[str, Any] = dict(per="held")
"""One entry per particle that a constraint holds, or a scalar for all of them."""

HELD: Mapping[str, Any] = dict(per="held", indices=True)
"""Indices of the particles that a constraint holds."""

COUNT: Mapping[str, Any] = dict(static=True, count=True)
"""Number of particles of a material that has no arrays to tell it; belongs to the structure."""

DRAWN: Mapping[str, Any] = dict(drawn=True)
"""Drawn or sampled: stands for a shape as a whole, and is no number that anybody would vary."""

UNIT: Mapping[str, Any] = dict(unit=True)
"""A direction: a unit vector, shape (3,)."""

FOREVER = 1e9
"""[s]; the end of a window that never closes."""

START: Mapping[str, Any] = dict(window="start")
END: Mapping[str, Any] = dict(window="end")
"""Bounds of the time in which a part acts [s]; outside [start, end) it changes nothing."""
EDGE: Mapping[str, Any] = dict(window="edge")
"""Width of the smooth edges that the windows of a part have [s], half of it outside (`mpm.edges`); None = none."""


def find_owner(part: Any, path: tuple) -> str | None:
    """Of what a leaf has one entry each: "particle", "block" or "held"; None = of nothing that is counted.

    Args:
        part: A pytree.
        path: To the leaf, as `jax.tree_util.tree_map_with_path` has it. The outermost mark counts.
    """
    for key in path:
        if isinstance(key, jax.tree_util.GetAttrKey):
            per = _find_metadata(part, key.name).get("per")
            if per is not None:
                return per
            part = getattr(part, key.name)
        elif isinstance(key, jax.tree_util.SequenceKey):
            part = part[key.idx]
        elif isinstance(key, jax.tree_util.DictKey):
            part = part[key.key]
        else:  # a node of somebody's own, which does not say what lies where
            return None
    return None


def find_fields(part: Any, **mark: Any) -> tuple[str, ...]:
    """The names of a dataclass's own fields whose metadata has all of ``mark``."""
    return _find_marked(type(part), frozenset(mark.items())) if dataclasses.is_dataclass(part) else ()


def iterate_windows(part: Any) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Start and end [s] of every window of ``part`` and of the dataclasses in its fields, edges included.

    On the host: this is asked for every frame, and operations of a device would take longer than all else.
    """
    edges = [
        np.asarray(edge) for name in find_fields(part, **EDGE) if (edge := getattr(part, name)) is not None
    ]
    room = 0.5 * max(edges, default=0.0)
    for start, end in zip(find_fields(part, **START), find_fields(part, **END)):
        yield np.asarray(getattr(part, start)) - room, np.asarray(getattr(part, end)) + room
    for field in _list_fields(part):
        yield from iterate_windows(getattr(part, field.name))


@cache
def _find_marked(kind: type, mark: frozenset[tuple[str, Any]]) -> tuple[str, ...]:
    """As `find_fields`; looked up for every frame of a simulation."""
    return tuple(field.name for field in dataclasses.fields(kind) if mark <= field.metadata.items())


def _list_fields(part: Any) -> tuple[dataclasses.Field, ...]:
    return dataclasses.fields(part) if dataclasses.is_dataclass(part) else ()


def _find_metadata(part: Any, name: str) -> Mapping[str, Any]:
    return next((field.metadata for field in _list_fields(part) if field.name == name), {})
