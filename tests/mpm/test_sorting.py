"""Particles that have mixed are simulated in another order, and nobody can tell."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.mpm import (
    DomainBox,
    DruckerPrager,
    Fluid,
    Grid,
    Model,
    PrescribedMotion,
    State,
    cell_order,
    simulate,
    sorting,
)
from tests.mpm.blocks import block, lattice

CELLS = 20
OPTIONS = dict(frame_count=5, frame_dt=0.02, ledger=True)


@pytest.fixture
def mixture(x64):
    """A fluid on sand, both in random order, each particle with parameters of its own."""
    pytest.importorskip("numba")
    rng = np.random.default_rng(3)
    dx = 1 / CELLS
    sand, water = (
        rng.permutation(lattice((6, 6, 3), dx, low)) for low in ((0.3, 0.3, 0.2), (0.3, 0.3, 0.35))
    )
    x = np.concatenate([sand, water])

    def around(value, count):
        return jnp.asarray(value * rng.uniform(0.8, 1.2, count))

    n = len(sand)
    materials = (
        DruckerPrager(around(4e4, n), around(6e4, n), around(0.6, n), around(10.0, n)),
        Fluid(around(5e4, n)),
    )
    volume = jnp.asarray(rng.uniform(0.9, 1.1, len(x)) * dx**3 / 8)
    model = Model(
        grid=Grid.whole(1.0, CELLS),
        dt=jnp.asarray(1e-3),
        gravity=jnp.asarray([2.0, 0, -9.8]),
        mass=around(1000.0, len(x)) * volume,
        volume=volume,
        materials=materials,
        boundaries=(DomainBox(3),),
        viscosity=around(1.0, len(x)),
    )
    return model, State.at_rest(jnp.asarray(x), v=around(1.0, (len(x), 3)), materials=materials)


def test_another_order_changes_nothing_but_round_off(mixture, monkeypatch):
    """State, ledger and substeps of every frame, particles in the caller's order."""
    found = list(simulate(*mixture, **OPTIONS))
    monkeypatch.setattr(sorting, "MIXED", 2)
    expected = list(simulate(*mixture, **OPTIONS))
    assert found[1].order is not None and all(frame.order is None for frame in expected)
    assert len(jax.tree.leaves(found[-1].state.history)) == 1  # sand remembers
    for one, other in zip(found, expected):
        assert one.substeps == other.substeps
        parts = [(frame.state, frame.exchange) for frame in (one, other)]
        for a, b in zip(*map(jax.tree.leaves, parts)):
            np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9 * max(1, float(np.abs(b).max())))


def test_a_run_goes_on_in_the_order_that_it_had(mixture):
    """A continued run is the same to the last bit."""
    whole = list(simulate(*mixture, **OPTIONS))
    rest = list(simulate(*mixture, **OPTIONS, begin=whole[2]))
    for one, other in zip(rest, whole[3:]):
        parts = [(frame.state, frame.exchange, frame.order) for frame in (one, other)]
        assert all(np.array_equal(a, b) for a, b in zip(*map(jax.tree.leaves, parts)))


def test_order_is_kept_until_particles_have_mixed(mixture):
    """Blocks of materials stay together; cells follow each other within them."""
    model, state = mixture
    order = sorting.update_order(None, model, state)
    assert order is not None
    half = len(order) // 2
    assert set(order[:half]) == set(range(half))
    np.testing.assert_array_equal(order[:half], cell_order(np.asarray(state.x)[:half], model.grid.dx))
    assert sorting.update_order(order, model, state) is order
    shaken = dataclasses.replace(state, x=state.x[::-1])
    assert sorting.update_order(order, model, shaken) is not order


def test_what_names_its_particles_is_left_alone(mixture):
    """So is what other transfers than the kernels' move, and a solid, which lies as it was sorted."""
    model, state = mixture
    grip = PrescribedMotion.fixed(jnp.arange(3), state.x.dtype)
    assert sorting.update_order(None, model.replace(constraints=(grip,)), state) is None
    assert sorting.update_order(None, model.replace(forces=(state.x[:, 0],)), state) is None
    assert sorting.update_order(None, model.replace(kernels="reference"), state) is None
    solid, at_rest = block()
    assert sorting.update_order(None, solid, at_rest) is None
