"""Reading PhysGM's predictions (feed-forward physics of a captured object): class, E and nu as a `Material`.

PhysGM writes `predicted_phys.json` with decoded values, {"E": 2440000.0, "nu": 0.398, "material": "Rubber"}. Its
network's own outputs are standardised: E = 0.1 * 10^(2.456477 m + 7.387210), nu = 0.111 m + 0.398; they are
read as well, as {"E_mu": ..., "nu_mu": ..., "phys_logits": [14 numbers]} or with "material" for the logits.

It predicts neither density nor strength: those are the library's, the strength with the strain at yield kept.
PhysGM's own simulation lumps its classes (wood, glass and plastic are all its elastic `metal`, of one density).
"""

from __future__ import annotations

import math

from pydantic import ValidationError

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import format_validation_error, shorten
from physagent_jax.core.strict import LARGEST
from physagent_jax.scene.config import Material
from physagent_jax.scene.materials import LIBRARY, count_substeps, replace_youngs_modulus
from physagent_jax.scene.presets import PRESETS, PresetName

# PhysGM's classes in the order of its logits, and what they are here.
CLASSES = {
    "Wood": "oak",
    "Metal": "steel",
    "Plastic": "abs",
    "Glass": "glass",
    "Fabric": "cotton_fabric",
    "Leather": "leather",
    "Ceramic": "porcelain",
    "Stone": "granite",
    "Rubber": "natural_rubber",
    "Paper": "cardboard",
    "Sand": "dry_sand",
    "Snow": "packed_snow",
    "Plasticine": "plasticine",
    "Foam": "pu_foam",
}
FALLBACK = "Rubber"  # PhysGM simulates what it has no class for as jelly, and rubber too
LARGEST_NU = 0.49
CLIP_SECONDS, EXPENSIVE = 2.0, 100_000
_LENGTH, _GRAVITY = 1.0, 9.8  # an object's longest side here [m]; [m/s^2]


def decode_youngs_modulus(standardised: float) -> float:
    """E [Pa] of the network's output; inf where it has no number."""
    exponent = 2.456477 * standardised + 7.387210
    return 0.1 * 10**exponent if exponent < 300 else math.inf


def decode_poissons_ratio(standardised: float) -> float:
    """nu of the network's output."""
    return 0.111 * standardised + 0.398


def import_physgm(data: object, *, warn_of_cost: bool = True) -> tuple[Material, list[str]]:
    """The material of a prediction.

    Args:
        data: Decoded `predicted_phys.json`, or the network's standardised outputs.
        warn_of_cost: Whether a stiffness that needs many substeps is worth a warning.

    Returns:
        The material, and a warning for each value that had to be changed or will not simulate well.

    Raises:
        UserError: A key is missing or has the wrong type.
    """
    if not isinstance(data, dict):
        raise UserError("a PhysGM prediction is a JSON object", got=type(data).__name__, do="Check the file")
    warnings: list[str] = []
    if "E_mu" in data or "nu_mu" in data:
        youngs_modulus = decode_youngs_modulus(_read_number(data, "E_mu"))
        poissons_ratio = decode_poissons_ratio(_read_number(data, "nu_mu"))
    else:
        youngs_modulus, poissons_ratio = _read_number(data, "E"), _read_number(data, "nu")
    if not (math.isfinite(youngs_modulus) and youngs_modulus > 0):
        raise UserError(
            "PhysGM prediction: E must be positive and finite", got=youngs_modulus, do="Mend the file"
        )
    name = _read_class(data, warnings)
    nu = min(max(poissons_ratio, 0.0), LARGEST_NU)
    if nu != poissons_ratio:
        warnings.append(
            f"PhysGM predicts nu = {poissons_ratio:.4g}, outside [0, {LARGEST_NU}]: {nu:g} is taken"
        )
    known = LIBRARY[CLASSES[name]]
    try:
        material = replace_youngs_modulus(known.material, youngs_modulus).changed(
            poissons_ratio=nu,
            reason=f"PhysGM predicts {name}, E = {youngs_modulus:.3g} Pa, nu = {poissons_ratio:.3g}; "
            f"the rest as of {known.name} ({known.what})",
        )
    except ValidationError as error:
        raise format_validation_error(error, "PhysGM prediction", do="Mend the file") from None
    warnings += _find_too_soft(material) or (_find_too_stiff(material) if warn_of_cost else [])
    return material, warnings


def _find_too_soft(material: Material) -> list[str]:
    weight = material.density * _GRAVITY * _LENGTH
    if material.youngs_modulus >= weight:
        return []
    return [
        "the predicted material is softer than needed to carry its own weight "
        f"({weight / material.youngs_modulus:.2g} times): the object will collapse under gravity; a larger "
        "`material.youngs_modulus` overrules it"
    ]


def _find_too_stiff(material: Material) -> list[str]:
    many = count_substeps(material, PRESETS[PresetName.FAST].domain.dx, CLIP_SECONDS)
    if many <= EXPENSIVE:
        return []
    return [
        f"the predicted material is so stiff that a clip of {CLIP_SECONDS:g} s takes at least {many:,} substeps on "
        "the fast preset's grid: `material.soften` makes it affordable"
    ]


def _read_class(data: dict, warnings: list[str]) -> str:
    if "material" not in data and "phys_logits" in data:
        logits = data["phys_logits"]
        if not isinstance(logits, list) or len(logits) != len(CLASSES) or not all(map(_is_finite, logits)):
            raise UserError(
                f"PhysGM prediction: `phys_logits` must be {len(CLASSES)} numbers",
                got=repr(logits)[:60],
                do="Mend the file",
            )
        return list(CLASSES)[logits.index(max(logits))]
    name = data.get("material")
    if not isinstance(name, str):
        raise UserError(
            "PhysGM prediction: `material` must be a class name", got=repr(name)[:60], do="Mend the file"
        )
    if name in CLASSES:
        return name
    warnings.append(
        f"PhysGM's class {shorten(name, 60)!r} is not known: the object is taken as rubber, as PhysGM does"
    )
    return FALLBACK


def _read_number(data: dict, key: str) -> float:
    if key not in data:
        raise UserError(f"PhysGM prediction: `{key}` is missing", do="Pass PhysGM's predicted_phys.json")
    value = data[key]
    if not _is_finite(value):
        raise UserError(
            f"PhysGM prediction: `{key}` must be a finite number", got=repr(value)[:60], do="Mend the file"
        )
    return float(value)


def _is_finite(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and -LARGEST <= value <= LARGEST
