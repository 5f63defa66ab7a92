"""The generalised vortex: a manufactured solution with large shear and rotation, without boundaries."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.cases.base import Numerics, Problem, Signal, lattice
from benchmarks.cases.elastic import MARGIN, grid_for, neo_hookean_body
from benchmarks.cases.manufactured import ManufacturedForce, distance_from, positions, set_in_motion
from physagent_jax.mpm import lame_parameters

_INNER, _OUTER = 0.75, 1.25  # radii of the ring [m]
_AMPLITUDE = 0.1
_E, _NU, _RHO = 1000.0, 0.3, 1000.0
_RATE = float(np.pi * np.sqrt(_E / _RHO))

# RMS errors [m] at t = 0.5 and 1 s of an independent float64 code (two-dimensional, MLS, Courant number 0.2), by
# cells across the ring and particles per cell and axis.
_REFERENCE = {
    (5, 2): (7.6e-3, 2.1e-2),
    (5, 3): (6.7e-3, 1.3e-2),
    (10, 2): (1.3e-3, 3.3e-3),
    (10, 3): (1.5e-3, 4.3e-3),
    (20, 2): (5.4e-4, 1.8e-3),
    (20, 3): (2.3e-4, 3.4e-4),
}


def vortex_motion(X: jax.Array, t: jax.Array, amplitude: float = _AMPLITUDE) -> jax.Array:
    """Rest position to position [m]: each circle of the ring turns by its own angle, there and back in 1 s."""
    angle = _compute_twist(jnp.hypot(X[0], X[1]), t, amplitude)
    c, s = jnp.cos(angle), jnp.sin(angle)
    return jnp.stack([c * X[0] - s * X[1], s * X[0] + c * X[1], X[2]])


def vortex_force(
    X: jax.Array, t: jax.Array, amplitude: float = _AMPLITUDE, mu: float = lame_parameters(_E, _NU)[0]
) -> jax.Array:
    """Body force [m/s^2] that holds the ring to `vortex_motion` (Kamojjala et al. 2015)."""
    R = jnp.hypot(X[0], X[1])
    swing, rate = jnp.sin(_RATE * t), _RATE * jnp.cos(_RATE * t)
    rims = (4 * R - 3) * (4 * R - 5)
    curve = 96 * R**3 - 240 * R**2 + 188 * R - 45
    radial = R * (amplitude * rims) ** 2 * (4096 * mu / _RHO * (swing * (R - 1)) ** 2 - (rate * rims) ** 2)
    hoop = -amplitude * swing * (R * (_RATE * rims) ** 2 + 64 * mu / _RHO * curve)
    angle = jnp.arctan2(X[1], X[0]) + _compute_twist(R, t, amplitude)
    c, s = jnp.cos(angle), jnp.sin(angle)
    return jnp.stack([radial * c - hoop * s, radial * s + hoop * c, jnp.zeros_like(c)])


def _compute_twist(R: jax.Array, t: jax.Array, amplitude: float) -> jax.Array:
    """Angle of the circle of radius R [rad]; it and its slope vanish on the rims, so that they carry no traction."""
    return amplitude * jnp.sin(_RATE * t) * (1 - 32 * (R - 1) ** 2 + 256 * (R - 1) ** 4)


class Vortex:
    """A neo-Hookean ring twists within itself by a tenth of a radian, and back.

    The motion is plane and keeps the volume, and this material then has no stress normal to the plane: a slab
    one cell thick with free faces is exact. ``resolution`` counts cells across the ring (dx = 0.5 m / resolution).
    The problem is unstable: at 20 cells, an amplitude of 0.3 already breaks the ring numerically with 4 particles
    per cell in the plane.

    RMS errors at t = 0.5 s (1 s) in mm, 3 particles per cell and axis, Courant number 0.2, float64:

    | cells | reference | MLS | gradient form |
    |---|---|---|---|
    | 5 | 6.7 (13) | 6.2 (12.8) | 5.7 (13.5) |
    | 10 | 1.5 (4.3) | 1.42 (4.24) | 1.41 (4.32) |
    | 20 | 0.23 (0.34) | 0.25 (0.33) | 0.28 (0.33) |
    """

    name = "vortex"
    title = "generalised vortex: displacement error at the greatest twist and after the return"
    source = "manufactured solution of Kamojjala, Brannon, Sadeghirad and Guilkey 2015"
    resolutions: tuple[int, ...] = (5, 10, 20)

    def problem(self, numerics: Numerics) -> Problem:
        """One second, sampled at half of it and at its end."""
        cells = numerics.resolution or 10
        dx = (_OUTER - _INNER) / cells
        half = int(np.ceil(_OUTER / dx))
        X = lattice((2 * half, 2 * half, 1), dx, (-half * dx, -half * dx, 0.0), numerics.per_axis)
        R = np.hypot(X[:, 0], X[:, 1])
        X = X[(R > _INNER) & (R < _OUTER)]
        shift = np.array([MARGIN + half, MARGIN + half, MARGIN]) * dx
        grid, volume = grid_for((2 * half, 2 * half, 1), dx), (dx / numerics.per_axis) ** 3
        force = ManufacturedForce(jnp.asarray(X, numerics.dtype), vortex_force)
        model, state = neo_hookean_body(numerics, grid, X + shift, volume, _E, _NU, _RHO, forces=(force,))
        dt = float(model.dt)
        every = max(1, round(0.5 / dt))
        exact = positions(vortex_motion, X, [every * dt, 2 * every * dt]) + shift
        state = set_in_motion(state, vortex_motion, X, dt)
        return Problem(model, state, 2 * every, every, distance_from(exact), {})

    def judge(self, problem: Problem, signal: Signal) -> dict[str, float]:
        """RMS distance from the exact positions [m]."""
        return {"twisted [m]": float(signal.values[0, 0]), "returned [m]": float(signal.values[1, 1])}

    def bars(self, numerics: Numerics) -> dict[str, float]:
        """1.3 times the reference errors; that is below 5e-4 m at 20 cells and 3 particles per axis."""
        twisted, returned = _REFERENCE[numerics.resolution or 10, numerics.per_axis]
        return {"twisted [m]": 1.3 * twisted, "returned [m]": 1.3 * returned}
