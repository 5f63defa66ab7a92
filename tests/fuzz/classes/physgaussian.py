"""PhysGaussian's scene files."""

from __future__ import annotations

import json
from pathlib import Path

from physagent_jax.core.reading import read_json
from physagent_jax.scene.physgaussian import import_physgaussian
from tests.fuzz.contract import Case
from tests.fuzz.drawing import Draw, altered, any_json, damaged, encoded

NAME = "config.json"
GOOD = {
    "opacity_threshold": 0.02, "rotation_degree": [90.0], "rotation_axis": [0],
    "sim_area": [-1, 1, -1, 1, -1, 1], "scale": 1.0, "substep_dt": 1e-4, "frame_dt": 0.02, "frame_num": 10,
    "n_grid": 50, "grid_lim": 2.0, "g": [0, 0, -9.8], "material": "jelly", "E": 2e4, "nu": 0.3,
    "density": 200, "yield_stress": 100.0, "hardening": 1, "xi": 0.1, "friction_angle": 30.0,
    "plastic_viscosity": 1.0, "softening": 0.1, "rpic_damping": 0.0, "grid_v_damping_scale": 0.9999,
    "additional_material_params": [
        {"point": [1, 1, 1], "size": [0.2, 0.2, 0.2], "E": 2e6, "nu": 0.4, "density": 100},
    ],
    "particle_filling": {
        "n_grid": 100, "density_threshold": 5.0, "search_threshold": 3, "max_particles_num": 100,
        "max_partciels_per_cell": 1, "search_exclude_direction": 5, "ray_cast_direction": 4,
        "boundary": None, "smooth": False, "visualize": False,
    },
    "boundary_conditions": [
        {"type": "bounding_box"},
        {
            "type": "cuboid", "point": [1, 1, 0.3], "size": [0.5, 0.5, 0.1], "velocity": [0, 0, 0],
            "start_time": 0, "end_time": 1e3, "reset": 1,
        },
        {
            "type": "particle_impulse", "force": [0.1, 0, 0], "num_dt": 20, "point": [1, 1, 1.5],
            "size": [1, 1, 0.5], "start_time": 0,
        },
        {
            "type": "surface_collider", "point": [1, 1, 0.2], "normal": [0, 0, 1], "surface": "cut",
            "friction": 0.5, "start_time": 0, "end_time": 10.0,
        },
        {
            "type": "enforce_particle_translation", "point": [1, 1, 1], "size": [0.1, 0.1, 0.1],
            "velocity": [0, 0, 1], "start_time": 0, "end_time": 0.5,
        },
        {
            "type": "enforce_particle_velocity_rotation", "normal": [0, 0, 1], "point": [1, 1, 1],
            "start_time": 0.0, "end_time": 0.5, "half_height_and_radius": [0.2, 0.5], "rotation_scale": 1.0,
            "translation_scale": 0.0,
        },
        {
            "type": "release_particles_sequentially", "normal": [0, 0, 1], "point": [1, 1, 1],
            "start_position": 0.5, "end_position": 1.5, "num_layers": 20, "start_time": 0.0,
            "end_time": 0.5,
        },
    ],
    "mpm_space_viewpoint_center": [1, 1, 1], "mpm_space_vertical_upward_axis": [0, 0, 1],
    "default_camera_index": -1, "show_hint": False, "init_azimuthm": 0.0, "init_elevation": 10.0,
    "init_radius": 2.0, "move_camera": False,
}  # fmt: skip
LAWS = ("jelly", "metal", "sand", "foam", "snow", "plasticine", "watermelon", "fluid", "stationary", "")


def make(draw: Draw) -> Case:
    """One such file, imported."""
    document = json.loads(json.dumps(GOOD)) | {"material": draw.one(LAWS[:4])}
    if draw.chance(0.3):
        document["material"] = draw.one(LAWS)
    for key in draw.sample(sorted(document), draw.one([0, 0, 3, 20])):
        del document[key]
    units = draw.one([None, 1.0, 0.01])
    match draw.one(["altered"] * 6 + ["damaged", "any"]):
        case "altered":
            what, content = altered(draw, document or {"E": 1})
        case "damaged":
            what, content = damaged(draw, encoded(document))
        case _:
            keys = draw.sample(sorted(GOOD), 3)
            document |= {key: any_json(draw) for key in keys}
            what, content = f"any JSON for {keys}", encoded(document)
    return Case(what, lambda folder: _import(folder, units), {NAME: content})


def _import(folder: Path, units: float | None):
    return import_physgaussian(read_json(folder / NAME), object_path="x.ply", file_units_per_metre=units)
