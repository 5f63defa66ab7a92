"""Planes, boxes and moving cuboids against Newton's and Coulomb's laws."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.mpm import Contact, Cuboid, DomainBox, Grid, HalfSpace, step
from tests.mpm.blocks import block

G = 9.8


def plane(contact, friction=0.0, height=0.4, start=0.0, end=1e9):
    return HalfSpace(
        jnp.array([0.0, 0.0, height]),
        jnp.array([0.0, 0.0, 1.0]),
        jnp.array(friction),
        jnp.array(start),
        jnp.array(end),
        contact,
    )


@jax.jit
def run(model, state, steps):
    return jax.lax.fori_loop(0, steps, lambda _, s: step(model, s), state)


def slide(contact, friction, slope_degrees, seconds=0.4):
    """Displacement along and off the plane of a stiff block under gravity tilted by the slope."""
    slope = np.radians(slope_degrees)
    gravity = jnp.asarray(np.array([np.sin(slope), 0, -np.cos(slope)]) * G)
    model, state = block(
        (4, 4, 4),
        size=1.2,
        grid_cells=24,
        low=(0.2, 0.5, 0.4),
        youngs_modulus=1e6,
        dt=5e-4,
        gravity=gravity,
        dtype=np.float64,
        boundaries=(plane(contact, friction), DomainBox()),
    )
    steps = round(seconds / 5e-4)
    end = run(model, state, steps)
    return np.asarray((end.x - state.x).mean(0)), end


@pytest.mark.parametrize("friction", [0.0, 0.15, 0.3])
def test_sliding_block_obeys_coulomb(friction, x64):
    slope, seconds = np.radians(30), 0.4
    moved, _ = slide(Contact.SEPARATE, friction, 30, seconds)
    exact = 0.5 * G * (np.sin(slope) - friction * np.cos(slope)) * seconds**2
    np.testing.assert_allclose(moved[0], exact, rtol=0.02)
    assert abs(moved[2]) < 0.005  # it neither sinks in nor lifts off (a tenth of a cell)


@pytest.mark.parametrize("mu", [0.62, 0.8])
def test_block_stays_when_friction_exceeds_the_slope(mu, x64):
    """Once its own elastic shear has built up, it creeps less than a thousandth of its length in 0.2 s.

    tan 30 = 0.577: a little more friction than that is enough.
    """
    early, _ = slide(Contact.SEPARATE, mu, 30, seconds=0.2)
    late, _ = slide(Contact.SEPARATE, mu, 30, seconds=0.4)
    assert abs(late[0] - early[0]) < 1e-3 * 0.2


def test_slip_plane_is_frictionless_and_sticky_plane_holds(x64):
    slope = np.radians(30)
    slipping, _ = slide(Contact.SLIP, 0.9, 30)  # friction means nothing to a slip plane
    np.testing.assert_allclose(slipping[0], 0.5 * G * np.sin(slope) * 0.4**2, rtol=0.02)
    sticking, _ = slide(Contact.STICKY, 0.0, 30)
    assert abs(sticking[0]) < 2e-3  # only the block's own shear


@pytest.mark.parametrize(("contact", "leaves"), [(Contact.SEPARATE, True), (Contact.SLIP, False)])
def test_only_a_separating_plane_lets_go(contact, leaves, x64):
    model, state = block(
        low=(0.4, 0.4, 0.4),
        youngs_modulus=1e6,
        dt=5e-4,
        gravity=jnp.array([0.0, 0.0, 2.0]),
        dtype=np.float64,
        boundaries=(plane(contact, height=0.425),),
    )
    end = run(model, state, 400)
    bottom = float(end.x[:, 2].min() - state.x[:, 2].min())
    assert (bottom > 0.8 * 0.5 * 2.0 * 0.2**2) == leaves


def test_projections_of_single_velocities():
    grid, v = Grid.whole(1.0, 4), jnp.array([3.0, 4.0, -2.0])
    field = jnp.broadcast_to(v, (5, 5, 5, 3))

    def at_floor(contact, friction=0.0, velocity=field, time=0.0, **window):
        return np.asarray(
            plane(contact, friction, height=0.5, **window).apply(velocity, grid, jnp.asarray(time))
        )[2, 2, 1]

    np.testing.assert_allclose(at_floor(Contact.STICKY), 0)
    np.testing.assert_allclose(at_floor(Contact.SLIP), [3, 4, 0])
    np.testing.assert_allclose(at_floor(Contact.SEPARATE), [3, 4, 0])
    np.testing.assert_allclose(at_floor(Contact.SEPARATE, 0.5), [3 * 0.8, 4 * 0.8, 0])  # 5 - 0.5 * 2 = 4
    np.testing.assert_allclose(at_floor(Contact.SEPARATE, 3.0), [0, 0, 0])
    np.testing.assert_allclose(at_floor(Contact.SEPARATE, 0.5, -field), [-3, -4, 2])  # leaving: untouched
    np.testing.assert_allclose(at_floor(Contact.STICKY, start=1.0), v)  # not yet
    np.testing.assert_allclose(at_floor(Contact.STICKY, time=2.0, end=1.0), v)  # no longer
    above = np.asarray(plane(Contact.STICKY, height=0.5).apply(field, grid, jnp.asarray(0.0)))[2, 2, 3]
    np.testing.assert_allclose(above, v)


def test_domain_box_stops_and_counts():
    model, state = block(low=(0.4, 0.4, 0.4), dt=1e-3)
    thrown = dataclasses.replace(state, v=jnp.broadcast_to(jnp.array([-3.0, 0, 0]), state.v.shape))
    end = run(model, thrown, 300)
    assert np.isfinite(np.asarray(end.x)).all()
    assert float(end.x[:, 0].min()) >= 2 * 0.05 - 1e-6
    unguarded, _ = block(low=(0.4, 0.4, 0.4), dt=1e-3, boundaries=())
    end = run(unguarded, thrown, 300)
    assert int(end.stopped) > 0 and float(end.x[:, 0].min()) >= 2 * 0.05 - 1e-6


def test_moving_cuboid_takes_the_block_along(x64):
    speed = jnp.array([0.5, 0.0, 0.0])
    cuboid = Cuboid(jnp.array([0.5, 0.5, 0.5]), jnp.full(3, 0.2), speed, jnp.array(0.1), jnp.array(0.3))
    model, state = block(dtype=np.float64, dt=1e-3, boundaries=(cuboid,))
    before = run(model, state, 100)
    np.testing.assert_allclose(before.x, state.x, atol=1e-12)  # its window is not open yet
    after = run(model, before, 200)
    np.testing.assert_allclose(after.x - state.x, np.broadcast_to(0.2 * speed, state.x.shape), atol=1e-6)
