"""Images of splats: the differentiable pipeline, and the convenient call that sizes its buffers."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.core.pytree import register_dataclass
from physagent_jax.gaussians.cloud import Splats
from physagent_jax.kernels import Kernels, find_platform, threads, use_cpu
from physagent_jax.kernels.forks import refuse_fork
from physagent_jax.render.camera import Camera
from physagent_jax.render.layout import TileLayout
from physagent_jax.render.project import Projected, project
from physagent_jax.render.rasterize import blend
from physagent_jax.render.tiles import build_tile_lists, count_pairs, find_tile_rectangles, make_tile_grid

TILE_SIZE = 16

# More pairs than this would need gigabytes for one image.
_MAX_CAPACITY = 1 << 28

# Capacity that sufficed for clouds of this size at this resolution: the next frame needs about as much,
# and the same capacity means the same compiled program.
capacities: dict[tuple[int, int, int], int] = {}


@register_dataclass
@dataclasses.dataclass(frozen=True)
class RenderedImage:
    """One RGB-D image.

    Attributes:
        rgb: Colour over the background; not negative, may exceed 1 where the SH do, shape (h, w, 3).
        depth: Expected z-depth of what was hit [m]; 0 where no Gaussian contributes, shape (h, w).
        alpha: Coverage in [0, 1]; 0 or at least 1/255, shape (h, w).
    """

    rgb: jax.Array
    depth: jax.Array
    alpha: jax.Array


def render(
    splats: Splats, camera: Camera, *, background=(1.0, 1.0, 1.0), kernels: Kernels = "auto"
) -> RenderedImage:
    """Render on whatever device JAX uses, sizing buffers as needed. Not for use inside `jit`.

    Args:
        splats: Gaussians in world space.
        camera: Pinhole camera.
        background: Colour behind the splats, shape (3,).
        kernels: As `rasterize` has it.

    Raises:
        UserError: The Gaussians overlap so many tiles that the image does not fit into memory, or ``kernels`` are not
            to be had.
    """
    key = _make_key(splats, camera)
    capacity = capacities.get(key) or choose_pair_capacity(splats, camera)
    rendering, total = rasterize(splats, camera, background, capacity=capacity, kernels=kernels)
    if int(total) > capacity:  # not what is noted by now: another thread may have noted more since
        capacity = round_up(int(total))
        rendering, _ = rasterize(splats, camera, background, capacity=capacity, kernels=kernels)
    capacities[key] = max(capacity, capacities.get(key, 0))
    return rendering


def render_all(
    frames: Sequence[Splats],
    camera: Camera | Sequence[Camera],
    *,
    background=(1.0, 1.0, 1.0),
    kernels: Kernels = "auto",
) -> list[RenderedImage]:
    """`render` of each frame, `choose_batch_size` at the same time; all from one camera, or each from its own.

    On CPU a frame by itself leaves cores idle while its tile lists are made.
    """

    def one(splats: Splats, camera: Camera) -> RenderedImage:
        return jax.block_until_ready(render(splats, camera, background=background, kernels=kernels))

    cameras = [camera] * len(frames) if isinstance(camera, Camera) else list(camera)
    views = list(zip(frames, cameras, strict=True))
    alone = [view for view in views[:1] if _make_key(*view) not in capacities]
    done = [one(*view) for view in alone]  # so that what has to be compiled is compiled once
    with ThreadPoolExecutor(choose_batch_size()) as pool:
        return done + list(pool.map(lambda view: one(*view), views[len(done) :]))


def to_uint8(rgb) -> np.ndarray:
    """Colours in [0, 1], rounded to levels of 8 bits; what is beyond is clipped."""
    return (np.clip(np.asarray(rgb), 0, 1) * 255 + 0.5).astype(np.uint8)


def choose_batch_size() -> int:
    """Frames that are best rendered at the same time: on CPU one per core."""
    if find_platform() != "cpu":
        return 1
    return threads.thread_count() if use_cpu() else threads.core_count()


def choose_pair_capacity(splats: Splats, camera: Camera) -> int:
    """A capacity for `rasterize` with room for about a quarter more pairs than these splats need.

    Raises:
        UserError: The Gaussians overlap so many tiles that the image does not fit into memory.
    """
    refuse_fork()
    return round_up(int(_count_pairs(_project(splats, camera), camera.width, camera.height)))


def rasterize(
    splats: Splats,
    camera: Camera,
    background: np.ndarray | jax.Array,
    *,
    capacity: int,
    tile_size: int = TILE_SIZE,
    lanes: int | None = None,
    kernels: Kernels = "auto",
) -> tuple[RenderedImage, jax.Array]:
    """Renders; differentiable with respect to splats, camera pose and background.

    The order of the Gaussians and their box on the image carry no gradient.

    Args:
        splats: Gaussians in world space.
        camera: Pinhole camera.
        background: Colour behind the splats, shape (3,).
        capacity: Room for pairs (Gaussian, tile), static; see `choose_pair_capacity`.
        tile_size: Edge of a tile [px].
        lanes: Tiles blended in lockstep; default one on the CPU, all elsewhere.
        kernels: As in `mpm.Model`. Those for the CPU blend in single precision, tiles of 16 pixels one at a time;
            anything else is blended in JAX.

    Returns:
        The image, and the number of pairs it needed. If that exceeds ``capacity`` the image is NaN
        everywhere: call again with more room.
    """
    if lanes is None:
        tiles = int(np.prod(make_tile_grid(camera.width, camera.height, tile_size)))
        lanes = 1 if find_platform() == "cpu" else tiles
    layout = TileLayout(camera.width, camera.height, tile_size, lanes)
    refuse_fork()
    projected = _project(splats, camera)
    background = _cast(background, splats.means.dtype)
    return draw(projected, background, capacity, layout, use_cpu(kernels))


def _project(splats: Splats, camera: Camera) -> Projected:
    """`project` as the program that `choose_pair_capacity` and `rasterize` share."""
    return project(splats, jax.tree.map(lambda array: _cast(array, splats.means.dtype), camera))


def _cast(array, dtype) -> np.ndarray | jax.Array:
    """``array`` in the one precision of a picture: cameras come as float64 from NumPy."""
    return array.astype(dtype) if isinstance(array, jax.Array) else np.asarray(array, dtype)


@functools.partial(jax.jit, static_argnums=(2, 3, 4))
def draw(
    projected: Projected, background: np.ndarray | jax.Array, capacity: int, layout: TileLayout, native: bool
):
    """The program behind `rasterize`: tile lists, then blending; NaN everywhere if ``capacity`` is too small."""
    width, height = layout.width, layout.height
    with jax.named_scope("tile_lists"):
        lists = build_tile_lists(projected, width, height, capacity=capacity, tile_size=layout.tile_size)
    with jax.named_scope("blend"):
        features, transmittance = blend(projected, lists, layout, native)
    valid = jnp.where(lists.total <= capacity, 1.0, jnp.nan).astype(features.dtype)
    alpha = 1 - transmittance
    rgb = features[..., :3] + transmittance[..., None] * background
    depth = jnp.where(alpha > 0, features[..., 3] / jnp.where(alpha > 0, alpha, 1), 0)
    return RenderedImage(rgb * valid, depth * valid, alpha * valid), lists.total


@jax.jit
def _count_pairs(projected: Projected, width: int, height: int) -> jax.Array:
    """For pictures of any size: neither of them is static."""
    return count_pairs(find_tile_rectangles(projected, width, height, TILE_SIZE))


def _make_key(splats: Splats, camera: Camera) -> tuple[int, int, int]:
    return splats.means.shape[0], camera.width, camera.height


def round_up(total: int) -> int:
    """A quarter more than ``total``, rounded up to a few steps per power of two to compile rarely."""
    if total > _MAX_CAPACITY:
        raise UserError(
            "the Gaussians cover too many tiles to render",
            got="more than 2^31 pairs" if total == np.iinfo(np.int32).max else f"{total} pairs",
            do="Move the camera out of the object, or lower the resolution",
        )
    wanted = max(1024, total + total // 4)
    step = 1 << (wanted.bit_length() - 3)
    return -(-wanted // step) * step
