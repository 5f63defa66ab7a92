"""The blending kernels as JAX functions."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.kernels import ffi
from physagent_jax.kernels.threads import choose_team, thread_count
from physagent_jax.render.kernels.blend import PACKED, PIXELS, SIDE
from physagent_jax.render.kernels.handlers import register_handler
from physagent_jax.render.layout import TileLayout

_SLACK = 1e-3  # by which `reach` is longer than exact arithmetic has it


def fits(layout: TileLayout, dtype) -> bool:
    """Return whether the kernels are made for this: float32, tiles of 16 pixels, one at a time."""
    return dtype == jnp.float32 and layout.tile_size == SIDE and layout.lanes == 1


def blend(layout: TileLayout, limits, packed, gaussians, starts) -> tuple[jax.Array, jax.Array]:
    """Features, shape (tiles, 1, PIXELS, 4), and the transmittance left, shape (tiles, 1, PIXELS).

    Args:
        layout: Tiles; see `fits`.
        limits: Least alpha, greatest alpha, transmittance at which blending stops.
        packed: Gaussians, shape (n, PACKED).
        gaussians: As in `tiles.TileLists`.
        starts: As in `tiles.TileLists`.
    """
    results = (
        jax.ShapeDtypeStruct((layout.tiles, 4, PIXELS), jnp.float32),
        jax.ShapeDtypeStruct((layout.tiles, PIXELS), jnp.float32),
    )
    call = jax.ffi.ffi_call(register_handler("blend"), results, vmap_method="sequential")
    reach = _find_reach(packed, limits[0])
    _check("blend", layout, dict(packed=packed, reach=reach, gaussians=gaussians, starts=starts))
    features, transmittance = call(
        packed, reach, gaussians, starts, _pack_sizes(layout), _pack_limits(limits), **choose_team()
    )
    return features.swapaxes(1, 2)[:, None], transmittance[:, None]


def blend_backward(
    layout: TileLayout, limits, packed, gaussians, starts, g, g_transmittance, features, transmittance
) -> jax.Array:
    """Derivative by ``packed``, from the cotangents of `blend`'s results and these."""
    parts = thread_count()
    results = (
        jax.ShapeDtypeStruct((parts, packed.shape[0], PACKED), jnp.float32),
        jax.ShapeDtypeStruct((parts, 3, PIXELS), jnp.float32),
    )
    call = jax.ffi.ffi_call(register_handler("blend_backward"), results, vmap_method="sequential")
    lists = dict(packed=packed, reach=_find_reach(packed, limits[0]), gaussians=gaussians, starts=starts)
    images = dict(
        g=g[:, 0].swapaxes(1, 2),
        g_transmittance=g_transmittance[:, 0],
        features=features[:, 0].swapaxes(1, 2),
        transmittance=transmittance[:, 0],
        inside=layout.pixels(jnp.asarray(layout.tile_ids()[:, 0]), jnp.float32)[2].astype(jnp.float32),
    )
    _check("blend_backward", layout, lists | images)
    options = _pack_sizes(layout), _pack_limits(limits)
    gradient, _ = call(*lists.values(), *options, *images.values(), **choose_team())
    return gradient.sum(0)


def _check(kernel: str, layout: TileLayout, operands: dict[str, jax.Array]) -> None:
    count, tiles = operands["packed"].shape[0], layout.tiles
    shapes = dict(packed=(count, PACKED), reach=(count,), gaussians=operands["gaussians"].shape[:1])
    shapes |= dict(starts=(tiles + 1,))
    if "g" in operands:
        shapes |= dict.fromkeys(("g", "features"), (tiles, 4, PIXELS))
        shapes |= dict.fromkeys(("g_transmittance", "transmittance", "inside"), (tiles, PIXELS))
    ffi.check_operands(kernel, operands, shapes, "float32", gaussians="int32", starts="int32")


def _find_reach(packed: jax.Array, least_alpha: float) -> jax.Array:
    """Square of the distance in y beyond which no pixel reaches the least alpha, shape (n,); infinite if in doubt.

    Over x the exponent is greatest at dx = -b dy / a, where it is -(c - b^2 / a) dy^2 / 2.
    """
    a, b, c, opacity = packed[:, 2], packed[:, 3], packed[:, 4], packed[:, 5]
    steepness = c - b * b / a
    room = 2 * jnp.log(opacity / least_alpha) + _SLACK
    good = (a > 0) & (steepness > 1e-6 * c) & jnp.isfinite(room)
    return jnp.where(good, (1 + _SLACK) * room / jnp.where(good, steepness, 1), jnp.inf)


def _pack_sizes(layout: TileLayout) -> np.ndarray:
    return np.asarray([layout.columns, layout.width, layout.height], np.int32)


def _pack_limits(limits) -> np.ndarray:
    """The limits as the kernels compare with them: alpha is to be greater than the number before the least."""
    least, *others = np.asarray(limits, np.float32)
    return np.asarray([np.nextafter(least, np.float32(0)), *others], np.float32)
