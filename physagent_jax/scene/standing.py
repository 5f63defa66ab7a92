"""Objects that stay as they were captured under their own weight, standing or held, until something acts.

A captured object stood when it was captured. Whether it does in a scene is decided by its shape (mass centre over its
feet) and by the stiffness that its kind implies, which was chosen for visible motion and not for thin legs or stems:
what they carry strains them, or makes them buckle (`scene.burden`). Those parts are made stiffer, as far as that can be
simulated, and the others stay as they are. Where it is not enough, or somebody has chosen the stiffness, less weight
acts. What would fall over, or is left hardly any weight, is held at its feet, as if it were fixed to a plate. Where it
is to leave its place it is free, and what would fall over has no weight then, unless it is to fall.

Lean, stiffness, support and damping are decided here, and nowhere else.
"""

from __future__ import annotations

import dataclasses
import math
import warnings
from pathlib import Path

import numpy as np

from physagent_jax.core.strict import Vector
from physagent_jax.forces.part import split_name
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.forces.slabs import make_end_region
from physagent_jax.scene.body import Body
from physagent_jax.scene.burden import Burden, find_burden, find_firmness
from physagent_jax.scene.config import Anchor, Bearing, Domain, Material, MaterialModel, Source
from physagent_jax.scene.damping import (
    MOST_SLOWER,
    compute_viscosity,
    find_affordable_ratio,
    find_lowest_mode,
    find_slowdown,
)
from physagent_jax.scene.level import LARGEST_LEAN, LARGEST_TILT, find_tilt
from physagent_jax.scene.load import holds_splats, load_object
from physagent_jax.scene.materials.cost import find_affordable_modulus
from physagent_jax.scene.placement import place
from physagent_jax.scene.priors import explain_damping_ratio
from physagent_jax.scene.template import SceneTemplate
from physagent_jax.scene.world import World, find_foot, find_ground_height, find_overhang

FLOWS = (MaterialModel.FLUID, MaterialModel.DRUCKER_PRAGER, MaterialModel.SNOW)
CAN_STAND = (MaterialModel.NEO_HOOKEAN, MaterialModel.FIXED_COROTATED, MaterialModel.HENCKY)
SEEN_SAG = 1e-3  # [L] by which an object's weight bends it, below which it is as straight as without
TOPPLES = 0.0  # [L] of overhang from which on an object does not stand
UNSTEADY = 3.0  # [degrees] of tilt that a touch gives: what falls over by less does not stand by itself
HOPS_OVER = 30.0  # [degrees] of the same: what is steadier lands on its feet where it is hit from above
BEHIND = 0.5  # of its extent along a blow on a side, beyond which it is held
LIGHT = 0.5  # share of its weight, with less of which nothing keeps an object on the ground
_LEVEL = 0.7  # component along the vertical below which a way is level
HELD_FOOT = 0.1  # of its height, that is held of what would fall over: its feet
# Times its weight, borne by what is to get up where it lands: with less it stays as its fall has pressed it.
LANDING = 2.5
LYING = 0.1  # the same of what lies limp where it lands
_POTS = frozenset(("pot", "flowerpot", "planter", "tub"))  # words for what a plant stands in
_RIM = 0.7  # of its height, up to which a plant's pot is held at most


@dataclasses.dataclass(frozen=True)
class Support:
    """The freedom that user and sentence leave to whatever makes an object stand.

    Attributes:
        keep_material: Leave the stiffness as it is: somebody has chosen it.
        keep_weight: Leave gravity as it is: the sentence needs it. What cannot bear its weight then collapses.
        let_go: Leave it free: the sentence or the user says so.
        struck: Way of a blow that presses it in, unit vector.
        rigid: Its matter is hard, and nothing asks it to deform: it bears its weight, whatever its stand-in does.
        lands: It is dropped, and is to get up again where it lands.
        flops: It is dropped, and is to land limp: it need not stand.
    """

    keep_material: bool = False
    keep_weight: bool = False
    let_go: bool = False
    struck: Vector | None = None
    rigid: bool = False
    lands: bool = False
    flops: bool = False


DEFAULT = Support()


def level(source: Source, domain: Domain, anchor: Anchor, world: World) -> Source:
    """The source tilted so that the object stands; as it is if it does, never would, or is held.

    Args:
        source: The object, at an absolute path.
        domain: What it is placed in.
        anchor: What is held.
        world: What surrounds it.

    Raises:
        UserError: The object cannot be used.
    """
    if not world.ground or anchor.kind != "none":
        return source
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # they are heeded when the object is loaded in earnest
        loaded = load_object(source, Path())
        cloud, _ = place(loaded.cloud, source, domain, loaded.origin)
    largest = LARGEST_TILT if holds_splats(Path(source.path)) else LARGEST_LEAN
    tilt = find_tilt(np.asarray(cloud.means, np.float64), largest)
    return source if tilt is None else source.model_copy(update=dict(tilt=tilt))


def explain_tilt(source: Source) -> tuple[str, ...]:
    """Explain in words how `level` turned a source."""
    angle = math.hypot(*source.tilt)
    turned = (
        f"the object was turned by {angle:.1f} degrees, so that it stands on its feet rather than on an edge"
    )
    return (turned,) if angle else ()


def make_stand(
    template: SceneTemplate,
    body: Body,
    support: Support = DEFAULT,
) -> tuple[SceneTemplate, tuple[str, ...]]:
    """The template in which the object stays as it was captured, and in words what had to be changed for it.

    Args:
        template: The scene without its force field.
        body: Its object.
        support: The freedom that is left.
    """
    template, held = hold_upright(template, body, support)
    template, bearing = _bear(template, body, support)
    return template, (*held, *bearing)


def hold_upright(
    template: SceneTemplate,
    body: Body,
    support: Support = DEFAULT,
) -> tuple[SceneTemplate, tuple[str, ...]]:
    """The template with the feet held of what its weight does not keep upright, and why in words.

    What would fall over is without weight where it is let go. Arguments as for `make_stand`.
    """
    world, flows = template.world, template.material.model in FLOWS
    if template.anchor.kind == "base":
        return dataclasses.replace(template, anchor=_hold_pot(template, body)), ()
    if world.gravity != "down" or not world.ground or template.anchor.kind != "none" or flows:
        return template, ()
    overhang = find_overhang(body)
    if overhang > TOPPLES:
        why = f"the object's mass centre is {overhang:.2f} of its length beyond what it stands on"
        result = "it would fall over at once"
    elif support.let_go:
        return template, ()
    elif (angle := find_tipping_angle(body, overhang)) < UNSTEADY:
        why = f"the object falls over once it is tilted by {angle:.2g} degrees"
        result = "a touch would knock it over"
    elif support.struck and abs(support.struck[2]) < _LEVEL:
        why = "the object is pressed in from a side: the half behind is held, or it would slide away"
        held = Anchor(kind="region", region=make_end_region(support.struck, BEHIND), reason=why)
        return dataclasses.replace(template, anchor=held), (why,)
    elif support.struck and angle < HOPS_OVER:
        why, result = "the object is hit from above", "it would hop and fall over"
    elif not support.rigid and (weight := _bear(template, body, support)[0].world.weight) < LIGHT:
        why = f"the object can bear {100 * weight:.2g} % of its weight"
        result = "a touch would carry it away"
    else:
        return template, ()
    if support.let_go and support.keep_weight:
        return template, ()
    if support.let_go:
        note = f"{why}: {result}, so it is without weight while it leaves its place"
        return _change_world(template, gravity="none", ground=False), (note,)
    why = f"{why}: its feet are held, or {result}"
    held = Anchor(kind="base", fraction=HELD_FOOT, reason=why)
    return dataclasses.replace(template, anchor=held), (why,)


def find_tipping_angle(body: Body, overhang: float) -> float:
    """The angle by which an object can be tilted before it falls over [degrees], given its `find_overhang` [L]."""
    height = np.average(body.particles.x[:, 2], weights=body.particles.volume) - find_foot(body)
    return math.degrees(math.atan2(-overhang * body.extent, max(float(height), 1e-9)))


def _bear(template: SceneTemplate, body: Body, support: Support) -> tuple[SceneTemplate, tuple[str, ...]]:
    """The template in which elastic matter bears the weight, or as much of it as it can, and what was changed."""
    material = template.material
    load = 1.0 if support.keep_material else LYING if support.flops else LANDING if support.lands else 1.0
    if not is_borne(template) or load * find_own_burden(template, body).share <= 1:
        return template, ()
    borne = template if support.keep_material else _stiffen(template, body, load)
    most = max(find_affordable_modulus(material, template.preset.domain.dx) / material.youngs_modulus, 1.0)
    needed = find_largest_factor(borne.bearing)
    if not support.keep_material and needed <= most:
        return borne, (explain_stiffening(needed),)
    if load > 1:
        return _bear(template, body, dataclasses.replace(support, lands=False))
    carrying = find_bearing_modulus(template, body)
    if support.keep_material:
        needed, most = carrying / material.youngs_modulus, 1.0
    share = _round_down(most / needed)
    weight = 1.0 if support.keep_weight else share
    why = _explain_collapse(carrying, chosen=support.keep_material, weight=weight)
    template = _change_world(template, weight=weight)
    return (template if support.keep_material else _stiffen(template, body, share)), (why,)


def find_bearing_modulus(template: SceneTemplate, body: Body) -> float:
    """Least uniform Young's modulus [Pa] that bears the weight, to two digits."""
    least = max(find_own_burden(template, body).share * template.material.youngs_modulus, 1e-12)
    return -_round_down(-least)


def explain_stiffening(times: float) -> str:
    """Explain that parts were made up to ``times`` as stiff."""
    return f"the parts that bear its own weight were made up to {times:.2g} times as stiff, so that it stands"


def find_own_firmness(template: SceneTemplate, body: Body) -> np.ndarray | None:
    """The factors of stiffness of the object's particles (`find_firmness`)."""
    return find_firmness(
        body, template.material, template.anchor, template.bearing, dx=template.preset.domain.dx
    )


def find_largest_factor(bearing: Bearing | None) -> float:
    """Factor of the stiffest part's Young's modulus."""
    return 1.0 if bearing is None else bearing.most


def _stiffen(template: SceneTemplate, body: Body, weight: float) -> SceneTemplate:
    """The template in which some parts are stiff enough for a share of the weight."""
    bearing = Bearing(ground=_find_ground(template, body), weight=weight)
    stiffer = dataclasses.replace(template, bearing=bearing)
    firmness = find_own_firmness(stiffer, body)
    assert firmness is not None
    bearing = bearing.model_copy(update=dict(most=float(firmness.max())))
    reason = f"{template.material.reason}; {explain_stiffening(bearing.most)}"
    return dataclasses.replace(stiffer, bearing=bearing, material=template.material.changed(reason=reason))


def _change_world(template: SceneTemplate, **changes) -> SceneTemplate:
    return dataclasses.replace(template, world=dataclasses.replace(template.world, **changes))


def _find_ground(template: SceneTemplate, body: Body) -> float | None:
    """Height of the ground that the object rests on or hangs over [m]."""
    world = template.world
    return find_ground_height(world, body, template.anchor, drop=False) if world.ground else None


def _round_down(value: float) -> float:
    """The largest number of two digits that is no larger."""
    digits = 10.0 ** (math.floor(math.log10(abs(value))) - 1)
    return math.floor(value / digits + 1e-9) * digits


def _explain_collapse(needed: float, *, chosen: bool, weight: float) -> str:
    """Explain what is done with an object that cannot bear its weight, and which option helps."""
    why = "with the stiffness that was chosen" if chosen else "even as stiff as it can be simulated quickly"
    what = "it will sag or collapse"
    if weight < 1:
        what = f"{100 * weight:.2g} % of its weight acts, and it stays as it was captured"
    slower = "" if chosen else ", slowly"
    return (
        f"the object cannot carry its own weight {why}: {what}; "
        f"`material.youngs_modulus` {needed:.2g} carries it{slower}, and so does a lower `material.density`"
    )


def damp(template: SceneTemplate, body: Body) -> tuple[Material, str | None]:
    """The template's material with its damping ratio, and what the user should know of it.

    A ratio that nobody has chosen holds as far as it costs few substeps; drag, for what is held, costs none.
    """
    material, wanted = template.material, template.damping_ratio
    chosen = material.damping_ratio is not None or material.viscosity is not None
    ratio = (material.damping_ratio or 0.0) if chosen else wanted
    if not ratio:
        return material, None
    note = None
    if template.anchor.kind == "none":
        dx, particles = template.preset.domain.dx, body.particles
        firmness, most = find_own_firmness(template, body), find_largest_factor(template.bearing)
        free = np.zeros(particles.count, bool)
        mode = find_lowest_mode(particles.x, particles.volume, free, material, firmness)
        times = find_slowdown(compute_viscosity(ratio, material, mode), material, dx, most)
        if chosen and times > MOST_SLOWER:
            note = f"a damping ratio of {ratio:g} takes {times:.1f} times as many substeps as none"
        elif not chosen and (ratio := find_affordable_ratio(wanted, material, mode, dx, most)) < wanted:
            note = (
                f"motion dies out with a damping ratio of {ratio:g}; its kind's {wanted:g} would take {times:.1f} "
                f"times as many substeps as none, and is there for `material.damping_ratio` {wanted:g}"
            )
    if chosen:
        return material, note
    reasons = (
        material.reason,
        f"damping: {explain_damping_ratio(template.matter)}",
        note,
    )
    return material.changed(damping_ratio=ratio, reason="; ".join(filter(None, reasons))), note


def stands(template: SceneTemplate, body: Body, *, drop: bool) -> bool:
    """Return whether the object rests under its own weight when the clip begins, visibly.

    What is lifted to be dropped bears nothing yet; what its weight moves by less than `SEEN_SAG` is not seen.
    """
    falls = drop and template.anchor.kind == "none"
    return is_borne(template) and not falls and find_own_burden(template, body).sag > SEEN_SAG


def is_borne(template: SceneTemplate) -> bool:
    """Return whether elastic matter bears the object's weight, on the ground or at what is held."""
    supported = template.anchor.kind != "none" or template.world.ground
    return template.world.gravity == "down" and supported and template.material.model in CAN_STAND


def find_own_burden(template: SceneTemplate, body: Body) -> Burden:
    """The burden of the object's own weight where it is borne (`is_borne`)."""
    world, anchor = template.world, template.anchor
    ground = find_ground_height(world, body, anchor, drop=False) if world.ground else None
    return find_burden(body, template.material, anchor, ground=ground, dx=template.preset.domain.dx)


def _hold_pot(template: SceneTemplate, body: Body) -> Anchor:
    """The anchor of a plant that holds its pot up to the rim, which would bend with the plant; else as it is."""
    pots = [part for part in body.parts if _POTS & {*split_name(part.name)}]
    if template.source.kind != "plant" or not pots:
        return template.anchor
    height = body.shape[:, 2]
    inside = height[make_region_mask(pots[0].moved, body.shape)]
    low, rim = np.quantile(inside, (0.05, 0.9)) - height.min()
    if low > template.anchor.fraction * np.ptp(height):
        return template.anchor
    share = min(max(float(rim / np.ptp(height)), template.anchor.fraction), _RIM)
    return template.anchor.model_copy(update=dict(fraction=round(share, 3)))
