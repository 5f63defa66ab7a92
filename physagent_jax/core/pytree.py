"""Dataclasses as JAX pytrees that never pass for each other."""

from __future__ import annotations

import dataclasses
from typing import Any, TypeVar

import jax

T = TypeVar("T")


def register_dataclass(cls: type[T]) -> type[T]:
    """Register a dataclass as a pytree; fields with ``metadata=dict(static=True)`` belong to its structure.

    In place of `jax.tree_util.register_dataclass`, whose tree structures compare equal (in jaxlib 0.10.1)
    for different classes with the same field names and static values. A jitted function then finds, when
    their hashes share a slot, what it compiled for the other class: a neo-Hookean body that moves like a
    fixed-corotated one, now and then. Nodes registered with functions of their own compare the class.
    """
    fields: Any = [field for field in dataclasses.fields(cls) if field.init]  # type: ignore[arg-type]
    data = [field.name for field in fields if not field.metadata.get("static")]
    static = [field.name for field in fields if field.metadata.get("static")]

    def flatten_with_keys(instance):
        children = tuple((jax.tree_util.GetAttrKey(name), getattr(instance, name)) for name in data)
        return children, tuple(getattr(instance, name) for name in static)

    def flatten(instance):
        return tuple(getattr(instance, name) for name in data), tuple(getattr(instance, n) for n in static)

    def unflatten(values, children):
        return cls(**dict(zip(data, children)), **dict(zip(static, values)))

    jax.tree_util.register_pytree_with_keys(cls, flatten_with_keys, unflatten, flatten)
    return cls
