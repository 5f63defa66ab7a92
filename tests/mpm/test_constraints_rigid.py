"""Rigid bodies: conserved momenta, Euler's equations, contact, shape."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.distance import pdist
from scipy.spatial.transform import Rotation

from physagent_jax.mpm import Contact, DomainBox, HalfSpace, RigidBody, step
from physagent_jax.mpm.constraints import before_p2g
from physagent_jax.mpm.energy import angular_momentum, kinetic_energy, momentum
from physagent_jax.mpm.linalg import skew
from physagent_jax.mpm.transfer import scatter_momentum, stencil
from tests.mpm.blocks import block
from tests.mpm.test_gradients import make_case, quick_jit


@jax.jit
def run(model, state, steps):
    return jax.lax.fori_loop(0, steps, lambda _, s: step(model, s), state)


def everything(state):
    return jnp.arange(len(state.x), dtype=jnp.int32)


SMALL = dict(size=0.7, grid_cells=14)


def rigid_block(
    cells=(4, 3, 2), low=(0.25, 0.28, 0.3), spin=(0, 0, 0), velocity=(0, 0, 0), whole=False, **options
):
    """A block that is one rigid body, turning about its centre; with a grid, unless it is told to be the ``whole``."""
    model, state = block(cells, low=low, **{**SMALL, "dtype": np.float64, **options})
    model = model.replace(constraints=(RigidBody(everything(state), whole=whole),))
    return model, turning(state, spin, velocity)


def turning(state, spin, velocity=(0, 0, 0)):
    W = skew(jnp.asarray(spin, state.x.dtype))
    v = (state.x - state.x.mean(0)) @ W.T + jnp.asarray(velocity, state.x.dtype)
    return dataclasses.replace(state, v=v, C=jnp.broadcast_to(W, state.C.shape))


def inertia(model, state):
    """Moment of inertia about the centre with the particles' own m dx^2 / 2, from its definition."""
    r, m = np.asarray(state.x - state.x.mean(0)), np.asarray(model.mass)
    orbital = sum(mi * (ri @ ri * np.eye(3) - np.outer(ri, ri)) for mi, ri in zip(m, r))
    return orbital + m.sum() * model.grid.dx**2 / 2 * np.eye(3)


def noisy(state, seed=0):
    rng = np.random.default_rng(seed)
    return dataclasses.replace(
        state,
        v=jnp.asarray(rng.normal(size=state.v.shape)),
        C=jnp.asarray(20 * rng.normal(size=state.C.shape)),
    )


def test_the_rigid_field_has_the_momenta_of_the_matter_it_replaces(x64):
    model, state = rigid_block()
    state, about = noisy(state), jnp.array([0.1, 0.7, 0.2])
    rigid = jax.jit(before_p2g)(model, state)
    np.testing.assert_allclose(momentum(model, rigid), momentum(model, state), rtol=1e-12)
    np.testing.assert_allclose(
        angular_momentum(model, rigid, about), angular_momentum(model, state, about), rtol=1e-12
    )
    # It is rigid: one skew C for all, and v = V + w x r.
    C = np.asarray(rigid.C)
    np.testing.assert_allclose(C, np.broadcast_to(-C[0].T, C.shape), atol=1e-13)
    r, v = np.asarray(rigid.x - rigid.x.mean(0)), np.asarray(rigid.v)
    np.testing.assert_allclose(v - v.mean(0), r @ C[0].T, atol=1e-13)


def test_the_grid_gets_those_momenta_too(x64):
    model, state = rigid_block()
    rigid = jax.jit(before_p2g)(model, noisy(state))
    grid, m = model.grid, model.mass
    nodes = scatter_momentum(
        stencil(rigid.x, grid), grid, m, m[:, None] * rigid.v, m[:, None, None] * rigid.C
    )
    x = np.stack(np.broadcast_arrays(*grid.node_positions(jnp.float64)), axis=-1)
    p = np.asarray(nodes[..., :3])
    np.testing.assert_allclose(p.sum((0, 1, 2)), momentum(model, rigid), rtol=1e-12)
    np.testing.assert_allclose(
        np.cross(x, p).sum((0, 1, 2)), angular_momentum(model, rigid, jnp.zeros(3)), rtol=1e-12
    )


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_spin_about_a_principal_axis_goes_on_exactly(axis, x64):
    spin = 4.0 * np.eye(3)[axis]
    model, state = rigid_block(spin=spin, velocity=(0.1, 0.0, -0.2), dt=1e-3)
    end = run(model, state, 300)
    centre = np.asarray(state.x.mean(0))
    turned = Rotation.from_rotvec(0.3 * spin).apply(np.asarray(state.x) - centre)
    np.testing.assert_allclose(end.x, turned + centre + 0.3 * np.array([0.1, 0.0, -0.2]), atol=1e-12)
    R = Rotation.from_rotvec(0.3 * spin).as_matrix()
    np.testing.assert_allclose(end.F, np.broadcast_to(R, end.F.shape), atol=1e-12)
    np.testing.assert_allclose(kinetic_energy(model, end), kinetic_energy(model, state), rtol=1e-12)
    about = jnp.asarray(centre)
    np.testing.assert_allclose(
        angular_momentum(model, end, about), angular_momentum(model, state, about), atol=1e-13
    )


def precession(model, state, spin, seconds):
    """Orientation of a torque-free body by Euler's equations in its own frame (scipy, eighth order)."""
    I = inertia(model, state)
    inverse = np.linalg.inv(I)

    def rates(_, y):
        w = y[4:]
        return [*(0.5 * _multiply(y[:4], [*w, 0.0])), *(inverse @ np.cross(I @ w, w))]

    start = [0.0, 0.0, 0.0, 1.0, *spin]
    y = solve_ivp(rates, (0, seconds), start, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    R = Rotation.from_quat(y[:4])
    return R.as_matrix(), R.apply(y[4:])


def _multiply(p, q):
    """Quaternion product, scalar last."""
    a, b = np.asarray(p[:3]), np.asarray(q[:3])
    return np.append(p[3] * b + q[3] * a + np.cross(a, b), p[3] * q[3] - a @ b)


@pytest.mark.parametrize("whole", [False, True])
def test_a_tumbling_body_obeys_eulers_equations(whole, x64):
    """About its intermediate axis, where the motion is unstable and no symmetry helps."""
    spin, seconds = (0.4, 5.0, -0.3), 1.0
    errors, energies = [], []
    for steps in (200, 400):
        model, state = rigid_block(
            (6, 4, 1), low=(0.2, 0.25, 0.32), spin=spin, dt=seconds / steps, whole=whole
        )
        R, w = precession(model, state, spin, seconds)
        end = run(model, state, steps)
        errors.append(
            (np.abs(np.asarray(end.F[0]) - R).max(), np.abs(np.asarray(end.C[0]) - _make_skew(w)).max())
        )
        energies.append(abs(float(kinetic_energy(model, end) / kinetic_energy(model, state)) - 1))
        centre = state.x.mean(0)
        L0, L1 = (angular_momentum(model, s, centre) for s in (state, end))
        np.testing.assert_allclose(L1, L0, rtol=1e-12, atol=1e-13)
        shape = np.asarray(state.x - centre) @ np.asarray(end.F[0]).T
        np.testing.assert_allclose(end.x - end.x.mean(0), shape, atol=1e-12)  # particles and F agree
    assert errors[1][0] < 5e-3 and errors[1][1] < 2e-2
    ratio = np.array(errors[0]) / np.array(errors[1])
    assert (ratio > 3.3).all(), (errors, ratio)  # second order
    assert energies[1] < 1e-4


def _make_skew(w):
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def rigid_meets_soft():
    """A tumbling rigid block on its way into a soft one at rest, in one cloud of particles."""
    model, state = block(
        (5, 3, 3), low=(0.3, 0.3, 0.3), youngs_modulus=2e4, dtype=np.float64, dt=1e-3, size=0.8, grid_cells=16
    )
    rigid = np.asarray(state.x)[:, 0] < 0.4
    body = np.flatnonzero(rigid)
    state = dataclasses.replace(
        state, x=state.x + jnp.where(rigid[:, None], jnp.array([-0.1, 0.02, 0.0]), 0.0)
    )
    r = state.x[body] - state.x[body].mean(0)
    W = skew(jnp.array([0.0, 2.0, 3.0]))
    v = state.v.at[body].set(r @ W.T + jnp.array([1.0, 0.0, 0.0]))
    state = dataclasses.replace(state, v=v, C=state.C.at[body].set(W))
    return model.replace(constraints=(RigidBody(jnp.asarray(body, jnp.int32)),), boundaries=()), state, body


def test_a_rigid_body_that_meets_a_soft_one_loses_what_the_other_gains(x64):
    model, state, body = rigid_meets_soft()
    end = run(model, state, 250)
    soft = np.setdiff1d(np.arange(len(state.x)), body)
    assert float(end.v[soft, 0].mean()) > 0.2  # they have met
    np.testing.assert_allclose(momentum(model, end), momentum(model, state), rtol=1e-12, atol=1e-12)
    about = jnp.full(3, 0.5)
    np.testing.assert_allclose(
        angular_momentum(model, end, about), angular_momentum(model, state, about), rtol=1e-11, atol=1e-13
    )
    assert np.abs(np.asarray(end.F[soft]) - np.eye(3)).max() > 0.02  # the soft one is dented


def test_its_shape_never_drifts(x64):
    model, state, body = rigid_meets_soft()
    end = run(model, state, 1000)
    np.testing.assert_allclose(pdist(np.asarray(end.x[body])), pdist(np.asarray(state.x[body])), atol=1e-12)
    F = np.asarray(end.F[body])
    np.testing.assert_allclose(F.transpose(0, 2, 1) @ F, np.broadcast_to(np.eye(3), F.shape), atol=1e-12)


def test_single_precision_keeps_the_shape_to_round_off():
    model, state = rigid_block(spin=(1.0, 5.0, 0.5), dtype=np.float32, dt=1e-3)
    end = run(model, state, 2000)
    np.testing.assert_allclose(pdist(np.asarray(end.x)), pdist(np.asarray(state.x)), atol=2e-5)
    assert end.x.dtype == np.float32


def floor(height, mu):
    return HalfSpace(
        jnp.array([0.0, 0.0, height]),
        jnp.array([0.0, 0.0, 1.0]),
        jnp.array(mu),
        jnp.zeros(()),
        jnp.array(1e9),
        Contact.SEPARATE,
    )


@pytest.mark.parametrize(("mu", "slides"), [(0.3, True), (0.8, False)])
def test_a_rigid_block_on_a_slope_obeys_coulomb(mu, slides, x64):
    slope, g = np.radians(30), 9.8
    model, state = rigid_block(
        (4, 4, 2),
        low=(0.2, 0.2, 0.2),
        dt=1e-3,
        gravity=jnp.array([np.sin(slope), 0, -np.cos(slope)]) * g,
        boundaries=(floor(0.2, mu), DomainBox()),
    )
    settled, end = run(model, state, 50), run(model, state, 200)
    gained = float((end.v - settled.v)[:, 0].mean())
    exact = g * (np.sin(slope) - mu * np.cos(slope)) * 0.15 if slides else 0.0
    np.testing.assert_allclose(gained, exact, rtol=1e-3, atol=1e-3)
    # It neither sinks nor tips.
    np.testing.assert_allclose((end.x - state.x)[:, 2], 0, atol=1e-3)
    np.testing.assert_allclose(end.F, np.broadcast_to(np.eye(3), end.F.shape), atol=5e-3)


def rebounding(model, e, slow=0.0):
    (body,) = model.constraints
    return model.replace(
        constraints=(dataclasses.replace(body, restitution=jnp.array(e), least_speed=jnp.array(slow)),)
    )


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_a_block_that_lands_flat_leaves_the_floor_with_e_times_its_speed(e, x64):
    model, state = rigid_block(
        low=(0.25, 0.28, 0.3),
        dt=1e-3,
        gravity=jnp.zeros(3),
        velocity=(0.3, 0, -2.0),
        boundaries=(floor(0.2, 0.0), DomainBox()),
    )
    end = run(rebounding(model, e), state, 100)
    np.testing.assert_allclose(end.v, np.broadcast_to([0.3, 0, 2.0 * e], end.v.shape), atol=0.02)


def test_a_corner_that_hits_goes_back_with_e_times_its_speed(x64):
    """Newton's law at the one point that touches, on a floor without friction; the centre keeps less."""
    e = 0.6
    model, state = rigid_block(
        low=(0.25, 0.25, 0.35),
        dt=5e-4,
        gravity=jnp.zeros(3),
        velocity=(0, 0, -2.0),
        boundaries=(floor(0.2, 0.0), DomainBox()),
    )
    centre = state.x.mean(0)
    tilted = Rotation.from_euler("xy", [25, 40], degrees=True).apply(np.array(state.x - centre))
    state = dataclasses.replace(state, x=jnp.asarray(tilted) + centre)
    model, lowest = rebounding(model, e), int(np.asarray(state.x)[:, 2].argmin())
    for _ in range(300):
        before, state = state, run(model, state, 1)
        if abs(float(state.v[lowest, 2]) + 2.0) > 0.1:
            break
    # The particle's velocity is told at its new place: the turn within the step counts for little.
    assert float(before.v[lowest, 2]) == pytest.approx(-2.0, abs=1e-6)
    assert float(state.v[lowest, 2]) == pytest.approx(2.0 * e, rel=0.02)
    assert -2.0 < float(state.v[:, 2].mean()) < 2.0 * e - 0.1


def test_what_is_slower_than_the_least_speed_does_not_rebound(x64):
    model, state = rigid_block(
        low=(0.25, 0.28, 0.22),
        dt=1e-3,
        velocity=(0, 0, -0.2),
        gravity=jnp.array([0, 0, -9.8]),
        boundaries=(floor(0.2, 0.5), DomainBox()),
    )
    end = run(rebounding(model, 0.9, slow=1.0), state, 300)
    np.testing.assert_allclose(end.v, 0, atol=1e-3)


def test_round_off_does_not_decide_what_a_rigid_body_touches(x64):
    """Nodes that a step of the contact has stopped move into the floor by round-off, or out of it: a change in the last
    digits of what meets a floor that moves must stay one."""
    model, state = make_case("neo-Hookean", ("moving floor",), "rigid part", ("push",))
    advance = quick_jit(lambda state: step(model, state))
    for _ in range(6):
        near = advance(dataclasses.replace(state, v=state.v * (1 + 1e-12)))
        state = advance(state)
        np.testing.assert_allclose(near.v, state.v, atol=1e-11)


def test_a_tall_rigid_body_stands_where_it_is_put(x64):
    """Most of its mass is far from the floor that carries it."""
    model, state = rigid_block(
        (2, 2, 8),
        low=(0.3, 0.3, 0.2),
        dt=1e-3,
        gravity=jnp.array([0, 0, -9.8]),
        boundaries=(floor(0.2, 0.5), DomainBox()),
    )
    np.testing.assert_allclose(run(model, state, 300).x, state.x, atol=1e-3)


@pytest.mark.parametrize("offset", [0.01, 0.5, 0.9])  # of the floor over a layer of nodes [cells]
@pytest.mark.parametrize("tilt", [0.0, 30.0])
def test_a_rigid_body_comes_down_to_the_floor(offset, tilt, x64):
    """A gap of a cell between what has landed and the ground is seen."""
    dx = SMALL["size"] / SMALL["grid_cells"]
    height = (4 + offset) * dx
    normal = Rotation.from_euler("y", tilt, degrees=True).apply([0.0, 0.0, 1.0])
    plane = dataclasses.replace(floor(height, 0.5), normal=jnp.asarray(normal))
    plane = dataclasses.replace(plane, point=jnp.array([0.35, 0.35, height]))
    model, state = rigid_block(
        (4, 4, 2), low=(0.25, 0.25, height + 0.12), dt=1e-3, boundaries=(plane, DomainBox())
    )
    model = model.replace(gravity=-9.8 * jnp.asarray(normal))
    gap = ((run(model, state, 400).x - plane.point) @ plane.normal).min()
    np.testing.assert_allclose(gap, 0.25 * dx, atol=0.06 * dx)


def rigid_above_soft(height, **options):
    """A rigid block on a soft one, both of equal size, in a medium that slows everything."""
    model, state = block(
        (3, 3, 6),
        low=(0.27, 0.27, height),
        **SMALL,
        youngs_modulus=2e4,
        dtype=np.float64,
        dt=1e-3,
        boundaries=(floor(0.2, 0.5), DomainBox()),
        **options,
    )
    body = np.flatnonzero(np.asarray(state.x)[:, 2] > height + 0.15)
    return model.replace(constraints=(RigidBody(jnp.asarray(body, jnp.int32)),)), state, body


def test_a_rigid_block_rests_on_a_soft_one_and_does_not_creep_into_it(x64):
    model, state, body = rigid_above_soft(0.2, gravity=jnp.array([0, 0, -9.8]), damping_rate=20.0)
    early = run(model, state, 1200)
    late = run(model, early, 1200)
    sunk = float((state.x - late.x)[body, 2].mean())
    weight = 1000 * 9.8 * (0.15 + 0.15 / 2)  # per area: all of the body, and half of the soft block
    np.testing.assert_allclose(sunk, weight / 2e4 * 0.15, rtol=0.2)
    assert float(jnp.abs(late.x - early.x)[body].max()) < 1e-4


def test_gradients_through_a_collision_agree_with_finite_differences(x64):
    model, state, body = rigid_meets_soft()

    def begun(motion):
        spin, speed = motion[:3], motion[3]
        r = state.x[body] - state.x[body].mean(0)
        v = state.v.at[body].set(r @ skew(spin).T + speed * jnp.array([1.0, 0.1, 0.0]))
        return dataclasses.replace(state, v=v, C=state.C.at[body].set(skew(spin)))

    def measured(end):
        turned = end.F[body[0], 0, 1] + end.F[body[0], 2, 1]
        return turned + (end.v.mean(0) @ jnp.array([1.0, 2.0, 3.0])) + end.v[-1, 0]

    @quick_jit
    @jax.grad
    def gradient(motion):
        advance = jax.checkpoint(lambda s, _: (step(model, s), None))
        return measured(jax.lax.scan(advance, begun(motion), None, length=90)[0])

    eps = 1e-5 * jnp.eye(4)
    for at in (jnp.array([0.5, -1.0, 2.0, 1.2]), jnp.array([0.0, 0.0, 0.0, 1.2])):  # also from no spin at all
        ends = [[measured(run(model, begun(at + sign * e), 90)) for e in eps] for sign in (1, -1)]
        difference = (jnp.array(ends[0]) - jnp.array(ends[1])) / 2e-5
        assert float(jnp.abs(difference).min()) > 1e-4
        np.testing.assert_allclose(gradient(at), difference, rtol=1e-5, atol=1e-8)


def test_global_damping_slows_a_rigid_body_too(x64):
    """v(t) = v0 exp(-rate t) in free space, as for any other matter."""
    model, state, _ = rigid_above_soft(0.35, gravity=jnp.zeros(3), damping_rate=5.0)
    state = dataclasses.replace(state, v=state.v.at[:, 0].set(1.0))
    end = run(model, state, 100)
    np.testing.assert_allclose(end.v[:, 0], np.exp(-0.5), rtol=1e-9)
