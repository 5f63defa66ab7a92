"""Playing one scene into a folder."""

from __future__ import annotations

import warnings
from pathlib import Path

from physagent_jax.cli.console import warn
from physagent_jax.core.files import check_writable, write_text
from physagent_jax.kernels import ahead
from physagent_jax.output.motion_file import write_motion
from physagent_jax.output.run_files import motion_of
from physagent_jax.output.splats import write_splat_frames
from physagent_jax.output.video import write_frames, write_video
from physagent_jax.run_folder import SimulationRecord, Stages
from physagent_jax.scene.body import body_of
from physagent_jax.scene.compile import compile_scene
from physagent_jax.scene.config import SceneConfig, dump_scene
from physagent_jax.simulation import Progress, play
from physagent_jax.stopwatch import Stopwatch


def play_scene(
    config: SceneConfig,
    base_dir: Path,
    out: Path,
    progress: Progress,
    *,
    save_frames: bool,
    save_splats: bool,
) -> tuple[SimulationRecord, Stages]:
    """Simulates ``config`` and writes scene.json, simulation.json, video.mp4 and motion.npz to ``out``.

    Raises:
        UserError: The scene cannot be simulated, or ``out`` cannot be written or is a file.
    """
    check_writable(out)
    ahead.begin()
    watch = Stopwatch()
    with watch("prepare"), warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        body = body_of(config, base_dir)
        scene = compile_scene(config, body, base_dir)
    for warning in caught:
        warn(warning.message)
    recording = play(scene, watch, progress)
    with watch("write"):
        write_text(out / "scene.json", dump_scene(config))
        write_text(out / "simulation.json", recording.record.model_dump_json(indent=2))
        write_video(out / "video.mp4", recording.rgb, 1 / config.timing.frame_dt)
        write_motion(out / "motion.npz", motion_of(scene, recording))
        if save_frames:
            write_frames(out / "frames", recording.rgb)
        if save_splats:
            write_splat_frames(out / "splats", body, recording.x[:, scene.back], recording.F[:, scene.back])
    return recording.record, watch.stages()
