"""A beam clamped at one end bends under its own weight: the elastica, and its first bending period."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from scipy.integrate import solve_bvp
from scipy.optimize import curve_fit

from benchmarks.cases.base import Numerics, Problem, Signal, observed_steps
from benchmarks.cases.elastic import neo_hookean_body, wave_speed
from benchmarks.cases.plane import sheet, sheet_grid, side_walls
from physagent_jax.mpm import PrescribedMotion

_E, _RHO, _LENGTH, _SLENDER = 1e6, 1000.0, 1.0, 10  # nu = 0; _SLENDER = length over height
_HELD, _FREE = 3, 4  # cells: clamped part, free space around
_ROOT = 3.5160153 / (2 * np.pi)  # f = _ROOT sqrt(EI / rho A) / L^2, first clamped-free mode


class Cantilever:
    """Settles, critically damped, to the large deflection B = q L^3 / E I = 4: the tip drops by 0.43 L.

    ``resolution`` counts cells through the height H = L / 10. nu = 0, so plane strain is plane stress.

    The clamped particles end at mid-cell and hold the nodes up to half a cell before. The grid's field vanishes up
    to another half cell further back, and there the beam's length L begins; counted from the last clamped
    particle it would be a cell short, and the tip 10 % too low with 4 cells through the height.

    What is left is the creep of light nodes, which falls with more particles, not with more cells, and with
    `Lumped.aggregation` (docs/accuracy.md, "Light nodes and particles per cell").
    """

    name = "cantilever"
    title = "cantilever under its own weight: large static deflection"
    source = "elastica: E I theta'' + q (L - s) cos(theta) = 0, theta(0) = theta'(L) = 0"
    resolutions = (4, 8)
    load = 4.0

    def problem(self, numerics: Numerics) -> Problem:
        """One and a half periods of critical damping leave 1e-3 of the way."""
        omega = 2 * np.pi * first_frequency()
        return _make_beam(numerics, self.load, 1.5 / first_frequency(), damping_rate=float(2 * omega))

    def judge(self, problem: Problem, signal: Signal) -> dict[str, float]:
        """Errors of the tip's drop (relative) and of its retreat (over L), and what is left to settle."""
        drop, retreat = elastica(self.load)
        x, z = signal.values[:, 0], signal.values[:, 1]
        late = z[len(z) * 9 // 10 :]
        return {
            "tip drop": float(-z[-1] / _LENGTH / drop - 1),
            "tip retreat / L": float(-x[-1] / _LENGTH - retreat),
            "unsettled": float(np.ptp(late) / _LENGTH / drop),
        }

    def bars(self, numerics: Numerics) -> dict[str, float]:
        """10 % with 4 cells through the height, 4 % with 8 (and 3 particles per cell and axis)."""
        bar = 0.04 if (numerics.resolution or 4) >= 8 else 0.10
        return {"tip drop": bar, "tip retreat / L": bar, "unsettled": 0.01}


class CantileverSwing:
    """Gravity sets in suddenly, B = 0.1, no damping: the tip swings about q L^4 / 8 E I with the first period.

    Errors of period and mean drop: -0.33 % and -0.8 % with 4 cells through the height, 0.03 % and 0.03 % with 8.
    """

    name = "cantilever-swing"
    title = "cantilever under sudden gravity: first bending period and mean deflection"
    source = "Euler-Bernoulli beam: f = 3.516 sqrt(E I / rho A) / (2 pi L^2), static tip q L^4 / 8 E I"
    resolutions = (4, 8)
    load = 0.1

    def problem(self, numerics: Numerics) -> Problem:
        """Two periods."""
        return _make_beam(numerics, self.load, 2 / first_frequency())

    def judge(self, problem: Problem, signal: Signal) -> dict[str, float]:
        """Relative errors of period and mean, the peak over the static drop less 2, and the decay per period."""
        static, f = self.load / 8 * _LENGTH, first_frequency()

        def swing(t, mean, amplitude, f, decay):
            return mean - amplitude * np.exp(-decay * t) * np.cos(2 * np.pi * f * t)

        drop = -signal.values[:, 1]
        (mean, _, frequency, decay), _ = curve_fit(swing, signal.t, drop, p0=[static, static, f, 0.01 * f])
        return {
            "period": float(f / frequency - 1),
            "mean drop": float(mean / static - 1),
            "peak over static - 2": float(drop.max() / mean - 2),
            "decay per period": float(decay / frequency),
        }

    def bars(self, numerics: Numerics) -> dict[str, float]:
        """Half the static bar for the period, since f ~ stiffness^(1/2)."""
        bar = 0.04 if (numerics.resolution or 4) >= 8 else 0.10
        return {"period": bar / 2, "mean drop": bar, "peak over static - 2": 0.1}


def first_frequency() -> float:
    """Of the first bending mode [Hz], with E I / rho A = c^2 H^2 / 12."""
    return float(_ROOT * wave_speed(_E, 0.0, _RHO) * (_LENGTH / _SLENDER) / np.sqrt(12) / _LENGTH**2)


def elastica(load: float) -> tuple[float, float]:
    """Drop and retreat of the tip over L, for B = q L^3 / E I."""

    def slopes(s, y):
        theta, curvature = y[:2]
        return np.stack([curvature, -load * (1 - s) * np.cos(theta), np.cos(theta), np.sin(theta)])

    def ends(a, b):
        return np.array([a[0], b[1], a[2], a[3]])

    s = np.linspace(0, 1, 101)
    solution = solve_bvp(slopes, ends, s, np.zeros((4, len(s))), tol=1e-8)
    return float(abs(solution.y[3, -1])), float(1 - solution.y[2, -1])


def _make_beam(numerics: Numerics, load: float, duration: float, **model) -> Problem:
    height = numerics.resolution or 4
    dx = _LENGTH / _SLENDER / height
    cells, deep = height * _SLENDER, int(0.6 * load / 4 * height * _SLENDER) + 2
    low = ((_FREE + 0.5) * dx, (_FREE + deep) * dx)
    x = sheet((_HELD + cells - 1, height), dx, low, numerics.per_axis)
    clamp = np.flatnonzero(x[:, 0] < low[0] + _HELD * dx)
    spacing = dx / numerics.per_axis
    ends = [np.flatnonzero(x[:, 0] > x[:, 0].max() - (n + 0.5) * spacing) for n in range(2)]
    last, before = ends[0], np.setdiff1d(ends[1], ends[0])
    body, state = neo_hookean_body(
        numerics,
        sheet_grid(_HELD + cells + 2 * _FREE, deep + height + 2 * _FREE, dx),
        x,
        dx * spacing**2,
        E=_E,
        nu=0.0,
        rho=_RHO,
        # B = q L^3 / E I with q = rho g H and I = H^3 / 12, per width
        gravity=[0, 0, -load * _E / (12 * _RHO * _LENGTH * _SLENDER**2)],
        boundaries=side_walls(dx, numerics.dtype),
        constraints=(PrescribedMotion.fixed(jnp.asarray(clamp, jnp.int32), numerics.dtype),),
        **model,
    )
    rest = np.array([low[0] + (_HELD + cells - 1) * dx, low[1] + height * dx / 2])

    def observe(x, v, C, F):
        one, two = x[last].mean(0), x[before].mean(0)
        tip = one + 0.5 * (one - two)
        return tip[jnp.array([0, 2])] - jnp.asarray(rest, x.dtype)

    steps, every = observed_steps(duration, float(body.dt), 400)
    return Problem(body, state, steps, every, observe, {})
