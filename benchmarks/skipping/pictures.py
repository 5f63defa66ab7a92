"""Skips of Gaussians and files: harmonics and rotations that nobody sees, files that nobody asked for."""

from __future__ import annotations

import dataclasses
import tempfile
from functools import cache
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.skipping.base import Answer, Pair, Sizes, Skip, Way
from benchmarks.skipping.scene import SIZE, cube
from physagent_jax.forces.schema import ForceField
from physagent_jax.gaussians import Binding, GaussianCloud, deform
from physagent_jax.output.motion_file import write_motion
from physagent_jax.output.splats import write_splat_frames
from physagent_jax.output.video import write_frames, write_video
from physagent_jax.render import Camera, Projected, look_at, project
from physagent_jax.run.artifacts import make_motion
from physagent_jax.scene.body import make_scene_body
from physagent_jax.scene.compile import CompiledScene, compile_scene
from physagent_jax.scene.config import Domain, Filling, Rendering, SceneConfig, Source, Timing
from physagent_jax.simulation.recording import Recording
from physagent_jax.simulation.simulate import simulate_scene

ROBOT = Path(__file__).resolve().parents[2] / "examples" / "assets" / "robot.ply"
_COEFFICIENTS = 16  # of degree 3


def _make_cloud(sizes: Sizes) -> tuple[GaussianCloud, Binding, jax.Array]:
    """A Gaussian on every particle of the cube, of one colour from all sides; and the deformation of each."""
    _, state = cube(sizes)
    rng, count = np.random.default_rng(1), sizes.particles
    quats = rng.normal(size=(count, 4))
    cloud = GaussianCloud(
        means=state.x,
        quats=jnp.asarray(quats / np.linalg.norm(quats, axis=1, keepdims=True), jnp.float32),
        scales=jnp.asarray(rng.uniform(0.002, 0.01, (count, 3)), jnp.float32),
        opacities=jnp.asarray(rng.uniform(0.2, 1.0, count), jnp.float32),
        sh=jnp.asarray(rng.uniform(-1, 1, (count, 1, 3)), jnp.float32),
    )
    binding = Binding(
        indices=jnp.arange(count, dtype=jnp.int32)[:, None],
        weights=jnp.ones((count, 1), jnp.float32),
        offsets=jnp.zeros((count, 1, 3), jnp.float32),
    )
    return cloud, binding, state.F


def _make_camera() -> Camera:
    middle = 0.5 * SIZE
    eye, target = (middle, middle - 2.0, middle + 0.5), (middle, middle, middle)
    return look_at(eye, target, (0, 0, 1), fov_degrees=40.0, width=320, height=320)


def _compare_harmonics(sizes: Sizes) -> Pair:
    cloud, binding, F = _make_cloud(sizes)
    camera = _make_camera()
    unseen = jnp.zeros((sizes.particles, _COEFFICIENTS - 1, 3), jnp.float32)
    padded = dataclasses.replace(cloud, sh=jnp.concatenate([cloud.sh, unseen], axis=1))

    def way(cloud: GaussianCloud) -> Way:
        splats = deform(cloud, binding, cloud.means, F, jnp.eye(3, dtype=jnp.float32))
        return Way(lambda: project(splats, camera), _read_projection)

    return Pair(way(padded.of_least_degree()), way(padded), sizes.particles, unit="projection")


def _compare_rotations(sizes: Sizes) -> Pair:
    cloud, binding, F = _make_cloud(sizes)
    identity = jnp.eye(3, dtype=jnp.float32)
    linear = jnp.concatenate([cloud.sh, jnp.zeros((sizes.particles, 3, 3), jnp.float32)], axis=1)
    padded = dataclasses.replace(cloud, sh=linear)

    def way(cloud: GaussianCloud) -> Way:
        return Way(
            lambda: deform(cloud, binding, cloud.means, F, identity),
            lambda splats: _read_projection(project(splats, _make_camera())),
        )

    return Pair(way(cloud), way(padded), sizes.particles, unit="frame")


def _read_projection(projected: Projected) -> Answer:
    names = ("means2d", "conics", "depths", "opacities", "colors")
    return {name: np.asarray(getattr(projected, name)) for name in names}


@cache
def _simulate_clip(particles: int, frames: int, pixels: int) -> tuple[CompiledScene, Recording]:
    """The bundled robot, dropped."""
    config = SceneConfig(
        source=Source(path=str(ROBOT), name="robot", kind="robot", up="-y"),
        filling=Filling(max_particles=particles),
        domain=Domain(size=4.0, cells=48),
        timing=Timing(frame_count=frames, frame_dt=0.02),
        force_field=ForceField(default_drop=True),
        rendering=Rendering(width=pixels, height=pixels),
    )
    scene = compile_scene(config, make_scene_body(config, ROBOT.parent))
    return scene, simulate_scene(scene)


def _compare_files(sizes: Sizes) -> Pair:
    scene, recording = _simulate_clip(sizes.clip_particles, sizes.clip_frames, sizes.clip_pixels)

    def write(everything: bool) -> Answer:
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder)
            write_video(out / "video.mp4", recording.rgb, 1 / scene.config.timing.frame_dt)
            motion = make_motion(scene, recording)
            write_motion(out / "motion.npz", motion)
            if everything:
                write_frames(out / "frames", recording.rgb)
                write_splat_frames(out / "splats", scene.body, motion.x, motion.F)
            return {name: (out / name).read_bytes() for name in ("video.mp4", "motion.npz")}

    lean = Way(lambda: write(everything=False), lambda files: files)
    full = Way(lambda: write(everything=True), lambda files: files)
    gaussians = scene.body.cloud.count
    note = f"{len(recording.rgb)} frames of {gaussians:,} Gaussians, {sizes.clip_pixels} px"
    return Pair(lean, full, scene.body.particles.count, unit="clip", note=note)


SKIPS = (
    Skip(
        "harmonics",
        "view directions and spherical harmonics, where all coefficients beyond the first are zero",
        "the coefficients up to degree 3 as the file has them",
        _compare_harmonics,
    ),
    Skip(
        "rotations of Gaussians",
        "the rotation of every Gaussian, which turns its harmonics, where colours do not depend on the view",
        "the polar rotation of every F, for colours with harmonics of degree 1 that are all zero",
        _compare_rotations,
    ),
    Skip(
        "frames and splats",
        "a PNG and a PLY per frame, unless asked for",
        "`--save-frames --save-splats`; the files that both leave must be equal byte by byte",
        _compare_files,
    ),
)
