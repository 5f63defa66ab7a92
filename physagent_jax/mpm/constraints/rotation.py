"""Finite rotations from rotation vectors."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from physagent_jax.mpm.linalg import cross


def rotate(x: jax.Array, rotation_vector: jax.Array) -> jax.Array:
    """Rotate ``x`` (..., 3) by rotation vectors [rad], shape (3,) or (..., 3) (Rodrigues' formula).

    x + sin(t)/t w x x + (1 - cos t)/t^2 w x (w x x) with t = |w|: smooth through w = 0, where its derivative
    is the infinitesimal rotation.
    """
    squared = (rotation_vector**2).sum(-1, keepdims=True)
    small = squared < 1e-4  # where the series is exact to round-off
    angle = jnp.sqrt(jnp.where(small, 1.0, squared))
    first = jnp.where(small, 1 - squared / 6 + squared**2 / 120, jnp.sin(angle) / angle)
    half = jnp.sin(0.5 * angle) / angle
    second = jnp.where(small, 0.5 - squared / 24 + squared**2 / 720, 2 * half**2)
    w = jnp.broadcast_to(rotation_vector, x.shape)
    turned = cross(w, x)
    return x + first * turned + second * cross(w, turned)


def rotation_matrix(rotation_vector: jax.Array) -> jax.Array:
    """The matrices of `rotate`, shape (..., 3, 3)."""
    eye = jnp.broadcast_to(jnp.eye(3, dtype=rotation_vector.dtype), (*rotation_vector.shape, 3))
    return jnp.swapaxes(rotate(eye, rotation_vector[..., None, :]), -1, -2)
