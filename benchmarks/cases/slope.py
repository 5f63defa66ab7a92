"""An endless slope of dry sand: the angle at which it flows, and how fast it starts."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.cases.base import Numerics, Problem, Signal, observed_steps
from benchmarks.cases.bodies import body, half_space
from benchmarks.cases.plane import sheet, sheet_grid, side_walls
from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm import Boundary, Contact, DruckerPrager, lame_parameters

_RHO, _G, _HEIGHT, _NU = 1600.0, 9.81, 0.1, 0.3
_STIFFNESS = 1e3  # E over rho g H
_PHI = 30.0  # friction angle in triaxial compression [deg]
_FLOOR, _WIDTH, _MIDDLE = (
    4,
    12,
    8,
)  # node of the floor; cells along the slope; cells of them left of the middle
_STILL, _FLOWING = 10.0, 1.5  # durations in sqrt(H / g)


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Endless(Boundary):
    """Makes the motion uniform along x: all nodes move like those of one column.

    What is uniform at first then stays so, like a layer without ends, as long as matter covers that column's
    stencils.

    Attributes:
        column: Window index in x of the column that leads, static.
    """

    column: int = dataclasses.field(metadata=dict(static=True))

    def apply(self, velocity: jax.Array, grid, time: jax.Array) -> jax.Array:
        """The leading column's velocities everywhere."""
        del grid, time
        return jnp.broadcast_to(velocity[self.column : self.column + 1], velocity.shape)


@dataclasses.dataclass(frozen=True)
class Slope:
    """A layer on a sticky floor, gravity tilted ``beyond`` degrees past the critical angle.

    Drucker-Prager fitted to triaxial compression yields in simple shear without dilation at
    tan(theta) = 2 sqrt(3) sin(phi) / (3 - sin(phi)): theta = 34.7 degrees for phi = 30. Below, the layer rests;
    above, it accelerates with g (sin(beyond) / cos(theta)), all of it alike. On a grid the layers next to the
    floor lag behind, because APIC diffuses the floor's rest upwards; the top does not know of it yet and is judged.

    ``resolution`` counts cells through the depth. A layer that rests does so after 1 sqrt(H / g): over 5 s it
    creeps as far as over 10 sqrt(H / g) = 1 s, where it is judged.
    """

    beyond: float = -2.0
    title = "endless slope of sand: rest below the critical angle, acceleration above"
    source = "Drucker-Prager (Klar et al. 2016) in simple shear"

    @property
    def name(self) -> str:
        """With the side of the critical angle."""
        return f"slope-{'flows' if self.beyond > 0 else 'rests'}"

    @property
    def resolutions(self) -> tuple[int, ...]:
        """A slope that flows needs depth above the layers that lag."""
        return (16, 24) if self.beyond > 0 else (8, 16)

    @property
    def acceleration(self) -> float:
        """Of the flow, downhill [m/s^2]."""
        return float(_G * np.sin(np.radians(self.beyond)) / np.cos(np.radians(critical_angle(_PHI))))

    def problem(self, numerics: Numerics) -> Problem:
        """Gravity sets in suddenly."""
        cells = numerics.resolution or self.resolutions[0]
        dx = _HEIGHT / cells
        floor = _FLOOR * dx
        x = sheet((_WIDTH, cells), dx, (4 * dx, floor - 0.5 * dx), numerics.per_axis)
        mu, lam = lame_parameters(_STIFFNESS * _RHO * _G * _HEIGHT, _NU)
        parameters = (mu, lam, np.radians(_PHI), 0.0)
        angle = np.radians(critical_angle(_PHI) + self.beyond)
        model, state = body(
            numerics,
            sheet_grid(_WIDTH + 14, cells + 8, dx),
            x,
            dx * (dx / numerics.per_axis) ** 2,
            DruckerPrager(*(jnp.full(len(x), value, numerics.dtype) for value in parameters)),
            rho=_RHO,
            speed=float(np.sqrt((lam + 2 * mu) / _RHO)),
            gravity=(_G * np.sin(angle), 0, -_G * np.cos(angle)),
            boundaries=(
                *side_walls(dx, numerics.dtype),
                Endless(4 + _MIDDLE),
                half_space((0, 0, floor), (0, 0, 1), Contact.STICKY, numerics.dtype),
            ),
        )
        top = np.flatnonzero(x[:, 2] > x[:, 2].max() - dx)
        start = float(x[top, 0].mean())
        duration = (_FLOWING if self.beyond > 0 else _STILL) * float(np.sqrt(_HEIGHT / _G))
        steps, every = observed_steps(duration, float(model.dt), 400)

        def observe(x, v, C, F):
            return jnp.stack([x[top, 0].mean() - start, v[top, 0].mean()])

        return Problem(model, state, steps, every, observe, dict(dx=dx))

    def judge(self, problem: Problem, signal: Signal) -> dict[str, float]:
        """At rest: the top's creep in cells, in all and over the second half. Flowing: its relative acceleration."""
        moved, speed = signal.values.T
        late = len(moved) // 2
        if self.beyond > 0:
            fitted = np.polyfit(signal.t[late:], speed[late:], 1)[0]
            return {"acceleration": float(fitted / self.acceleration - 1)}
        cells = moved / problem.exact["dx"]
        return {
            "creep [cells]": float(np.abs(cells).max()),
            "late creep [cells]": float(np.ptp(cells[late:])),
        }

    def bars(self, numerics: Numerics) -> dict[str, float]:
        """Less than a cell, and nothing worth mentioning at the end; or 10 %."""
        if self.beyond > 0:
            return {"acceleration": 0.10}
        return {"creep [cells]": 1.0, "late creep [cells]": 0.01}


def critical_angle(phi: float) -> float:
    """At which an endless slope of friction angle ``phi`` begins to flow; both in degrees."""
    sine = np.sin(np.radians(phi))
    return float(np.degrees(np.arctan(2 * np.sqrt(3) * sine / (3 - sine))))


def triaxial_angle(repose: float) -> float:
    """The friction angle of a slope that begins to flow at ``repose``; both in degrees."""
    slope = np.tan(np.radians(repose))
    return float(np.degrees(np.arcsin(3 * slope / (2 * np.sqrt(3) + slope))))
