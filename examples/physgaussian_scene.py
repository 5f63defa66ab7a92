"""A PhysGaussian config on one's own splats: what is understood, what is not, and the motion.

Run: python examples/physgaussian_scene.py
"""

import json
import tempfile
import warnings
from pathlib import Path

import physagent_jax as pa

ROBOT = Path(__file__).parent / "assets" / "robot.ply"
CONFIG = {
    "opacity_threshold": 0.02,
    "rotation_degree": [90.0],  # PhysGaussian turns the object upright itself
    "rotation_axis": [0],
    "substep_dt": 5e-4,
    "frame_dt": 2e-2,
    "frame_num": 10,
    "E": 2e5,
    "nu": 0.4,
    "material": "jelly",
    "density": 200,
    "g": [0.0, 0.0, -2.0],
    "grid_v_damping_scale": 0.9999,
    "n_grid": 50,
    "boundary_conditions": [
        {"type": "bounding_box"},
        {"type": "cuboid", "point": [1, 1, 0.4], "size": [1, 1, 0.15], "velocity": [0, 0, 0],
         "start_time": 0, "end_time": 1e3, "reset": 1},
    ],
    "particle_filling": {"n_grid": 50, "density_threshold": 2.0, "search_threshold": 1.0,
                         "max_particles_num": 3000, "max_partciels_per_cell": 1,
                         "search_exclude_direction": 5, "ray_cast_dir": 4, "boundary": [0, 2, 0, 2, 0, 2],
                         "smooth": False},
    "mpm_space_vertical_upward_axis": [0, 0, 1],
    "mpm_space_viewpoint_center": [1, 1, 1],
    "default_camera_index": -1,
    "show_hint": False,
    "init_azimuthm": 0.0,
    "init_elevation": 10.0,
    "init_radius": 2.0,
    "move_camera": False,
}  # fmt: skip


def main(folder):
    """Return how far the object's top sinks [m], and what was not understood."""
    path = Path(folder) / "config.json"
    path.write_text(json.dumps(CONFIG))
    with warnings.catch_warnings(record=True) as notes:
        warnings.simplefilter("always")
        scene = pa.load_scene(path, object_path=ROBOT)
    recording = pa.simulate_scene(scene)
    return float(recording.x[0, :, 2].max() - recording.x[-1, :, 2].max()), [
        str(note.message) for note in notes
    ]


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        sunk, notes = main(folder)
        print(f"the top sinks by {1000 * sunk:.1f} mm", *notes, sep="\n")
        assert sunk > 1e-3
