"""Fragments: one body until it breaks, then rigid pieces that fly apart and come to rest."""

import dataclasses

import jax.numpy as jnp
import numpy as np

from physagent_jax.mpm.constraints import Shatter
from physagent_jax.mpm.gridless import needs_grid
from tests.mpm.test_constraints_rigid import run
from tests.mpm.test_gradients import quick_jit
from tests.mpm.test_gridless import FLOOR, whole_block

PIECES, STEPS = 5, 900


def make_block(start=0.0, speed=1.0):
    model, state = whole_block(gravity=jnp.array([0.0, 0.0, -9.8]), boundaries=(FLOOR,))
    up = np.array([0.0, 0.0, 1.0])
    fragments = Shatter.of(
        np.asarray(state.x), PIECES, up, jnp.asarray(speed, state.x.dtype), jnp.asarray(start, state.x.dtype)
    )
    return model.replace(constraints=(*model.constraints, fragments)), state, fragments


def list_pieces(fragments, count):
    rows = np.asarray(fragments.particles).reshape(PIECES, -1)
    return [row[row < count] for row in rows]


def test_every_particle_is_of_one_fragment(x64):
    _, state, fragments = make_block()
    rows = list_pieces(fragments, len(state.x))
    np.testing.assert_array_equal(np.sort(np.concatenate(rows)), np.arange(len(state.x)))


def test_it_is_in_one_piece_until_it_breaks(x64):
    """It falls freely as one, and keeps its shape."""
    model, state, _ = make_block(start=1e3)
    assert not needs_grid(model)
    end = run(model, state, STEPS)
    time, before, after = STEPS * float(model.dt), np.asarray(state.x), np.asarray(end.x)
    old, new = (np.linalg.norm(x - x.mean(0), axis=1) for x in (before, after))
    np.testing.assert_allclose(new, old, atol=1e-9)
    assert abs(after.mean(0)[2] - before.mean(0)[2]) <= 0.5 * 9.8 * time**2 + 1e-9


def test_fragments_keep_their_shape_part_and_come_to_rest(x64):
    model, state, fragments = make_block(speed=0.6)
    end = run(model, state, STEPS)
    rows, before, after = list_pieces(fragments, len(state.x)), np.asarray(state.x), np.asarray(end.x)
    for row in rows:
        old, new = (np.linalg.norm(x[row] - x[row[0]], axis=1) for x in (before, after))
        np.testing.assert_allclose(new, old, atol=1e-9)
    old, new = (np.array([x[row].mean(0) for row in rows]).std(0)[:2].sum() for x in (before, after))
    assert new > 1.5 * old, "they lie wider than they were"
    np.testing.assert_allclose(end.F @ jnp.swapaxes(end.F, 1, 2), np.eye(3) + 0 * end.F, atol=1e-9)
    assert np.sqrt(np.mean(np.asarray(end.v) ** 2)) < 0.1
    assert after[:, 2].min() > float(FLOOR.point[2]) - 0.1 * model.grid.dx


def test_the_domains_wall_stops_a_fragment_as_a_whole(x64):
    model, state, fragments = make_block(speed=30.0)
    end = run(model, state, STEPS)
    low = model.wall * model.grid.dx
    high = model.grid.cells * model.grid.dx - low
    assert float(end.x.min()) >= low - 1e-9 and float(end.x.max()) <= high + 1e-9
    for row in list_pieces(fragments, len(state.x)):
        old, new = (np.linalg.norm(np.asarray(x)[row] - x[row[0]], axis=1) for x in (state.x, end.x))
        np.testing.assert_allclose(new, old, atol=1e-9)


def test_on_a_grid_fragments_go_by_gravity_alone(x64):
    """Through the grid those that touch would cling together: what it left there is not theirs."""
    model, state, fragments = make_block()
    clung = dataclasses.replace(state, x=state.x + 0.01, time=state.time + model.dt)
    forced = dataclasses.replace(state, v=state.v + model.dt * model.gravity)
    here, there = quick_jit(
        lambda: (fragments.after_g2p(model, state, clung), fragments.move(model, state, forced))
    )()
    np.testing.assert_allclose(here.x, there.x, atol=1e-12)
    assert here.time == clung.time
