"""Cross-sections of a body across an axis, and where a pull along it strains them most."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer

from physagent_jax.forces.parameters import Array

SECTIONS, SECTION_WIDTH = 32, 0.1  # cross-sections looked at, and half their thickness in body lengths
_TINY = float(np.finfo(np.float32).tiny)


def find_stress_concentration(
    rest: np.ndarray, volume: np.ndarray, axis: Array, extent: float
) -> Array | float:
    """The strain of a `scale` in the weakest section over that in a uniform bar's middle; at least 1.

    A pull grows along the object and is carried by its cross-section: a thin neck with much behind it
    would tear where a bar only stretches. Compared are the pull beyond a section over the section's
    area, largest over sections across the axis, and L / 2 of the bar.

    Args:
        rest: Rest positions of the pulled particles [m], shape (n, 3).
        volume: Their rest volumes [m^3], shape (n,).
        axis: Unit vector, shape (3,), traced or not.
        extent: Longest extent L of the object [m].
    """
    if extent == 0:  # all particles in one place
        return 1.0
    xp = jnp if isinstance(axis, Tracer) else np
    volume = volume.astype(xp.result_type(float))
    height = rest @ axis
    side = xp.sign(height - xp.average(height, weights=volume))
    pull = volume * (side - xp.average(side, weights=volume))

    def stress(section):
        # A tent of width 2 w instead of a sharp cut, so that layers of particles do not alias.
        distance = (height - section) / (SECTION_WIDTH * extent)
        area = (volume * xp.maximum(1 - xp.abs(distance), 0)).sum() / (SECTION_WIDTH * extent)
        return xp.abs((pull * xp.clip(0.5 + 0.5 * distance, 0, 1)).sum()) / xp.maximum(area, _TINY)

    sections = xp.linspace(height.min(), height.max(), SECTIONS)
    largest = max(map(stress, sections)) if xp is np else jax.lax.map(stress, sections).max()
    return xp.maximum(1.0, largest / (0.5 * extent))
