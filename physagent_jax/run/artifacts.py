"""Files of a run besides JSON: videos, motion, overlays, splats."""

from __future__ import annotations

import shutil
from pathlib import Path, PurePosixPath

import numpy as np

from physagent_jax.core.files import link_or_copy, replace_file, write_text
from physagent_jax.motion.schema import Judgement
from physagent_jax.output.motion_file import Motion, read_motion, write_motion
from physagent_jax.output.splats import SplatFormat, make_splat_names, write_splat_frames
from physagent_jax.output.video import make_frame_names, write_frames, write_picture, write_video
from physagent_jax.perception.measure import Perception
from physagent_jax.perception.overlay import draw_overlay
from physagent_jax.run.key_frames import spread_evenly
from physagent_jax.run.spec import SaveChoice
from physagent_jax.run.store import PLAIN_VIDEO, VIDEO, RunStore
from physagent_jax.scene.body import Body
from physagent_jax.scene.compile import CompiledScene
from physagent_jax.scene.config import SceneConfig, dump_scene
from physagent_jax.simulation.ending import Moved, simulate_ending
from physagent_jax.simulation.notes import Notes
from physagent_jax.simulation.presentation import PLAIN, draw_presentation
from physagent_jax.simulation.recording import Recording

FILMSTRIP_FRAMES = 6


def write_rollout(
    store: RunStore,
    index: int,
    scene: CompiledScene,
    recording: Recording,
    *,
    save_motion: bool = True,
    save_frames: bool = False,
) -> None:
    """Leave what was simulated in round ``index``: the motion too, and PNG frames on request (the video is lossy)."""
    folder = f"iterations/{index}"
    store.write(f"{folder}/force_field.json", scene.config.force_field)
    write_recording(store, scene, recording, folder=folder, save_motion=save_motion, save_frames=save_frames)


def write_recording(
    store: RunStore,
    scene: CompiledScene,
    recording: Recording,
    *,
    folder: str = "",
    save_motion: bool = True,
    save_frames: bool = False,
) -> None:
    """Leave a scene and what its simulation gave in ``folder`` of the run folder; "" = at its top.

    The video and the frames are the plain pictures that perception gets.
    """
    place = PurePosixPath(folder)
    write_text(store.claimed(f"{place / 'scene.json'}"), dump_scene(scene.config))
    store.write(f"{place / 'simulation.json'}", recording.record)
    write_video(store.claimed(f"{place / PLAIN_VIDEO}"), recording.rgb, 1 / scene.config.timing.frame_dt)
    if save_motion:
        write_motion(store.claimed(f"{place / 'motion.npz'}"), make_motion(scene, recording))
    if save_frames:
        store.claim(*make_frame_names(f"{place / 'frames'}", len(recording.rgb)))
        write_frames(store.path / place / "frames", recording.rgb)


def write_verdict(
    store: RunStore, index: int, rgb: np.ndarray, seen: Perception, judgement: Judgement
) -> None:
    """Leave what was seen and concluded in round ``index``; the judgement marks the round complete."""
    store.write(f"iterations/{index}/motion_report.json", seen.report)
    write_filmstrip(store.claimed(f"iterations/{index}/overlay.png"), rgb, seen)
    store.write(f"iterations/{index}/judgement.json", judgement)


def write_presentation(
    store: RunStore,
    config: SceneConfig,
    body: Body,
    x: np.ndarray,
    F: np.ndarray,
    size: tuple[int, int],
    *,
    notes: Notes = PLAIN,
    folder: str = "",
) -> Path:
    """Leave the video for people in ``folder``; positions and F are of the body's particles, all frames.

    Returns:
        The video's path.
    """
    pictures = draw_presentation(config, body, x, F, size, notes)
    return write_video(store.claimed(f"{PurePosixPath(folder, VIDEO)}"), pictures, 1 / config.timing.frame_dt)


def write_clip(
    store: RunStore,
    index: int,
    scene: CompiledScene,
    recording: Recording,
    size: tuple[int, int],
    notes: Notes = PLAIN,
    moved: Moved | None = None,
) -> Path:
    """Leave the video for people of round ``index``; the first round's is at the top of the folder at once, too.

    ``moved`` are the model's particles to its end, if that has been simulated.

    Returns:
        The video's path in the round's folder.
    """
    x, F = simulate_ending(recording, moved)
    path = write_presentation(
        store, scene.config, scene.body, x, F, size, notes=notes, folder=f"iterations/{index}"
    )
    if index == 0:
        _put_on_top(store, index, [VIDEO])
    return path


def rehearse_clip(scene: CompiledScene, size: tuple[int, int]) -> None:
    """Draw the rest pose for people, and drop it: the programs are then there when the clip is drawn."""
    x, F = (np.asarray(each)[scene.back][None] for each in (scene.state.x, scene.state.F))
    next(iter(draw_presentation(scene.config, scene.body, x, F, size)), None)


def put_best_on_top(store: RunStore, index: int, *, save_frames: bool) -> None:
    """Put what round ``index`` has left at the top of the folder, its large files under a second name."""
    folder = store.round_folder(index)
    frames = sorted(path.name for path in (folder / "frames").glob("*.png")) if save_frames else []
    shown = [VIDEO] if (folder / VIDEO).is_file() else []
    _put_on_top(
        store,
        index,
        ["scene.json", PLAIN_VIDEO, "motion.npz", *shown, *(f"frames/{name}" for name in frames)],
    )


def _put_on_top(store: RunStore, index: int, names: list[str]) -> None:
    store.claim(*names)
    for name in names:
        with replace_file(store.path / name) as temporary:
            # A scene file is edited by people, who do not expect another one to change with it.
            (shutil.copyfile if name == "scene.json" else link_or_copy)(
                store.round_folder(index) / name, temporary
            )


def write_best(
    store: RunStore,
    index: int,
    config: SceneConfig,
    body: Body,
    save: SaveChoice,
) -> None:
    """Put round ``index`` at the top of the folder, and what was asked for of the best round alone.

    A round without a video for people gets one, from its motion file.
    """
    missing = None if (store.round_folder(index) / VIDEO).is_file() else save.video_size
    if missing is not None or save.splats:
        motion = read_motion(store.round_folder(index) / "motion.npz")
        if missing is not None:
            folder = f"iterations/{index}"
            write_presentation(
                store, config, body, motion.x, motion.F, missing, notes=save.notes, folder=folder
            )
        if save.splats:
            write_splats(store, config, body, motion.x, motion.F, save.splats)
    put_best_on_top(store, index, save_frames=save.frames)


def write_splats(
    store: RunStore, config: SceneConfig, body: Body, x: np.ndarray, F: np.ndarray, form: SplatFormat
) -> None:
    """Leave one file of 3D Gaussians per frame.

    Args:
        store: The run folder.
        config: The scene.
        body: The object at rest.
        x: Particle positions in the body's order [m], shape (T, n, 3).
        F: Deformation gradients, shape (T, n, 3, 3).
        form: The files' format.
    """
    store.claim(*make_splat_names("splats", len(x), form))
    write_splat_frames(store.path / "splats", body, x, F, form=form, up=config.source.up)


def make_motion(scene: CompiledScene, recording: Recording) -> Motion:
    """The recording as a motion file's contents, particles in the body's order."""
    body, cloud = scene.body, scene.body.cloud
    return Motion(
        times=np.arange(len(recording.x)) * scene.config.timing.frame_dt,
        x=recording.x[:, scene.back],
        F=recording.F[:, scene.back],
        binding_indices=np.asarray(body.binding.indices),
        binding_weights=np.asarray(body.binding.weights),
        binding_offsets=np.asarray(body.binding.offsets),
        cloud_means=np.asarray(cloud.means),
        cloud_quats=np.asarray(cloud.quats),
        cloud_scales=np.asarray(cloud.scales),
        cloud_opacities=np.asarray(cloud.opacities),
        cloud_sh=np.asarray(cloud.sh),
        cloud_rotation=body.placement.rotation,
    )


def write_filmstrip(path: Path, rgb: np.ndarray, seen: Perception) -> None:
    """A strip of evenly spaced frames with perception's mask and tracks drawn on them."""
    chosen = spread_evenly(len(rgb), FILMSTRIP_FRAMES)
    strip = np.concatenate(draw_overlay(rgb, seen.masks, seen.tracks, seen.visible, frames=chosen), axis=1)
    write_picture(path, strip)
