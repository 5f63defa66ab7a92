"""Two elastic disks meet: what the rebound loses, and when contact begins."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from benchmarks.cases.base import Numerics, Problem, Signal, observed_steps
from benchmarks.cases.elastic import neo_hookean_body
from benchmarks.cases.plane import sheet, sheet_grid, side_walls

_E, _NU, _RHO, _RADIUS, _SPEED = 1000.0, 0.3, 1000.0, 0.2, 0.1
_SIDE, _CENTRES = 1.5, (0.5, 1.0)  # of the domain, and of either disk along x and z alike [m]
_DURATION = 3.0  # [s]
_ONSET = 1e-3  # relative loss of closing speed that counts as contact

# Restitution in an independent float64 code, 9 particles per cell, MLS stress.
_REFERENCE = {20: 0.827, 40: 0.892, 80: 0.911}


class Disks:
    """E = 1000, nu = 0.3, rho = 1000, R = 0.2, v = +-(0.1, 0.1) towards each other; plane strain.

    ``resolution`` counts cells per metre: R is a fifth of it. The fields of two bodies meet when about two cells
    are left between them, so contact is early; the grid also holds them together a little when they part.
    9 particles per cell (``per_axis`` = 3), Courant number 0.3, float64:

    | cells per metre | restitution, reference | restitution | first contact, reference [s] | first contact [s] |
    |---|---|---|---|---|
    | 20 | 0.827 | 0.836 | 0.71 | 0.72 |
    | 40 | 0.892 | 0.897 | 0.92 | 0.92 |
    | 80 | 0.911 | 0.913 | 1.02 | 1.02 |

    Bodies with sharp surfaces would touch at 1.086 s.
    """

    name = "disks"
    title = "two elastic disks: restitution, onset of contact, energy, momentum"
    source = "set-up of Sulsky, Chen & Schreyer 1994; restitution of an independent code"
    resolutions = (20, 40, 80)

    def problem(self, numerics: Numerics) -> Problem:
        """From 0.31 m apart to well after the rebound."""
        cells = numerics.resolution or 20
        dx, across = 1 / cells, round(_SIDE * cells)
        square = sheet((across, across), dx, (0.0, 0.0), numerics.per_axis)
        one, other = (square[np.hypot(square[:, 0] - c, square[:, 2] - c) < _RADIUS] for c in _CENTRES)
        along = np.array([1.0, 0.0, 1.0])
        v = _SPEED * np.concatenate([np.tile(along, (len(one), 1)), np.tile(-along, (len(other), 1))])
        model, state = neo_hookean_body(
            numerics,
            sheet_grid(across, across, dx),
            np.concatenate([one, other]),
            dx * (dx / numerics.per_axis) ** 2,
            E=_E,
            nu=_NU,
            rho=_RHO,
            v=v,
            boundaries=side_walls(dx, numerics.dtype),
        )
        count, material = len(one), model.materials[0]
        mass, volume = float(model.mass[0]), float(model.volume[0])

        def observe(x, v, C, F):
            closing = ((v[:count].mean(0) - v[count:].mean(0)) * jnp.asarray(along, v.dtype)).sum() / (
                4 * _SPEED
            )
            kinetic = 0.5 * mass * ((v**2).sum() + dx**2 / 4 * (C**2).sum())
            elastic = volume * material.energy(F, ()).sum()
            momentum = jnp.sqrt((v.mean(0) ** 2).sum())
            return jnp.stack([closing, kinetic + elastic, momentum])

        steps, every = observed_steps(_DURATION, float(model.dt), 400)
        energy = 0.5 * mass * float((v**2).sum())
        return Problem(model, state, steps, every, observe, dict(energy=energy, dx=dx))

    def judge(self, problem: Problem, signal: Signal) -> dict[str, float]:
        """Restitution less the reference's; cells of gap per side at contact; energy gained; momentum lost."""
        closing, energy, momentum = signal.values.T
        restitution, dx = -closing[-1], problem.exact["dx"]
        touch = signal.t[np.argmax(closing < 1 - _ONSET)]
        gap = np.sqrt(2) * (_CENTRES[1] - _CENTRES[0] - 2 * _SPEED * touch) - 2 * _RADIUS
        return {
            "restitution": float(restitution - _REFERENCE.get(round(1 / dx), 1.0)),
            "gap at contact [cells]": float(gap / 2 / dx),
            "energy gain": float(max(0.0, energy.max() / problem.exact["energy"] - 1)),
            "momentum": float(momentum.max() / (np.sqrt(2) * _SPEED)),
        }

    def bars(self, numerics: Numerics) -> dict[str, float]:
        """1.1 cells, 1e-3, 1e-6 (float32: 1e-5), and 0.02 in restitution with the reference's 9 particles per cell."""
        momentum = 1e-6 if numerics.dtype == np.float64 else 1e-5
        bars = {"gap at contact [cells]": 1.1, "energy gain": 1e-3, "momentum": momentum}
        known = numerics.per_axis == 3 and (numerics.resolution or 20) in _REFERENCE
        return bars | ({"restitution": 0.02} if known else {})
