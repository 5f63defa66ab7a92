"""A material's properties by name and unit, for tables and reports."""

from __future__ import annotations

from physagent_jax.scene.config.material import ELASTIC_MODELS, OPTIONAL_PARAMETERS, Material

_NAMES = {
    "damping_ratio": ("damping ratio", ""),
    "viscosity": ("viscosity", "Pa s"),
    "yield_stress": ("yield stress", "Pa"),
    "hardening_modulus": ("hardening modulus", "Pa"),
    "softening_modulus": ("softening modulus", "Pa"),
    "plastic_viscosity": ("plastic viscosity", "Pa s"),
    "friction_angle": ("friction angle", "\u00b0"),
    "cohesion": ("cohesion", "Pa"),
    "fragments": ("fragments", ""),
    "critical_compression": ("critical compression", ""),
    "critical_stretch": ("critical stretch", ""),
    "hardening_coefficient": ("hardening coefficient", ""),
    "hardening_cap": ("hardening cap", ""),
    "bulk_modulus": ("bulk modulus", "Pa"),
    "tension": ("bears tension", ""),
    "restitution": ("coefficient of restitution", ""),
}


def describe_material(material: Material) -> list[tuple[str, float | bool, str]]:
    """The active properties of a material: (name, value, unit) of each that its model uses.

    Units take SI prefixes, but for the degree and kg/m^3; "" is a pure number.
    """
    rows: list[tuple[str, float | bool, str]] = []
    if material.model in ELASTIC_MODELS:
        rows.append(("Young\u2019s modulus", material.youngs_modulus, "Pa"))
        rows.append(("Poisson\u2019s ratio", material.poissons_ratio, ""))
    rows.append(("density", material.density, "kg/m\u00b3"))
    for name in OPTIONAL_PARAMETERS:
        value = getattr(material, name)
        if value is not None:
            rows.append((_NAMES[name][0], value, _NAMES[name][1]))
    return rows
