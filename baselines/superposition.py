"""Motions added up: what several forces do, from what each does alone.

Displacements of a body that turns do not add: twice a small turn of each particle is a larger body, and would pass for
a stretch. So every motion is taken apart into the way of the mass centre, the turn of the whole, and the change of
shape in the axes that turn with it. Ways and shapes are added as vectors, turns as rotation vectors, which is exact
about one axis; then they are put together again.
"""

from __future__ import annotations

import dataclasses
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.metrics.clips import Clip, find_rotation_vectors, find_rotations
from physagent_jax.mpm.constraints.rotation import rotation_matrix

HEADER = 2
"""Rows before the particles' of what is added up: the way of the centre, and the rotation vector [rad]."""


@partial(jax.tree_util.register_dataclass, data_fields=["x", "centre", "turn", "shape"], meta_fields=[])
@dataclasses.dataclass(frozen=True)
class Base:
    """A motion that others are added to.

    Attributes:
        x: Paths [m], shape (T, n, 3).
        centre: Centre of the mass [m], shape (T, 3).
        turn: Rotation of the whole from the first frame, shape (T, 3, 3).
        shape: Places about the centre in axes that turn with it [m], shape (T, n, 3).
    """

    x: np.ndarray
    centre: np.ndarray
    turn: np.ndarray
    shape: np.ndarray

    @classmethod
    def of(cls, x: np.ndarray, mass: np.ndarray) -> Base:
        """Take paths apart."""
        x, weight = np.asarray(x, np.float32), np.asarray(mass / np.sum(mass), np.float32)
        centre = np.einsum("n,tni->ti", weight, x)
        turn = np.asarray(find_rotations(Clip(x, weight, 1.0).maps(None)))
        return cls(x, centre, turn, np.einsum("tji,tnj->tni", turn, x - centre[:, None]))

    def add(self, motions) -> jax.Array:
        """Paths with a sum of `compare` added, shape (T, n, 3); may be traced.

        Args:
            motions: Shape (T, `HEADER` + n, 3).
        """
        way, turn, shape = motions[:, 0], motions[:, 1], motions[:, HEADER:]
        turned = jax.vmap(rotation_matrix)(turn) @ jnp.asarray(self.turn, motions.dtype)
        return (self.centre + way)[:, None] + jnp.einsum("tij,tnj->tni", turned, self.shape + shape)

    def compare(self, x: np.ndarray, mass: np.ndarray) -> np.ndarray:
        """The difference of paths from these, to be added up, shape (T, `HEADER` + n, 3).

        By less than half a turn, or the other way round is nearer.
        """
        other = Base.of(x, mass)
        turn = find_rotation_vectors(jnp.asarray(other.turn @ np.swapaxes(self.turn, 1, 2)))
        rows = (other.centre - self.centre)[:, None], np.asarray(turn)[:, None], other.shape - self.shape
        return np.concatenate(rows, axis=1)
