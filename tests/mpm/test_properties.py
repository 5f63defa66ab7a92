"""Properties of any scene: random ones, drawn by hypothesis, that share one executable."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from physagent_jax.forces.terms import Torque, UniformAcceleration
from physagent_jax.mpm import DomainBox, simulate, stable_dt, step
from physagent_jax.mpm.energy import momentum
from physagent_jax.mpm.transfer import scatter_momentum, stencil
from tests.mpm.blocks import block

CELLS = 20
SCENES = settings(max_examples=15, deadline=None, derandomize=True)
unit = st.floats(-1.0, 1.0, allow_subnormal=False)
vectors = st.tuples(unit, unit, unit)


@pytest.fixture(autouse=True, scope="module")
def double():
    """Double precision: these are statements about round-off."""
    with jax.enable_x64(True):
        yield


@st.composite
def scenes(draw, gravity=True):
    """A jittered, strained, moving block anywhere in the domain, with a push and a turn."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    low = 0.2 + 0.45 * (0.5 + 0.5 * np.array(draw(vectors)))
    modulus = 10 ** draw(st.floats(3.0, 7.0))
    speed = 0.2 * np.sqrt(modulus / 1000.0)
    weight = jnp.array([0.0, 0.0, -9.8 if gravity else 0.0])
    forever = jnp.asarray(1e9)
    push = UniformAcceleration(20 * jnp.array(draw(vectors)), jnp.zeros(()), forever)
    turn = Torque(jnp.array([0.0, 0.6, 0.8]), jnp.asarray(30.0 * draw(unit)), jnp.zeros(()), forever)
    model, state = block(
        (3, 3, 3),
        low=low,
        youngs_modulus=modulus,
        dtype=np.float64,
        gravity=weight,
        forces=(push, turn) if gravity else (),
    )
    shape = state.F.shape
    state = dataclasses.replace(
        state,
        x=state.x + 0.2 * model.grid.dx * jnp.asarray(rng.uniform(-1, 1, state.x.shape)),
        v=speed * (jnp.array(draw(vectors)) + 0.1 * jnp.asarray(rng.uniform(-1, 1, state.x.shape))),
        F=state.F + 0.05 * jnp.asarray(rng.uniform(-1, 1, shape)),
    )
    return model.replace(dt=0.7 * stable_dt(model, state)), state


@jax.jit
def several(model, state):
    return jax.lax.fori_loop(0, 20, lambda _, s: step(model, s), state)


@given(scenes())
@SCENES
def test_finite_inside_and_balanced(scene):
    """Whatever pushes and wherever: finite, within the walls, and momentum is what forces and walls gave."""
    model, state = scene
    last, given_ = None, jnp.zeros(3)
    for frame in simulate(model, state, frame_count=4, frame_dt=20 * float(model.dt), ledger=True):
        last, given_ = frame.state, given_ + frame.exchange.force_impulse + frame.exchange.boundary_impulse
    assert all(np.isfinite(np.asarray(leaf)).all() for leaf in (last.x, last.v, last.C, last.F))
    margin = 1.5 * model.grid.dx
    assert margin <= float(last.x.min()) and float(last.x.max()) <= CELLS * model.grid.dx - margin
    assert int(last.stopped) == 0
    assert float(jnp.linalg.det(last.F).min()) > 0
    scale = float(model.mass.sum()) * float(jnp.abs(last.v).max() + jnp.abs(state.v).max() + 1)
    np.testing.assert_allclose(momentum(model, last) - momentum(model, state), given_, atol=1e-12 * scale)


@given(scenes(gravity=False))
@SCENES
def test_momentum_is_kept_in_free_space(scene):
    model, state = scene
    model = model.replace(boundaries=())
    scale = float(model.mass.sum() * jnp.abs(state.v).max())
    after = momentum(model, several(model, state))
    np.testing.assert_allclose(after, momentum(model, state), atol=1e-13 * max(scale, 1e-9))


@given(scenes())
@SCENES
def test_the_grid_has_the_particles_mass(scene):
    model, state = scene
    zero = jnp.zeros_like(state.F)
    nodes = scatter_momentum(
        stencil(state.x, model.grid), model.grid, model.mass, model.mass[:, None] * state.v, zero
    )
    np.testing.assert_allclose(nodes[..., 3].sum(), model.mass.sum(), rtol=1e-13)
    assert float(nodes[..., 3].min()) >= 0


@given(scenes(), st.integers(0, 2**32 - 1))
@SCENES
def test_the_order_of_particles_does_not_matter(scene, seed):
    model, state = scene
    order = np.random.default_rng(seed).permutation(len(state.x))
    mixed = dataclasses.replace(state, x=state.x[order], v=state.v[order], F=state.F[order])
    one, other = several(model, state), several(model, mixed)
    np.testing.assert_allclose(one.x[order], other.x, atol=1e-12)
    np.testing.assert_allclose(one.F[order], other.F, atol=1e-9)


@given(scenes(), st.tuples(*[st.integers(-2, 2)] * 3))
@SCENES
def test_a_shift_by_whole_cells_does_not_matter(scene, cells):
    model, state = scene
    model = model.replace(boundaries=(), gravity=None)  # walls do not shift, nor do the domain's faces below
    shift = model.grid.dx * jnp.asarray(cells, state.x.dtype)
    middle = dataclasses.replace(state, x=state.x - state.x.mean(0) + 0.5)
    moved = dataclasses.replace(middle, x=middle.x + shift)
    one, other = several(model, middle), several(model, moved)
    assume(int(one.stopped) == 0 and int(other.stopped) == 0)
    np.testing.assert_allclose(one.x + shift, other.x, atol=1e-11)
    np.testing.assert_allclose(one.F, other.F, atol=1e-8)


def test_the_walls_are_what_keeps_matter_inside():
    """The statement above is not empty: without walls the same throw ends at the last line of defence."""
    model, state = block((3, 3, 3), low=(0.2, 0.4, 0.4), dtype=np.float64, dt=1e-3, boundaries=())
    thrown = dataclasses.replace(state, v=jnp.broadcast_to(jnp.array([-5.0, 0.0, 0.0]), state.v.shape))
    for boundaries, stopped in (((), True), ((DomainBox(),), False)):
        end = several(model.replace(boundaries=boundaries, dt=jnp.asarray(2e-3)), thrown)
        assert (int(end.stopped) > 0) is stopped
