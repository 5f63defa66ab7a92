"""Free flight: what the simulator must do exactly, whatever the grid."""

from __future__ import annotations

import dataclasses

import jax.numpy as jnp
import numpy as np

from benchmarks.cases.base import Numerics, Problem, Signal, lattice
from benchmarks.cases.elastic import MARGIN, grid_for, neo_hookean_body

_E, _NU, _RHO, _DX = 1e5, 0.3, 1000.0, 1 / 32
_STEPS = 5000
_APEX, _RANGE = 12, 16  # cells


class Projectile:
    """A block thrown across 16 cells and 12 cells high follows the parabola that symplectic Euler gives.

    After n steps v = v0 + n g dt and x = x0 + n v0 dt + g dt^2 n (n + 1) / 2, which is g t dt / 2 beyond the
    continuous parabola. All else stays as it is: F = I, C = 0. Any damping, gravity at empty nodes, or weights that
    do not sum to one would show. ``resolution`` counts cells along the block's side; the flight takes 5000 steps.

    In float64 we are 6e-14 m off. In float32 it is 3.8e-5 m of a way of 1.3 m, but 3.3e-5 m of that is what the
    bare recurrence for one point without any grid is off in float32.
    """

    name = "projectile"
    title = "thrown block: deviation from the discrete parabola"
    source = "closed form of symplectic Euler in uniform gravity"
    resolutions: tuple[int, ...] = (2, 3)

    def problem(self, numerics: Numerics) -> Problem:
        """Sampled at the apex and where it comes down again."""
        cells = numerics.resolution or 2
        x = lattice((cells,) * 3, _DX, (MARGIN * _DX,) * 3, numerics.per_axis)
        grid = grid_for((cells + _RANGE, cells, cells + _APEX), _DX)
        volume = (_DX / numerics.per_axis) ** 3
        model, state = neo_hookean_body(numerics, grid, x, volume, _E, _NU, _RHO)
        dt = float(model.dt)
        duration, g = _STEPS * dt, np.array([0.0, 0.0, -8 * _APEX * _DX / (_STEPS * dt) ** 2])
        v0 = np.array([_RANGE * _DX / duration, 0.0, -g[2] * duration / 2])
        model = model.replace(gravity=jnp.asarray(g, numerics.dtype))
        state = dataclasses.replace(state, v=jnp.broadcast_to(jnp.asarray(v0, numerics.dtype), x.shape))
        v0, g = np.asarray(state.v[0], np.float64), np.asarray(model.gravity, np.float64)  # as rounded
        x0, exact = np.asarray(state.x, np.float64), []
        for n in (_STEPS // 2, _STEPS):
            parabola = x0 + n * v0 * dt + g * dt**2 * n * (n + 1) / 2
            exact.append((parabola.astype(numerics.dtype), (v0 + n * g * dt).astype(numerics.dtype)))

        def observe(x, v, C, F):
            distances = [abs(x - there).max() for there, _ in exact] + [
                abs(v - then).max() for _, then in exact
            ]
            return jnp.stack([*distances, abs(F - jnp.eye(3, dtype=F.dtype)).max(), abs(C).max()])

        return Problem(
            model, state, _STEPS, _STEPS // 2, observe, dict(speed=float(np.linalg.norm(v0)), dt=dt)
        )

    def judge(self, problem: Problem, signal: Signal) -> dict[str, float]:
        """The greatest over all particles at the apex and at the end; C as its part in a step, C dt."""
        apex, end = signal.values
        return {
            "position [m]": float(max(apex[0], end[1])),
            "velocity": float(max(apex[2], end[3])) / problem.exact["speed"],
            "deformation": float(end[4]),
            "affine": float(end[5]) * problem.exact["dt"],
        }

    def bars(self, numerics: Numerics) -> dict[str, float]:
        """Round-off of 5000 steps; in float32 the position's is mostly the recurrence's own (see above)."""
        if np.dtype(numerics.dtype) == np.float64:
            return {"position [m]": 1e-12, "velocity": 1e-12, "deformation": 1e-12, "affine": 1e-12}
        return {"position [m]": 5e-5, "velocity": 1e-4, "deformation": 1e-4, "affine": 1e-6}


class FreeBody:
    """A block thrown with random particle velocities vibrates, but its momentum is constant.

    ``resolution`` counts cells along its side.
    """

    name = "momentum"
    title = "vibrating block: change of its momentum"
    source = "Newton's first law"
    resolutions: tuple[int, ...] = (3, 4)

    def problem(self, numerics: Numerics) -> Problem:
        """2000 steps."""
        cells = numerics.resolution or 3
        x = lattice((cells,) * 3, _DX, (2 * MARGIN * _DX,) * 3, numerics.per_axis)
        noise = np.random.default_rng(0).normal(size=x.shape)
        volume = (_DX / numerics.per_axis) ** 3
        grid = grid_for((cells,) * 3, _DX, 2 * MARGIN)
        model, state = neo_hookean_body(
            numerics, grid, x, volume, _E, _NU, _RHO, v=0.2 * noise + np.array([0.03, -0.02, 0.01])
        )
        before = np.asarray(state.v, np.float64).mean(0)
        exact = dict(before=before, speed=float(np.linalg.norm(before)))
        return Problem(model, state, 2000, 200, lambda x, v, C, F: v.mean(0), exact)

    def judge(self, problem: Problem, signal: Signal) -> dict[str, float]:
        """The greatest change relative to the momentum."""
        change = np.linalg.norm(signal.values - problem.exact["before"], axis=-1).max()
        return {"momentum": float(change) / problem.exact["speed"]}

    def bars(self, numerics: Numerics) -> dict[str, float]:
        """Round-off of 2000 steps."""
        return {"momentum": 1e-12 if np.dtype(numerics.dtype) == np.float64 else 1e-5}
