"""A swirl in a free disk of fluid dies out by viscosity alone."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from scipy.special import j0, j1, jn_zeros

from benchmarks.cases.base import Numerics, Problem, Signal, observed_steps
from benchmarks.cases.bodies import body
from benchmarks.cases.plane import sheet, sheet_grid, side_walls
from physagent_jax.mpm import Fluid

_RHO, _NU, _RADIUS = 1000.0, 1.0, 1.0  # _NU: kinematic viscosity eta / rho [m^2/s]
_SOUND = 10.0  # [m/s]
_SPEED = 1e-2  # amplitude [m/s]: a thousandth of the sound speed, and less than a hundredth of a cell in all
_MARGIN = 4  # cells
_LIFETIMES = 1.5

WAVE_NUMBER = float(jn_zeros(2, 1)[0]) / _RADIUS
"""kappa [1/m]: J2(kappa R) = 0 makes the free edge free of shear."""


class Swirl:
    """v_theta = J1(kappa r) decays as exp(-eta kappa^2 t / rho), kappa R = 5.136.

    J1(kappa r) e_theta is an eigenfunction of the Laplacian without divergence, and its shear stress
    eta r d/dr (v / r) = -eta kappa J2(kappa r) vanishes at the edge: no walls, no period, no pressure.

    ``resolution`` counts cells along the radius. The step is viscous: the Courant number is taken of 6 nu / dx,
    the speed at which shear spreads over a cell, where that exceeds the sound speed. The decay is too fast by
    (Courant number 0.3, float64) 6.8 % (8 cells), 4.5 % (12), 2.2 % (16), 1.3 % (24). Part of that is APIC's own,
    per step: with 16 cells 6.4 % at half the step, 0.1 % at twice.
    """

    name = "swirl"
    title = "viscous decay of a swirl in a free disk"
    source = "Navier-Stokes equations at small amplitude: v_theta = J1(kappa r) exp(-nu kappa^2 t)"
    resolutions = (8, 16, 24)

    def problem(self, numerics: Numerics) -> Problem:
        """One and a half lifetimes."""
        cells = numerics.resolution or 16
        dx = _RADIUS / cells
        x = sheet((2 * cells, 2 * cells), dx, (_MARGIN * dx, _MARGIN * dx), numerics.per_axis)
        offset = x - np.array([1.0, 0.0, 1.0]) * (_MARGIN * dx + _RADIUS)
        offset[:, 1] = 0
        inside = np.linalg.norm(offset, axis=-1) < _RADIUS
        x, offset = x[inside], offset[inside]
        v, C = swirl(offset)
        model, state = body(
            numerics,
            sheet_grid(2 * (cells + _MARGIN), 2 * (cells + _MARGIN), dx),
            x,
            dx * (dx / numerics.per_axis) ** 2,
            Fluid(jnp.full(len(x), _RHO * _SOUND**2, numerics.dtype), tension=True),
            rho=_RHO,
            speed=max(_SOUND, 6 * _NU / dx),
            v=_SPEED * v,
            C=_SPEED * C,
            boundaries=side_walls(dx, numerics.dtype),
            viscosity=jnp.full(len(x), _RHO * _NU, numerics.dtype),
        )
        rate = _NU * WAVE_NUMBER**2
        steps, every = observed_steps(_LIFETIMES / rate, float(model.dt), 100)
        mode = (v / ((v**2).sum() * _SPEED)).astype(numerics.dtype)
        return Problem(model, state, steps, every, lambda x, v, C, F: (v * mode).sum()[None], dict(rate=rate))

    def judge(self, problem: Problem, signal: Signal) -> dict[str, float]:
        """Relative errors of the decay rate (fitted) and of what is left at the end."""
        rate, amplitude = problem.exact["rate"], signal.values[:, 0]
        fitted = -np.polyfit(signal.t, np.log(amplitude), 1)[0]
        left = amplitude[-1] / np.exp(-rate * signal.t[-1])
        return {"decay rate": float(fitted / rate - 1), "amplitude": float(left - 1)}

    def bars(self, numerics: Numerics) -> dict[str, float]:
        """5 % in the rate from 16 cells on; 8 % below."""
        return {"decay rate": 0.05 if (numerics.resolution or 16) >= 16 else 0.08}


def swirl(offset: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """J1(kappa r) e_theta and its gradient [1/m] at ``offset`` [m] from the centre in x and z, (n, 3), (n, 3, 3)."""
    x, z = offset[:, 0], offset[:, 2]
    r = np.hypot(x, z)
    k = WAVE_NUMBER
    turn = j1(k * r) / r
    slope = (k * j0(k * r) - 2 * turn) / r**2  # (d turn / d r) / r
    v, gradient = np.zeros_like(offset), np.zeros((len(offset), 3, 3))
    v[:, 0], v[:, 2] = -turn * z, turn * x
    gradient[:, 0, 0], gradient[:, 0, 2] = -slope * x * z, -turn - slope * z**2
    gradient[:, 2, 0], gradient[:, 2, 2] = turn + slope * x**2, slope * x * z
    return v, gradient
