"""A finished run, opened again: its figures, its scene simulated once more, and pictures from a camera that circles.

Run: python examples/replay_and_render.py [run folder]
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

import physagent_jax as pa
from physagent_jax.output.video import write_video

ROBOT = Path(__file__).parent / "assets" / "robot.ply"


def make_run(folder):
    """A small run to open."""
    spec = pa.RunSpec.model_validate(
        dict(
            object=dict(path=str(ROBOT)),
            prompt="drop the robot",
            overrides=dict(frame_count=12, max_particles=800, width=96, height=96),
            rounds=1,
            save=dict(video_size=None),
        )
    )
    return pa.synthesize(spec, Path(folder) / "run")


def main(run, video):
    """Write a video from a circling camera; return how far the replay is from what the run stored [m]."""
    recording = pa.simulate_scene(pa.load_scene(run.folder / "scene.json"))
    stored = run.motion().x
    count = len(stored)
    center = stored[0].mean(0)
    pictures = []
    for index, angle in enumerate(np.linspace(0, np.pi, count)):
        eye = center + 3.0 * np.array([np.sin(angle), -np.cos(angle), 0.3])
        camera = pa.look_at(eye, center, (0, 0, 1), fov_degrees=45, width=128, height=128)
        pictures.append(pa.render_recording(recording, camera, frames=[index])[0])
    write_video(video, np.stack(pictures), fps=25)
    return float(np.abs(recording.x[:, recording.scene.back] - stored).max())


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        run = pa.open_run(sys.argv[1]) if len(sys.argv) > 1 else make_run(folder)
        print(run.prompt, "->", run.manifest.verdict)
        distance = main(run, "replay.mp4")
    print(f"the replay is the run to {1000 * distance:.3f} mm; replay.mp4 circles around it")
    assert distance < 1e-3
