"""A pulse in a rod whose stiffness has a step: what it throws back, and what it lets through."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from scipy.special import erfc

from benchmarks.cases.base import Numerics, Problem, Signal, lattice
from benchmarks.cases.bodies import body
from benchmarks.cases.elastic import MARGIN, grid_for
from physagent_jax.mpm import NeoHookean

_RHO, _LENGTH, _SECTION = 1000.0, 1.0, 2
_MODULI = 1e5, 4e5  # [Pa], left and right of the step
_STEP, _PLACE, _WIDTH = 0.5, 0.3, 0.04  # of the length: of the step, of the pulse's middle, and its spread
_AFTER = 0.12  # of the length, how far the left part's sound has gone since the middle met the step


class SteppedRod:
    """A Gaussian pulse of velocity runs to the right in a free rod of nu = 0, to where E is four times as great.

    Of a pulse in a part of impedance Z_1 = sqrt(E_1 rho), Z_1 - Z_2 over Z_1 + Z_2 of the velocity is thrown back, here
    -1/3, and 2 Z_1 over that sum goes on, here 2/3, c_2 / c_1 = 2 times as wide. ``resolution`` counts cells along the
    rod; the step lies between two cells. The error is of the velocity along the whole rod, when both have parted.
    """

    name = "stepped-rod"
    title = "pulse at a step of stiffness: velocity along the rod"
    source = "one-dimensional wave equation (d'Alembert), impedances; Achenbach 1973, sec. 1.4"
    resolutions: tuple[int, ...] = (64, 128, 256)

    def problem(self, numerics: Numerics) -> Problem:
        """Until both pulses have parted."""
        cells = numerics.resolution or 128
        dx = _LENGTH / cells
        X = lattice((cells, _SECTION, _SECTION), dx, (0.0,) * 3, numerics.per_axis)
        E = np.where(X[:, 0] < _STEP * _LENGTH, *_MODULI)
        slow, fast = np.sqrt(np.asarray(_MODULI) / _RHO)
        size = 1e-3 * slow
        where, width = X[:, 0] - _PLACE * _LENGTH, _WIDTH * _LENGTH
        v, F, x = np.zeros_like(X), np.broadcast_to(np.eye(3), (len(X), 3, 3)).copy(), X + MARGIN * dx
        v[:, 0] = size * np.exp(-0.5 * (where / width) ** 2)
        F[:, 0, 0] -= v[:, 0] / slow  # runs to the right
        x[:, 0] += size / slow * width * np.sqrt(np.pi / 2) * erfc(where / (np.sqrt(2) * width))
        mu = jnp.asarray(E / 2, numerics.dtype)
        model, state = body(
            numerics,
            grid_for((cells, _SECTION, _SECTION), dx),
            x,
            (dx / numerics.per_axis) ** 3,
            NeoHookean(mu, jnp.zeros_like(mu)),
            rho=_RHO,
            speed=float(fast),
            v=v,
            F=F,
        )
        end = (_STEP - _PLACE + _AFTER) * _LENGTH / slow
        steps = int(np.ceil(end / float(model.dt)))
        planes = np.unique(X[:, 0], return_inverse=True)[1].reshape(-1)
        count = int(planes.max()) + 1

        def observe(x, v, C, F):
            total = jnp.zeros(count, v.dtype).at[planes].add(v[:, 0])
            return total * count / (len(planes) * size)

        places = np.unique(X[:, 0])
        return Problem(model, state, steps, steps, observe, dict(places=places, slow=slow, fast=fast))

    def judge(self, problem: Problem, signal: Signal) -> dict[str, float]:
        """Of the exact velocity half a substep before the end, and of the greatest velocity of either pulse."""
        places, slow, fast = (problem.exact[name] for name in ("places", "slow", "fast"))
        step, ratio = _STEP * _LENGTH, float(fast / slow)
        gone = float(slow) * (signal.t[-1] - 0.5 * problem.dt) - (step - _PLACE * _LENGTH)
        back = (1 - ratio) / (1 + ratio) * _pulse(places - (step - gone), _WIDTH * _LENGTH)
        on = 2 / (1 + ratio) * _pulse(places - (step + ratio * gone), ratio * _WIDTH * _LENGTH)
        exact, seen = np.where(places < step, back, on), signal.values[-1]
        left = places < step
        return {
            "velocity (rms)": float(np.sqrt(np.mean((seen - exact) ** 2) / np.mean(exact**2))),
            "thrown back": float(seen[left].min() / back.min() - 1),
            "let through": float(seen[~left].max() / on.max() - 1),
        }

    def bars(self, numerics: Numerics) -> dict[str, float]:
        """Of second order: 5 % of the velocity and of the peaks at 128 cells, where 20 and 10 % had been set first."""
        scale = (128 / (numerics.resolution or 128)) ** 2
        return {"velocity (rms)": 0.05 * scale, "thrown back": 0.05 * scale, "let through": 0.05 * scale}


def _pulse(places: np.ndarray, width: float) -> np.ndarray:
    return np.exp(-0.5 * (places / width) ** 2)
