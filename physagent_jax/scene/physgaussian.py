"""Reading PhysGaussian's scene files (Xie et al. 2024): keys, defaults and quirks of its JSON as a `SceneConfig`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pydantic import ValidationError

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import format_validation_error
from physagent_jax.scene.config import (
    CameraConfig,
    Domain,
    Filling,
    MaterialRegion,
    SceneConfig,
    Source,
    Timing,
    Transfer,
)
from physagent_jax.scene.physgaussian_conditions import ConditionReader, read_conditions
from physagent_jax.scene.physgaussian_materials import MATERIAL_KEYS, find_unused_keys, read_material
from physagent_jax.scene.placement import find_extra_rotation

CENTER = (1.0, 1.0, 1.0)  # PhysGaussian centres every object here

# Keys that PhysGaussian reads and never uses, or of its interface.
_MEANINGLESS = {
    "pic_damping": "PhysGaussian reads it but never uses it",
    "show_hint": "it belongs to PhysGaussian's command line",
    "move_camera": "the camera stands still here",
    "delta_a": "the camera stands still here",
    "delta_e": "the camera stands still here",
    "delta_r": "the camera stands still here",
}
_KNOWN = {
    "g", "n_grid", "grid_lim", "substep_dt", "frame_dt", "frame_num", "scale",
    "opacity_threshold", "rotation_degree", "rotation_axis", "sim_area", "rpic_damping", "grid_v_damping_scale",
    "additional_material_params", "boundary_conditions", "particle_filling", "mpm_space_viewpoint_center",
    "mpm_space_vertical_upward_axis", "default_camera_index", "init_azimuthm", "init_elevation", "init_radius",
}  # fmt: skip


def is_physgaussian(data: object) -> bool:
    """Return whether decoded JSON looks like a PhysGaussian scene rather than one of ours."""
    telling = {"substep_dt", "frame_num", "n_grid", "grid_lim", "boundary_conditions", "opacity_threshold"}
    return isinstance(data, dict) and "source" not in data and len(telling & data.keys()) >= 2


def import_physgaussian(
    data: dict, *, object_path: str, file_units_per_metre: float | None = None
) -> tuple[SceneConfig, list[str]]:
    """Translate a PhysGaussian scene.

    Missing keys take PhysGaussian's defaults, with one exception: its default gravity is the scalar 9.8,
    on which its own solver fails, so that (0, 0, -9.8) is taken, with a warning. PhysGaussian's frame 0 comes
    after one interval and ours is the rest pose: the clip gets one more picture and lasts as long.
    Its filling thresholds are in units of overlapping Gaussians and are kept so (``density_unit``), and
    particles get its volumes (``volumes``), since its impulses are forces per particle and act by mass.

    Args:
        data: Decoded JSON.
        object_path: The 3DGS PLY; PhysGaussian's files do not name it.
        file_units_per_metre: The placed object's ``1 / Placement.scale``, to convert the camera's radius, which
            PhysGaussian measures in the file's units; None = taken as metres, with a warning.

    Returns:
        The scene, and one warning for each key that has no or another meaning here.

    Raises:
        UserError: A material that is not available, a wrong type, NaN, or a missing key; names the key.
    """
    if not isinstance(data, dict):
        raise UserError("a PhysGaussian scene is a JSON object", got=type(data).__name__, do="Check the file")
    reader = ConditionReader(data, "")
    try:
        source = _read_source(reader, object_path)
        material, notes = read_material(reader)
        substep_dt = reader.number("substep_dt", 1e-4)
        # First, since the rest is measured in cells and steps.
        domain = Domain(size=reader.number("grid_lim", 2.0), cells=reader.integer("n_grid", 50))
        timing = Timing(
            frame_count=reader.integer("frame_num", 100) + 1,
            frame_dt=reader.number("frame_dt", 1e-2),
            substep_dt=substep_dt,
        )
        boundaries, constraints = read_conditions(reader, substep_dt)
        config = SceneConfig(
            preset="physgaussian",
            source=source,
            filling=_read_filling(reader, domain),
            material=material,
            material_regions=_read_regions(reader),
            domain=domain,
            timing=timing,
            transfer=_read_transfer(reader, substep_dt),
            gravity=_read_gravity(reader),
            always_gravity=True,
            boundaries=boundaries,
            constraints=constraints,
            camera=_read_camera(reader, source, file_units_per_metre),
        )
    except ValidationError as error:
        raise format_validation_error(error, "PhysGaussian scene") from None
    for note in notes:
        reader.warn(note)
    meaningless = _MEANINGLESS | find_unused_keys(reader)
    for key in data:
        if key in meaningless:
            reader.warn(f"`{key}` is ignored: {meaningless[key]}")
        elif key not in _KNOWN | MATERIAL_KEYS:
            reader.warn(f"`{key}` is ignored: it is not known")
    return config, reader.warnings


def _read_source(reader: ConditionReader, object_path: str) -> Source:
    crop: Any = None if reader.data.get("sim_area") is None else reader.numbers("sim_area", 6)
    return Source(
        path=object_path,
        opacity_threshold=reader.number("opacity_threshold", 0.02),
        crop=crop,
        rotation_degrees=reader.numbers("rotation_degree", None, ()),
        rotation_axes=reader.numbers("rotation_axis", None, ()),  # type: ignore[arg-type]
        extent=reader.number("scale", 1.0),
        center=CENTER,
    )


def _read_regions(reader: ConditionReader) -> tuple[MaterialRegion, ...]:
    """Boxes of other E, nu and density; the law and its other keys are the scene's."""
    return tuple(
        MaterialRegion(
            point=part.vector("point"), half_size=part.vector("size"), material=read_material(reader, part)[0]
        )
        for part in reader.parts("additional_material_params")
    )


def _read_filling(reader: ConditionReader, domain: Domain) -> Filling:
    """Filling; its cells are counted along the domain there and along the object here."""
    if reader.data.get("particle_filling") is None:
        return Filling(enabled=False, max_particles=2_000_000, volumes="cells")
    part = reader.part("particle_filling")
    asked = round(part.integer("n_grid", 4 * domain.cells) * reader.number("scale", 1.0) / domain.size)
    cells = min(max(asked, 4), 512)
    if cells != asked:
        reader.warn(f"`particle_filling.n_grid` is {asked:,} cells along the object: {cells} are taken")
    for key in part.data:
        if key in ("visualize", "boundary") and part.data[key]:
            why = "filled particles are not drawn" if key == "visualize" else "all of the object is filled"
            reader.warn(f"`particle_filling.{key}` is ignored: {why}")
    exclude = part.integer("search_exclude_direction", 5)
    return Filling(
        cells=cells,
        density_unit="overlap",
        density_threshold=part.number("density_threshold", 5.0),
        search_threshold=part.number("search_threshold", 3.0),
        exclude_direction=exclude if 0 <= exclude <= 5 else None,
        ray_cast_direction=part.integer("ray_cast_direction", 4),
        particles_per_cell=part.integer("max_partciels_per_cell", 1),  # the key is spelt so
        max_particles=part.integer("max_particles_num", 2_000_000),
        smooth=bool(part.data.get("smooth", False)),
        volumes="cells",
    )


def _read_transfer(reader: ConditionReader, substep_dt: float) -> Transfer:
    """Damping: a factor per substep there, a rate here; rpic_damping below -0.001 turns affine terms off."""
    rpic = reader.number("rpic_damping", 0.0)
    factor = reader.number("grid_v_damping_scale", 1.1)  # 1 or more means none
    if factor <= 0:
        raise UserError("PhysGaussian scene: `grid_v_damping_scale` must be positive", got=factor)
    return Transfer(
        scheme="pic" if rpic < -0.001 else "apic",
        rpic_damping=max(rpic, 0.0),
        damping_rate=-math.log(factor) / substep_dt if factor < 1 else 0.0,
    )


def _read_gravity(reader: ConditionReader) -> tuple[float, float, float]:
    if isinstance(reader.data.get("g"), list | tuple):
        return reader.vector("g")
    scalar = reader.number("g", 9.8)
    reader.warn(
        f"`g` is {'missing' if 'g' not in reader.data else 'a number'}, on which PhysGaussian itself fails: "
        f"gravity is taken as (0, 0, {-abs(scalar):g})"
    )
    return (0.0, 0.0, -abs(scalar))


def _read_camera(reader: ConditionReader, source: Source, units_per_metre: float | None) -> CameraConfig:
    """The orbit camera. Its angles count from an axis that is built in the file's frame, hence the rotation."""
    target = reader.vector("mpm_space_viewpoint_center", CENTER)
    up = np.asarray(reader.vector("mpm_space_vertical_upward_axis", (0.0, 0.0, 1.0)))
    keys = ("init_azimuthm", "init_elevation", "init_radius")
    from_dataset = reader.integer("default_camera_index", 0) >= 0
    if from_dataset or any(reader.data.get(key) is None for key in keys):
        reader.warn(
            "the camera is the default one: PhysGaussian takes it from `cameras.json` of the 3DGS model"
        )
        return CameraConfig(target=target)
    azimuth, elevation, radius = (reader.number(key) for key in keys)
    norm = np.linalg.norm(up)
    if norm == 0:
        raise UserError(
            "PhysGaussian scene: `mpm_space_vertical_upward_axis` must not be zero", got=up.tolist()
        )
    if not np.allclose(up / norm, (0, 0, 1), atol=1e-3):
        reader.warn("`mpm_space_vertical_upward_axis` is ignored: pictures have +z up here")
    if units_per_metre is None:
        reader.warn("`init_radius` is taken as metres: PhysGaussian measures it in the file's units")
        units_per_metre = 1.0
    if abs(elevation) > 85:
        reader.warn("`init_elevation` is limited to 85 degrees")
    turn = find_extra_rotation(source.rotation_degrees, source.rotation_axes)
    return CameraConfig(
        target=target,
        azimuth_degrees=_convert_azimuth(math.radians(azimuth), turn, up / norm),
        elevation_degrees=min(max(elevation, -85.0), 85.0),
        distance=radius / units_per_metre,
    )


def _convert_azimuth(azimuth: float, turn: np.ndarray, up: np.ndarray) -> float:
    """Degrees from -y about +z of the direction that PhysGaussian's ``azimuth`` [rad] means."""
    vertical = turn.T @ up  # in the file's frame
    first = np.array([1.0, 1.0, 1.0])
    if abs(first @ vertical) < 0.01:
        first = np.array([0.72, 0.37, -0.67])
    first = first - (first @ vertical) * vertical
    first /= np.linalg.norm(first)
    second = np.cross(first, vertical)
    x, y, _ = turn @ (math.cos(azimuth) * first + math.sin(azimuth) * second)
    return math.degrees(math.atan2(x, -y))
