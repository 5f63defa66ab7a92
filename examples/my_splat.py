"""Load a splat, push it with a sentence, read where its particles go, and look at it from another side.

Run: python examples/my_splat.py [object.ply]
"""

import sys
from pathlib import Path

import imageio.v3 as iio

import physagent_jax as pa

ROBOT = Path(__file__).parent / "assets" / "robot.ply"


def main(path=ROBOT, folder="."):
    """Return how far the object's centre moves to the viewer's left [m]."""
    loaded = pa.load_object(path, max_particles=4000)
    scene = pa.build_scene(loaded, "push it to the left", frame_count=12, width=160, height=160)
    recording = pa.simulate_scene(scene)

    x = recording.x  # positions of the particles [m], shape (frames, n, 3)
    moved = x[-1].mean(0) - x[0].mean(0)

    camera = pa.look_at((5, 0, 3), (2, 2, 2), (0, 0, 1), fov_degrees=45, width=160, height=160)
    pictures = pa.render_recording(recording, camera)
    iio.imwrite(Path(folder) / "my_splat.png", pictures[-1])
    return -moved[0]


if __name__ == "__main__":
    distance = main(*sys.argv[1:])
    print(f"moved {distance:.2f} m to the left; the last frame is in my_splat.png")
    assert distance > 0.5
