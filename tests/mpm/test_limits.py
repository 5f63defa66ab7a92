"""Limits of the method are said before anything is simulated, with the number that helps."""

import warnings

import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax import mpm
from physagent_jax.mpm.limits import THINNEST, find_limits
from tests.mpm.blocks import block

DX = 1 / 20
EVER = jnp.array(1e9)


def obstacle(kind=mpm.Box, **fields):
    common = dict(friction=jnp.array(0.0), start=jnp.array(0.0), end=EVER) if kind is not mpm.Cuboid else {}
    return kind(point=jnp.full(3, 0.5), **common, **fields)


def box(half, **fields):
    return obstacle(half_size=jnp.array([0.3, 0.3, half]), **fields)


def said(boundaries=(), **options):
    model, state = block((3, 3, 3), boundaries=boundaries, **options)
    assert model.grid.dx == pytest.approx(DX)
    return find_limits(model, state, 1.0)


@pytest.mark.parametrize("cells", [0.5, 1.0, 2.0, 2.9])
def test_obstacles_of_few_cells_are_said_with_the_cells_that_hold(cells):
    """20 cells along the domain; an obstacle of c cells has THINNEST of them with 20 THINNEST / c."""
    half = cells * DX / 2
    (sentence,) = said((mpm.DomainBox(), box(half)))
    needed = int(np.ceil(20 * THINNEST / cells - 1e-4))
    assert f"`boundaries[1]` (Box) is {cells:.2g} cells thick" in sentence
    assert f"take {needed} cells along the domain's side" in sentence
    # With so many cells it is silent.
    assert cells * needed / 20 >= THINNEST - 1e-6


def test_what_is_thick_or_has_no_far_side_is_not_said():
    plane = mpm.HalfSpace(jnp.full(3, 0.3), jnp.array([0, 0, 1.0]), jnp.array(0.0), jnp.array(0.0), EVER)
    thin_container = box(1 * DX, container=True)
    assert said((mpm.DomainBox(), plane, box(1.51 * DX), thin_container)) == []
    ball = obstacle(mpm.Sphere, radius=jnp.array(1.51 * DX))
    assert said((ball,)) == []


def test_balls_and_moving_cuboids_are_measured_too():
    ball = obstacle(mpm.Sphere, radius=jnp.array(0.8 * DX))
    cuboid = mpm.Cuboid(jnp.full(3, 0.5), jnp.array([0.2, DX / 2, 0.2]), jnp.zeros(3), jnp.array(0.0), EVER)
    first, second = said((ball, cuboid))
    assert "(Sphere) is 1.6 cells" in first and "(Cuboid) is 1 cells" in second


@pytest.mark.parametrize(("gap", "count"), [(0.0, 0), (3.0, 1)])
def test_bodies_that_start_apart_are_said_to_stick(gap, count):
    model, state = block((6, 3, 3))
    x = np.asarray(state.x)
    x = x + np.where(x[:, :1] > np.median(x[:, 0]), gap * DX, 0) * np.array([1, 0, 0])
    state = mpm.State.at_rest(jnp.asarray(x), materials=model.materials)
    found = find_limits(model, state, 1.0)
    assert len(found) == count and all("2 bodies start apart" in each and "stick" in each for each in found)


def liquid(per_axis, duration):
    x = np.stack(np.meshgrid(*[np.arange(0.4, 0.6, DX / per_axis)] * 3, indexing="ij"), -1).reshape(-1, 3)
    n, volume = len(x), (DX / per_axis) ** 3
    model = mpm.Model(
        mpm.Grid.whole(1.0, 20),
        dt=jnp.array(1e-3),
        gravity=None,
        mass=jnp.full(n, 1000 * volume),
        volume=jnp.full(n, volume),
        materials=(mpm.Fluid(jnp.full(n, 2e5)),),
    )
    return model, mpm.State.at_rest(jnp.asarray(x, jnp.float32), materials=model.materials), duration


def test_liquids_of_few_particles_and_long_clips_are_said_to_lose_volume():
    (sparse,) = find_limits(*liquid(1, 0.5))
    assert "1 particles along a cell's side" in sparse and "quarter of its depth" in sparse
    (long,) = find_limits(*liquid(2, 3.0))
    assert "stirred" in long and "8 %" in long
    assert find_limits(*liquid(2, 0.5)) == []


def test_simulate_tells_and_can_be_told_not_to():
    model, state = block((3, 3, 3), boundaries=(box(DX / 2),))
    with pytest.warns(UserWarning, match="cells thick"):
        next(mpm.simulate(model, state, frame_count=1, frame_dt=0.01))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        next(mpm.simulate(model, state, frame_count=1, frame_dt=0.01, tell_limits=False))
