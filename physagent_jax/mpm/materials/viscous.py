"""Viscosity beside a material's own stress: of liquids, and as Kelvin-Voigt damping of solids."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from physagent_jax.mpm.linalg import determinant, transpose


def viscous_stress(viscosity: jax.Array, C: jax.Array, F: jax.Array) -> jax.Array:
    """Newtonian Kirchhoff stress 2 eta J dev(sym grad v) [Pa], shape (n, 3, 3).

    Args:
        viscosity: eta [Pa s], shape (n,).
        C: The particles' velocity gradients [1/s], shape (n, 3, 3).
        F: Their deformation gradients, shape (n, 3, 3).
    """
    D = 0.5 * (C + transpose(C))
    mean = (D[:, 0, 0] + D[:, 1, 1] + D[:, 2, 2])[:, None, None] / 3
    deviator = D - mean * jnp.eye(3, dtype=D.dtype)
    return (2 * viscosity * determinant(F))[:, None, None] * deviator
