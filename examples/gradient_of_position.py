"""The gradient of a final position with respect to the force field that led there, and a few steps along it.

Run: python examples/gradient_of_position.py
"""

import dataclasses
from pathlib import Path

import jax
import jax.numpy as jnp

import physagent_jax as pa

ROBOT = Path(__file__).parent / "assets" / "robot.ply"
FRAMES = 3
PUSH = {"actions": [{"action_type": "translation", "vector": [1, 0, 0], "magnitude": 0.8}]}


def main(steps=3):
    """Return the distance to the target before each step [m]."""
    loaded = pa.load_object(ROBOT, max_particles=300, cells=32)
    scene = pa.build_scene(loaded, force_field=PUSH, world="free", frame_count=FRAMES)
    parameters = pa.ForceFieldParameters.of(scene.config.force_field, FRAMES)
    start = pa.trajectory(scene).x[0].mean(0)
    target = start + jnp.array([0.5, 0.0, 0.5])  # [m]

    @jax.jit
    @jax.value_and_grad
    def miss(vector):
        (action,) = parameters.actions
        moved = pa.ForceFieldParameters(actions=(dataclasses.replace(action, vector=vector),))
        return jnp.linalg.norm(pa.trajectory(scene, moved).x[-1].mean(0) - target)

    vector, distances = jnp.array([1.0, 0.0, 0.0]), []
    for _ in range(steps):
        distance, slope = miss(vector)
        distances.append(float(distance))
        vector = vector - slope * distance / (slope**2).sum()  # Polyak's step: what is linear is met at once
    return distances


if __name__ == "__main__":
    distances = main()
    print("distance to the target [mm]:", *(f"{1000 * d:.2f}" for d in distances))
    assert distances[-1] < 0.1 * distances[0]
