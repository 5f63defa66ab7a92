"""PhysGaussian's materials in our conventions.

Its metal and plasticine bound |dev tau| itself, ours sigma_y = sqrt(3/2) |dev tau| is the stress of a bar that
yields; its foam compares with sqrt(2/3) sigma_y already. Its bound grows or falls per |d eps_plastic|, ours per
equivalent plastic strain, which is sqrt(2/3) of it. Hence

    sigma_y = sqrt(3/2) yield_stress,  H = sqrt(3/2) 2 mu xi sqrt(3/2) = 3 mu xi,  S = 3/2 softening.

Its fluid (that of warp-mpm, which PhysGaussian names and then refuses) has p = K (J^-1.1 - 1): our K is 1.1 of it.
"""

from __future__ import annotations

import math

from physagent_jax.core.errors import UserError
from physagent_jax.core.names import suggest
from physagent_jax.core.reading import shorten
from physagent_jax.scene.config import Material, MaterialModel
from physagent_jax.scene.physgaussian_conditions import ConditionReader

# The keys that each of its materials reads besides E, nu and density.
_KEYS = {
    "jelly": (),
    "metal": ("yield_stress", "hardening", "xi"),
    "sand": ("friction_angle",),
    "foam": ("yield_stress", "plastic_viscosity"),
    "snow": (),
    "plasticine": ("yield_stress", "softening", "hardening", "xi"),
    "fluid": ("bulk_modulus",),
}
_PLASTIC_KEYS = frozenset(key for keys in _KEYS.values() for key in keys)
MATERIAL_KEYS = _PLASTIC_KEYS | {"material", "E", "nu", "density"}
_WATER_EXPONENT = 1.1

_STRESS = "PhysGaussian's stress is wrong by a factor of the stretch; here it is Hencky's"
_DIFFERENCES = {
    "metal": _STRESS,
    "foam": _STRESS,
    "sand": "sand that was pulled apart gives its gained volume back before it bears pressure, which PhysGaussian "
    "leaves out, and every particle has its own volume where PhysGaussian takes the mean",
    "snow": "PhysGaussian's snow has no stress at all; here Stomakhin's law acts, with the parameters of its paper",
    "plasticine": "the elastic law is Hencky's where PhysGaussian has the fixed-corotated one, and what has lost all "
    "strength still resists compression",
    "fluid": "PhysGaussian itself refuses `fluid`: it is read as warp-mpm's, with tension",
}


def find_unused_keys(reader: ConditionReader) -> dict[str, str]:
    """Keys of other materials than the scene's, and why they are ignored."""
    name = reader.data.get("material", "jelly")
    return {key: f"it means nothing for `{name}`" for key in _PLASTIC_KEYS - set(_KEYS.get(name, ()))}


def read_material(reader: ConditionReader, part: ConditionReader | None = None) -> tuple[Material, list[str]]:
    """The scene's material, or that of an entry of `additional_material_params`, and what acts differently here.

    Missing keys take PhysGaussian's defaults: friction_angle 25, softening 0.1, everything else 0. Without a yield
    stress its metal and foam keep no shear stress, so they become liquids, and its plasticine is elastic.

    Raises:
        UserError: An unknown material, a wrong type, or a missing key; names the key.
    """
    name = reader.data.get("material", "jelly")
    if not isinstance(name, str) or name not in _KEYS:
        near = suggest(name, _KEYS) if isinstance(name, str) else ""
        raise UserError(
            "PhysGaussian scene: `material` is unknown",
            got=shorten(repr(name), 60),
            do=f"{near if near.startswith('Did') else ''} Available: {', '.join(_KEYS)}",
        )
    if part is None:
        youngs_modulus, nu = reader.number("E", 1e5), reader.number("nu", 0.4)
        density = reader.number("density", 200.0)
    else:
        youngs_modulus, nu = part.number("E"), part.number("nu")
        density = part.number("density", reader.number("density", 200.0))
    notes = [f"`material`: {_DIFFERENCES[name]}"] if name in _DIFFERENCES else []
    law = _read_law(name, reader, youngs_modulus, nu, notes)
    origin = f"PhysGaussian's `{name}`" if part is None else "PhysGaussian's `additional_material_params`"
    values = {"youngs_modulus": youngs_modulus, "poissons_ratio": nu, "density": density, "reason": origin}
    return Material.model_validate(values | law), notes


def _read_law(name: str, reader: ConditionReader, youngs_modulus: float, nu: float, notes: list[str]) -> dict:
    """The model and its own parameters; E and nu may still be out of range."""
    mu = youngs_modulus / (2 * (1 + nu)) if nu > -1 else 0.0
    match name:
        case "metal":
            return _read_metal(reader, mu, notes)
        case "sand":
            return {
                "model": MaterialModel.DRUCKER_PRAGER,
                "friction_angle": reader.number("friction_angle", 25.0),
                "cohesion": 0.0,
            }
        case "foam":
            return _read_foam(reader, notes)
        case "snow":
            return {"model": MaterialModel.SNOW}
        case "plasticine":
            return _read_plasticine(reader, mu, notes)
        case "fluid":
            bulk = youngs_modulus / (3 * (1 - 2 * nu)) if nu < 0.5 else 1.0
            bulk_modulus = _WATER_EXPONENT * reader.number("bulk_modulus", bulk)
            return {"model": MaterialModel.FLUID, "tension": True, "bulk_modulus": bulk_modulus}
        case _:
            return {"model": MaterialModel.FIXED_COROTATED}


def _read_metal(reader: ConditionReader, mu: float, notes: list[str]) -> dict:
    bound = reader.number("yield_stress", 0.0)
    if bound <= 0:
        notes.append(_find_no_yield_stress("metal", "a liquid: it keeps no shear stress"))
        return {"model": MaterialModel.FLUID, "tension": True}
    return {
        "model": MaterialModel.VON_MISES,
        "yield_stress": math.sqrt(1.5) * bound,
        "hardening_modulus": 3 * mu * _read_hardening(reader),
    }


def _read_foam(reader: ConditionReader, notes: list[str]) -> dict:
    yield_stress = reader.number("yield_stress", 0.0)
    viscosity = reader.number("plastic_viscosity", 0.0)
    if yield_stress <= 0:
        notes.append(
            _find_no_yield_stress("foam", "a liquid of half its plastic viscosity, as slow flow of it is")
        )
        # Slow steady flow: dev tau = plastic_viscosity d, and a liquid has 2 eta d.
        return {"model": MaterialModel.FLUID, "tension": True, "viscosity": 0.5 * viscosity}
    return {"model": MaterialModel.VISCOPLASTIC, "yield_stress": yield_stress, "plastic_viscosity": viscosity}


def _read_plasticine(reader: ConditionReader, mu: float, notes: list[str]) -> dict:
    bound = reader.number("yield_stress", 0.0)
    if bound <= 0:
        notes.append(_find_no_yield_stress("plasticine", "elastic: its return mapping then does nothing"))
        return {"model": MaterialModel.FIXED_COROTATED}
    softening = 1.5 * reader.number("softening", 0.1) - 3 * mu * _read_hardening(reader)
    law = {"yield_stress": math.sqrt(1.5) * bound}
    if softening >= 0:
        return law | {"model": MaterialModel.PLASTICINE, "softening_modulus": softening}
    notes.append(
        "`xi` hardens this plasticine more than `softening` softens it: it is read as metal that hardens"
    )
    return law | {"model": MaterialModel.VON_MISES, "hardening_modulus": -softening}


def _read_hardening(reader: ConditionReader) -> float:
    """`xi`, which acts only if `hardening` is 1."""
    return reader.number("xi", 0.0) if reader.number("hardening", 0.0) == 1 else 0.0


def _find_no_yield_stress(name: str, outcome: str) -> str:
    return f"`yield_stress` is missing or 0, with which PhysGaussian's {name} is {outcome}; so it is here"
