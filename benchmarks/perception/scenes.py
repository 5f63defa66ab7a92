"""Clips as an RGB-D camera sees them: a moved object, drawn by the product's renderer, before a background."""

from __future__ import annotations

import dataclasses
import functools
from pathlib import Path

import cv2
import jax.numpy as jnp
import numpy as np

from benchmarks.perception.motions import LOOK, Motion
from physagent_jax.gaussians.cloud import GaussianCloud, Splats
from physagent_jax.gaussians.covariance import quats_scales_to_covariances, transform_covariances
from physagent_jax.gaussians.formats import read_ply
from physagent_jax.render import Camera, look_at, render_all
from physagent_jax.scene.procedural import PROCEDURAL

ASSETS = Path(__file__).resolve().parents[2] / "examples" / "assets"
OBJECTS = ("robot", "plant", "loaf")
DISTANCES = {"near": 2.4, "middle": 3.2, "far": 4.4}
"""From camera to object [body lengths]."""
BACKGROUNDS = ("plain", "picture", "room")
NOISES = ("none", "camera")
WIDTH, HEIGHT, FRAMES, FRAME_DT = 400, 300, 24, 0.04
_COLOUR_NOISE = 2.0
_DEPTH_NOISE = 0.0012
"""Standard deviation of a depth camera's noise over the square of depth [1/m] (structured light: Khoshelham and
Oude Elberink 2012 find 0.0014)."""
_DROPPED, _DROPPED_EDGE = 0.02, 0.5
"""Shares of pixels without depth: anywhere, and at jumps in depth."""


@dataclasses.dataclass(frozen=True)
class Sight:
    """A moved object by itself.

    Attributes:
        colour: Premultiplied by coverage, float32, shape (T, H, W, 3).
        alpha: Coverage, shape (T, H, W).
        depth: z-depth [m], 0 where nothing is, shape (T, H, W).
        means: Centres of the Gaussians per frame [m], shape (T, n, 3).
        floor: Height of the lowest point of the clip [m].
        camera: Where it is seen from.
        size: Longest extent of the means in frame 0 [m].
    """

    colour: np.ndarray
    alpha: np.ndarray
    depth: np.ndarray
    means: np.ndarray
    floor: float
    camera: Camera
    size: float


@functools.cache
def load(name: str) -> tuple[GaussianCloud, np.ndarray]:
    """An object, 1 m long and centred, as it was captured, and the rotation that stands it up."""
    cloud = read_ply(ASSETS / "robot.ply") if name == "robot" else PROCEDURAL[name](0)
    stand = (
        np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]) if name == "robot" else np.eye(3)
    )  # its card: up is -y
    means = np.asarray(cloud.means, np.float64)
    scale = 1 / np.ptp(means, axis=0).max()
    means = (means - means.mean(0)) * scale
    scaled = dataclasses.replace(
        cloud, means=jnp.asarray(means, jnp.float32), scales=cloud.scales * np.float32(scale)
    )
    return scaled, stand


def make_camera(distance: float) -> Camera:
    """Look along `LOOK` at the origin."""
    return look_at(-distance * LOOK, (0, 0, 0), (0, 0, 1), fov_degrees=40.0, width=WIDTH, height=HEIGHT)


def film(name: str, motion: Motion, distance: float) -> Sight:
    """Draw an object under a motion."""
    (cloud, stand), camera = load(name), make_camera(distance)
    rest = np.asarray(cloud.means, np.float64)
    covariances = quats_scales_to_covariances(cloud.quats, cloud.scales)
    frames, means = [], []
    for s in np.linspace(0, 1, FRAMES):
        A = motion.matrix(s)
        u, _, vt = np.linalg.svd(A)
        moved = rest @ (A @ stand).T + motion.shift(s)
        means.append(moved)
        F = jnp.broadcast_to(jnp.asarray(A @ stand, jnp.float32), (len(rest), 3, 3))
        R = jnp.broadcast_to(jnp.asarray(u @ vt @ stand, jnp.float32), (len(rest), 3, 3))
        frames.append(
            Splats(
                jnp.asarray(moved, jnp.float32),
                transform_covariances(F, covariances),
                cloud.opacities,
                cloud.sh,
                R,
            )
        )
    drawn = render_all(frames, camera, background=(0.0, 0.0, 0.0))
    path = np.stack(means)
    return Sight(
        colour=np.stack([np.asarray(d.rgb) for d in drawn]),
        alpha=np.stack([np.asarray(d.alpha) for d in drawn]),
        depth=np.stack([np.asarray(d.depth) for d in drawn]),
        means=path,
        floor=float(np.percentile(path[..., 2], 0.2, axis=1).min()),
        camera=camera,
        size=float(np.ptp(path[0], axis=0).max()),
    )


def compose(sight: Sight, background: str, noise: str, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Put the object before a background.

    Args:
        sight: The object.
        background: One of `BACKGROUNDS`: white without a surface, as the product's own pictures; a slanted wall with a
            busy picture on it; a floor on which the object's lowest point touches down, and a wall behind.
        noise: One of `NOISES`.
        seed: Seed of pictures and noise.

    Returns:
        Pictures, uint8, shape (T, H, W, 3), and z-depth [m], nan or 0 where there is none, shape (T, H, W).
    """
    rng = np.random.default_rng(seed)
    if background == "plain":
        rgb, depth = sight.colour + (1 - sight.alpha[..., None]), sight.depth.copy()
    else:
        picture, behind = (_draw_wall if background == "picture" else _draw_room)(sight, rng)
        front = (sight.alpha > 0.5) & (sight.depth < behind)
        hidden = (sight.alpha > 0.5) & ~front
        alpha = np.where(hidden, 0, sight.alpha)[..., None]
        rgb = np.where(hidden[..., None], 0, sight.colour) + (1 - alpha) * picture
        depth = np.where(front, sight.depth, behind)
    rgb = 255 * np.clip(rgb, 0, 1)
    if noise == "camera":
        rgb = rgb + rng.normal(0, _COLOUR_NOISE, rgb.shape)
        depth = np.stack([_degrade(d, rng) for d in depth])
    return np.clip(rgb, 0, 255).round().astype(np.uint8), depth.astype(np.float32)


def _degrade(depth: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """One frame of depth as a depth camera has it: noise that grows with z^2, dropped pixels, most at jumps."""
    seen = depth > 0
    kernel = np.ones((3, 3), np.uint8)
    far = np.where(seen, depth, depth.max() + 1).astype(np.float32)
    jump = cv2.dilate(far, kernel) - cv2.erode(far, kernel) > 0.08
    dropped = rng.uniform(size=depth.shape) < np.where(jump, _DROPPED_EDGE, _DROPPED)
    noisy = depth + rng.normal(0, _DEPTH_NOISE, depth.shape) * depth**2
    return np.where(seen & ~dropped, noisy, np.nan)


def _cast_rays(camera: Camera) -> np.ndarray:
    """World directions of the pixels with unit z-depth, shape (H, W, 3)."""
    x, y = np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5)
    view = np.stack([x, y, np.ones_like(x)], -1) @ np.linalg.inv(np.asarray(camera.K, float)).T
    return view @ np.asarray(camera.viewmat, float)[:3, :3]


def _intersect_plane(camera: Camera, normal: np.ndarray, offset: float) -> np.ndarray:
    """z-depth of the plane normal . x = offset; inf where it is not before the camera, shape (H, W)."""
    along = _cast_rays(camera) @ normal
    with np.errstate(divide="ignore", invalid="ignore"):
        z = (offset - camera.center @ normal) / along
    return np.where(z > 0, z, np.inf)


def _draw_wall(sight: Sight, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    behind = float(sight.means[..., 1].max()) + 0.6
    normal = np.array([0.35, 1.0, 0.1])
    z = _intersect_plane(
        sight.camera, normal / np.linalg.norm(normal), (behind + 0.3) / float(np.linalg.norm(normal))
    )
    return _paint_photograph(rng), z


def _draw_room(sight: Sight, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    camera = sight.camera
    behind = float(sight.means[..., 1].max()) + 0.8
    floor, wall = (
        _intersect_plane(camera, np.array([0, 0, 1.0]), sight.floor),
        _intersect_plane(camera, np.array([0, 1.0, 0]), behind),
    )
    z = np.minimum(floor, wall)
    points = camera.center + _cast_rays(camera) * z[..., None]
    boards = np.floor(points[..., 0] / 0.18).astype(int)
    grain = 0.5 + 0.5 * np.sin(37 * points[..., 0] + 3 * np.sin(5 * points[..., 1] + boards))
    tone = rng.uniform(0.75, 1.0, 400)[boards % 400] * (0.8 + 0.2 * grain)
    wood = tone[..., None] * np.array([0.62, 0.46, 0.32])
    paper = np.array([0.72, 0.74, 0.68]) * (0.85 + 0.15 * _paint_photograph(rng, detail=1.0)[..., :1])
    return np.where((floor < wall)[..., None], wood, paper), z


def _paint_photograph(rng: np.random.Generator, detail: float = 1.2) -> np.ndarray:
    """Colours with a photograph's spectrum, falling as 1/f, and hard-edged patches; (H, W, 3) in 0..1."""
    fy, fx = np.fft.fftfreq(HEIGHT)[:, None], np.fft.fftfreq(WIDTH)[None]
    amplitude = 1 / np.maximum(np.hypot(fx, fy), 1 / WIDTH) ** detail
    waves = np.fft.fft2(rng.normal(size=(HEIGHT, WIDTH, 3)), axes=(0, 1)) * amplitude[..., None]
    picture = np.fft.ifft2(waves, axes=(0, 1)).real
    picture = picture @ np.array([[1, 0.5, 0.4], [0.5, 1, 0.5], [0.4, 0.5, 1]])
    picture = 0.45 + 0.16 * (picture - picture.mean()) / picture.std()
    for _ in range(12):
        corner, side = rng.uniform(0, (WIDTH, HEIGHT)), rng.uniform(15, 70, 2)
        box = cv2.boxPoints((tuple(corner), tuple(side), float(rng.uniform(0, 90)))).astype(np.int32)
        layer = picture.copy()
        cv2.fillPoly(layer, [box], rng.uniform(0.1, 0.9, 3).tolist())
        picture = 0.4 * picture + 0.6 * layer
    return np.clip(picture, 0, 1)
