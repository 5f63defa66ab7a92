"""A manufactured standing wave in a cube between slip walls."""

from __future__ import annotations

from typing import Literal

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.cases.base import Numerics, Problem, Signal, lattice
from benchmarks.cases.bodies import half_space
from benchmarks.cases.elastic import MARGIN, grid_for, neo_hookean_body
from benchmarks.cases.manufactured import ManufacturedForce, distance_from, positions, set_in_motion
from physagent_jax.mpm import Contact, lame_parameters
from physagent_jax.mpm.boundaries import SymmetryPlane

_E, _NU, _RHO, _AMPLITUDE = 1e4, 0.3, 1.0, 0.05
_MU, _LAM = lame_parameters(_E, _NU)
_SPEED = float(np.sqrt(_E / _RHO))
_DURATION = 2 / _SPEED  # one period of the standing wave


def cube_motion(X: jax.Array, t: jax.Array) -> jax.Array:
    """Rest position to position [m]: u_i = A sin(pi X_i) sin(pi (phi_i + c t)) in the unit cube."""
    return X + _compute_displacement(X, t)


def cube_force(X: jax.Array, t: jax.Array) -> jax.Array:
    """Body force [m/s^2] that holds the cube to `cube_motion` (Wallstedt & Guilkey 2008)."""
    F = 1 + _AMPLITUDE * jnp.pi * jnp.cos(jnp.pi * X) * _compute_swing(X, t)
    stress = (_LAM * (jnp.log(F.prod()) - 1) - _MU) / (_RHO * F**2)
    return jnp.pi**2 * _compute_displacement(X, t) * (_MU / _RHO - _SPEED**2 - stress)


def _compute_displacement(X: jax.Array, t: jax.Array) -> jax.Array:
    return _AMPLITUDE * jnp.sin(jnp.pi * X) * _compute_swing(X, t)


def _compute_swing(X: jax.Array, t: jax.Array) -> jax.Array:
    phase = jnp.asarray([0, 2 / 3, 4 / 3], X.dtype)
    return jnp.sin(jnp.pi * (phase + _SPEED * t))


class AxisAligned:
    """Each coordinate of a neo-Hookean cube swings by itself, held by slip walls on all six faces.

    ``resolution`` counts cells along a side. RMS displacement errors after one period (0.02 s), relative to the
    amplitude, in per cent; Courant number 0.3, 8 particles per cell, float64:

    | cells | slip, MLS | slip, gradient form | mirror, MLS | mirror, gradient form |
    |---|---|---|---|---|
    | 8 | 30.1 | 51.1 | 6.5 | 8.2 |
    | 16 | 13.8 | 24.4 | 1.65 | 2.1 |

    Slip walls zero the nodes at and behind them, which makes the scheme first order (1.1 here); planes of symmetry
    make it second order (2.0), and eight times as accurate at 16 cells.
    """

    name = "axis-aligned"
    title = "manufactured wave in a cube between frictionless walls: displacement error after a period"
    source = "manufactured solution of Wallstedt and Guilkey 2008"
    resolutions = (8, 12, 16)

    def __init__(self, walls: Literal["mirror", "slip"] = "mirror"):
        self.walls = walls

    def problem(self, numerics: Numerics) -> Problem:
        """One period in time; particles start displaced, because the phases of the axes differ."""
        cells = numerics.resolution or 16
        dx = 1 / cells
        X = lattice((cells,) * 3, dx, (0.0,) * 3, numerics.per_axis)
        low = MARGIN * dx
        model, state = neo_hookean_body(
            numerics,
            grid_for((cells,) * 3, dx),
            positions(cube_motion, X, [0.0])[0] + low,
            (dx / numerics.per_axis) ** 3,
            _E,
            _NU,
            _RHO,
            forces=(ManufacturedForce(jnp.asarray(X, numerics.dtype), cube_force),),
            boundaries=tuple(
                self._make_wall(axis, node, side, dx, numerics.dtype)
                for axis in range(3)
                for node, side in ((MARGIN, 1), (MARGIN + cells, -1))
            ),
        )
        dt = float(model.dt)
        steps = max(1, round(_DURATION / dt))
        exact = positions(cube_motion, X, [steps * dt]) + low
        state = set_in_motion(state, cube_motion, X, dt)
        return Problem(model, state, steps, steps, distance_from(exact), {})

    def _make_wall(self, axis: int, node: int, side: int, dx: float, dtype):
        if self.walls == "mirror":
            return SymmetryPlane(jnp.asarray(node, jnp.int32), axis, side)
        normal = (side * np.eye(3)[axis]).tolist()
        return half_space(np.full(3, node * dx).tolist(), normal, Contact.SLIP, dtype)

    def judge(self, problem: Problem, signal: Signal) -> dict[str, float]:
        """RMS distance from the exact positions over the amplitude."""
        return {"displacement": float(signal.values[0, 0]) / _AMPLITUDE}

    def bars(self, numerics: Numerics) -> dict[str, float]:
        """1.3 times what we measure: a bar against change for the worse."""
        cells = numerics.resolution or 16
        if self.walls == "mirror":
            return {"displacement": 1.3 * {"mls": 4.22, "gradient": 5.38}[numerics.stress_form] / cells**2}
        return {"displacement": 1.3 * {"mls": 2.4, "gradient": 4.1}[numerics.stress_form] / cells}
