"""Softer stand-ins for stiff materials, which keep what can be seen.

An explicit step resolves the sound wave through one cell, so that steel costs a thousand times more substeps
than rubber although neither visibly compresses. A softer stand-in of the same density bends more under the
same load, and is otherwise the same material.
"""

from __future__ import annotations

import math

from pydantic import ValidationError

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import format_validation_error
from physagent_jax.scene.config.material import ELASTIC_MODELS, WITHOUT_STRESS, Material, MaterialModel
from physagent_jax.scene.materials.cost import count_substeps, stiffness

SEEN = 0.01
"""Strain that can be seen: about a pixel of an object that is a hundred pixels long."""
SOFT = 10.0
"""[m] E / rho g of what visibly sags and quivers: jelly."""
STIFFEST = 1e7
"""[m] E / rho g of the stiffest matter: ceramics."""
HARD = 1e5
"""[m] E / rho g from which on nobody sees a body deform under its weight, pushes or falls: plastics, wood, metals."""
BULKY = 0.45
"""[1] nu from which on nobody sees that the volume stays: at 0.49 sound is twice as fast, and the step half as long."""
STANDARD_GRAVITY = 9.80665
"""[m/s^2]."""
_SCALED = ("yield_stress", "hardening_modulus", "softening_modulus", "plastic_viscosity", "bulk_modulus")


def is_hard(material: Material) -> bool:
    """Return whether a true material deforms by less than can be seen (`HARD`)."""
    elastic = material.model in ELASTIC_MODELS - {MaterialModel.DRUCKER_PRAGER, MaterialModel.SNOW}
    return elastic and material.youngs_modulus > HARD * material.density * STANDARD_GRAVITY


def soften_material(material: Material, factor: float) -> Material:
    """A stand-in ``factor`` times as soft; the stable step grows by sqrt(factor).

    Density, nu and all strains stay: yield stress, hardening, softening and plastic viscosity are divided like
    E, so that it yields at the same strain and relaxes in the same time. The damping of a solid is divided by
    sqrt(factor), which keeps its damping ratio; the viscosity of a fluid stays, since it decides how it flows.
    Friction and cohesion of granular matter stay as well: whether a heap stands is decided by strength over
    weight, not over stiffness.

    Raises:
        UserError: ``factor`` is below 1, not finite or beyond sense, or there is nothing to soften.
    """
    if not (math.isfinite(factor) and factor >= 1):
        raise UserError(
            "a material is softened by a factor of at least 1", got=factor, do="1 changes nothing"
        )
    if factor == 1:
        return material
    if material.model in WITHOUT_STRESS:
        raise UserError(
            f"a {material.model} body has no stiffness that could be softened", do="Choose another material"
        )
    try:
        soft = _scale(material, 1 / factor)
    except ValidationError as error:
        raise format_validation_error(error, "the softened material", do="Soften it less") from None
    return soft.changed(
        reason=f"{_join(material.reason)}{factor:g} times as soft, with the same strains at yield"
    )


def replace_youngs_modulus(material: Material, youngs_modulus: float) -> Material:
    """The material with another E [Pa] and the same strains; see `soften_material`."""
    return _scale(material, youngs_modulus / material.youngs_modulus)


def soften_for(material: Material, *, dx: float, duration: float, at_most: int = 10_000) -> Material:
    """The material, softened just enough for a clip of ``duration`` [s] to take ``at_most`` substeps.

    Raises:
        UserError: The viscosity alone needs more substeps; softening does not help.
    """
    return soften_material(material, find_softening(material, dx=dx, duration=duration, at_most=at_most))


def find_softening(material: Material, *, dx: float, duration: float, at_most: int) -> float:
    """The factor of `soften_for`, rounded up to two digits; 1 if nothing is to be done.

    Raises:
        UserError: As `soften_for`.
    """
    if count_substeps(material, dx, duration) <= at_most:
        return 1.0
    # From the condition of `mpm.timestep`, dt^2 (4 k / m) + 2 dt (8 eta / m) = 4 with m = rho dx^2.
    step, inertia = duration / at_most, material.density * dx**2
    viscous = 4 - 16 * step * (material.viscosity or 0.0) / inertia
    if material.model is not MaterialModel.FLUID:
        factor = _compute_damped_factor(material, step, inertia)
    elif viscous <= 0:
        raise UserError(
            f"a viscosity of {material.viscosity:g} Pa s needs more than {at_most} substeps on this grid, "
            "however soft the matter",
            do="Use a coarser grid or a lower viscosity",
        )
    else:
        factor = stiffness(material) * 4 * step**2 / (viscous * inertia)
    digits = 10 ** (math.floor(math.log10(factor)) - 1)
    return max(1.0, math.ceil(factor / digits - 1e-9) * digits)


def find_contrast(material: Material, *, dx: float, duration: float, at_most: int) -> float:
    """The factor that softens a true material for pictures, and keeps its place among the others.

    Softened just to what a clip affords, rubber, wood and steel would all end at the same speed of sound, and move
    alike. The number of its own lengths of 1 m that a material bears at a strain of 1, R = E / rho g, is compressed
    instead: R = `SOFT` (jelly) stays, `STIFFEST` becomes what is affordable, and what lies between goes by powers.

    Args:
        material: The true material.
        dx: Cell length [m].
        duration: Length of the clip [s].
        at_most: Number of substeps that a clip affords.

    Raises:
        UserError: As `find_softening`.
    """
    least = find_softening(material, dx=dx, duration=duration, at_most=at_most)
    borne = _compute_bearing_modulus(material) / (material.density * STANDARD_GRAVITY)
    if material.model is MaterialModel.FLUID or not SOFT < borne < STIFFEST:
        return least
    stiffest = _scale(material, STIFFEST / borne).changed(poissons_ratio=0.3)
    top = STIFFEST / find_softening(stiffest, dx=dx, duration=duration, at_most=at_most)
    power = min(1.0, math.log(max(top / SOFT, 1.0)) / math.log(STIFFEST / SOFT))
    factor = borne / (SOFT * (borne / SOFT) ** power)
    digits = 10 ** (math.floor(math.log10(factor)) - 1)
    return max(least, math.ceil(factor / digits - 1e-9) * digits)


def limit_poissons_ratio(material: Material) -> Material:
    """A stand-in for pictures whose nu is `BULKY` at most: of the same E, it bends and stretches as before."""
    nu = material.poissons_ratio
    if nu is None or nu <= BULKY:
        return material
    return material.changed(
        poissons_ratio=BULKY, reason=f"{_join(material.reason)}nu {BULKY:g} in place of {nu:g}"
    )


def explain_softening(before: Material, after: Material, *, length: float = 1.0) -> str | None:
    """Explain the visible differences of a softer stand-in; None if there are none.

    The measure is the strain of a column of ``length`` under its own weight, rho g L / E (K of a fluid): the loads of
    the force fields are of the same order. Slender parts bend more than that.

    Args:
        before: The material.
        after: Its stand-in.
        length: The object's longest side [m].
    """
    load = before.density * STANDARD_GRAVITY * length
    old, new = load / _compute_bearing_modulus(before), load / _compute_bearing_modulus(after)
    yields = before.yield_stress is not None and before.yield_stress > load >= (after.yield_stress or 0.0)
    if new - old < SEEN and not yields:
        return None
    factor = _compute_bearing_modulus(before) / _compute_bearing_modulus(after)
    name = f"softened {factor:.3g} times, this material looks different"
    strain = f"its own weight strains it by {100 * new:.2g} % in place of {100 * old:.2g} %"
    return f"{name}: {strain}{', and makes it yield' if yields else ''}; soften it less, or not at all"


def _compute_bearing_modulus(material: Material) -> float:
    """Modulus [Pa] that bears a body's own weight."""
    fluid = material.model is MaterialModel.FLUID
    return (material.bulk_modulus or math.inf) if fluid else (material.youngs_modulus or math.inf)


def _compute_damped_factor(material: Material, step: float, inertia: float) -> float:
    """Damping shrinks with the root of the factor, so that root solves 4 f - 16 dt eta sqrt(f) / m = 4 k dt^2 / m."""
    damping = 2 * step * (material.viscosity or 0.0) / inertia
    root = damping + math.sqrt(damping**2 + stiffness(material) * step**2 / inertia)
    return root**2


def _scale(material: Material, share: float) -> Material:
    names = [name for name in _SCALED if getattr(material, name) is not None]
    changes = {name: share * getattr(material, name) for name in ("youngs_modulus", *names)}
    if material.viscosity is not None and material.model is not MaterialModel.FLUID:
        changes["viscosity"] = math.sqrt(share) * material.viscosity
    return material.changed(**changes)


def _join(reason: str) -> str:
    return f"{reason}; " if reason else ""
