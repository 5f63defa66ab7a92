"""Wave fronts in a bar: how fast they travel, what is behind them, and how a bar rebounds from a wall."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from benchmarks.cases.base import Numerics, Problem, Signal, lattice
from benchmarks.cases.bodies import half_space
from benchmarks.cases.elastic import MARGIN, grid_for, neo_hookean_body
from physagent_jax.mpm import Contact

_E, _RHO, _LENGTH = 1e5, 1000.0, 1.0
_SPEED = float(np.sqrt(_E / _RHO))
_JUMP = 1e-3 * _SPEED  # of velocity [m/s]
_SECTION = 2  # cells along a side of the cross-section
_STATION = 0.75  # of the length, where the front is watched


class WaveFront:
    """The left half of a free bar of nu = 0 moves, the right half does not: fronts run both ways at c_0.

    Behind them the velocity is half the jump and the stress is -rho c_0 times that. Watched in the cell at three
    quarters of the length. ``resolution`` counts cells along the bar.

    Courant number 0.3, float64; delay of half the jump in cells, plateau (the worse of velocity and stress) and
    overshoot in per cent:

    | cells | MLS: delay | plateau | overshoot | gradient form: delay | plateau | overshoot |
    |---|---|---|---|---|---|---|
    | 32 | 0.51 | -0.49 | 13.2 | 0.58 | -0.43 | 15.5 |
    | 64 | 0.65 | 0.23 | 15.4 | 0.74 | 0.20 | 17.6 |
    | 128 | 0.84 | 0.04 | 17.5 | 0.94 | 0.03 | 19.5 |

    Short waves lag behind: the front widens as t^(1/3) and trails a ringing. Without damping it tends to the
    greatest value of the Airy function's integral, 1.274 (256 cells: 19 %, and 22 % at Courant number 0.9). A bar
    of 15 % would be met on coarse grids only, where the scheme damps more, and reward damping.
    """

    name = "wave-front"
    title = "step of velocity in a free bar: arrival, plateau and overshoot"
    source = "one-dimensional wave equation (d'Alembert)"
    resolutions: tuple[int, ...] = (32, 64, 128)

    def problem(self, numerics: Numerics) -> Problem:
        """Until the front has come back from the end."""
        cells = numerics.resolution or 64
        dx = _LENGTH / cells
        X = lattice((cells, _SECTION, _SECTION), dx, (0.0,) * 3, numerics.per_axis)
        v = np.zeros_like(X)
        v[:, 0] = np.where(X[:, 0] < _LENGTH / 2, _JUMP, 0)
        grid, volume = grid_for((cells, _SECTION, _SECTION), dx), (dx / numerics.per_axis) ** 3
        model, state = neo_hookean_body(numerics, grid, X + MARGIN * dx, volume, _E, 0.0, _RHO, v=v)
        seen = np.flatnonzero(abs(X[:, 0] - _STATION * _LENGTH) < 0.51 * dx)

        def observe(x, v, C, F):
            axial = F[seen, 0, 0]
            return jnp.stack([v[seen, 0].mean() / (_JUMP / 2), (1 / axial - axial).mean() * (_SPEED / _JUMP)])

        steps = int(np.ceil(0.8 * _LENGTH / _SPEED / float(model.dt)))
        return Problem(model, state, steps, 1, observe, dict(dx=dx))

    def judge(self, problem: Problem, signal: Signal) -> dict[str, float]:
        """Delay of half the jump, in cells; mean velocity and stress well behind the front; greatest velocity."""
        t, (v, stress) = signal.t * _SPEED / _LENGTH, signal.values.T
        travel = _STATION - 0.5
        after = int(np.argmax(v > 0.5))
        arrival = np.interp(0.5, v[after - 1 : after + 1], t[after - 1 : after + 1])
        plateau = abs(t - 2 * travel) < 0.1
        return {
            "arrival [cells]": float((arrival - travel) * _LENGTH / problem.exact["dx"]),
            "velocity": float(v[plateau].mean() - 1),
            "stress": float(stress[plateau].mean() - 1),
            "overshoot": float(v[t < 2.8 * travel].max() - 1),
        }

    def bars(self, numerics: Numerics) -> dict[str, float]:
        """A cell and 1 % of the way; 3 %; and for the ringing its undamped limit."""
        cells = numerics.resolution or 64
        return {
            "arrival [cells]": 1 + 0.01 * cells * (_STATION - 0.5),
            "velocity": 0.03,
            "stress": 0.03,
            "overshoot": 0.275,
        }


class WallImpact:
    """A bar of nu = 0 flies against a rigid frictionless wall and leaves it after 2 L / c_0 with all its momentum.

    While it touches, the wall pushes with rho c_0 v per area. ``resolution`` counts cells along the bar. The
    rebound lacks what trails behind the fronts, whose width grows as (t dx^2)^(1/3): a share of cells^(-2/3).

    Errors in per cent at Courant number 0.3, float64; those of the gradient form differ by less than 0.1:

    | cells | contact time | force | momentum | kinetic energy |
    |---|---|---|---|---|
    | 16 | 0.30 | 0.01 | -6.3 | -9.1 |
    | 32 | 0.01 | 0.03 | -3.9 | -5.4 |
    | 64 | -0.03 | 0.03 | -2.4 | -3.2 |
    """

    name = "wall-impact"
    title = "bar against a wall: contact time, force and rebound"
    source = "one-dimensional wave equation with unilateral contact"
    resolutions: tuple[int, ...] = (16, 32, 64)

    def problem(self, numerics: Numerics) -> Problem:
        """From first contact until well after the rebound."""
        cells = numerics.resolution or 32
        dx = _LENGTH / cells
        X = lattice((cells, _SECTION, _SECTION), dx, (0.0,) * 3, numerics.per_axis)
        v = np.zeros_like(X)
        v[:, 0] = -_JUMP
        wall = half_space((MARGIN * dx, 0, 0), (1, 0, 0), Contact.SEPARATE, numerics.dtype)
        grid, volume = grid_for((cells, _SECTION, _SECTION), dx), (dx / numerics.per_axis) ** 3
        model, state = neo_hookean_body(
            numerics, grid, X + MARGIN * dx, volume, _E, 0.0, _RHO, v=v, boundaries=(wall,)
        )
        steps = int(np.ceil(3 * _LENGTH / _SPEED / float(model.dt)))

        def observe(x, v, C, F):
            return jnp.stack([v[:, 0].mean() / _JUMP, (v**2).sum(-1).mean() / _JUMP**2])

        return Problem(model, state, steps, 1, observe, {})

    def judge(self, problem: Problem, signal: Signal) -> dict[str, float]:
        """Contact time from when the momentum is -0.8 and +0.8 of the first; mean force; what is missing in the end."""
        t, (momentum, energy) = signal.t * _SPEED / _LENGTH, signal.values.T
        rising = slice(0, int(np.argmax(momentum)) + 1)
        begin, end = np.interp([-0.8, 0.8], momentum[rising], t[rising])
        touching = (t > 0.3) & (t < 1.7)
        return {
            "contact time": float((end - begin) / 1.6 - 1),
            "force": float(np.polyfit(t[touching], momentum[touching], 1)[0] - 1),
            "momentum": float(momentum[-1] - 1),
            "kinetic energy": float(energy[-1] - 1),
        }

    def bars(self, numerics: Numerics) -> dict[str, float]:
        """A cell and 1 % for the time; 3 % for the force; cells^(-2/3) / 2 for the rebound."""
        cells = numerics.resolution or 32
        return {"contact time": 0.01 + 1 / (2 * cells), "force": 0.03, "momentum": 0.5 * cells ** (-2 / 3)}
