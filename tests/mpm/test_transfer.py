"""P2G and G2P against a plain loop over particles and nodes, and against fields they must reproduce."""

import jax
import jax.numpy as jnp
import jax.test_util
import numpy as np
import pytest

from physagent_jax.mpm import Grid
from physagent_jax.mpm.transfer import (
    gather_affine,
    scatter_mass,
    scatter_momentum,
    stencil,
    velocity_gradient,
)
from tests.mpm.blocks import sums_in_order

GRID = Grid.whole(1.0, 10)


def spline(distance):
    """Quadratic B-spline at a distance in cells (Steffen et al. 2008), written independently."""
    r = abs(distance)
    return 0.75 - r * r if r < 0.5 else 0.5 * (1.5 - r) ** 2 if r < 1.5 else 0.0


@pytest.fixture
def particles(x64):
    rng = np.random.default_rng(0)
    return (
        rng.uniform(0.2, 0.8, (40, 3)),
        rng.uniform(0.5, 2, 40),
        rng.normal(size=(40, 3)),
        rng.normal(size=(40, 3, 3)),
    )


def test_p2g_equals_a_loop_over_all_nodes(particles):
    x, mass, momentum, affine = particles
    expected = np.zeros((11, 11, 11, 4))
    for p in range(len(x)):
        for node in np.ndindex(11, 11, 11):
            offset = np.array(node) * 0.1 - x[p]
            w = np.prod([spline(d / 0.1) for d in offset])
            if w > 0:
                expected[node][:3] += w * (momentum[p] + affine[p] @ offset)
                expected[node][3] += w * mass[p]
    got = scatter_momentum(stencil(jnp.asarray(x), GRID), GRID, *map(jnp.asarray, (mass, momentum, affine)))
    np.testing.assert_allclose(got, expected, atol=1e-13)


def test_mass_and_momentum_are_conserved(particles):
    x, mass, momentum, affine = particles
    s = stencil(jnp.asarray(x), GRID)
    nodes = scatter_momentum(s, GRID, *map(jnp.asarray, (mass, momentum, affine))).sum((0, 1, 2))
    np.testing.assert_allclose(nodes[3], mass.sum(), rtol=1e-14)
    np.testing.assert_allclose(nodes[:3], momentum.sum(0), atol=1e-13)
    np.testing.assert_allclose(scatter_mass(s, GRID, jnp.asarray(mass)).sum(), mass.sum(), rtol=1e-14)


def test_g2p_reproduces_linear_velocity_fields_exactly(particles):
    x = jnp.asarray(particles[0])
    gradient, constant = np.arange(9.0).reshape(3, 3) - 4, np.array([1.0, -2.0, 3.0])
    nodes = np.stack(np.broadcast_arrays(*GRID.node_positions(jnp.float64)), -1)
    v, C = gather_affine(stencil(x, GRID), GRID, jnp.asarray(nodes @ gradient.T + constant))
    np.testing.assert_allclose(v, particles[0] @ gradient.T + constant, atol=1e-12)
    np.testing.assert_allclose(C, np.broadcast_to(gradient, (40, 3, 3)), atol=1e-11)


@sums_in_order
def test_a_shifted_window_sees_the_same_nodes(particles):
    x, mass, momentum, affine = map(jnp.asarray, particles)
    part = Grid(jnp.array([1, 1, 1], jnp.int32), (9, 9, 9), 0.1, 10)
    whole = scatter_momentum(stencil(x, GRID), GRID, mass, momentum, affine)
    np.testing.assert_array_equal(
        scatter_momentum(stencil(x, part), part, mass, momentum, affine), whole[1:10, 1:10, 1:10]
    )


def test_particles_below_the_grid_never_deposit_on_the_far_side():
    x = jnp.array([[-0.3, 0.5, 0.5]])  # its stencil has negative indices, which would wrap in JAX
    nodes = scatter_momentum(stencil(x, GRID), GRID, jnp.ones(1), jnp.ones((1, 3)), jnp.zeros((1, 3, 3)))
    assert float(jnp.abs(nodes[5:]).sum()) == 0.0


def test_transfers_are_differentiable(particles):
    x, mass, momentum, affine = map(jnp.asarray, particles)

    def round_trip(x, momentum):
        nodes = scatter_momentum(stencil(x, GRID), GRID, mass, momentum, affine)
        v, C = gather_affine(stencil(x, GRID), GRID, nodes[..., :3])
        return (v**2).sum() + (C**2).sum() * 1e-3

    jax.test_util.check_grads(round_trip, (x, momentum), order=1, modes=["fwd", "rev"], eps=1e-6, rtol=1e-6)


def test_classical_stress_impulse_acts_through_the_slopes_of_the_weights(particles):
    """Node by node against difference quotients of the weights; in all it adds no momentum."""
    x, mass, momentum, impulse = particles
    nothing, h = np.zeros((40, 3, 3)), 1e-6
    expected = np.zeros((11, 11, 11, 3))
    for p in range(len(x)):
        for node in np.ndindex(11, 11, 11):

            def weight(at, node=node):
                return np.prod([spline(d / 0.1) for d in np.array(node) * 0.1 - at])

            slope = [(weight(x[p] + h * e) - weight(x[p] - h * e)) / (2 * h) for e in np.eye(3)]
            expected[node] += impulse[p] @ slope
    s = stencil(jnp.asarray(x), GRID)
    got = scatter_momentum(s, GRID, *map(jnp.asarray, (mass, 0 * momentum, nothing, impulse)))[..., :3]
    np.testing.assert_allclose(got, expected, atol=1e-6)
    np.testing.assert_allclose(got.sum((0, 1, 2)), 0, atol=1e-11)


def test_velocity_gradient_reproduces_linear_fields_exactly(particles):
    gradient = np.arange(9.0).reshape(3, 3) - 4
    nodes = np.stack(np.broadcast_arrays(*GRID.node_positions(jnp.float64)), -1) @ gradient.T
    got = velocity_gradient(stencil(jnp.asarray(particles[0]), GRID), GRID, jnp.asarray(nodes))
    np.testing.assert_allclose(got, np.broadcast_to(gradient, (40, 3, 3)), atol=1e-11)
