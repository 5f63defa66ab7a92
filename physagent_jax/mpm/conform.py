"""A model and a state in one precision, and of shapes that fit: what everything that follows may rely on.

The CPU kernels read memory as it is laid out, and JAX computes in the widest precision that it meets: a mass in double
precision beside positions in single would be taken for other numbers by the ones, and change the type of the state in
the other. What decides is the precision of the positions.
"""

from __future__ import annotations

import dataclasses
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer

from physagent_jax.core.arrays import to_device
from physagent_jax.core.errors import UserError
from physagent_jax.mpm.state import Grid, Model, State

PRECISIONS = ("float32", "float64")
_Part = TypeVar("_Part")


def conform(model: Model, state: State) -> tuple[Model, State]:
    """Both in the precision of ``state.x``; arrays that have it already are left alone, and nothing is compiled.

    Raises:
        UserError: Something is no number, or of a shape that does not fit.
    """
    x = _convert_numbers("state.x", state.x)
    dtype = jax.dtypes.canonicalize_dtype(x.dtype)
    if dtype.name not in PRECISIONS:
        raise UserError("positions must be in single or double precision", got=f"state.x of {dtype}")
    _check_sizes(model, state)
    count = len(state.x)

    def real(name: str, shape: tuple[int, ...]) -> Any:
        part, field = (model, name[6:]) if name.startswith("model.") else (state, name[6:])
        return _conform_array(name, getattr(part, field), dtype, shape)

    matrices = (count, 3, 3)
    state = dataclasses.replace(
        state,
        x=real("state.x", (count, 3)),
        v=real("state.v", (count, 3)),
        C=real("state.C", matrices),
        F=real("state.F", matrices),
        time=real("state.time", ()),
        stopped=_conform_array("state.stopped", state.stopped, np.dtype(np.int32), ()),
        history=tuple(
            _conform_per_particle("state.history", past, material.count, dtype)
            for past, material in zip(state.history, model.materials)
        )
        if len(state.history) == len(model.materials)
        else state.history,  # `step` says what is wrong with it
    )
    model = model.replace(
        grid=_conform_grid(model.grid),
        dt=real("model.dt", ()),
        gravity=None if model.gravity is None else real("model.gravity", (3,)),
        mass=real("model.mass", (count,)),
        volume=real("model.volume", (count,)),
        viscosity=None if model.viscosity is None else real("model.viscosity", (count,)),
        damping_rate=None if _is_nothing(model.damping_rate) else real("model.damping_rate", ()),
        materials=tuple(
            _conform_per_particle(type(material).__name__, material, material.count, dtype)
            for material in model.materials
        ),
        forces=_conform_real(model.forces, dtype),
        boundaries=_conform_real(model.boundaries, dtype),
        constraints=_conform_real(model.constraints, dtype),
    )
    return model, state


def as_field(value: Any, like: jax.Array, what: str) -> jax.Array:
    """Convert the result of a user's force, law or boundary to the precision of ``like`` and a fitting shape.

    Raises:
        UserError: It does not fit.
    """
    value = jnp.asarray(value)
    try:
        fits = np.broadcast_shapes(value.shape, like.shape) == like.shape
    except ValueError:
        fits = False
    if not fits or not (
        jnp.issubdtype(value.dtype, jnp.floating) or jnp.issubdtype(value.dtype, jnp.integer)
    ):
        raise UserError(
            f"{what} must be numbers of the shape {like.shape}", got=f"{value.dtype} of {value.shape}"
        )
    return value.astype(like.dtype)


def _check_sizes(model: Model, state: State) -> None:
    sizes = {name: _find_length(getattr(state, name)) for name in ("x", "v", "C", "F")}
    sizes |= {"mass": _find_length(model.mass), "volume": _find_length(model.volume)}
    sizes["materials"] = sum(_count_particles(material) for material in model.materials)
    if model.viscosity is not None:
        sizes["viscosity"] = _find_length(model.viscosity)
    if len(set(sizes.values())) > 1:
        raise UserError(
            "`model` and `state` must speak of the same number of particles",
            got=", ".join(f"{name}: {size}" for name, size in sizes.items()),
        )


def _find_length(value: Any) -> int | None:
    shape = np.shape(value)
    return shape[0] if shape else None


def _count_particles(material: Any) -> int:
    try:
        return int(material.count)
    except (IndexError, AttributeError, TypeError) as error:
        raise UserError(
            f"the parameters of {type(material).__name__} must be arrays with one number per particle"
        ) from error


def _is_nothing(value: Any) -> bool:
    """Return whether it is known to be zero before anything is traced, so that it can be skipped."""
    return value is None or (isinstance(value, float | int) and value == 0)


def _conform_grid(grid: Grid) -> Grid:
    """A grid that a stencil has room in.

    Raises:
        UserError: It has not.
    """
    if len(grid.shape) != 3 or min(grid.shape) < 3 or not 0 < grid.dx < np.inf or grid.cells < 3:
        raise UserError(
            "a grid must have three nodes or more along each axis, and a positive spacing",
            got=f"shape={grid.shape}, dx={grid.dx}, cells={grid.cells}",
        )
    return dataclasses.replace(
        grid, origin=_conform_array("model.grid.origin", grid.origin, np.dtype(np.int32), (3,))
    )


def _convert_numbers(name: str, value: Any) -> Any:
    """``value`` as an array of real numbers.

    Raises:
        UserError: It is none.
    """
    if not hasattr(value, "dtype"):
        try:
            value = jnp.asarray(value)
        except (TypeError, ValueError) as error:
            raise UserError(f"`{name}` must be an array of numbers", got=type(value).__name__) from error
    if not (jnp.issubdtype(value.dtype, jnp.floating) or jnp.issubdtype(value.dtype, jnp.integer)):
        raise UserError(f"`{name}` must be an array of numbers", got=f"an array of {value.dtype}")
    return value


def _conform_array(name: str, value: Any, dtype: np.dtype, shape: tuple[int, ...]) -> Any:
    value = _convert_numbers(name, value)
    if value.shape != shape:
        raise UserError(f"`{name}` must have the shape {shape}", got=value.shape)
    if np.issubdtype(dtype, np.integer) and jnp.issubdtype(value.dtype, jnp.floating):
        raise UserError(f"`{name}` must be whole numbers", got=f"an array of {value.dtype}")
    return _cast(value, dtype)


def _cast(value: Any, dtype: np.dtype) -> Any:
    """``value`` itself if that is its precision. What is known is converted by NumPy (see `to_device`)."""
    if jax.dtypes.canonicalize_dtype(value.dtype) == dtype:
        return value
    return value.astype(dtype) if isinstance(value, Tracer) else to_device(value, dtype)


def _conform_per_particle(name: str, part: _Part, count: int, dtype: np.dtype) -> _Part:
    """A material, or what it remembers, with arrays of one number per particle, or one for all."""

    def convert(path, leaf):
        if isinstance(leaf, float | int) or jnp.issubdtype(getattr(leaf, "dtype", float), jnp.bool_):
            return leaf
        leaf = _convert_numbers(name + jax.tree_util.keystr(path), leaf)
        if leaf.ndim == 1 and len(leaf) != count:
            raise UserError(
                f"`{name}{jax.tree_util.keystr(path)}` must have one number per particle of its block, {count}",
                got=len(leaf),
            )
        return _cast(leaf, dtype)

    return jax.tree_util.tree_map_with_path(convert, part)


def _conform_real(parts: _Part, dtype: np.dtype) -> _Part:
    """Forces, boundaries or constraints; what they hold beside real numbers, such as indices, is their own affair."""

    def convert(leaf):
        return _cast(leaf, dtype) if jnp.issubdtype(getattr(leaf, "dtype", bool), jnp.floating) else leaf

    return jax.tree.map(convert, parts)
