"""Steps of GMFlow that have no weights: places, windows, matching, and looking up flow.

Arrays have their channels last.
"""

from __future__ import annotations

import math
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

_TEMPERATURE = 10000.0  # of the wave lengths that tell places (Carion et al. 2020)


def make_grid(height: int, width: int) -> jax.Array:
    """The place (x, y) of each cell, shape (height, width, 2)."""
    x, y = jnp.meshgrid(jnp.arange(width, dtype=jnp.float32), jnp.arange(height, dtype=jnp.float32))
    return jnp.stack([x, y], -1)


def encode_places(height: int, width: int, channels: int) -> np.ndarray:
    """Sines and cosines of each cell's place in its window, of y and then of x, shape (height, width, channels)."""
    half = channels // 2
    scale = _TEMPERATURE ** (2 * (np.arange(half) // 2) / half)

    def waves(count: int) -> np.ndarray:
        phase = (np.arange(1, count + 1) * 2 * np.pi / (count + 1e-6))[:, None] / scale
        return np.stack([np.sin(phase[:, 0::2]), np.cos(phase[:, 1::2])], -1).reshape(count, half)

    down = np.broadcast_to(waves(height)[:, None], (height, width, half))
    along = np.broadcast_to(waves(width)[None], (height, width, half))
    return np.concatenate([down, along], -1).astype(np.float32)


def split(features: Any, splits: int) -> Any:
    """Cut pictures into ``splits`` x ``splits`` windows, shape (batch * splits^2, h, w, channels)."""
    batch, height, width, channels = features.shape
    cut = features.reshape(batch, splits, height // splits, splits, width // splits, channels)
    return cut.transpose(0, 1, 3, 2, 4, 5).reshape(-1, height // splits, width // splits, channels)


def merge(windows: jax.Array, splits: int) -> jax.Array:
    """The opposite of `split`."""
    _, height, width, channels = windows.shape
    grid = windows.reshape(-1, splits, splits, height, width, channels).transpose(0, 1, 3, 2, 4, 5)
    return grid.reshape(-1, splits * height, splits * width, channels)


def mask_shifted(height: int, width: int, splits: int) -> np.ndarray:
    """The mask that keeps apart cells of shifted windows that do not touch in the picture: 0, or -100 between these.

    Returns:
        To be added to scores, shape (splits^2, cells of a window, cells of a window).
    """

    def number(count: int) -> np.ndarray:
        window = count // splits
        starts = np.array([count - window, count - window // 2])
        return (np.arange(count)[:, None] >= starts).sum(1)

    region = (3 * number(height)[:, None] + number(width))[None, ..., None]
    cells = np.asarray(split(region, splits)).reshape(splits**2, -1)
    return np.where(cells[:, :, None] == cells[:, None, :], 0.0, -100.0).astype(np.float32)


def attend(
    queries: jax.Array, keys: jax.Array, values: jax.Array, mask: jax.Array | None = None
) -> jax.Array:
    """Softmax attention with one head, over the last but one axis."""
    scores = queries @ keys.mT / math.sqrt(queries.shape[-1])
    return jax.nn.softmax(scores if mask is None else scores + mask) @ values


def attend_in_windows(
    queries: jax.Array, keys: jax.Array, values: jax.Array, splits: int, shifted: bool
) -> jax.Array:
    """Attention of each cell to those of its window, shape (batch, height, width, channels).

    Args:
        queries: Features of the cells that ask, shape (batch, height, width, channels).
        keys: Features of the cells that are asked.
        values: Features that these tell.
        splits: Windows along a side.
        shifted: Whether the windows lie half a window further.
    """
    batch, height, width, channels = queries.shape
    shift = (height // splits // 2, width // splits // 2) if shifted else (0, 0)
    back = (-shift[0], -shift[1])
    asking, asked, telling = (
        split(jnp.roll(each, back, (1, 2)), splits).reshape(batch, splits**2, -1, channels)
        for each in (queries, keys, values)
    )
    mask = jnp.asarray(mask_shifted(height, width, splits)) if shifted else None
    told = attend(asking, asked, telling, mask)
    window = (height // splits, width // splits)
    return jnp.roll(merge(told.reshape(-1, *window, channels), splits), shift, (1, 2))


def match_globally(first: jax.Array, second: jax.Array) -> jax.Array:
    """Flow by the mean place of all cells of the other picture, weighted by likeness, both ways.

    Args:
        first: Features, shape (batch, height, width, channels).
        second: Those of the other picture.

    Returns:
        Flow [cells] from ``first`` to ``second``, then from ``second`` to ``first``; shape (2 batch, height, width, 2).
    """
    batch, height, width, channels = first.shape
    likeness = (
        first.reshape(batch, -1, channels) @ second.reshape(batch, -1, channels).mT / math.sqrt(channels)
    )
    grid = make_grid(height, width)
    shares = jax.nn.softmax(jnp.concatenate([likeness, likeness.mT]))
    return (shares @ grid.reshape(-1, 2)).reshape(-1, height, width, 2) - grid


def match_nearby(first: jax.Array, second: jax.Array, radius: int) -> jax.Array:
    """Flow by the mean place of the cells within ``radius``, weighted by likeness; the picture's alone count.

    Args:
        first: Features, shape (batch, height, width, channels).
        second: Those of the other picture.
        radius: Half side of the square that is searched [cells].

    Returns:
        Flow [cells] from ``first`` to ``second``, shape (batch, height, width, 2).
    """
    channels = first.shape[-1]
    near = look_around(first.shape[1], first.shape[2], radius)
    likeness = _map_around(second, radius, lambda there: (first * there).sum(-1)) / math.sqrt(channels)
    inside = _map_around(jnp.ones_like(first[..., :1]), radius, lambda there: there[..., 0]) > 0
    shares = jax.nn.softmax(jnp.where(inside, likeness, -1e9), axis=0)
    return jnp.einsum("kbhw,kc->bhwc", shares, near)


def spread_nearby(queries: jax.Array, keys: jax.Array, flow: jax.Array, radius: int) -> jax.Array:
    """Flow as a mean of the neighbours' flow, weighted by likeness; beyond the picture all is 0, and counts.

    Args:
        queries: Features of each cell, shape (batch, height, width, channels).
        keys: Features by which its neighbours are judged.
        flow: Shape (batch, height, width, 2).
        radius: Half side of the neighbourhood [cells].
    """
    scores = _map_around(keys, radius, lambda there: (queries * there).sum(-1)) / math.sqrt(keys.shape[-1])
    return (jax.nn.softmax(scores, axis=0)[..., None] * _map_around(flow, radius, lambda there: there)).sum(0)


def look_around(height: int, width: int, radius: int) -> jax.Array:
    """Steps (x, y) to the cells of a square, shape ((2 radius + 1)^2, 2)."""
    side = jnp.arange(-radius, radius + 1)
    y, x = jnp.meshgrid(side, side, indexing="ij")
    return jnp.stack([x, y], -1).reshape(-1, 2).astype(jnp.float32)


def _map_around(values: jax.Array, radius: int, look) -> jax.Array:
    """Stack what ``look`` says of ``values`` moved by each step of `look_around`; 0 comes in at the edges."""
    _, height, width, _ = values.shape
    wide = jnp.pad(values, ((0, 0), (radius, radius), (radius, radius), (0, 0)))
    side = 2 * radius + 1

    def step(k: jax.Array) -> jax.Array:
        rows = jax.lax.dynamic_slice_in_dim(wide, k // side, height, 1)
        return look(jax.lax.dynamic_slice_in_dim(rows, k % side, width, 2))

    return jax.lax.map(step, jnp.arange(side**2))


def warp(features: jax.Array, flow: jax.Array) -> jax.Array:
    """Features looked up bilinearly at each cell's place after ``flow``; 0 beyond the picture."""
    _, height, width, _ = features.shape
    place = make_grid(height, width) + flow
    low = jnp.floor(place)
    share = place - low
    total = jnp.zeros_like(features)
    for dy, dx in ((0, 0), (0, 1), (1, 0), (1, 1)):
        x, y = (low[..., 0] + dx).astype(int), (low[..., 1] + dy).astype(int)
        weight = (share[..., 0] if dx else 1 - share[..., 0]) * (share[..., 1] if dy else 1 - share[..., 1])
        weight = jnp.where((x >= 0) & (x < width) & (y >= 0) & (y < height), weight, 0.0)
        taken = jax.vmap(lambda each, y, x: each[y, x])(features, y.clip(0, height - 1), x.clip(0, width - 1))
        total += weight[..., None] * taken
    return total


def double(flow: jax.Array) -> jax.Array:
    """Flow at twice the resolution, in the new cells; the corner cells stay the corners."""

    def stretch(count: int) -> np.ndarray:
        place = np.arange(2 * count) * (count - 1) / (2 * count - 1)
        return np.maximum(0, 1 - np.abs(place[:, None] - np.arange(count))).astype(np.float32)

    return 2 * jnp.einsum("ih,jw,bhwc->bijc", stretch(flow.shape[1]), stretch(flow.shape[2]), flow)


def blend_up(flow: jax.Array, scores: jax.Array, factor: int) -> jax.Array:
    """Flow at ``factor`` times the resolution, each pixel a convex mixture of 3 x 3 cells (Teed and Deng 2020).

    Args:
        flow: [cells], shape (batch, height, width, 2).
        scores: Scores of the nine cells for each pixel of a cell, shape (batch, height, width, 9 factor^2).
        factor: Pixels along a cell's side.

    Returns:
        Flow [px], shape (batch, factor * height, factor * width, 2).
    """
    batch, height, width, _ = flow.shape
    shares = jax.nn.softmax(scores.reshape(batch, height, width, 9, factor, factor), axis=3)
    around = _map_around(factor * flow, 1, lambda there: there)
    fine = jnp.einsum("bhwkyx,kbhwc->bhywxc", shares, around)
    return fine.reshape(batch, factor * height, factor * width, 2)
