"""The order of particles in memory.

Neighbours in space that are neighbours in memory find their nodes in the processor's caches, and threads with
contiguous shares of the particles touch few of the same planes of the grid. A solid keeps its neighbours, so that
sorting it once, at rest, pays for the whole run; what flows is sorted again when it has mixed.
"""

from __future__ import annotations

from functools import partial
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.mpm import kernels
from physagent_jax.mpm.fields import find_owner
from physagent_jax.mpm.state import Model, State

MIXED = 0.25  # share of neighbours in memory that are no neighbours in space, from which sorting pays
_SAMPLED = 16  # particles per pair that is looked at
_Part = TypeVar("_Part", Model, State)


def cell_order(x: np.ndarray, dx: float, group: np.ndarray | None = None) -> np.ndarray:
    """The particles' indices, cell by cell, the cells in the grid's own order in memory.

    Args:
        x: Positions [m], shape (n, 3).
        dx: Spacing of the grid [m].
        group: Particles of equal group stay together, the groups in ascending order; shape (n,). Materials need this
            (`Model.materials`). None = one group.

    Returns:
        Shape (n,). Particles of the same cell keep their order.
    """
    i, j, k = np.floor(np.asarray(x) / dx).astype(np.int64).T
    keys = (k, j, i) if group is None else (k, j, i, np.asarray(group))
    return np.lexsort(keys)


def update_order(order: np.ndarray | None, model: Model, state: State) -> np.ndarray | None:
    """The order in which particles had better lie for the coming frame: ``order`` until they have mixed.

    Only the kernels gain by it. A model with constraints, which name their particles, or with forces of its own
    numbers per particle keeps its order.

    Args:
        order: The present one: a particle in each place, shape (n,); None = as they are.
        model: Particles as they are.
        state: The state of the same particles.
    """
    if (
        not (kernels.use_cpu(model.kernels) or kernels.use_cuda(model.kernels))
        or model.constraints
        or _has_particle_fields(model.forces, len(state.x))
    ):
        return order
    x = np.asarray(state.x)
    pairs = _sample_pairs(order, len(x))
    rows = np.floor(x[pairs][..., :2] / model.grid.dx)
    if np.mean(np.abs(rows[0] - rows[1]).max(-1) > 1) <= MIXED:
        return order
    counts = [material.count for material in model.materials]
    return cell_order(x, model.grid.dx, np.repeat(np.arange(len(counts)), counts))


def _sample_pairs(order: np.ndarray | None, count: int) -> np.ndarray:
    """Some particles, and those that come next in memory, shape (2, m)."""
    first = np.arange(0, count - 1, _SAMPLED)
    places = np.stack([first, first + 1])
    return places if order is None else order[places]


def _has_particle_fields(forces: tuple[Any, ...], count: int) -> bool:
    """Return whether a force has numbers per particle, or may have: an unmarked array as long as there are any."""

    def own(path, leaf):
        return find_owner(forces, path) == "particle" or (jnp.ndim(leaf) > 0 and len(leaf) == count)

    return any(jax.tree.leaves(jax.tree.map_with_path(own, forces)))


def permute_particles(order: np.ndarray | None, model: Model, state: State) -> tuple[Model, State]:
    """Both with their particles in that order."""
    if order is None:
        return model, state
    counts = tuple(material.count for material in model.materials)
    return _permute(model, order, counts), _permute(state, order, counts)


def unpermute_particles(order: np.ndarray | None, model: Model, state: State) -> State:
    """A state of `permute_particles` with its particles as they were."""
    if order is None:
        return state
    back = np.empty_like(order)
    back[order] = np.arange(len(order))
    return _permute(state, back, tuple(material.count for material in model.materials))


@partial(jax.jit, static_argnames="counts")
def _permute(part: _Part, order: jax.Array, counts: tuple[int, ...]) -> _Part:
    starts = np.cumsum((0, *counts))

    def take(path, leaf):
        own = find_owner(part, path)
        if own == "block" and jnp.ndim(leaf):
            first, last = starts[path[1].idx : path[1].idx + 2]
            return leaf[order[first:last] - first] if len(leaf) == last - first else leaf
        return leaf[order] if own == "particle" else leaf

    return jax.tree.map_with_path(take, part)
