"""A term acts on the particles of its region."""

from __future__ import annotations

import jax


def confine(value: jax.Array, weight: jax.Array | None) -> jax.Array:
    """``value`` times the region's weight.

    Args:
        value: One per particle, shape (n, ...).
        weight: 1 inside the region, 0 outside, shape (n,); None = everywhere.
    """
    return value if weight is None else weight.reshape(-1, *[1] * (value.ndim - 1)) * value
