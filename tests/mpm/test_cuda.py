"""The CUDA kernels against the reference that they stand for, where there is a GPU; elsewhere, what chooses them."""

import dataclasses
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.kernels import use_cuda
from physagent_jax.mpm import Grid, kernels, materials, replay, simulate, transfer
from physagent_jax.mpm.schedule import Schedule
from physagent_jax.mpm.sorting import cell_order
from tests.mpm.blocks import block

GPU = jax.default_backend() == "gpu"
needs_gpu = pytest.mark.skipif(not GPU, reason="no GPU")
TOLERANCE = {"float32": 1e-5, "float64": 1e-13}  # round-off of sums in another order
GRID = Grid(jnp.array([3, 4, 5], jnp.int32), (12, 9, 14), 0.05, 60)


def cloud(count, dtype, sort):
    """Particles in `GRID`, with F, C and stress of all kinds."""
    rng = np.random.default_rng(count)
    low = (np.asarray(GRID.origin) + 1) * GRID.dx
    x = low + rng.uniform(size=(count, 3)) * (np.array(GRID.shape) - 4) * GRID.dx
    x = x[cell_order(x, GRID.dx)] if sort else x
    arrays = dict(
        x=x,
        v=rng.normal(size=(count, 3)),
        C=rng.normal(size=(count, 3, 3)),
        F=np.eye(3) + 0.1 * rng.normal(size=(count, 3, 3)),
        mu=rng.uniform(1e3, 2e3, count),
        lam=rng.uniform(1e3, 2e3, count),
        mass=rng.uniform(1, 2, count),
        volume=rng.uniform(1e-3, 2e-3, count),
        velocity=rng.normal(size=(*GRID.shape, 3)),
    )
    return {name: jnp.asarray(array, dtype) for name, array in arrays.items()}


def scatter(module, form, c):
    """Nodes by the given stress, and by the neo-Hookean one."""
    dv, dt = jnp.asarray([0.3, -0.2, 0.1], c["x"].dtype), jnp.asarray(1e-3, c["x"].dtype)
    law = materials.NeoHookean(c["mu"], c["lam"])
    tau, others = law.stress(c["F"]), (c["mass"], c["volume"], dv, dt)
    plain = module.p2g(form, GRID, c["x"], c["v"], c["C"], tau, *others)
    if module is transfer:
        return plain, plain
    fused = module.p2g_neo_hookean(form, GRID, c["x"], c["v"], c["C"], c["F"], law.mu, law.lam, *others)
    return plain, fused


def gather(module, form, c):
    return module.g2p(
        form, 1, GRID, c["x"], c["v"], c["C"], c["F"], c["velocity"], jnp.asarray(1e-3, c["x"].dtype)
    )


def close(got, expected, tolerance):
    def compare(got, expected):
        got, expected = np.asarray(got), np.asarray(expected)
        np.testing.assert_allclose(got, expected, atol=tolerance * max(1e-30, np.abs(expected).max()))

    jax.tree.map(compare, got, expected)


@needs_gpu
@pytest.mark.parametrize("sort", [True, False])
@pytest.mark.parametrize("form", ["mls", "gradient"])
@pytest.mark.parametrize("count", [1, 7, 32, 3001])
def test_p2g_and_g2p_equal_the_reference(count, form, sort, x64):
    """In both precisions, the reference in double."""
    for make in (scatter, gather):
        expected = jax.jit(partial(make, transfer, form))(cloud(count, "float64", sort))
        for dtype, tolerance in TOLERANCE.items():
            got = jax.jit(partial(make, kernels.load_cuda_kernels(), form))(cloud(count, dtype, sort))
            close(got, expected, tolerance)


@needs_gpu
def test_what_is_outside_or_not_finite_is_counted_and_writes_nowhere_else():
    c = cloud(64, "float32", True)
    c["x"] = c["x"].at[3].set(0.0).at[5].set(50.0).at[7, 1].set(jnp.nan)
    c["v"] = c["v"].at[7].set(jnp.nan)
    nodes = [np.asarray(scatter(module, "mls", c)[0]) for module in (kernels.load_cuda_kernels(), transfer)]
    mass = [each[..., 3] for each in nodes]
    assert np.isfinite(mass[0]).sum() >= np.isfinite(mass[1]).sum()
    got, expected = (gather(module, "mls", c).health for module in (kernels.load_cuda_kernels(), transfer))
    assert (int(got.beyond), bool(got.finite)) == (int(expected.beyond), bool(expected.finite))
    assert int(got.outside) == int(expected.outside)


def falling(law, choice):
    """A block that hits the floor, in double precision."""
    made = block(
        low=(0.4, 0.4, 0.15), dtype=np.float64, gravity=jnp.array([0, 0, -9.8]), material=law, kernels=choice
    )
    return made[0], dataclasses.replace(made[1], v=made[1].v.at[:, 2].set(-2.0))


@needs_gpu
@pytest.mark.parametrize("law", [materials.NeoHookean, materials.FixedCorotated])
def test_a_simulation_equals_the_reference(law, x64):
    one, other = (
        list(simulate(*falling(law, choice), frame_count=3, frame_dt=0.02))[-1]
        for choice in ("cuda", "reference")
    )
    assert one.substeps == other.substeps
    np.testing.assert_allclose(one.state.x, other.state.x, atol=1e-10)
    np.testing.assert_allclose(one.state.F, other.state.F, atol=1e-8)
    assert one.min_J == pytest.approx(other.min_J, abs=1e-8)


@needs_gpu
def test_a_gradient_equals_that_of_the_reference(x64):
    found = []
    for choice in ("cuda", "reference"):
        model, state = falling(materials.NeoHookean, choice)
        schedule = Schedule.of(model, simulate(model, state, frame_count=3, frame_dt=5e-3))

        def loss(v, model=model, state=state, schedule=schedule):
            return (replay(model, dataclasses.replace(state, v=v), schedule)[-1].x ** 2).sum()

        found.append(np.asarray(jax.grad(loss)(state.v)))
    close(*found, 1e-9)


@pytest.mark.skipif(GPU, reason="there is a GPU")
def test_without_a_gpu_they_are_refused_in_one_sentence():
    assert not use_cuda("auto")
    with pytest.raises(UserError, match='`kernels="cuda"` cannot be used: JAX runs on cpu'):
        use_cuda("cuda")
