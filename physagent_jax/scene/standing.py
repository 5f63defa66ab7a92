"""Objects that stand under their own weight: those that would fall over are held, those too soft for it made stiffer.

A captured object stood when it was captured. Whether it does in a scene is decided by its shape (mass centre over its
feet) and by the stiffness that its kind implies, which was chosen for visible motion and not for its legs.
"""

from __future__ import annotations

import dataclasses
import math

from physagent_jax.core.recent import Recent
from physagent_jax.scene.body import Body
from physagent_jax.scene.compliance import measure_lean
from physagent_jax.scene.config import Material, MaterialModel
from physagent_jax.scene.fuse import CAN_STAND, SceneTemplate
from physagent_jax.scene.materials.soften import replace_youngs_modulus
from physagent_jax.scene.world import explain_toppling

FLOWS = (MaterialModel.FLUID, MaterialModel.DRUCKER_PRAGER, MaterialModel.SNOW)
MOST_LEAN = 0.25  # by which its weight may turn or strain an object, to first order; beyond, it falls over or collapses
_recent: Recent[float] = Recent(4)


def make_stand(
    template: SceneTemplate, body: Body, *, keep_material: bool = False
) -> tuple[SceneTemplate, tuple[str, ...]]:
    """The template in which the object stands as it was captured, and in words what had to be changed for it.

    Args:
        template: The scene without its force field.
        body: Its object.
        keep_material: Leave the stiffness as it is: somebody has chosen it. What is too soft then sags, and it is said.
    """
    world, material = template.world, template.material
    if world.gravity != "down" or not world.ground or template.anchor.kind != "none":
        return template, ()
    why = explain_toppling(world, body, template.anchor, flows=material.model in FLOWS)
    if why is not None:
        floating = dataclasses.replace(world, gravity="none", ground=False)
        return dataclasses.replace(template, world=floating), (why,)
    if material.model not in CAN_STAND:
        return template, ()
    least = find_bearing_modulus(body, material)
    if material.youngs_modulus >= least:
        return template, ()
    if keep_material:
        return template, (
            f"E = {material.youngs_modulus:.2g} Pa hardly bears the object's own weight, which wants {least:.2g} Pa: "
            "it will sag or collapse",
        )
    stiffer = replace_youngs_modulus(material, least)
    why = f"made stiffer, E = {least:.2g} Pa in place of {material.youngs_modulus:.2g} Pa, so that it bears its weight"
    stiffer = stiffer.changed(reason=f"{material.reason}; {why}")
    return dataclasses.replace(template, material=stiffer), (why,)


def find_bearing_modulus(body: Body, material: Material) -> float:
    """Least Young's modulus [Pa] with which the weight turns and strains the object by `MOST_LEAN`, to two digits.

    Args:
        body: The object at rest.
        material: What it is made of.
    """
    least = _measure_lean(body, material) / MOST_LEAN * material.youngs_modulus
    digits = 10.0 ** (math.floor(math.log10(max(least, 1e-12))) - 1)
    return math.ceil(least / digits - 1e-9) * digits


def _measure_lean(body: Body, material: Material) -> float:
    """`measure_lean`, remembered: scenes of an object differ in what acts, and it takes longer than they do."""
    return _recent.find(body, material, lambda: measure_lean(body, material))
