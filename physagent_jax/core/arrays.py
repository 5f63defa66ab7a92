"""From NumPy to JAX."""

from __future__ import annotations

import jax
import numpy as np


def to_device(values, dtype=None) -> jax.Array:
    """``values`` as a JAX array, for host code: `jnp.asarray` would compile a program per shape to convert them."""
    return jax.device_put(np.asarray(values, dtype))
