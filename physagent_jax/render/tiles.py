"""The Gaussians that touch each tile of the image, front to back."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.render.project import Projected

# Rounding must not lose a pixel whose alpha is exactly at the limit; the rasteriser decides in the end.
_MARGIN = 0.01

_INT32_MAX = np.iinfo(np.int32).max


@register_dataclass
@dataclasses.dataclass(frozen=True)
class TileLists:
    """Gaussians per tile in front-to-back order, tiles in row-major order.

    Attributes:
        gaussians: Indices of Gaussians, tile after tile, shape (capacity,), int32.
        starts: Where each tile's list starts, and the end of the last one, shape (tiles + 1,), int32.
        total: Pairs (Gaussian, tile) there are, int32; 2^31 - 1 stands for any larger number. If it exceeds
            the capacity the lists are incomplete and must not be used.
    """

    gaussians: jax.Array
    starts: jax.Array
    total: jax.Array


def make_tile_grid(width: int, height: int, tile_size: int) -> tuple[int, int]:
    """Columns and rows of tiles that cover the image."""
    return -(-width // tile_size), -(-height // tile_size)


def find_tile_rectangles(projected: Projected, width: int, height: int, tile_size: int) -> jax.Array:
    """The tiles that hold a pixel centre inside each Gaussian's box.

    Args:
        projected: Gaussians on the image plane.
        width: [px].
        height: [px].
        tile_size: [px].

    Returns:
        First column, first row, columns, rows (zero for Gaussians off the image), shape (n, 4), int32.
    """
    size = jnp.asarray([width, height], projected.means2d.dtype)
    means, extents = jax.lax.stop_gradient(projected.means2d), projected.extents
    # Clipped before the conversion: an int32 cannot hold every float.
    first = jnp.clip(jnp.ceil(means - extents - 0.5 - _MARGIN), 0, size).astype(jnp.int32)
    last = jnp.clip(jnp.floor(means + extents - 0.5 + _MARGIN), -1, size - 1).astype(jnp.int32)
    inside = jnp.all((last >= first) & (extents > 0), axis=-1, keepdims=True)
    first, last = first // tile_size, last // tile_size
    return jnp.concatenate([first, jnp.where(inside, last - first + 1, 0)], axis=-1)


def count_pairs(rectangles: jax.Array) -> jax.Array:
    """Number of pairs (Gaussian, tile), int32; 2^31 - 1 stands for any larger number."""
    counts = rectangles[:, 2] * rectangles[:, 3]
    overflow = jnp.sum(counts.astype(jnp.float32)) > 2.0**30
    return jnp.where(overflow, _INT32_MAX, jnp.sum(counts, dtype=jnp.int32))


def build_tile_lists(
    projected: Projected, width: int, height: int, *, capacity: int, tile_size: int
) -> TileLists:
    """Sort the pairs (Gaussian, tile) by tile, then depth.

    All pairs share one array of static size ``capacity``: there is no limit per tile that could leave
    holes. The Gaussians are sorted by depth once; a pair's key is then tile and depth rank packed into
    32 bits, because sorting a single key is several times faster than sorting keys with values.

    Args:
        projected: Gaussians on the image plane.
        width: [px].
        height: [px].
        capacity: Room for pairs.
        tile_size: [px].
    """
    count = projected.depths.shape[0]
    columns, rows = make_tile_grid(width, height, tile_size)
    tiles = columns * rows
    order = jnp.argsort(jax.lax.stop_gradient(projected.depths)).astype(jnp.int32)
    rectangles = find_tile_rectangles(projected, width, height, tile_size)[order]
    counts = rectangles[:, 2] * rectangles[:, 3]
    total = count_pairs(rectangles)

    # One slot per pair, in order of depth: which Gaussian it belongs to, and the how-manieth tile of it.
    rank = jnp.repeat(jnp.arange(count, dtype=jnp.int32), counts, total_repeat_length=capacity)
    slot = jnp.arange(capacity, dtype=jnp.int32)
    nth = slot - (jnp.cumsum(counts) - counts)[rank]
    column, row, across, _ = rectangles[rank].T
    across = jnp.maximum(across, 1)
    tile = (row + nth // across) * columns + column + nth % across
    tile = jnp.where(slot < total, tile, tiles)  # unused slots go to the end

    tile, rank = sort_pairs(tile, rank, tiles, count)
    starts = jnp.searchsorted(tile, jnp.arange(tiles + 1, dtype=jnp.int32)).astype(jnp.int32)
    return TileLists(gaussians=order[rank], starts=starts, total=total)


def sort_pairs(tile: jax.Array, rank: jax.Array, tiles: int, count: int) -> tuple[jax.Array, jax.Array]:
    """Sort pairs by tile, then depth rank.

    Args:
        tile: 0 to ``tiles`` (one past the end marks unused slots), shape (m,), int32.
        rank: 0 to ``count`` - 1, ascending, shape (m,), int32.
        tiles: Number of tiles.
        count: Number of Gaussians.
    """
    bits = max(count - 1, 1).bit_length()
    if (tiles + 1) << bits > 1 << 32:
        # The packed key does not fit. The pairs come in order of rank, which a stable sort keeps.
        tile, rank = jax.lax.sort((tile, rank), num_keys=1, is_stable=True)
        return tile, rank
    key = jax.lax.sort((tile.astype(jnp.uint32) << bits) | rank.astype(jnp.uint32), is_stable=False)
    return (key >> bits).astype(jnp.int32), (key & ((1 << bits) - 1)).astype(jnp.int32)
