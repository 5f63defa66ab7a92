"""Rigid bodies that are all there is: what a grid would give, without one."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.mpm import DomainBox, HalfSpace, SignedDistance, find_smallest_window, simulate, step
from physagent_jax.mpm.constraints import PrescribedMotion, rigid
from physagent_jax.mpm.frame import advance
from physagent_jax.mpm.gridless import needs_grid, use_grid
from tests.mpm.test_constraints_rigid import rigid_block, run
from tests.mpm.test_gradients import quick_jit

FLOOR = HalfSpace(
    point=jnp.array([0.0, 0.0, 0.22]),
    normal=jnp.array([0.0, 0.0, 1.0]),
    friction=jnp.asarray(0.4),
    start=jnp.asarray(0.0),
    end=jnp.asarray(1e9),
)


def whole_block(restitution=None, **options):
    model, state = rigid_block(whole=True, **options)
    body = model.constraints[0]
    if restitution is not None:
        body = dataclasses.replace(body, restitution=jnp.asarray(restitution), least_speed=jnp.asarray(0.05))
    return model.replace(constraints=(body,)), state


CASES = dict(
    tumbles=dict(spin=(3.0, 1.0, -2.0), velocity=(0.1, 0.0, 0.2)),
    falls=dict(spin=(2.0, -1.0, 0.5), gravity=jnp.array([0.0, 0.0, -9.8]), boundaries=(FLOOR,)),
    rebounds=dict(
        spin=(0.0, 1.0, 0.0), gravity=jnp.array([0.0, 0.0, -9.8]), boundaries=(FLOOR,), restitution=0.6
    ),
    damped=dict(spin=(3.0, 1.0, -2.0), velocity=(0.3, 0.0, 0.0), damping_rate=jnp.asarray(2.0)),
    rpic=dict(spin=(3.0, 1.0, -2.0), rpic_damping=0.7),
    pic=dict(spin=(3.0, 1.0, -2.0), velocity=(0.2, 0.0, 0.0), transfer="pic"),
)


@pytest.mark.parametrize("name", CASES)
def test_the_motion_is_that_on_a_grid(name, x64):
    model, state = whole_block(**CASES[name])
    assert not needs_grid(model)
    here, there = run(model, state, 150), run(use_grid(model), state, 150)
    assert np.abs(np.asarray(there.x - state.x)).max() > 0.01
    for field in ("x", "v", "C", "F"):
        np.testing.assert_allclose(getattr(here, field), getattr(there, field), atol=2e-9, err_msg=field)


def test_a_wall_of_the_domain_stops_its_particles(x64):
    model, state = whole_block(velocity=(4.0, 0.0, 0.0), boundaries=(DomainBox(padding=3),))
    end = run(model, state, 150)
    wall = (model.grid.cells - 3) * model.grid.dx
    assert wall - 0.5 * model.grid.dx < float(end.x[:, 0].max()) < wall
    np.testing.assert_allclose(end.v, 0, atol=2e-3)


def test_derivatives_are_those_on_a_grid(x64):
    model, state = whole_block(**CASES["falls"])

    def land(speed, model):
        thrown = dataclasses.replace(state, v=state.v + speed)
        end = jax.lax.scan(lambda s, _: (step(model, s), None), thrown, None, length=60)[0]
        return (end.x[:, 0] * end.x[:, 2]).mean()

    speed = jnp.array([0.3, 0.0, -1.0])
    here, there = (quick_jit(jax.grad(land))(speed, each) for each in (model, use_grid(model)))
    assert np.abs(there).min() > 1e-4
    np.testing.assert_allclose(here, there, rtol=1e-6)


def test_what_is_more_than_one_rigid_body_needs_a_grid(x64):
    model, state = whole_block()
    body, half = model.constraints[0], jnp.arange(len(state.x) // 2, dtype=jnp.int32)
    mesh = SignedDistance(
        values=jnp.ones((2, 2, 2)),
        origin=jnp.zeros(3),
        spacing=1.0,
        friction=jnp.asarray(0.0),
        start=jnp.asarray(0.0),
        end=jnp.asarray(1.0),
    )
    assert needs_grid(model.replace(constraints=(dataclasses.replace(body, particles=half, whole=False),)))
    assert needs_grid(model.replace(constraints=(body, PrescribedMotion.fixed(half))))
    assert needs_grid(model.replace(constraints=()))
    assert needs_grid(model.replace(boundaries=(mesh,)))
    assert not needs_grid(model)


def test_windows_of_a_flight_are_one_program():
    model, state = whole_block(velocity=(3.0, 0.0, 0.0), dtype=np.float32)
    model = model.replace(grid=find_smallest_window(0.7, 14))
    before = advance._cache_size()  # pyright: ignore[reportAttributeAccessIssue]
    frames = list(simulate(model, state, frame_count=4, frame_dt=0.03, substep_dt=2.5e-3))
    assert len({frame.grid_shape for frame in frames}) > 1
    assert advance._cache_size() == before + 1  # pyright: ignore[reportAttributeAccessIssue]


def test_the_ledger_still_closes():
    model, state = whole_block(**CASES["falls"], dtype=np.float32)
    frames = list(simulate(model, state, frame_count=4, frame_dt=0.05, ledger=True))
    assert frames[-1].exchange is not None
    assert np.isfinite(float(frames[-1].exchange.boundary_work))


def test_what_is_led_and_let_go_moves_as_on_a_grid(x64):
    model, state = whole_block(gravity=jnp.array([0.0, 0.0, -9.8]), boundaries=(FLOOR,))
    lead = PrescribedMotion(
        jnp.arange(len(state.x), dtype=jnp.int32),
        jnp.array([0.2, 0.0, 0.3]),
        jnp.array([0.0, 3.0, 1.0]),
        jnp.asarray(state.x.mean(0) + jnp.array([0.1, 0.0, 0.0])),
        jnp.asarray(0.02),
        jnp.asarray(0.07),
        whole=True,
    )
    model = model.replace(constraints=(*model.constraints, lead))
    assert not needs_grid(model)
    here, there = run(model, state, 150), run(use_grid(model), state, 150)
    for field in ("x", "v", "C", "F"):
        np.testing.assert_allclose(getattr(here, field), getattr(there, field), atol=2e-9, err_msg=field)


def test_some_of_the_points_that_touch_say_what_all_do(x64, monkeypatch):
    gravity = jnp.array([0.0, 0.0, -9.8])
    model, state = whole_block(cells=(5, 4, 2), low=(0.2, 0.2, 0.22), gravity=gravity, boundaries=(FLOOR,))
    state = dataclasses.replace(state, v=state.v + jnp.array([0.8, 0.0, 0.0]))
    ends = []
    for most in (4096, 30):  # 80 touch
        monkeypatch.setattr(rigid, "MOST_POINTS", most)
        ends.append(jax.jit(lambda s: jax.lax.fori_loop(0, 150, lambda _, s: step(model, s), s))(state))
    way = ends[0].x - state.x
    seconds = 0.15  # before it stops; Coulomb: v t - mu g t^2 / 2
    np.testing.assert_allclose(way[:, 0].mean(), 0.8 * seconds - 0.4 * 9.8 * seconds**2 / 2, rtol=0.02)
    np.testing.assert_allclose(ends[1].x, ends[0].x, atol=0.01 * float(way[:, 0].mean()))
