"""Small particle blocks for the simulator's tests."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.mpm import DomainBox, Grid, Model, NeoHookean, State, lame_parameters

sums_in_order = pytest.mark.skipif(
    jax.default_backend() != "cpu", reason="sums on a GPU are in no fixed order"
)


def lattice(cells, dx, low, per_axis=2) -> np.ndarray:
    """``per_axis``**3 particles per cell in a box of ``cells`` cells with low corner ``low``, shape (n, 3)."""
    axes = [(np.arange(count * per_axis) + 0.5) * dx / per_axis for count in cells]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3) + np.asarray(low)


def block(
    cells=(4, 4, 4),
    *,
    size=1.0,
    grid_cells=20,
    low=(0.4, 0.4, 0.4),
    youngs_modulus=1e5,
    poissons_ratio=0.3,
    density=1000.0,
    dt=1e-3,
    dtype=np.float32,
    material=NeoHookean,
    **model,
) -> tuple[Model, State]:
    """An elastic block at rest in a domain that is one whole window."""
    dx = size / grid_cells
    x = lattice(cells, dx, low).astype(dtype)
    volume = np.full(len(x), (dx / 2) ** 3, dtype)
    mu, lam = lame_parameters(youngs_modulus, poissons_ratio)
    solid = material(jnp.full(len(x), mu, dtype), jnp.full(len(x), lam, dtype))
    model.setdefault("gravity", None)
    model.setdefault("boundaries", (DomainBox(),))
    return (
        Model(
            grid=Grid.whole(size, grid_cells),
            dt=jnp.asarray(dt, dtype),
            mass=jnp.asarray(density * volume),
            volume=jnp.asarray(volume),
            materials=(solid,),
            **model,
        ),
        State.at_rest(jnp.asarray(x)),
    )
