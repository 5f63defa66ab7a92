"""The cost of a material: the stable substep and the number of substeps of a clip."""

from __future__ import annotations

import math

from physagent_jax.scene.config.material import ELASTIC_MODELS, Material, MaterialModel

AFFORDABLE_RATE = 5000.0  # substeps of a second of the clip that a stiffness which nobody has chosen may take


def stable_step(material: Material, dx: float) -> float:
    """Longest stable substep of a material at rest [s]; inf for what has no stress.

    dx sqrt(rho / k) with k = E / (1 - 2 nu) of a solid, 3 K of a fluid (dx / (sqrt(3) c)) and the stiffness at the
    hardening cap of snow. Viscosity shortens it as in `mpm.timestep`. Stretch and speed can shorten it further.

    Args:
        material: The material.
        dx: Grid spacing [m].
    """
    inertia = material.density * dx**2
    damping = 16 * (material.viscosity or 0.0) / inertia
    rate = damping + math.sqrt(damping**2 + 64 * stiffness(material) / inertia)
    return 8 / rate if rate > 0 else math.inf


def stiffness(material: Material) -> float:
    """Largest tangent d tau / d ln lambda [Pa] that the material has at rest, or at snow's hardening cap."""
    if material.model is MaterialModel.FLUID:
        assert material.bulk_modulus is not None
        return 3 * material.bulk_modulus
    if material.model not in ELASTIC_MODELS:
        return 0.0
    at_rest = material.youngs_modulus / (1 - 2 * material.poissons_ratio)
    return at_rest * (material.hardening_cap or 1.0)


def count_substeps(material: Material, dx: float, duration: float) -> int:
    """Substeps that a clip of ``duration`` [s] needs at least."""
    step = stable_step(material, dx)
    return 1 if math.isinf(step) else math.ceil(duration / step)


def find_affordable_modulus(material: Material, dx: float) -> float:
    """Young's modulus [Pa] with which a material takes `AFFORDABLE_RATE` substeps for a second; it has no viscosity."""
    return material.youngs_modulus * (AFFORDABLE_RATE * stable_step(material, dx)) ** 2
