"""Windows with smooth edges: what they add up to, and what becomes of them as the edges grow narrow."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import quad

from physagent_jax.forces.envelope import Envelope
from physagent_jax.forces.terms import UniformAcceleration, UniformField, VelocityChange, Wind
from physagent_jax.mpm.edges import set_edges, window_fraction, window_value
from physagent_jax.mpm.plan import find_acting
from tests.mpm.blocks import block

START, END, STEPS, DT = 0.31, 0.74, 37, 1 / 37


@jax.jit
def shares(start, end, edge):
    """Of all substeps of a second, shape (STEPS,)."""
    times = jnp.arange(STEPS) * DT
    return jax.vmap(lambda time: window_fraction(time, jnp.asarray(DT), start, end, edge))(times)


def arrays(*values):
    return [jnp.asarray(value) for value in values]


@pytest.mark.parametrize("edge", [1e-9, 0.02, 0.2, 0.5])
def test_the_share_is_the_mean_of_the_smooth_window(edge, x64):
    """Also of edges that meet, and that are cut where the clip begins; over all substeps it is the window's length."""
    value, (start, end, width) = jax.jit(window_value), arrays(START, END, edge)
    got = shares(start, end, width)
    np.testing.assert_allclose(got.sum() * DT, END - START, rtol=1e-12)
    for index in (3, 11, 12, 20, 27):
        begin, stop = index * DT, (index + 1) * DT
        bounds = [each for each in (START, END) if begin < each < stop]
        mean = quad(lambda t: float(value(jnp.asarray(t), start, end, width)), begin, stop, points=bounds)
        np.testing.assert_allclose(got[index], mean[0] / DT, atol=1e-7)


def test_as_the_edge_narrows_it_is_the_hard_window(x64):
    """To second order in what the window passes on of a smooth profile."""
    profile = jnp.exp(2 * (jnp.arange(STEPS) + 0.5) * DT)
    hard = (shares(*arrays(START, END), None) * profile).sum()
    fine = [
        abs(float((shares(*arrays(START, END, edge)) * profile).sum() - hard)) for edge in (0.4, 0.2, 0.1)
    ]
    assert fine[0] / fine[1] == pytest.approx(4, rel=0.2) and fine[1] / fine[2] == pytest.approx(4, rel=0.3)
    np.testing.assert_allclose(
        shares(*arrays(START, END, 1e-12)), shares(*arrays(START, END), None), atol=1e-9
    )


@pytest.mark.parametrize(("start", "edge"), [(START, 0.1), (START, 1.0), (0.02, 0.1), (START, 0.0)])
def test_it_has_the_derivative_of_differences_by_both_bounds(start, edge, x64):
    weight = jnp.asarray(np.random.default_rng(0).normal(size=STEPS))

    def respond(bounds):
        return (shares(*bounds, jnp.asarray(edge)) * weight).sum()

    at, h = jnp.array([start, END]), 1e-7
    slopes = jax.grad(respond)(at)
    differences = [(respond(at + e) - respond(at - e)) / (2 * h) for e in h * jnp.eye(2)]
    np.testing.assert_allclose(slopes, differences, rtol=1e-6)
    assert np.abs(slopes).min() > 0


def test_what_begins_with_the_clip_begins_at_once(x64):
    got = shares(*arrays(0.0, END, 0.3))
    np.testing.assert_allclose(got[:5], 1)
    hard, soft = (
        jax.grad(
            lambda start, edge=edge: (shares(start, jnp.asarray(END), edge) * jnp.arange(1, STEPS + 1)).sum()
        )(0.0)
        for edge in (None, jnp.asarray(0.3))
    )
    assert hard == pytest.approx(-STEPS)  # the first substep loses what comes later: nothing is before
    assert soft == pytest.approx(hard)


def test_a_blow_with_an_edge_is_spread_and_keeps_its_size(x64):
    """And then it has a derivative by its moment: it comes later."""
    x = jnp.zeros((1, 3))

    def move(moment, edge):
        (blow,) = set_edges((VelocityChange(jnp.array([2.0, 0, 0]), moment, moment),), edge)
        gained = [blow.acceleration(x, x, None, i * DT, DT)[0, 0] * DT for i in range(STEPS)]
        return jnp.cumsum(jnp.array(gained)).sum() * DT, jnp.array(gained).sum()

    (way, total), h = move(START, jnp.asarray(0.2)), 1e-6
    assert total == pytest.approx(2.0) and way == pytest.approx(2 * (1 - START), abs=2 * DT)
    slope = jax.grad(lambda moment: move(moment, jnp.asarray(0.2))[0])(START)
    difference = (move(START + h, jnp.asarray(0.2))[0] - move(START - h, jnp.asarray(0.2))[0]) / (2 * h)
    assert slope == pytest.approx(float(difference), rel=1e-6) and slope == pytest.approx(-2.0, rel=0.02)
    assert jax.grad(lambda moment: move(moment, None)[0])(START) == 0


def test_what_acts_in_a_frame_reaches_as_far_as_its_edges():
    window = arrays(0.3, 0.5)
    force = UniformAcceleration(jnp.ones(3), *window)
    gust = Wind(jnp.array([1.0, 0, 0]), 1.0, 1.0, 0.0, Envelope.constant(*window))
    for part in (force, UniformField(jnp.ones(3), Envelope.constant(*window)), gust):
        model, _ = block((1, 1, 1), forces=(part,))
        (soft,) = set_edges(model.forces, 0.1)
        assert find_acting(model, 0.2, 0.29).forces == find_acting(model, 0.51, 0.6).forces == ()
        softened = model.replace(forces=(soft,))
        assert find_acting(softened, 0.2, 0.26).forces == find_acting(softened, 0.54, 0.6).forces == (0,)
        assert find_acting(softened, 0.2, 0.24).forces == ()
