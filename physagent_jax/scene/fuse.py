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
from physagent_jax.scene.camera import frame_camera, shows_points
from physagent_jax.scene.compliance import find_compliance
from physagent_jax.scene.config import (
    CameraConfig,
    HalfSpace,
    SceneConfig,
)
from physagent_jax.scene.cost import find_stable_step
from physagent_jax.scene.response import Setting, find_responses
from physagent_jax.scene.standing import CAN_STAND, damp, find_own_firmness, stands
from physagent_jax.scene.template import SceneTemplate
from physagent_jax.scene.world import build_boundaries, find_gravity, find_opposition


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
    drop = force_field.default_drop
    # What falls has all of its weight.
    world = dataclasses.replace(template.world, weight=1.0) if drop else template.world
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
    weight = -find_gravity(world)[2] if weighs else 0.0
    firmness = find_own_firmness(template, body)
    setting = Setting(body, material, template.anchor, standing, weight, opposition, time, firmness)
    scaling = scaling.model_copy(update=dict(responses=find_responses(setting, force_field)))
    for faint in (response for response in scaling.responses if response.note):
        _warn_of_faint(faint)
    config = SceneConfig(
        prompt=template.prompt,
        preset=template.preset_name,
        source=template.source,
        filling=preset.filling,
        material=damp(template, body)[0],
        bearing=template.bearing,
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


def find_holding(template: SceneTemplate, body: Body) -> Holding | None:
    """Find the compliance of the held object; None where it does not bend elastically or cannot be told."""
    if template.material.model not in CAN_STAND:
        return None
    compliance = find_compliance(body, template.material, template.anchor, find_own_firmness(template, body))
    if compliance is None:
        return None
    k = 2 * calibration.TRAVEL * body.extent / calibration.HELD_TIME**2
    return Holding(
        compliance=compliance.mean,
        square=compliance.square,
        damping_ratio=template.material.damping_ratio,
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
