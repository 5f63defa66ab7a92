"""Front-to-back blending of Gaussians, tile by tile, with its derivative.

Pixel p sees Gaussian i with alpha_i = min(0.999, o_i exp(-q_i(p) / 2)), q_i the squared Mahalanobis distance
on the image plane, and alpha_i = 0 where that is below 1/255. With the transmittance
T_i = prod_{j < i} (1 - alpha_j) a feature c is blended to C = sum_i T_i alpha_i c_i (Kerbl et al. 2023,
eq. 3). Blending stops once T <= 1e-4: later Gaussians change a pixel by less than that.
"""

from __future__ import annotations

import functools
from typing import Any

import jax
import jax.numpy as jnp

from physagent_jax.render import kernels
from physagent_jax.render.layout import TileLayout
from physagent_jax.render.project import ALPHA_MIN, Projected
from physagent_jax.render.tiles import TileLists

ALPHA_MAX = 0.999
TRANSMITTANCE_STOP = 1e-4
_LIMITS = (ALPHA_MIN, ALPHA_MAX, TRANSMITTANCE_STOP)

# Gaussians blended between two checks whether a tile is finished.
_CHUNK = 16


def blend(
    projected: Projected, lists: TileLists, layout: TileLayout, native: bool
) -> tuple[jax.Array, jax.Array]:
    """Blend colour and depth.

    Args:
        projected: Gaussians on the image plane.
        lists: From `build_tile_lists` with the same sizes; complete (total <= capacity).
        layout: Tiles, and how many are blended in lockstep. One is best where arrays of a tile's size fill the
            machine (CPU); all tiles are best where each operation is a kernel launch (GPU).
        native: Whether the CPU kernels are to be used, if they are made for this layout and precision.

    Returns:
        Blended red, green, blue and z-depth, shape (h, w, 4), and the transmittance left, shape (h, w).
    """
    packed = jnp.concatenate(
        [
            projected.means2d,
            projected.conics,
            projected.opacities[:, None],
            projected.colors,
            projected.depths[:, None],
        ],
        axis=-1,
    )
    kernel = _find_kernels(layout, packed.dtype) if native else None
    blended: Any = _blend(
        layout, kernel, packed, lists.gaussians, lists.starts
    )  # `custom_vjp` hides the type
    features, transmittance = blended
    return layout.to_image(features), layout.to_image(transmittance)


def _find_kernels(layout: TileLayout, dtype) -> Any:
    """The module of the CPU kernels; None if they are not made for this."""
    module = kernels.load_cpu_kernels()
    return module if module.fits(layout, dtype) else None


def _evaluate_alpha(row: jax.Array, x: jax.Array, y: jax.Array) -> jax.Array:
    """Alpha o exp(-q / 2) before any limit, of one Gaussian per lane, shape (lanes, pixels)."""
    mean_x, mean_y, a, b, c, opacity = (row[:, i, None] for i in range(6))
    dx, dy = x - mean_x, y - mean_y
    return opacity * jnp.exp(-0.5 * (a * dx * dx + c * dy * dy) - b * dx * dy)


def _find_list(starts: jax.Array, tile: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Start and length of the tiles' lists; ids past the last tile have empty lists."""
    begin = starts.at[tile].get(mode="clip")
    return begin, starts.at[tile + 1].get(mode="clip") - begin


@functools.partial(jax.custom_vjp, nondiff_argnums=(0, 1))
def _blend(layout: TileLayout, kernel: Any, packed: jax.Array, gaussians: jax.Array, starts: jax.Array):
    features, transmittance, _ = _blend_forward(layout, kernel, packed, gaussians, starts)
    return features, transmittance


def _blend_forward(
    layout: TileLayout, kernel: Any, packed: jax.Array, gaussians: jax.Array, starts: jax.Array
):
    """Features (groups, lanes, pixels, 4), transmittance (groups, lanes, pixels), steps made (groups,) or None."""
    if kernel is not None:
        return *kernel.blend(layout, _LIMITS, packed, gaussians, starts), None

    def group(tile):
        x, y, inside = layout.pixels(tile, packed.dtype)
        begin, length = _find_list(starts, tile)

        def unfinished(state):
            i, T, _ = state
            return jnp.any((i < length) & (jnp.max(T, axis=1) > TRANSMITTANCE_STOP))

        def step(offset, state):
            i, T, C = state
            row = packed[gaussians.at[begin + i + offset].get(mode="clip")]
            alpha = _evaluate_alpha(row, x, y)
            blended = (alpha >= ALPHA_MIN) & (T > TRANSMITTANCE_STOP) & (i + offset < length)[:, None]
            alpha = jnp.where(blended, jnp.minimum(alpha, ALPHA_MAX), 0.0)
            return i, T * (1 - alpha), C + (T * alpha)[None] * row[:, 6:].T[:, :, None]

        def chunk(state):
            i, T, C = jax.lax.fori_loop(0, _CHUNK, step, state)
            return i + _CHUNK, T, C

        C = jnp.zeros((4, *x.shape), packed.dtype)
        i, T, C = jax.lax.while_loop(unfinished, chunk, (jnp.int32(0), inside.astype(packed.dtype), C))
        return jnp.moveaxis(C, 0, -1), T, i

    return jax.lax.map(group, layout.tile_ids())


def _blend_fwd(layout: TileLayout, kernel: Any, packed: jax.Array, gaussians: jax.Array, starts: jax.Array):
    features, transmittance, steps = _blend_forward(layout, kernel, packed, gaussians, starts)
    return (features, transmittance), (packed, gaussians, starts, features, transmittance, steps)


def _blend_bwd(layout: TileLayout, kernel: Any, residuals, cotangents):
    """Front to back again, with prefix sums in place of a reverse pass.

    With g the cotangent of C, g_T that of the final transmittance, and P_i = sum_{j <= i} T_j alpha_j c_j.g:
    dL/dalpha_i = T_i c_i.g - (C.g + T_final g_T - P_i) / (1 - alpha_i), because alpha_i dims all that is behind.
    The loop leaves two numbers per Gaussian and pixel; every derivative of a Gaussian is a sum of those over
    pixels with fixed weights, which is made for a chunk of Gaussians at a time as a matrix product.
    """
    packed, gaussians, starts, features, transmittance, steps = residuals
    if kernel is not None:
        lists = packed, gaussians, starts
        return (
            kernel.blend_backward(layout, _LIMITS, *lists, *cotangents, features, transmittance),
            None,
            None,
        )

    def group(dpacked, inputs):
        tile, g, gT, C, T_final, steps = inputs
        g = jnp.moveaxis(g, -1, 0)
        x, y, inside = layout.pixels(tile, packed.dtype)
        begin, length = _find_list(starts, tile)
        total = jnp.sum(jnp.moveaxis(C, -1, 0) * g, axis=0) + T_final * gT

        def chunk(n, state):
            dpacked, T, prefix = state
            local = n * _CHUNK + jnp.arange(_CHUNK, dtype=jnp.int32)
            index = gaussians.at[begin + local[:, None]].get(mode="clip")
            rows = packed[index]
            listed = local[:, None] < length

            def step(k, state):
                T, prefix, dexponents, weights = state
                row = rows[k]
                raw = _evaluate_alpha(row, x, y)
                blended = (raw >= ALPHA_MIN) & (T > TRANSMITTANCE_STOP) & listed[k][:, None]
                alpha = jnp.where(blended, jnp.minimum(raw, ALPHA_MAX), 0.0)
                weight = T * alpha
                seen = sum(row[:, 6 + channel, None] * g[channel] for channel in range(4))
                prefix = prefix + weight * seen
                dalpha = T * seen - (total - prefix) / (1 - alpha)
                # alpha = o exp(exponent); constant where it is capped.
                dexponent = jnp.where(blended & (raw < ALPHA_MAX), dalpha * raw, 0.0)
                return T * (1 - alpha), prefix, dexponents.at[k].set(dexponent), weights.at[k].set(weight)

            empty = jnp.zeros((_CHUNK, *x.shape), packed.dtype)
            T, prefix, dexponents, weights = jax.lax.fori_loop(0, _CHUNK, step, (T, prefix, empty, empty))
            drows = layout.geometry_derivatives(rows, dexponents, tile)
            dfeatures = jnp.einsum("klp,clp->klc", weights, g, precision="highest")
            return dpacked.at[index].add(jnp.concatenate([drows, dfeatures], axis=-1)), T, prefix

        state = (dpacked, inside.astype(packed.dtype), jnp.zeros_like(x))
        return jax.lax.fori_loop(0, -(-steps // _CHUNK), chunk, state)[0], None

    inputs = (layout.tile_ids(), *cotangents, features, transmittance, steps)
    dpacked, _ = jax.lax.scan(group, jnp.zeros_like(packed), inputs)
    return dpacked, None, None


_blend.defvjp(_blend_fwd, _blend_bwd)
