"""A block on an inclined plane: Coulomb friction, sliding and at rest."""

from __future__ import annotations

import dataclasses

import jax.numpy as jnp
import numpy as np

from benchmarks.cases.base import Numerics, Problem, Signal, observed_steps
from benchmarks.cases.bodies import half_space
from benchmarks.cases.elastic import neo_hookean_body
from benchmarks.cases.plane import sheet, sheet_grid, side_walls
from physagent_jax.mpm import Contact

_RHO, _G, _HEIGHT, _LONG = 1000.0, 9.81, 0.1, 2  # the block is _LONG times as long as high
_STIFFNESS = 1e4  # E over rho g H, nu = 0: the block yields by 1e-4 of its height
_VISCOSITY = 0.05  # over rho c H
_ANGLE = np.radians(30.0)
_FLOOR = 4  # node
_DURATION = 4.0  # in sqrt(H / g)


@dataclasses.dataclass(frozen=True)
class Incline:
    """Gravity is tilted by 30 degrees, the floor is level.

    A friction below tan(30 deg) = 0.577 lets the block slide with g (sin - mu cos), a larger one holds it.
    ``resolution`` counts cells through the height. The block starts compressed as it will be at rest, so that it
    presses evenly on the floor from the start, and half a cell deep in the floor's nodes, where the grid's velocity
    vanishes. Its internal viscosity damps the waves that sudden gravity sends through it; without, a block held
    by friction rattles on the floor for long, and slides a little whenever it is off.

    Error of the acceleration: 6e-7 in float64, 2e-5 in float32. Drift with mu = 0.7: 1e-4 L, all of it in the
    first 0.1 sqrt(H / g), when shear spreads through the block.
    """

    friction: float = 0.3
    title = "block on an incline: acceleration, or drift at rest"
    source = "Coulomb friction: a = g (sin(theta) - mu cos(theta)) if tan(theta) > mu, else rest"
    resolutions = (4, 8)

    @property
    def name(self) -> str:
        """With what the block does."""
        return "incline-slides" if self.acceleration > 0 else "incline-rests"

    @property
    def acceleration(self) -> float:
        """Along the slope [m/s^2]."""
        return float(max(0.0, _G * (np.sin(_ANGLE) - self.friction * np.cos(_ANGLE))))

    def problem(self, numerics: Numerics) -> Problem:
        """Four times sqrt(H / g): 1.0 m/s for mu = 0.3."""
        cells = numerics.resolution or 4
        dx = _HEIGHT / cells
        floor, left = _FLOOR * dx, 4 * dx
        base = floor - 0.5 * dx
        x = sheet((_LONG * cells, cells), dx, (left, base), numerics.per_axis)
        E = _STIFFNESS * _RHO * _G * _HEIGHT
        duration = _DURATION * float(np.sqrt(_HEIGHT / _G))
        travel = 0.5 * self.acceleration * duration**2
        pressure = _RHO * _G * np.cos(_ANGLE) * (base + _HEIGHT - x[:, 2])
        F = np.tile(np.eye(3), (len(x), 1, 1))
        F[:, 2, 2] -= pressure / E
        model, state = neo_hookean_body(
            numerics,
            sheet_grid(_LONG * cells + int(travel / dx) + 9, cells + 8, dx),
            x,
            dx * (dx / numerics.per_axis) ** 2,
            E=E,
            nu=0.0,
            rho=_RHO,
            F=F,
            viscosity=jnp.full(
                len(x), _VISCOSITY * _RHO * _HEIGHT * float(np.sqrt(E / _RHO)), numerics.dtype
            ),
            gravity=(_G * np.sin(_ANGLE), 0, -_G * np.cos(_ANGLE)),
            boundaries=(
                *side_walls(dx, numerics.dtype),
                half_space((0, 0, floor), (0, 0, 1), Contact.SEPARATE, numerics.dtype, self.friction),
            ),
        )
        steps, every = observed_steps(duration, float(model.dt), 400)
        x0 = float(x[:, 0].mean())
        return Problem(
            model,
            state,
            steps,
            every,
            lambda x, v, C, F: jnp.stack([x[:, 0].mean() - x0, v[:, 0].mean()]),
            {},
        )

    def judge(self, problem: Problem, signal: Signal) -> dict[str, float]:
        """Sliding: relative errors of the acceleration (fitted) and the distance. At rest: drift over length."""
        moved, speed = signal.values.T
        if self.acceleration == 0:
            late = np.ptp(moved[len(moved) // 2 :])
            return {
                "drift / L": float(np.abs(moved).max() / (_LONG * _HEIGHT)),
                "late drift / L": float(late / (_LONG * _HEIGHT)),
            }
        fitted = np.polyfit(signal.t, speed, 1)[0]
        distance = 0.5 * self.acceleration * signal.t[-1] ** 2
        return {
            "acceleration": float(fitted / self.acceleration - 1),
            "distance": float(moved[-1] / distance - 1),
        }

    def bars(self, numerics: Numerics) -> dict[str, float]:
        """2 % in acceleration, or 1e-3 of the block's length, 1e-6 of it in the second half."""
        if self.acceleration > 0:
            return {"acceleration": 0.02}
        return {"drift / L": 1e-3, "late drift / L": 1e-6}
