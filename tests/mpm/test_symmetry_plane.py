"""Half a body at a plane of symmetry moves as the whole body does."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.mpm import Lumped, Sharpened, step
from physagent_jax.mpm.boundaries import SymmetryPlane
from tests.mpm.blocks import block

advance = jax.jit(step)


@pytest.mark.parametrize("inertia", [Lumped(), Lumped(0.5), Sharpened(), Sharpened(0.18, 0.5)])
@pytest.mark.parametrize(("axis", "side"), [(0, 1), (0, -1), (2, 1)])
def test_half_a_body_moves_as_the_whole(axis, side, inertia, x64):
    """A block of 8x4x4 cells, ringing, and its half before a plane through its middle.

    To round-off, but for light nodes next to the plane that follow others: they see one layer of images.
    """
    cells = [4, 4, 4]
    cells[axis] = 8
    low = [0.4, 0.4, 0.4]
    low[axis] = 0.3
    model, state = block(cells, low=low, dtype=np.float64, youngs_modulus=1e4, dt=2e-3, inertia=inertia)
    middle = 0.5
    x = state.x - middle
    v = 0.3 * x * (1 + x**2).prod(-1, keepdims=True) + 0.1 * jnp.roll(x, 1, axis=1)
    v = v.at[:, axis].set(0.5 * jnp.sin(3 * x[:, axis]) * (1 + x[:, (axis + 1) % 3]))
    even = jnp.abs(x[:, axis : axis + 1])
    v = v.at[:, (axis + 1) % 3].set((even * x)[:, (axis + 1) % 3])
    v = v.at[:, (axis + 2) % 3].set((even * x)[:, (axis + 1) % 3])
    state = dataclasses.replace(state, v=v)
    before = np.flatnonzero(side * np.asarray(x)[:, axis] > 0)
    half_model = model.replace(
        mass=model.mass[before],
        volume=model.volume[before],
        materials=jax.tree.map(lambda a: a[before], model.materials),
        boundaries=(*model.boundaries, SymmetryPlane(jnp.asarray(10, jnp.int32), axis, side)),
    )
    half = jax.tree.map(lambda a: a[before] if a.ndim else a, state)
    for _ in range(40):
        state, half = advance(model, state), advance(half_model, half)
    assert np.abs(np.asarray(state.x)[before] - np.asarray(x + middle)[before]).max() > 1e-3
    error = 1e-5 if inertia.aggregation else 1e-12
    np.testing.assert_allclose(half.x, np.asarray(state.x)[before], atol=error)
    np.testing.assert_allclose(half.F, np.asarray(state.F)[before], atol=100 * error)


def test_matter_cannot_leave_the_plane_nor_pass_it(x64):
    """Bilateral and frictionless: the normal velocity on it vanishes, the tangential one is kept."""
    model, state = block(
        (4, 4, 4), low=(0.3, 0.4, 0.4), dtype=np.float64,
        boundaries=(SymmetryPlane(jnp.asarray(6, jnp.int32), 0, 1),),
    )  # fmt: skip
    state = dataclasses.replace(state, v=jnp.broadcast_to(jnp.array([0.0, 0.2, 0.0]), state.v.shape))
    for _ in range(20):
        state = advance(model, state)
    np.testing.assert_allclose(state.v, np.broadcast_to([0.0, 0.2, 0.0], state.v.shape), atol=1e-12)
    assert float(state.x[:, 0].min()) > 0.3
