"""The free-free elastic bar: first axial mode, without any boundary or body force."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from benchmarks.cases.base import (
    Numerics,
    Problem,
    Signal,
    cosine_deviation,
    fit_damped_cosine,
    lattice,
    observed_steps,
)
from benchmarks.cases.elastic import grid_for
from physagent_jax.mpm import Model, NeoHookean, State, lame_parameters

_E, _RHO, _DX = 1e5, 1000.0, 0.05
_SPEED = float(np.sqrt(_E / _RHO))
_MARGIN = 6  # cells of free space around the bar

# |frequency error| of an independent float64 code at Courant number 0.3 (MLS and classical stress form).
_REFERENCE = {
    "mls": {8: 0.0151, 16: 0.0039, 32: 0.00098},
    "gradient": {8: 0.0185, 16: 0.0048, 32: 0.0012},
}


class FreeBar:
    """v = a cos(pi X / L) along a bar of nu = 0 with a 4x4-cell section swings with f = c_0 / 2 L.

    ``resolution`` counts cells along the bar.
    """

    name = "bar"
    title = "free elastic bar: frequency of the first axial mode"
    source = "one-dimensional wave equation, free ends: f = sqrt(E / rho) / 2 L"
    resolutions = (8, 16, 32)

    def problem(self, numerics: Numerics) -> Problem:
        """Three periods of the mode, a hundredth of the sound speed in amplitude."""
        cells = numerics.resolution or 16
        low, length = _MARGIN * _DX, cells * _DX
        grid = grid_for((cells, 4, 4), _DX, _MARGIN)  # the window that a run of ours would have
        x = lattice((cells, 4, 4), _DX, (low, low, low), numerics.per_axis).astype(numerics.dtype)
        volume = np.full(len(x), (_DX / numerics.per_axis) ** 3, numerics.dtype)
        mu, lam = lame_parameters(_E, 0.0)
        mode = np.cos(np.pi * (x[:, 0] - low) / length).astype(numerics.dtype)
        v = np.zeros_like(x)
        v[:, 0] = 1e-3 * _SPEED * mode
        state = State.at_rest(jnp.asarray(x), jnp.asarray(v))
        model = Model(
            grid=grid,
            dt=jnp.asarray(0.0, numerics.dtype),
            gravity=None,
            mass=jnp.asarray(_RHO * volume),
            volume=jnp.asarray(volume),
            materials=(
                NeoHookean(jnp.full(len(x), mu, numerics.dtype), jnp.full(len(x), lam, numerics.dtype)),
            ),
        )
        model = numerics.finish(model, state, _SPEED)
        frequency = _SPEED / (2 * length)
        exact = dict(f=frequency, start=float((v[:, 0] * mode).mean()))
        steps, every = observed_steps(3 / frequency, float(model.dt), 400)
        return Problem(model, state, steps, every, lambda x, v, C, F: (v[:, 0] * mode).mean(), exact)

    def judge(self, problem: Problem, signal: Signal) -> dict[str, float]:
        """Errors of the frequency and of the signal itself, and the decay per period (exact: 0)."""
        exact = problem.exact["f"]
        frequency, decay = fit_damped_cosine(signal.t, signal.values[:, 0], exact)
        deviation = cosine_deviation(
            signal.t - problem.dt / 2, signal.values[:, 0], problem.exact["start"], exact
        )
        return {
            "frequency": frequency / exact - 1,
            "decay per period": decay / frequency,
            "signal (rms)": deviation,
        }

    def bars(self, numerics: Numerics) -> dict[str, float]:
        """1.3 times the reference errors."""
        return {"frequency": 1.3 * _REFERENCE[numerics.stress_form][numerics.resolution or 16]}
