"""What the object is made of."""

from __future__ import annotations

import enum

from pydantic import Field

from physagent_jax.scene.config.common import Positive
from physagent_jax.strict import Strict, Vector


class MaterialModel(enum.StrEnum):
    """Constitutive models."""

    NEO_HOOKEAN = "neo_hookean"
    FIXED_COROTATED = "fixed_corotated"


class Material(Strict):
    """A homogeneous material.

    Attributes:
        model: Constitutive model.
        youngs_modulus: E [Pa].
        poissons_ratio: nu, in [0, 0.5).
        density: Mass density [kg/m^3].
        reason: Where these values come from, for the report.
    """

    model: MaterialModel = MaterialModel.NEO_HOOKEAN
    youngs_modulus: Positive = 1e5
    poissons_ratio: float = Field(default=0.3, ge=0, lt=0.499)
    density: Positive = 200.0
    reason: str = ""


class MaterialRegion(Strict):
    """Another material inside an absolute box.

    Attributes:
        point: Centre [m].
        half_size: Half extents [m].
        material: The material there.
    """

    point: Vector
    half_size: Vector
    material: Material
