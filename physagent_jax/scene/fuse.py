"""Deterministic fusion of object, material, surroundings and force field into a `SceneConfig` (paper, A.3)."""

from __future__ import annotations

import dataclasses
import warnings

import numpy as np

from physagent_jax.forces import calibration
from physagent_jax.forces.free_path import compute_free_path
from physagent_jax.forces.scaling import make_closed_form_scaling
from physagent_jax.forces.schema import ForceField, Holding, Response
from physagent_jax.scene.body import Body
from physagent_jax.scene.burden import Burden, find_burden
from physagent_jax.scene.camera import frame_camera, shows_points
from physagent_jax.scene.compliance import find_compliance
from physagent_jax.scene.config import (
    Anchor,
    CameraConfig,
    HalfSpace,
    Material,
    SceneConfig,
    Source,
)
from physagent_jax.scene.config.material import MaterialModel
from physagent_jax.scene.cost import find_stable_step
from physagent_jax.scene.damping import (
    MOST_SLOWER,
    compute_viscosity,
    find_affordable_ratio,
    find_lowest_mode,
    find_slowdown,
)
from physagent_jax.scene.presets import Preset
from physagent_jax.scene.priors import explain_damping_ratio
from physagent_jax.scene.response import Setting, find_responses
from physagent_jax.scene.world import (
    FREE,
    World,
    build_boundaries,
    find_gravity,
    find_ground_height,
    find_opposition,
)

SEEN_SAG = 1e-3  # [L] by which an object's weight bends it, below which it is as straight as without
CAN_STAND = (MaterialModel.NEO_HOOKEAN, MaterialModel.FIXED_COROTATED, MaterialModel.HENCKY)


@dataclasses.dataclass(frozen=True)
class SceneTemplate:
    """A scene without its force field; the same for all rounds of a run.

    Attributes:
        prompt: The sentence, for the record.
        preset_name, preset: Grid, particles, time, transfer, pictures.
        source: The object.
        material: What it is made of.
        anchor: What is held.
        camera: Direction and lens; with ``target`` None it is placed to show the expected motion.
        world: What surrounds the object.
        friction: Friction of ground and obstacles.
        damping_rate: Drag of the surrounding air [1/s]; the preset's holds if it is larger.
        damping_ratio: Damping ratio of what nobody has chosen one for (`Material.damping_ratio`), as far as it
            costs few substeps.
        damping_kind: Kind that ``damping_ratio`` is of; None = the object's.
        ledger: Whether exchanged energy and momentum are recorded.
    """

    prompt: str
    preset_name: str
    preset: Preset
    source: Source
    material: Material
    anchor: Anchor
    camera: CameraConfig
    world: World = FREE
    friction: float = 0.0
    damping_rate: float = 0.0
    damping_ratio: float = 0.0
    damping_kind: str | None = None
    ledger: bool = False


def fuse(
    template: SceneTemplate, body: Body, force_field: ForceField, *, keep: CameraConfig | None = None
) -> SceneConfig:
    """The scene that simulates ``force_field``; the same input gives the same bytes.

    Args:
        template: The scene without its force field.
        body: Its object.
        force_field: What moves it.
        keep: The camera of an earlier round, which stays if it shows where the object will be.
    """
    preset, material = template.preset, template.material
    world, drop = template.world, force_field.default_drop
    held, damping_rate = (
        template.anchor.kind != "none",
        max(preset.transfer.damping_rate, template.damping_rate),
    )
    time = calibration.find_reference_time(held, preset.timing.duration)
    damped = 0.0 if held else damping_rate  # what is held bends, however slowly
    opposition = find_opposition(
        world, body, template.anchor, damping_rate=damped, time=time, drop=drop, friction=template.friction
    )
    scaling = make_closed_form_scaling(
        extent=body.extent,
        youngs_modulus=material.youngs_modulus,
        density=material.density,
        duration=time,
        damping_rate=damped,
        opposition=opposition,
        holding=find_holding(template, body) if held else None,
    )
    standing = world.ground and not drop
    weighs = world.gravity == "down" and (standing or template.anchor.kind == "base")
    setting = Setting(body, material, template.anchor, standing, weighs, opposition, time)
    scaling = scaling.model_copy(update=dict(responses=find_responses(setting, force_field)))
    for faint in (response for response in scaling.responses if response.note):
        _warn_of_faint(faint)
    config = SceneConfig(
        prompt=template.prompt,
        preset=template.preset_name,
        source=template.source,
        filling=preset.filling,
        material=damp(template, body)[0],
        domain=preset.domain,
        timing=preset.timing,
        transfer=preset.transfer.model_copy(update=dict(damping_rate=damping_rate)),
        gravity=find_gravity(world),
        always_gravity=world.gravity != "none",
        start="equilibrium" if stands(template, body, drop=drop) else "unstressed",
        boundaries=build_boundaries(world, body, template.anchor, drop=drop, friction=template.friction),
        anchor=template.anchor,
        force_field=force_field,
        scaling=scaling,
        camera=template.camera,
        rendering=preset.rendering,
        ledger=template.ledger,
    )
    config = _shorten_step(config, body)
    if config.camera.target is not None:
        return config
    points, start = estimate_sweep(config, body), np.asarray(body.cloud.means, np.float64)
    camera = frame_camera(points, config.camera, config.rendering, start=start)
    if keep is not None and shows_points(points, keep, config.rendering):
        camera = keep
    return config.model_copy(update=dict(camera=camera))


def _warn_of_faint(response: Response) -> None:
    """Say what no force in range makes visible."""
    where = "the whole object" if response.region is None else "that part of the object"
    verb = dict(torque="turned", scale="stretched").get(response.quantity, "moved")
    warnings.warn(
        f"{where} is too stiff, or held too firmly, to be {verb} visibly: {response.note}; a softer material "
        "(`material.youngs_modulus`) or the whole object shows more",
        UserWarning,
        stacklevel=3,
    )


def _shorten_step(config: SceneConfig, body: Body) -> SceneConfig:
    """The preset's step where the material allows it, else one that is fitted: nobody has chosen it."""
    step, stable = config.timing.substep_dt, find_stable_step(config, body)
    if step == "auto" or step <= stable:
        return config
    warnings.warn(
        f"the preset's substep of {step:.2g} s is too long for this material on this grid: it is fitted to them, "
        f"{stable:.2g} s at most",
        UserWarning,
        stacklevel=3,
    )
    return config.model_copy(update=dict(timing=config.timing.model_copy(update=dict(substep_dt="auto"))))


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
        mode = find_lowest_mode(particles.x, particles.volume, np.zeros(particles.count, bool), material)
        times = find_slowdown(compute_viscosity(ratio, material, mode), material, dx)
        if chosen and times > MOST_SLOWER:
            note = f"a damping ratio of {ratio:g} takes {times:.1f} times as many substeps as none"
        elif not chosen and (ratio := find_affordable_ratio(wanted, material, mode, dx)) < wanted:
            note = (
                f"motion dies out with a damping ratio of {ratio:g}; its kind's {wanted:g} would take {times:.1f} "
                f"times as many substeps as none, and is there for `material.damping_ratio` {wanted:g}"
            )
    if chosen:
        return material, note
    reasons = (
        material.reason,
        f"damping: {explain_damping_ratio(template.damping_kind or template.source.kind)}",
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


def find_holding(template: SceneTemplate, body: Body) -> Holding | None:
    """Find the compliance of the held object; None where it does not bend elastically or cannot be told."""
    if template.material.model not in CAN_STAND:
        return None
    compliance = find_compliance(body, template.material, template.anchor)
    if compliance is None:
        return None
    k = 2 * calibration.TRAVEL * body.extent / calibration.HELD_TIME**2
    return Holding(
        compliance=compliance,
        shift=calibration.EXPECTED_HELD_SHIFT * body.extent,
        least=k / calibration.HELD_RANGE,
        most=k * calibration.HELD_MOST,
    )


def estimate_sweep(config: SceneConfig, body: Body) -> np.ndarray:
    """Corners of where an unopposed object would be during the clip, for the camera [m], shape (m, 3).

    Only a guess for the framing: pushes and blows integrated as for a free body, cut off where the camera should no
    longer follow. What meets an upright wall may come back as far as that: the blow was made up for friction, which a
    rebound through the air does not feel.
    """
    low, high, extent = body.low, body.high, body.extent
    centre, half = 0.5 * (low + high), 0.5 * (high - low)
    grown = half + calibration.ROOM * extent * np.array([1.0, 1.0, calibration.ROOM_UPWARD])
    corners = centre + grown * np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T
    limit = (calibration.SWEEP if config.anchor.kind == "none" else calibration.HELD_SWEEP) * extent
    timing, scaling = config.timing, config.scaling
    assert scaling is not None
    path = compute_free_path(
        config.force_field, scaling, frame_dt=timing.frame_dt, frame_count=timing.frame_count
    )
    path = _stop_at_walls(path, config, body, limit)
    reach = np.linalg.norm(path, axis=1)
    path = path * np.minimum(1.0, limit / np.maximum(reach, 1e-12))[:, None]
    points = [corners + shift for shift in (path.min(0), path.max(0), np.zeros(3))]
    for boundary in config.boundaries:
        if isinstance(boundary, HalfSpace) and boundary.normal[2] > 0.5:
            floor = boundary.point[2] - calibration.FLOOR_ROOM * extent
            points.append(np.column_stack([corners[:, :2], np.full(len(corners), floor)]))
    return np.concatenate(points)


def _stop_at_walls(path: np.ndarray, config: SceneConfig, body: Body, rebound: float) -> np.ndarray:
    """Displacements, shape (T, 3) [m], that end where upright walls are met, and how far the object may come back."""
    for boundary in config.boundaries:
        if isinstance(boundary, HalfSpace) and abs(boundary.normal[2]) < 0.5:
            normal = np.asarray(boundary.normal, float)
            gap = float(((np.asarray(body.particles.x, float) - boundary.point) @ normal).min())
            beyond = np.maximum(-(path @ normal) - max(gap, 0.0), 0.0)
            if beyond.any():
                path = np.concatenate([path + beyond[:, None] * normal, rebound * normal[None]])
    return path
