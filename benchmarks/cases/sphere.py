"""The free elastic sphere: its breathing mode, without any boundary or body force."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from benchmarks.cases.base import (
    Numerics,
    Problem,
    Signal,
    cosine_deviation,
    fit_damped_cosine,
    lattice,
    observed_steps,
)
from benchmarks.cases.elastic import MARGIN, grid_for, neo_hookean_body, wave_speed

_E, _NU, _RHO, _RADIUS = 1e6, 0.3, 1000.0, 0.1
_SPEED = wave_speed(_E, _NU, _RHO)

# |frequency error| of an independent float64 code at Courant number 0.3, by cells per radius. It did not run the
# gradient form at 12 cells: what second order makes of 8.
_REFERENCE = {
    "mls": {4: 0.0340, 6: 0.0124, 8: 0.0096, 12: 0.0033},
    "gradient": {4: 0.0381, 6: 0.0142, 8: 0.0106, 12: 0.0106 * (8 / 12) ** 2},
}


def breathing_root(nu: float) -> float:
    """The least root of eta cot(eta) = 1 - eta^2 (1 - nu) / (2 (1 - 2 nu)) (Lamb 1882)."""
    q = (1 - nu) / (2 * (1 - 2 * nu))
    return float(brentq(lambda eta: eta * np.cos(eta) - (1 - q * eta**2) * np.sin(eta), 1.0, np.pi))  # type: ignore[arg-type]


class Sphere:
    """v = a j1(eta r / R) outwards swings with f = eta c_p / (2 pi R), j1 the spherical Bessel function.

    ``resolution`` counts cells per radius. Particles on a lattice make a rough surface, whose volume is scaled to
    the sphere's. Frequency errors (decay per period) in per cent, Courant number 0.3, float64:

    | cells | reference, MLS | MLS | reference, gradient form | gradient form |
    |---|---|---|---|---|
    | 4 | -3.40 (5.4) | -3.46 (5.4) | -3.81 | -4.15 (5.8) |
    | 6 | -1.24 (1.8) | -1.26 (1.8) | -1.42 | -1.56 (1.9) |
    | 8 | -0.96 (0.80) | -0.98 (0.79) | -1.06 | -1.14 (0.82) |
    | 12 | -0.33 (0.33) | -0.33 (0.30) | | -0.41 (0.31) |
    """

    name = "sphere"
    title = "free elastic sphere: frequency of the breathing mode"
    source = "linear elasticity, Lamb 1882"
    resolutions: tuple[int, ...] = (4, 6, 8, 12)

    def problem(self, numerics: Numerics) -> Problem:
        """Four periods of the mode, a thousandth of the sound speed in amplitude."""
        cells = numerics.resolution or 8
        dx = _RADIUS / cells
        x = lattice((2 * cells,) * 3, dx, (MARGIN * dx,) * 3, numerics.per_axis)
        radius = np.linalg.norm(x - (MARGIN + cells) * dx, axis=-1)
        x, radius = x[radius < _RADIUS], radius[radius < _RADIUS]
        eta = breathing_root(_NU)
        k = eta * radius / _RADIUS
        outwards = (x - (MARGIN + cells) * dx) / radius[:, None]
        mode = ((np.sin(k) / k**2 - np.cos(k) / k)[:, None] * outwards).astype(numerics.dtype)
        grid, volume = grid_for((2 * cells,) * 3, dx), 4 / 3 * np.pi * _RADIUS**3 / len(x)
        model, state = neo_hookean_body(numerics, grid, x, volume, _E, _NU, _RHO, v=1e-3 * _SPEED * mode)
        frequency = eta * _SPEED / (2 * np.pi * _RADIUS)
        exact = dict(f=frequency, start=1e-3 * _SPEED * float((mode**2).sum(-1).mean()))
        steps, every = observed_steps(4 / frequency, float(model.dt), 400)
        return Problem(model, state, steps, every, lambda x, v, C, F: (v * mode).sum(-1).mean(), exact)

    def judge(self, problem: Problem, signal: Signal) -> dict[str, float]:
        """Errors of the frequency and of the signal itself, and the decay per period (exact: 0)."""
        exact, y = problem.exact["f"], signal.values[:, 0]
        frequency, decay = fit_damped_cosine(signal.t, y, exact)
        return {
            "frequency": frequency / exact - 1,
            "decay per period": decay / frequency,
            "signal (rms)": cosine_deviation(signal.t - problem.dt / 2, y, problem.exact["start"], exact),
        }

    def bars(self, numerics: Numerics) -> dict[str, float]:
        """1.3 times the reference errors: below 1.5 % at 8 cells, below 0.6 % (0.62 % in the gradient form) at 12."""
        return {"frequency": 1.3 * _REFERENCE[numerics.stress_form][numerics.resolution or 8]}
