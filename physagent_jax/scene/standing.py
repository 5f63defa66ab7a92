"""Objects that stay as they were captured under their own weight, standing or held, until something acts.

A captured object stood when it was captured. Whether it does in a scene is decided by its shape (mass centre over its
feet) and by the stiffness that its kind implies, which was chosen for visible motion and not for thin legs or stems:
what they carry strains them, or makes them buckle (`scene.burden`). Such an object is made stiffer, as far as that can
be simulated. Where it is not enough, or somebody has chosen the stiffness, the weight is left out: what is held stays
where it is, what is free floats there.
"""

from __future__ import annotations

import dataclasses
import math

from physagent_jax.scene.body import Body
from physagent_jax.scene.config import Material, MaterialModel
from physagent_jax.scene.fuse import SceneTemplate, find_own_burden, is_borne
from physagent_jax.scene.materials.cost import find_affordable_modulus
from physagent_jax.scene.materials.soften import replace_youngs_modulus
from physagent_jax.scene.world import explain_toppling

FLOWS = (MaterialModel.FLUID, MaterialModel.DRUCKER_PRAGER, MaterialModel.SNOW)
MOST_STRAIN = 0.25  # by which its weight may strain an object, to first order; beyond, it collapses
MOST_BUCKLING = 0.75  # of the stress under which it gives way; the probe's grid is coarse


def make_stand(
    template: SceneTemplate, body: Body, *, keep_material: bool = False, keep_weight: bool = False
) -> tuple[SceneTemplate, tuple[str, ...]]:
    """The template in which the object stays as it was captured, and in words what had to be changed for it.

    Args:
        template: The scene without its force field.
        body: Its object.
        keep_material: Leave the stiffness as it is: somebody has chosen it.
        keep_weight: Leave gravity as it is: the sentence needs it. What cannot bear its weight then collapses.
    """
    world, material = template.world, template.material
    if not keep_weight:
        why = explain_toppling(world, body, template.anchor, flows=material.model in FLOWS)
        if why is not None:
            return _take_weight(template), (why,)
    if not is_borne(template):
        return template, ()
    needed = find_bearing_modulus(template, body)
    if material.youngs_modulus >= needed:
        return template, ()
    if not keep_material:
        most = max(find_affordable_modulus(material, template.preset.domain.dx), material.youngs_modulus)
        template = _stiffen(template, min(needed, most))
        if most >= needed:
            return template, (explain_stiffening(needed / material.youngs_modulus),)
    why = _explain_collapse(template, needed, chosen=keep_material, falls=keep_weight)
    return template if keep_weight else _take_weight(template), (why,)


def find_bearing_modulus(template: SceneTemplate, body: Body) -> float:
    """Least Young's modulus [Pa] that bears the weight within `MOST_STRAIN` and `MOST_BUCKLING`, to two digits."""
    burden = find_own_burden(template, body)
    share = max(burden.strain / MOST_STRAIN, burden.buckling / MOST_BUCKLING)
    least = max(share * template.material.youngs_modulus, 1e-12)
    digits = 10.0 ** (math.floor(math.log10(least)) - 1)
    return math.ceil(least / digits - 1e-9) * digits


def explain_stiffening(times: float) -> str:
    """Explain that a material was made ``times`` as stiff."""
    return f"made {times:.2g} times as stiff, so that it stands under its own weight"


def _stiffen(template: SceneTemplate, youngs_modulus: float) -> SceneTemplate:
    material: Material = template.material
    times = youngs_modulus / material.youngs_modulus
    if times <= 1:
        return template
    reason = f"{material.reason}; {explain_stiffening(times)}"
    stiffer = replace_youngs_modulus(material, youngs_modulus).changed(reason=reason)
    return dataclasses.replace(template, material=stiffer)


def _take_weight(template: SceneTemplate) -> SceneTemplate:
    """The template without gravity; what is free then floats over no ground."""
    ground = template.world.ground and template.anchor.kind != "none"
    return dataclasses.replace(
        template, world=dataclasses.replace(template.world, gravity="none", ground=ground)
    )


def _explain_collapse(template: SceneTemplate, needed: float, *, chosen: bool, falls: bool) -> str:
    """Explain what is done with an object that cannot bear its weight, and which option helps."""
    why = "with the stiffness that was chosen" if chosen else "even as stiff as it can be simulated quickly"
    if falls:
        what = "it will sag or collapse"
    elif template.anchor.kind == "none":
        what = "it is held in the air as it was captured, without gravity"
    else:
        what = "its weight is left out, and it stays as it was captured"
    slower = "" if chosen else ", slowly"
    return (
        f"the object cannot carry its own weight {why}: {what}; "
        f"`material.youngs_modulus` {needed:.2g} carries it{slower}, and so does a lower `material.density`"
    )
