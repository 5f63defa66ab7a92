"""The numbers of a model's part that can be varied, apart from what they are the numbers of.

A part (a force term, a constraint) is a pytree of which some leaves are numbers that a gradient may move, and others
say where it acts or how its field was drawn. `take_numbers` keeps the first alone, as a part of the same class with
None in place of the others; `put_numbers` gives a part other numbers. What is what, the fields' metadata say
(`mpm.fields`).
"""

from __future__ import annotations

import dataclasses
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer

from physagent_jax.core.arrays import to_device
from physagent_jax.mpm.fields import DRAWN, EDGE, END, FOREVER, UNIT

_Part = TypeVar("_Part")
_EXACT = 1e-6  # by which the square of a unit vector's length may be off: round-off, which is left as it is


def take_numbers(part: _Part) -> _Part:
    """``part`` with nothing but its numbers, in double precision on the host; the rest is None.

    Left out are what there is one of per particle, what is drawn or sampled, what has no effect (the field
    ``idle_fields`` of a part names those), and the end of a window that never closes.
    """
    idle = getattr(part, "idle_fields", ())
    kept = {}
    for field in _list_data(part):
        value = getattr(part, field.name)
        if dataclasses.is_dataclass(value):
            kept[field.name] = take_numbers(value)
        elif field.name in idle or not _is_number(field, value):
            kept[field.name] = None
        else:
            kept[field.name] = read_number(value)
    return dataclasses.replace(part, **kept)  # type: ignore[type-var]


def put_numbers(part: _Part, numbers: _Part | None, dtype: Any) -> _Part:
    """``part`` with ``numbers`` instead of its own, traced or not; where they are None it keeps its own.

    Directions are made unit vectors.

    Args:
        part: A registered dataclass.
        numbers: Numbers of the same class, as `take_numbers` makes them.
        dtype: Type of the numbers that the part gets.
    """
    if numbers is None:
        return part
    changed = {}
    for field in _list_data(part):
        own, given = getattr(part, field.name), getattr(numbers, field.name)
        if given is None:
            continue
        if dataclasses.is_dataclass(own):
            changed[field.name] = put_numbers(own, given, dtype)
        else:
            given = normalise(given) if UNIT.items() <= dict(field.metadata).items() else given
            changed[field.name] = cast(given, dtype)
    return dataclasses.replace(part, **changed)  # type: ignore[type-var]


def read_number(value: Any) -> Any:
    """``value`` in double precision on the host, unless it is traced."""
    return value if isinstance(value, Tracer) else np.asarray(value, np.float64)


def cast(value: Any, dtype: Any) -> jax.Array:
    """``value``, traced or not, as an array of ``dtype``."""
    return value.astype(dtype) if isinstance(value, Tracer) else to_device(value, dtype)


def normalise(direction: Any) -> Any:
    """A unit vector, shape (3,); one that is known and has unit length but for round-off stays as it is."""
    if isinstance(direction, Tracer):
        return direction / jnp.linalg.norm(direction)
    length = np.linalg.norm(direction)
    return direction if abs(length**2 - 1) < _EXACT else np.asarray(direction, np.float64) / length


def _is_number(field: dataclasses.Field, value: Any) -> bool:
    """Return whether a field's value is one that may be varied."""
    if value is None or not jnp.issubdtype(getattr(value, "dtype", float), jnp.floating):
        return False
    marks = dict(field.metadata)
    if any(mark.items() <= marks.items() for mark in (DRAWN, EDGE)) or (
        "per" in marks and np.ndim(value) > 0
    ):
        return False
    closes = not END.items() <= marks.items() or isinstance(value, Tracer)
    return closes or bool(np.all(np.asarray(value) < FOREVER))


def _list_data(part: Any) -> list[dataclasses.Field]:
    return [field for field in dataclasses.fields(part) if field.init and not field.metadata.get("static")]
