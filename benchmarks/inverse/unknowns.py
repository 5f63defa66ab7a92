"""Unknowns, in coordinates u in which a search is well scaled.

As PAC-NeRF and GIC have it (GIC's `simulator/estimator.py`: powers of ten for moduli, yield stress and viscosities, a
bounded map for Poisson's ratio, degrees for the friction angle, plain components for the velocity): a change of u by 1
is a factor of e, 10 degrees, 1 m/s, or the size of what is sought.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any, Literal

import jax.numpy as jnp
import numpy as np

Chart = Literal["log", "bounded", "linear"]
MOST_POISSONS_RATIO = 0.47  # for which the problems' steps are short enough


@dataclasses.dataclass(frozen=True)
class Unknown:
    """A number or a vector.

    Attributes:
        name: A field of `MaterialParameters`, or "velocity", "gravity", "impulse" or "friction".
        unit: Unit of its values; "" = none.
        chart: "log": value = e^u; "bounded": value = unit_size / (1 + e^-u); "linear": value = unit_size u.
        unit_size: As above.
        tolerance: Within which it is found.
        measure: "relative": |found - truth| / |truth|; "absolute"; "angle": of the cone of friction, atan of both
            [degrees].
        own_bar: Whether the tolerance is ours: reference values name none for it.
        size: Numbers that it has.
    """

    name: str
    unit: str
    chart: Chart
    unit_size: float
    tolerance: float
    measure: Literal["relative", "absolute", "angle"]
    own_bar: bool = False
    size: int = 1

    def decode(self, u: Any) -> Any:
        """The value at coordinates of shape (size,); a scalar if ``size`` is 1. Traced or not."""
        exp = np.exp if isinstance(u, np.ndarray) else jnp.exp  # in double precision on the host
        if self.chart == "log":
            value = exp(u)
        elif self.chart == "bounded":
            value = self.unit_size / (1.0 + exp(-u))
        else:
            value = self.unit_size * u
        return value[0] if self.size == 1 else value

    def encode(self, value: Any) -> np.ndarray:
        """The coordinates of a value, shape (size,)."""
        known = np.atleast_1d(np.asarray(value, np.float64))
        if self.chart == "log":
            return np.log(known)
        if self.chart == "bounded":
            return np.log(known / (self.unit_size - known))
        return known / self.unit_size

    @property
    def scale(self) -> float:
        """By how much of u a start may be off: a factor of 3, half the range, 20 degrees, the whole size."""
        return {"log": math.log(3.0), "bounded": 2.0, "linear": 2.0 if self.size == 1 else 1.0}[self.chart]

    def find_error(self, found: Any, truth: Any) -> float:
        """By ``measure``."""
        a, b = (np.atleast_1d(np.asarray(value, np.float64)) for value in (found, truth))
        if self.measure == "angle":
            return float(abs(np.degrees(np.arctan(a) - np.arctan(b)))[0])
        away = float(np.linalg.norm(a - b))
        return away / float(np.linalg.norm(b)) if self.measure == "relative" else away

    def spread(self, u: np.ndarray, covariance: np.ndarray) -> float:
        """Standard error in ``measure`` at ``u``, shape (size,), whose covariance has the shape (size, size)."""
        h = 1e-4
        sizes, axes = np.linalg.eigh(covariance)
        steps = h * np.sqrt(np.maximum(sizes, 0.0))[:, None] * axes.T
        here = self.decode(u)
        return float(np.linalg.norm([self.find_error(self.decode(u + step), here) / h for step in steps]))


def _log(name: str, unit: str, tolerance: float, *, own: bool = False) -> Unknown:
    return Unknown(name, unit, "log", 1.0, tolerance, "relative", own)


UNKNOWNS = {
    each.name: each
    for each in (
        _log("youngs_modulus", "Pa", 0.01),
        Unknown("poissons_ratio", "", "bounded", MOST_POISSONS_RATIO, 0.02, "absolute"),
        _log("density", "kg/m^3", 0.01, own=True),
        _log("yield_stress", "Pa", 0.03),
        _log("viscosity", "Pa s", 0.03, own=True),
        Unknown("friction_angle", "degrees", "linear", 10.0, 1.0, "absolute"),
        Unknown("friction", "", "log", 1.0, 1.0, "angle", own_bar=True),
        Unknown("velocity", "m/s", "linear", 1.0, 1e-3, "relative", size=3),
        Unknown("impulse", "m/s", "linear", 1.0, 0.01, "relative", size=3),
        Unknown("gravity", "m/s^2", "linear", 10.0, 0.01, "relative", own_bar=True, size=3),
    )
}
"""By name."""
