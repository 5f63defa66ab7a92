"""Clips: simulated, rendered and kept on the disk under a hash of what was simulated."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from functools import lru_cache
from pathlib import Path

import numpy as np

from benchmarks.verdicts.motions import Motion
from benchmarks.verdicts.scenes import REACH, count_lead, make_scene
from benchmarks.verdicts.things import THINGS, load_body
from physagent_jax.kernels.compile_cache import enable_compile_cache
from physagent_jax.render import Camera, render_all
from physagent_jax.scene.body import Body
from physagent_jax.scene.camera import frame_camera, make_reference_camera
from physagent_jax.scene.compile import compile_scene
from physagent_jax.scene.config import SceneConfig
from physagent_jax.simulation.simulate import deform_splats, simulate_frames

VERSION = 1  # of what is kept: another one simulates all clips anew
ROOM = 0.12  # [L] around what the camera shows
NEAR_ROOM = 0.35  # the same where things may leave the picture
DEPTH_UNIT = 2.5e-4  # [m] in which depth is kept
_PICTURES = ("rgb", "alpha", "depth")  # kept without the empty margin


@dataclasses.dataclass(frozen=True)
class Recording:
    """A clip.

    Attributes:
        particles: Positions [m], float32, shape (T, n, 3).
        gaussians: Centres [m], float32, shape (T, g, 3).
        rgb: Pictures over black, uint8, shape (T, H, W, 3).
        alpha: Coverage, uint8, shape (T, H, W).
        depth: z-depth of what is covered [m], 0 elsewhere, float32, shape (T, H, W).
        camera: Where it was taken from.
        ground: Height of the ground, or of what may lie below [m].
        middle: Middle of the object at the start [m], shape (3,).
    """

    particles: np.ndarray
    gaussians: np.ndarray
    rgb: np.ndarray
    alpha: np.ndarray
    depth: np.ndarray
    camera: Camera
    ground: float
    middle: np.ndarray


def record(name: str, motion: Motion, clips: Path, data: Path | None) -> Recording:
    """The clip of an object and a motion: read from ``clips``, or simulated, rendered and kept there.

    Args:
        name: Name of the object.
        motion: What happens.
        clips: Folder of clips.
        data: Folder of captured objects.
    """
    file = find_file(name, motion, clips, data)
    if file.is_file():
        return _read(file)
    scene, body = _scene(name, motion, clips, data)
    made = _simulate(scene, body, motion)
    _write(file, made)
    return made


def find_file(name: str, motion: Motion, clips: Path, data: Path | None) -> Path:
    """Folder of the clip, made or not; arguments as of `record`."""
    return clips / f"{name}-{hash_scene(_scene(name, motion, clips, data)[0], motion)}.npz"


def _scene(name: str, motion: Motion, clips: Path, data: Path | None) -> tuple[SceneConfig, Body]:
    source, body = load_body(name, clips, data)
    return make_scene(THINGS[name], source, body, motion), body


def hash_scene(scene: SceneConfig, motion: Motion) -> str:
    """Facts that clips of the same look share: not the place of the object's file, nor words."""
    # Without what is as it is by default: a new field of scenes does not make all clips anew.
    data = scene.model_dump(mode="json", exclude={"source": {"path"}, "prompt": True}, exclude_defaults=True)
    text = json.dumps([VERSION, motion.near, data], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _simulate(scene: SceneConfig, body: Body, motion: Motion) -> Recording:
    enable_compile_cache()  # many clips share their programs
    compiled = compile_scene(scene, body)
    frames = list(simulate_frames(compiled))[count_lead(motion) :]
    splats = [deform_splats(compiled, frame) for frame in frames]
    gaussians = np.stack([np.asarray(each.means)[: body.cloud.count] for each in splats])
    particles = np.stack([np.asarray(frame.state.x)[compiled.back] for frame in frames])
    camera = _frame(scene, gaussians, motion.near)
    images = render_all(splats, camera, background=(0.0, 0.0, 0.0))
    return Recording(
        particles=particles.astype(np.float32),
        gaussians=gaussians.astype(np.float32),
        rgb=np.stack([_to_uint8(image.rgb) for image in images]),
        alpha=np.stack([_to_uint8(image.alpha) for image in images]),
        depth=_quantise(np.stack([np.asarray(image.depth) for image in images])) * np.float32(DEPTH_UNIT),
        camera=camera,
        ground=float(body.low[2]) - (motion.lifted if motion.world == "ground" else REACH),
        middle=0.5 * (gaussians[0].min(0) + gaussians[0].max(0)),
    )


def _frame(scene: SceneConfig, gaussians: np.ndarray, near: bool) -> Camera:
    """A camera that shows where the object is in all frames, as far as that is not too far away."""
    low, high = gaussians[0].min(0), gaussians[0].max(0)
    room = NEAR_ROOM if near else REACH
    swept = np.concatenate([np.percentile(gaussians, share, axis=1) for share in (1, 99)])
    swept = np.concatenate([[low, high], np.clip(swept, low - room, high + room)])
    if near:
        swept = np.array([low - room, high + room])
    low, high = swept.min(0) - ROOM, swept.max(0) + ROOM
    corners = np.array(np.meshgrid(*zip(low, high))).reshape(3, -1).T
    placed = frame_camera(corners, scene.camera, scene.rendering)
    return make_reference_camera(placed, scene.rendering, scene.domain)


def _to_uint8(image) -> np.ndarray:
    return (np.clip(np.asarray(image), 0, 1) * 255 + 0.5).astype(np.uint8)


def _quantise(depth: np.ndarray) -> np.ndarray:
    """As an integer multiple of `DEPTH_UNIT`, uint16."""
    return np.clip(depth / DEPTH_UNIT + 0.5, 0, 65535).astype(np.uint16)


def _write(file: Path, made: Recording) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    camera = made.camera
    rows, columns = (np.flatnonzero(made.alpha.any(axis=axes)) for axes in ((0, 2), (0, 1)))
    top, bottom = (rows[0], rows[-1] + 1) if len(rows) else (0, 0)
    left, right = (columns[0], columns[-1] + 1) if len(columns) else (0, 0)
    arrays = {
        field.name: getattr(made, field.name)
        for field in dataclasses.fields(made)
        if field.name not in ("camera", "ground", *_PICTURES)
    }
    pictures = {"rgb": made.rgb, "alpha": made.alpha, "depth": _quantise(made.depth)}
    arrays |= {name: value[:, top:bottom, left:right] for name, value in pictures.items()}
    arrays["corner"] = np.array([top, left])
    arrays |= {"viewmat": np.asarray(camera.viewmat), "K": np.asarray(camera.K)}
    arrays |= {"size": np.array([camera.width, camera.height]), "ground": np.array(made.ground)}
    part = file.with_suffix(".part.npz")
    np.savez(part, **arrays)
    part.replace(file)


@lru_cache(maxsize=1)
def _read(file: Path) -> Recording:
    with np.load(file) as held:
        width, height = (int(side) for side in held["size"])
        return Recording(
            particles=held["particles"],
            gaussians=held["gaussians"],
            rgb=_uncrop(held, "rgb"),
            alpha=_uncrop(held, "alpha"),
            depth=_uncrop(held, "depth") * np.float32(DEPTH_UNIT),
            camera=Camera(viewmat=held["viewmat"], K=held["K"], width=width, height=height),
            ground=float(held["ground"]),
            middle=held["middle"],
        )


def _uncrop(held, name: str) -> np.ndarray:
    """A picture with its empty margin."""
    inner, (width, height), (top, left) = held[name], held["size"], held["corner"]
    whole = np.zeros((len(inner), height, width, *inner.shape[3:]), inner.dtype)
    whole[:, top : top + inner.shape[1], left : left + inner.shape[2]] = inner
    return whole
