"""Pixels grouped by tile, as the rasteriser walks them."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.render.tiles import make_tile_grid


class TileLayout:
    """Pixels grouped by tile and tiles grouped by lanes; hashable, so that it can be a static argument."""

    def __init__(self, width: int, height: int, tile_size: int, lanes: int):
        self.key = (width, height, tile_size, lanes)
        self.width, self.height, self.tile_size = width, height, tile_size
        self.columns, self.rows = make_tile_grid(width, height, tile_size)
        self.tiles = self.columns * self.rows
        self.lanes = min(lanes, self.tiles)
        self.groups = -(-self.tiles // self.lanes)

    def __hash__(self):
        return hash(self.key)

    def __eq__(self, other):
        return self.key == other.key

    def tile_ids(self) -> np.ndarray:
        """Tiles of each group; ids past the last tile fill up the last group. Shape (groups, lanes)."""
        return np.arange(self.groups * self.lanes, dtype=np.int32).reshape(self.groups, self.lanes)

    def pixels(self, tile: jax.Array, dtype) -> tuple[jax.Array, jax.Array, jax.Array]:
        """Pixel centres x and y [px] and whether they lie on the image, each shape (lanes, pixels)."""
        local = np.arange(self.tile_size**2, dtype=np.int32)
        x = (tile % self.columns * self.tile_size)[:, None] + local % self.tile_size
        y = (tile // self.columns * self.tile_size)[:, None] + local // self.tile_size
        return x.astype(dtype) + 0.5, y.astype(dtype) + 0.5, (x < self.width) & (y < self.height)

    def geometry_derivatives(self, rows: jax.Array, dexponents: jax.Array, tile: jax.Array) -> jax.Array:
        """Derivatives with respect to centre, conic and opacity of Gaussians, from those of the exponent.

        The exponent is -(a dx^2 + c dy^2) / 2 - b dx dy, a polynomial in the pixel's coordinates: its
        moments about the centre of the tile, shifted to the Gaussian, give everything.

        Args:
            rows: Packed Gaussians, shape (k, lanes, 10).
            dexponents: Derivatives per pixel, shape (k, lanes, pixels).
            tile: Shape (lanes,).

        Returns:
            Shape (k, lanes, 6).
        """
        local = np.arange(self.tile_size**2)
        center = 0.5 * self.tile_size
        u, v = local % self.tile_size + 0.5 - center, local // self.tile_size + 0.5 - center
        monomials = jnp.asarray(np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=-1), rows.dtype)
        # Full precision: GPUs would otherwise round single precision products to ten bits.
        s, su, sv, suu, suv, svv = jnp.moveaxis(jnp.matmul(dexponents, monomials, precision="highest"), -1, 0)
        mean_x, mean_y, a, b, c, opacity = (rows[..., i] for i in range(6))
        e = (tile % self.columns * self.tile_size).astype(rows.dtype) + center - mean_x
        f = (tile // self.columns * self.tile_size).astype(rows.dtype) + center - mean_y
        sx, sy = su + e * s, sv + f * s
        sxx, sxy, syy = (
            suu + e * (2 * su + e * s),
            suv + e * sv + f * su + e * f * s,
            svv + f * (2 * sv + f * s),
        )
        dopacity = s / jnp.where(opacity > 0, opacity, 1)
        return jnp.stack([a * sx + b * sy, c * sy + b * sx, -0.5 * sxx, -sxy, -0.5 * syy, dopacity], axis=-1)

    def to_image(self, values: jax.Array) -> jax.Array:
        """From (groups, lanes, pixels, ...) to (h, w, ...)."""
        size, rest = self.tile_size, values.shape[3:]
        values = values.reshape(self.groups * self.lanes, size, size, *rest)[: self.tiles]
        values = values.reshape(self.rows, self.columns, size, size, *rest).swapaxes(1, 2)
        values = values.reshape(self.rows * size, self.columns * size, *rest)
        return values[: self.height, : self.width]
