"""Many force fields on one object at once, with `jax.vmap`: which push brings it nearest to a target?

Run: python examples/many_force_fields.py
"""

import dataclasses
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

import physagent_jax as pa

ROBOT = Path(__file__).parent / "assets" / "robot.ply"
FRAMES = 3
PUSH = {"actions": [{"action_type": "translation", "vector": [1, 0, 0], "magnitude": 1.0}]}


def main():
    """Return the angle of the best push [degrees], and all distances to the target [m]."""
    loaded = pa.load_object(ROBOT, max_particles=300, cells=32)
    scene = pa.build_scene(loaded, force_field=PUSH, world="free", frame_count=FRAMES)
    (action,) = pa.ForceFieldParameters.of(scene.config.force_field, FRAMES).actions
    angles = np.arange(0, 360, 90)
    directions = np.stack([np.cos(np.radians(angles)), np.sin(np.radians(angles)), 0 * angles], axis=-1)
    start = pa.trajectory(scene).x[0].mean(0)
    target = start + jnp.array([0.0, -1.0, 0.0])  # [m]

    def end(vector):
        parameters = pa.ForceFieldParameters(actions=(dataclasses.replace(action, vector=vector),))
        return pa.trajectory(scene, parameters).x[-1].mean(0)

    distances = jnp.linalg.norm(jax.vmap(end)(directions) - target, axis=-1)
    return angles[int(distances.argmin())], distances


if __name__ == "__main__":
    best, distances = main()
    print(f"of {len(distances)} pushes the one at {best} degrees comes nearest: {distances.min():.4f} m")
    assert best == 270
