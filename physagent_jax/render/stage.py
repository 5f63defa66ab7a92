"""The surroundings of an object in pictures for people: a ground with a grid, a contact shadow, a horizon.

Never for perception, which gets the plain picture. All of it follows from the camera and the Gaussians.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.gaussians.cloud import Splats
from physagent_jax.render.blocks import (
    ACTOR_COLOUR,
    ACTOR_OPACITY,
    COLOUR,
    OPACITY,
    Block,
    cast_at_block,
    find_window,
)
from physagent_jax.render.camera import Camera
from physagent_jax.render.renderer import RenderedImage, to_uint8
from physagent_jax.render.shadow import ShadowMap, cast_shadow

HORIZON = np.array([0.925, 0.935, 0.945], np.float32)
ZENITH = np.array([0.70, 0.775, 0.86], np.float32)
GROUND = np.array([0.76, 0.745, 0.72], np.float32)
SHADOW = np.array([0.13, 0.14, 0.18], np.float32)  # share of light that is left where none arrives from above
BACKDROP = (np.array([0.955, 0.96, 0.965], np.float32), np.array([0.83, 0.85, 0.875], np.float32))
GRID_STEP, LINE_WIDTH, LINE_DARKNESS = 0.5, 0.012, 0.13  # [sizes], [sizes], [1]
HAZE_RANGE, MOST_HAZE = 14.0, 0.7  # [sizes] to where the ground has paled by 1 - 1/e; of it, at the horizon
FARTHEST = 400.0  # [sizes]; nothing of the ground can be told apart beyond
SUNK = 0.035  # [sizes] below the ground from which on it hides what is drawn: contact is softer than a plane


@dataclasses.dataclass(frozen=True)
class Stage:
    """The place where an object stands.

    Attributes:
        ground: Height of the ground, whose normal is +z [m]; None = there is none, only a plain backdrop.
        size: The object's longest side [m], by which the grid's step and the shadow's softness go.
        blocks: What else stands there.
    """

    ground: float | None
    size: float
    blocks: tuple[Block, ...] = ()


@dataclasses.dataclass(frozen=True)
class Backdrop:
    """A stage without its object, from one camera; the same for all frames that this camera takes.

    Attributes:
        stage, camera: The stage, and the camera that sees it.
        rgb: The picture, shape (h, w, 3), float32.
        levels: The same in levels of 8 bits, uint8.
        slope: Height that a ray gains per depth [1], shape (h, w).
        ground: Where rays meet the ground, x and y [m], nan where they do not, shape (h, w, 2); None without a ground,
            and from below it.
        solid: z-depth of the nearest block [m], inf where there is none, shape (h, w); None without blocks.
        lit: Share of light from above that ``rgb`` itself shows, as a photo of the object does, shape (h, w); None = 1.
    """

    stage: Stage
    camera: Camera
    rgb: np.ndarray
    levels: np.ndarray
    slope: np.ndarray
    ground: np.ndarray | None
    solid: np.ndarray | None
    lit: np.ndarray | None = None


def make_backdrop(stage: Stage, camera: Camera) -> Backdrop:
    """Draw sky and ground; without a ground, or from below it, a plain gradient in which nothing seems to hover."""
    rotation = np.asarray(camera.viewmat, np.float64)[:3, :3]
    rays = (rotation.T @ np.linalg.inv(np.asarray(camera.K, np.float64))).astype(np.float32)
    size = camera.height, camera.width
    grounded = stage.ground is not None and camera.center[2] > stage.ground
    if grounded:
        pixel = 1 / float(np.asarray(camera.K)[1, 1])
        drawn = _draw_ground(rays, np.float32(camera.center), stage.ground, stage.size, pixel, size)
    else:
        drawn = _draw_plain(rays, size)
    rgb, slope, ground = (np.asarray(each) for each in drawn)
    rgb = rgb + _make_dither(*size)
    solid = _draw_blocks(stage, camera, slope, rgb) if stage.blocks else None
    return Backdrop(stage, camera, rgb, to_uint8(rgb), slope, ground if grounded else None, solid)


def compose(
    image: RenderedImage, splats: Splats, backdrop: Backdrop, actors: Sequence[Block] = ()
) -> np.ndarray:
    """Put a rendered object on its stage.

    What is below the ground is hidden by it, but for a depth that contact may have.

    Args:
        image: Rendered over black, from the backdrop's camera.
        splats: What was rendered; they cast the shadow.
        backdrop: Backdrop of that camera.
        actors: Solids that act, drawn translucent.

    Returns:
        The picture, uint8, shape (h, w, 3).
    """
    levels = backdrop.levels.copy()
    rgb = np.asarray(image.rgb)
    alpha = np.asarray(image.alpha)
    boxes = []
    lit, part = _find_lit(splats, backdrop)
    if lit is not None:
        boxes.append(part)
        if backdrop.lit is not None:
            lit = np.minimum(lit / np.maximum(backdrop.lit, 1e-3), 1)
    rows, columns = np.flatnonzero(alpha.any(axis=1)), np.flatnonzero(alpha.any(axis=0))
    if len(rows):
        boxes.append((slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)))
    for part in boxes:
        behind = backdrop.rgb[part]
        if lit is not None:
            behind = behind * (SHADOW + lit[part][..., None] * (1 - SHADOW))
        shown = _find_shown(backdrop, np.asarray(image.depth)[part], part)
        cover = (shown * alpha[part])[..., None]
        levels[part] = to_uint8(shown[..., None] * rgb[part] + (1 - cover) * behind)
    for block in sorted(actors, key=lambda each: -float(backdrop.camera.forward @ each.center)):
        _draw_actor(block, levels, alpha, np.asarray(image.depth), backdrop)
    return levels


def put_picture(backdrop: Backdrop, rgb: np.ndarray, splats: Splats) -> Backdrop:
    """A backdrop that shows a photo of the stage, which holds the shadow of the object as it then was.

    Args:
        backdrop: The stage from the photo's camera.
        rgb: The photo without the object, in [0, 1], float32, shape (h, w, 3).
        splats: The object as it then was.
    """
    lit, _ = _find_lit(splats, backdrop)
    return dataclasses.replace(backdrop, rgb=rgb, levels=to_uint8(rgb), lit=lit)


def _find_lit(splats: Splats, backdrop: Backdrop) -> tuple[np.ndarray | None, tuple[slice, slice]]:
    """The share of light that reaches each pixel of the ground from above, shape (h, w), and where it may be below 1.

    None where nothing casts a shadow, or there is no ground to see it on.
    """
    nowhere, ground = np.s_[:0, :0], backdrop.stage.ground
    if backdrop.ground is None or ground is None:
        return None, nowhere
    shadow = cast_shadow(splats, ground, backdrop.stage.size)
    if shadow is None:
        return None, nowhere
    part = _find_on_screen(shadow, ground, backdrop.camera)
    lit = np.ones(backdrop.slope.shape, np.float32)
    lit[part] = 1 - shadow.sample(backdrop.ground[part])
    return lit, part


def _draw_actor(
    block: Block, levels: np.ndarray, alpha: np.ndarray, depth: np.ndarray, backdrop: Backdrop
) -> None:
    """Draw a translucent solid into ``levels``, in place; what is before it, and the ground, hide it."""
    camera, stage = backdrop.camera, backdrop.stage
    part = find_window(block, camera)
    hit, brightness = cast_at_block(block, camera, part)
    cover = np.where(np.isfinite(hit), ACTOR_OPACITY, 0.0)
    cover = cover * (1 - alpha[part] * (depth[part] < hit))
    if backdrop.ground is not None and stage.ground is not None:
        cover = cover * (
            camera.center[2] - stage.ground + np.where(np.isfinite(hit), hit, 0) * backdrop.slope[part] > 0
        )
    colour = 255 * np.clip(brightness[..., None] * ACTOR_COLOUR, 0, 1)
    levels[part] = np.rint(levels[part] + cover[..., None] * (colour - levels[part])).astype(np.uint8)


def _draw_blocks(stage: Stage, camera: Camera, slope: np.ndarray, rgb: np.ndarray) -> np.ndarray:
    """Draw the blocks into ``rgb``, in place, the farthest first.

    Returns:
        z-depth of the nearest [m], inf where there is none, shape (h, w).
    """
    ground = np.full(slope.shape, np.inf, np.float32)
    if stage.ground is not None and camera.center[2] > stage.ground:
        height = camera.center[2] - stage.ground
        ground = np.where(slope < 0, height / np.maximum(-slope, 1e-6), np.inf)
    hits = [cast_at_block(block, camera) for block in stage.blocks]
    middle = [float(camera.forward @ (block.center - camera.center)) for block in stage.blocks]
    nearest = np.full(slope.shape, np.inf, np.float32)
    for index in sorted(range(len(hits)), key=lambda index: -middle[index]):
        depth, brightness = hits[index]
        seen = np.isfinite(depth) & (depth < ground)
        rgb[seen] += OPACITY * (brightness[seen][:, None] * COLOUR - rgb[seen])
        nearest = np.where(seen, np.minimum(nearest, depth), nearest)
    return nearest


def _find_shown(backdrop: Backdrop, depth: np.ndarray, part) -> np.ndarray:
    """The share of the object that ground and blocks let through in a part of the picture, by where it is hit."""
    stage, shown = backdrop.stage, np.ones_like(depth)
    if backdrop.ground is not None and stage.ground is not None:
        height = (backdrop.camera.center[2] - stage.ground) + depth * backdrop.slope[part]
        shown = np.clip(2 + height / (SUNK * stage.size), 0, 1).astype(np.float32)
    if backdrop.solid is not None:
        within = np.clip((depth - backdrop.solid[part]) / (SUNK * stage.size) - 1, 0, 1)
        shown = shown * (1 - OPACITY * within)
    return shown


def _find_on_screen(shadow: ShadowMap, ground: float, camera: Camera) -> tuple[slice, slice]:
    """Rows and columns of the picture in which ``shadow`` may be seen."""
    low, high = shadow.low, shadow.low + shadow.cell * (np.array(shadow.darkness.shape) - 1)
    x, y = np.meshgrid([low[0], high[0]], [low[1], high[1]])
    view = np.asarray(camera.viewmat, np.float64)
    corners = np.stack([x.ravel(), y.ravel(), np.full(4, ground)], 1) @ view[:3, :3].T + view[:3, 3]
    if (corners[:, 2] < 1e-3).any():  # beside or behind the camera: it may reach anywhere
        return np.s_[: camera.height, : camera.width]
    pixels = corners @ np.asarray(camera.K, np.float64).T
    pixels = pixels[:, :2] / pixels[:, 2:]
    bounds = np.array([camera.width, camera.height])
    first = np.clip(np.floor(pixels.min(0)), 0, bounds - 1).astype(int)
    last = np.clip(np.ceil(pixels.max(0)), first + 1, bounds).astype(int)
    return np.s_[first[1] : last[1], first[0] : last[0]]


def _cast_rays(rays: jax.Array, size: tuple[int, int]) -> list[jax.Array]:
    """Components (x, y, z) in the world of rays of depth 1 through the pixels' centres, each of shape (h, w)."""
    u, v = jnp.arange(size[1]) + 0.5, jnp.arange(size[0]) + 0.5
    return [rays[i, 0] * u[None, :] + rays[i, 1] * v[:, None] + rays[i, 2] for i in range(3)]


@functools.partial(jax.jit, static_argnums=1)
def _draw_plain(rays: jax.Array, size: tuple[int, int]):
    share = jnp.linspace(0, 1, size[0])[:, None, None]
    rgb = jnp.broadcast_to((1 - share) * BACKDROP[0] + share * BACKDROP[1], (*size, 3))
    return rgb, _cast_rays(rays, size)[2], jnp.zeros((0,))


@functools.partial(jax.jit, static_argnums=5)
def _draw_ground(
    rays: jax.Array, eye: jax.Array, ground: float, scale: float, pixel: float, size: tuple[int, int]
):
    """Colours, slopes and ground points of a stage seen from ``eye`` [m]; ``pixel`` is a pixel's angle [rad]."""
    dx, dy, slope = _cast_rays(rays, size)
    flat = jnp.sqrt(dx * dx + dy * dy) + 1e-9
    length = jnp.sqrt(flat * flat + slope * slope)
    sky = HORIZON + (jnp.clip(slope / length, 0, 1) ** 0.8)[..., None] * (ZENITH - HORIZON)
    above = eye[2] - ground
    depth = above / jnp.maximum(-slope, 1e-6)
    seen = depth * length < FARTHEST * scale
    x, y = eye[0] + depth * dx, eye[1] + depth * dy
    across = depth * pixel  # what a pixel covers, across the line of sight and along it
    along = across * jnp.sqrt(1 + (depth * flat / above) ** 2)
    cos, sin = jnp.abs(dx) / flat, jnp.abs(dy) / flat
    step, width = GRID_STEP * scale, LINE_WIDTH * scale
    lines = jnp.maximum(
        _average_lines(x, cos * along + sin * across, step, width),
        _average_lines(y, sin * along + cos * across, step, width),
    )
    haze = MOST_HAZE * (1 - jnp.exp(-((jnp.where(seen, depth * length, jnp.inf) / scale / HAZE_RANGE) ** 2)))
    lines = LINE_DARKNESS * jnp.where(seen, lines, LINE_WIDTH / GRID_STEP)
    floor = (1 - lines)[..., None] * GROUND
    floor = floor + haze[..., None] * (HORIZON - floor)
    covered = jnp.clip(0.5 - slope / pixel, 0, 1)[..., None]  # the horizon's own row of pixels is mixed
    hit_mask = (seen & (slope < 0))[..., None]
    points = jnp.where(hit_mask, jnp.stack([x, y], axis=-1), jnp.nan)
    return sky + covered * (floor - sky), slope, points


def _average_lines(x: jax.Array, footprint: jax.Array, step: float, width: float) -> jax.Array:
    """Share of [x - footprint / 2, x + footprint / 2] in lines of ``width`` every ``step``: exact, so free of moire."""

    def covered_up_to(position):
        whole = jnp.floor(position / step)
        return whole * width + jnp.minimum(position - whole * step, width)

    x = x + 0.5 * width  # lines are centred on multiples of the step
    footprint = jnp.maximum(footprint, 1e-4 * step)
    return jnp.clip(
        (covered_up_to(x + 0.5 * footprint) - covered_up_to(x - 0.5 * footprint)) / footprint, 0, 1
    )


@functools.lru_cache(maxsize=4)
def _make_dither(height: int, width: int) -> np.ndarray:
    """Noise of half a level of 8 bits, always the same: gradients show no steps, shape (h, w, 1)."""
    noise = np.random.default_rng(0).random((height, width, 1), np.float32)
    return (noise - 0.5) / 255
