"""Parts that elastic cases share: a tight grid, and a neo-Hookean body on it."""

from __future__ import annotations

from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np

from benchmarks.cases.base import Numerics
from benchmarks.cases.bodies import body
from physagent_jax.mpm import Grid, Model, NeoHookean, State, lame_parameters

MARGIN = 4
"""Cells from the domain's faces to matter: the particles' wall, half a stencil, and room to swing."""


def grid_for(cells: Sequence[int], dx: float, margin: int = MARGIN) -> Grid:
    """A window for matter of ``cells`` cells per axis whose low corner sits ``margin`` cells from the origin."""
    nx, ny, nz = (int(count) + 2 * margin + 1 for count in cells)
    return Grid(jnp.zeros(3, jnp.int32), (nx, ny, nz), dx, max(nx, ny, nz) - 1)


def wave_speed(E: float, nu: float, rho: float) -> float:
    """c_p = sqrt((lam + 2 mu) / rho) [m/s]."""
    mu, lam = lame_parameters(E, nu)
    return float(np.sqrt((lam + 2 * mu) / rho))


def neo_hookean_body(
    numerics: Numerics, grid: Grid, x: np.ndarray, volume: float, E: float, nu: float, rho: float, **rest
) -> tuple[Model, State]:
    """`bodies.body` of Young's modulus E [Pa], Poisson's ratio nu and rest density rho [kg/m^3]."""
    mu, lam = (jnp.full(len(x), value, numerics.dtype) for value in lame_parameters(E, nu))
    speed = wave_speed(E, nu, rho)
    return body(numerics, grid, x, volume, NeoHookean(mu, lam), rho=rho, speed=speed, **rest)
