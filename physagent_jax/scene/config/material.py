"""The schema of an object's material."""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field, model_validator

from physagent_jax.core.strict import Strict
from physagent_jax.scene.config.common import HalfSize, Point


class MaterialModel(enum.StrEnum):
    """Constitutive models.

    NEO_HOOKEAN, FIXED_COROTATED, HENCKY: elastic. VON_MISES: metal, hardens. PLASTICINE: yields and softens.
    DRUCKER_PRAGER: sand, soil. BRITTLE: breaks into pieces. VISCOPLASTIC: foam, paste; flows at a finite rate.
    SNOW: Stomakhin et al. 2013. FLUID: weakly compressible liquid.
    RIGID: keeps its shape and moves as one body. STATIONARY: never moves.
    """

    NEO_HOOKEAN = "neo_hookean"
    FIXED_COROTATED = "fixed_corotated"
    HENCKY = "hencky"
    VON_MISES = "von_mises"
    PLASTICINE = "plasticine"
    DRUCKER_PRAGER = "drucker_prager"
    BRITTLE = "brittle"
    VISCOPLASTIC = "viscoplastic"
    SNOW = "snow"
    FLUID = "fluid"
    RIGID = "rigid"
    STATIONARY = "stationary"


_REQUIRED = "required"
_DERIVED = "derived from E and nu"
_VISCOSITY = {"viscosity": None}
_DAMPING = {"damping_ratio": None, **_VISCOSITY}

# What each model takes besides E, nu and density, with its default (None = not used unless given).
MODEL_PARAMETERS: Mapping[MaterialModel, Mapping[str, Any]] = {
    MaterialModel.NEO_HOOKEAN: _DAMPING,
    MaterialModel.FIXED_COROTATED: _DAMPING,
    MaterialModel.HENCKY: _DAMPING,
    MaterialModel.VON_MISES: {"yield_stress": _REQUIRED, "hardening_modulus": 0.0, **_DAMPING},
    MaterialModel.PLASTICINE: {"yield_stress": _REQUIRED, "softening_modulus": 0.0, **_DAMPING},
    MaterialModel.DRUCKER_PRAGER: {"friction_angle": 30.0, "cohesion": 0.0, **_VISCOSITY},
    MaterialModel.BRITTLE: {"friction_angle": 30.0, "cohesion": _REQUIRED, "fragments": None, **_DAMPING},
    MaterialModel.VISCOPLASTIC: {"yield_stress": _REQUIRED, "plastic_viscosity": 0.0, **_DAMPING},
    # Stomakhin et al. 2013, table 2; their hardening has no cap, an explicit step needs one.
    MaterialModel.SNOW: {
        "critical_compression": 2.5e-2,
        "critical_stretch": 7.5e-3,
        "hardening_coefficient": 10.0,
        "hardening_cap": 20.0,
        **_VISCOSITY,
    },
    MaterialModel.FLUID: {"bulk_modulus": _DERIVED, "tension": False, **_VISCOSITY},
    MaterialModel.RIGID: {"restitution": None},
    MaterialModel.STATIONARY: {},
}
OPTIONAL_PARAMETERS = tuple(dict.fromkeys(name for each in MODEL_PARAMETERS.values() for name in each))
WITHOUT_STRESS = frozenset({MaterialModel.RIGID, MaterialModel.STATIONARY})
ELASTIC_MODELS = frozenset(MaterialModel) - {MaterialModel.FLUID} - WITHOUT_STRESS
"""Models whose stress depends on E and nu."""

_GENERAL_DEFAULTS = {
    MaterialModel.SNOW: {"youngs_modulus": 1.4e5, "poissons_ratio": 0.2, "density": 400.0},
    MaterialModel.FLUID: {"density": 1000.0},
}
_Share = Annotated[float, Field(ge=1e-6, lt=1)]
# Diamond has E = 1.2e12 Pa; K of a fluid with nu near 1/2 is up to 170 times its E.
_Modulus = Annotated[float, Field(ge=0, le=1e15)]  # [Pa]
_Strength = Annotated[float, Field(ge=1e-6, le=1e16)]  # [Pa]
_Viscosity = Annotated[float, Field(ge=0, le=1e15)]  # [Pa s]; pitch has 2e8, a glacier 1e13


class Material(Strict):
    """A homogeneous material.

    Only the parameters of its model may be set (`MODEL_PARAMETERS`); what is left out or null takes the
    model's default, so that a dumped material says all that acts. For `snow`, E, nu and density default to
    1.4e5 Pa, 0.2 and 400 kg/m^3; a `fluid` has 1000 kg/m^3.

    Attributes:
        model: Constitutive model.
        youngs_modulus: E [Pa].
        poissons_ratio: nu, in [0, 0.499).
        density: Mass density [kg/m^3].
        reason: Where these values come from, for the report.
        damping_ratio: Share of critical damping of the object's own lowest mode, whose swing dies out as
            exp(-zeta w t); half the loss factor. What the simulation makes of it: `scene.damping`.
        viscosity: Newtonian viscosity of a fluid, Kelvin-Voigt damping of a solid [Pa s]; in place of a ratio.
        yield_stress: Uniaxial von Mises yield stress [Pa]; required where a model has one.
        hardening_modulus: Its growth per equivalent plastic strain [Pa]; default 0.
        softening_modulus: Its loss per equivalent plastic strain [Pa]; default 0.
        plastic_viscosity: Overstress over the rate of plastic flow [Pa s]; default 0, flow without delay.
        friction_angle: Internal friction [degrees]; default 30.
        cohesion: Shear strength without pressure [Pa]; default 0 of grains, required of what is brittle.
        fragments: Number of pieces into which brittle matter breaks, between which alone it is weak
            (`scene.fragments`); default: it is equally strong everywhere.
        critical_compression: Strain at which snow crushes; default 2.5e-2.
        critical_stretch: Strain at which snow tears; default 7.5e-3.
        hardening_coefficient: xi; crushed snow is exp(xi (1 - J_p)) times as stiff; default 10.
        hardening_cap: Largest such factor; default 20.
        bulk_modulus: K of a fluid [Pa]; default E / (3 (1 - 2 nu)). Without E, E follows from K.
        tension: Whether a fluid resists being pulled apart; default false.
        restitution: Coefficient of restitution of a rigid body against the ground and walls; default 0. What deforms
            rebounds as its elasticity lets it.
    """

    model: MaterialModel = MaterialModel.NEO_HOOKEAN
    youngs_modulus: Annotated[float, Field(ge=1e-3, le=1e13)] = 1e5
    poissons_ratio: float = Field(default=0.3, ge=0, lt=0.499)
    density: Annotated[float, Field(ge=1e-3, le=1e6)] = 200.0
    reason: str = ""
    damping_ratio: Annotated[float, Field(ge=0, le=1)] | None = None
    viscosity: _Viscosity | None = None
    yield_stress: _Strength | None = None
    hardening_modulus: _Modulus | None = None
    softening_modulus: _Modulus | None = None
    plastic_viscosity: _Viscosity | None = None
    friction_angle: Annotated[float, Field(ge=0, lt=90)] | None = None
    cohesion: _Modulus | None = None
    fragments: Annotated[int, Field(ge=2, le=1000)] | None = None
    critical_compression: _Share | None = None
    critical_stretch: _Share | None = None
    hardening_coefficient: Annotated[float, Field(ge=0, le=1e3)] | None = None
    hardening_cap: Annotated[float, Field(ge=1, le=1e6)] | None = None
    bulk_modulus: _Strength | None = None
    tension: bool | None = None
    restitution: Annotated[float, Field(ge=0, le=1)] | None = None

    @model_validator(mode="before")
    @classmethod
    def _fill(cls, data: Any) -> Any:
        model = _find_model(data)
        if model is None:
            return data
        given = {key: value for key, value in data.items() if value is not None}
        filled = {**_GENERAL_DEFAULTS.get(model, {}), **data}
        if model is MaterialModel.FLUID:
            filled |= _compute_fluid_moduli(given)
        for name, default in MODEL_PARAMETERS[model].items():
            if name not in given and default not in (None, _REQUIRED, _DERIVED):
                filled[name] = default
        return filled

    @model_validator(mode="after")
    def _check_belonging(self) -> Material:
        takes = MODEL_PARAMETERS[self.model]
        for name in OPTIONAL_PARAMETERS:
            given = getattr(self, name) is not None
            if given and name not in takes:
                known = ", ".join(f"`{own}`" for own in takes) or "none"
                raise ValueError(f"`{name}` has no meaning for `{self.model}` (its own parameters: {known})")
            if not given and takes.get(name) == _REQUIRED:
                raise ValueError(f"`{self.model}` needs `{name}`")
        if self.damping_ratio is not None and self.viscosity is not None:
            raise ValueError("`damping_ratio` and `viscosity` both say how motion dies out: give one of them")
        return self

    def changed(self, **changes: Any) -> Material:
        """The same with ``changes``; what has no meaning for a new model is dropped, the rest is kept.

        A fluid's K follows a change of E or nu unless K itself is given.

        Raises:
            pydantic.ValidationError: The changed material breaks the schema.
        """
        values = {**self.model_dump(), **changes}
        takes = MODEL_PARAMETERS.get(_find_model(values) or self.model, {})
        dropped = {name for name in OPTIONAL_PARAMETERS if name not in takes}
        if {"youngs_modulus", "poissons_ratio"} & changes.keys():
            dropped.add("bulk_modulus")
        for name in dropped - changes.keys():
            values[name] = None
        return Material.model_validate(values)


class MaterialRegion(Strict):
    """Another material inside an absolute box.

    Attributes:
        point: Centre [m].
        half_size: Half extents [m].
        material: The material there.
    """

    point: Point
    half_size: HalfSize
    material: Material


class Bearing(Strict):
    """The parts that bear an object's weight are as stiff as that takes (`scene.burden`), the others as their material.

    Attributes:
        ground: Height of the ground on which it stands [m]; null = it hangs on what is held.
        weight: Share of the weight that is borne; over 1 for what is to spring up again where it lands.
        most: Largest factor of Young's modulus of any part.
    """

    ground: Annotated[float, Field(ge=-1e6, le=1e6)] | None = None
    weight: Annotated[float, Field(ge=0, le=10)] = 1.0
    most: Annotated[float, Field(ge=1, le=1e12)] = 1.0


def _find_model(data: Any) -> MaterialModel | None:
    """The model that raw data names; None where the schema will complain itself."""
    if not isinstance(data, dict):
        return None
    try:
        return MaterialModel(data.get("model", MaterialModel.NEO_HOOKEAN))
    except ValueError:
        return None


def _compute_fluid_moduli(given: dict) -> dict[str, float]:
    """K from E and nu, or E from K, whichever is missing; nothing where a number is not one."""
    nu = given.get("poissons_ratio", 0.3)
    known = given.get("bulk_modulus", given.get("youngs_modulus", 1e5))
    if not (_is_number(nu) and _is_number(known) and 0 <= nu < 0.499):
        return {}
    factor = 3 * (1 - 2 * nu)
    if "bulk_modulus" not in given:
        return {"bulk_modulus": known / factor}
    return {} if "youngs_modulus" in given else {"youngs_modulus": known * factor}


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
