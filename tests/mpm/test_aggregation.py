"""Light nodes that follow their neighbours: what that keeps, that it slows every mode, and the paths that carry it."""

import dataclasses
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.mpm import (
    HalfSpace,
    Lumped,
    PrescribedMotion,
    Sharpened,
    inertia,
    kernels,
    rollout,
    step,
)
from physagent_jax.mpm.energy import momentum
from tests.mpm.blocks import block
from tests.mpm.test_kernels import close, pulls_equal

# Small scenes, whose programs take longer to compile than to run.
pytestmark = pytest.mark.usefixtures("least_optimised")

UP, ONE = jnp.array([0.0, 0.0, 1.0]), jnp.asarray(1.0)


def draw_nodes(shape, seed=0):
    """Some empty, some with next to nothing, some light and some heavy."""
    rng = np.random.default_rng(seed)
    nodes = rng.normal(size=(*shape, 8))
    nodes[..., 3] = rng.choice([0, 1e-7, 0.01, 0.1, 1.0, 2.0], size=shape)
    return jnp.asarray(nodes)


@pytest.mark.parametrize("shape", [(3, 4, 3), (4, 6, 17), (5, 3, 10), (2, 2, 1)])
def test_the_kernel_and_its_derivative_equal_the_reference(shape, x64):
    nodes = draw_nodes(shape)
    cpu = kernels.load_cpu_kernels()
    kernel, reference = (lambda nodes, of=of: of.aggregate(0.5, nodes, ONE, ONE) for of in (cpu, inertia))
    close(kernel(nodes), reference(nodes), 1e-13)
    pulls_equal(kernel, reference, (nodes,))
    empty = jnp.asarray(1e-3)
    kernel, reference = (
        lambda nodes, of=of: of.aggregated_velocity(0.5, nodes, ONE, ONE, empty) for of in (cpu, inertia)
    )
    close(kernel(nodes), reference(nodes), 1e-13)
    pulls_equal(kernel, reference, (nodes,))
    close(cpu.sum_neighbours(nodes), inertia.sum_neighbours(nodes), 1e-13)


def test_momentum_is_kept_and_what_is_uniform_stays(x64):
    nodes = draw_nodes((6, 5, 7))
    follows = inertia.aggregate(0.5, nodes, ONE, ONE)
    np.testing.assert_allclose(follows.sum((0, 1, 2)), nodes[..., 4:7].sum((0, 1, 2)), rtol=1e-12)
    assert float(jnp.abs(follows - nodes[..., 4:7]).max()) > 0.1
    uniform = nodes[..., 3:4] * jnp.array([1.0, -2.0, 3.0])
    moved = inertia.aggregate(0.5, nodes.at[..., 4:7].set(uniform), ONE, ONE)
    np.testing.assert_allclose(moved, uniform, atol=1e-14)


def test_a_body_does_so_beside_one_a_million_times_as_heavy(x64):
    """As it does alone, but for scale: next to nothing is told by the lightest particle."""
    light, heavy = draw_nodes((4, 4, 4)), jnp.ones((3, 4, 4, 8))
    both = jnp.concatenate([1e-6 * light, jnp.zeros((3, 4, 4, 8)), heavy])
    alone = inertia.aggregate(0.5, light, ONE, ONE)
    np.testing.assert_allclose(inertia.aggregate(0.5, both, ONE, 1e-6 * ONE)[:4], 1e-6 * alone, atol=1e-18)


def test_inside_a_body_nothing_changes(x64):
    nodes = draw_nodes((5, 5, 5)).at[..., 3].set(1.0)
    np.testing.assert_allclose(inertia.aggregate(0.8, nodes, ONE, ONE), nodes[..., 4:7], rtol=1e-12)


def test_no_mode_becomes_faster(x64):
    """As dv = W f with W at most 1 / m, whatever the stiffness: the eigenvalues of m^(1/2) W m^(1/2) are 0 to 1."""
    nodes = draw_nodes((3, 4, 3)).at[..., 4:7].set(0.0)
    mass = np.asarray(nodes[..., 3]).ravel()
    some = mass > 1e-5

    def respond(impulse):
        given = nodes.at[..., 4].set(impulse.reshape(nodes.shape[:3]))
        return inertia.aggregate(0.5, given, ONE, ONE)[..., 0].ravel()

    moved = np.asarray(jax.jacobian(respond)(jnp.zeros(len(mass))))[np.ix_(some, some)]  # m W
    root = np.sqrt(mass[some])
    symmetric = moved / root[:, None] * root
    np.testing.assert_allclose(symmetric, symmetric.T, atol=1e-12)
    values = np.linalg.eigvalsh(symmetric)
    assert -1e-12 < values[0] < 0.2 and 0.9 < values[-1] < 1 + 1e-12


def test_single_precision_has_derivatives_where_nodes_have_next_to_nothing():
    nodes = draw_nodes((4, 5, 6)).astype(jnp.float32)
    nodes = nodes.at[0, 0, :, 3].set(jnp.array([1e-44, 1e-30, 1e-20, 1e-10, 1e-6, 1.1e-5], jnp.float32))
    one = ONE.astype(jnp.float32)
    bars = jax.grad(lambda nodes: jnp.sin(inertia.aggregate(0.5, nodes, one, one)).sum())(nodes)
    assert np.isfinite(bars).all()


def thrown(choice, chosen, dtype=np.float64):
    """A block on a floor with friction, a corner of it held."""
    floor = HalfSpace(0.4 * UP, UP, jnp.asarray(0.3), jnp.zeros(()), jnp.asarray(1e9))
    grip = dataclasses.replace(PrescribedMotion.fixed(jnp.arange(4), dtype), velocity=0.1 * UP)
    rest = dict(boundaries=(floor,), constraints=(grip,), kernels=choice, inertia=chosen)
    model, state = block((3, 3, 3), dtype=dtype, gravity=-9.8 * UP, **rest)
    v = np.random.default_rng(0).normal(size=state.x.shape)
    return model, dataclasses.replace(state, v=jnp.asarray(0.2 * v + 0.05, dtype))


@pytest.mark.parametrize("chosen", [Lumped(0.5), Sharpened(0.18, 0.5)])
def test_the_kernels_follow_the_reference(chosen, x64):
    ends = []
    for choice in ("cpu", "reference"):
        model, state = thrown(choice, chosen)
        ends.append(jax.jit(lambda s, m=model: jax.lax.fori_loop(0, 20, lambda _, s: step(m, s), s))(state))
    plain = thrown("cpu", type(chosen)())
    plain = jax.lax.fori_loop(0, 20, lambda _, s: step(plain[0], s), plain[1])
    close(ends[0].x, ends[1].x, 1e-12)
    assert float(jnp.abs(plain.x - ends[0].x).max()) > 1e-6


def test_gradients_agree_with_differences(x64):
    def loss(p):
        model, state = thrown("cpu", Lumped(0.5))
        law = model.materials[0]
        model = model.replace(materials=(dataclasses.replace(law, mu=law.mu * p),))
        end, _ = rollout(model, state, frame_count=1, substeps=12)
        return (end.x[:, 2] ** 3).sum()

    h = 1e-5
    assert float(jax.grad(loss)(1.0)) == pytest.approx(float(loss(1 + h) - loss(1 - h)) / (2 * h), rel=1e-5)


def test_a_body_keeps_its_momentum(x64):
    model, state = block((3, 3, 3), dtype=np.float64, inertia=Lumped(0.5))
    v = np.random.default_rng(0).normal(size=state.x.shape)
    state = dataclasses.replace(state, v=jnp.asarray(0.2 * v))
    end = jax.jit(lambda s: jax.lax.fori_loop(0, 50, lambda _, s: step(model, s), s))(state)
    np.testing.assert_allclose(momentum(model, end), momentum(model, state), rtol=1e-12)


@pytest.mark.parametrize("make", [Lumped, partial(Sharpened, 0.18)])
@pytest.mark.parametrize("aggregation", [-0.1, 0.9, float("nan")])
def test_it_must_be_within_range(make, aggregation):
    with pytest.raises(UserError, match="aggregation"):
        make(aggregation)
