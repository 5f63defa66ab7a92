"""Spheres, boxes, signed distances and moving obstacles against geometry and the laws of motion."""

import dataclasses
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.mpm import Box, Contact, Cuboid, Grid, HalfSpace, SignedDistance, Sphere, step
from tests.mpm.blocks import block

G = 9.8
UP = np.array([0.0, 0.0, 1.0])


def always(friction=0.0, start=0.0, end=1e9):
    return dict(friction=jnp.asarray(friction), start=jnp.asarray(start), end=jnp.asarray(end))


def ball(centre=(0.5, 0.5, 0.5), radius=0.2, friction=0.0, **options):
    return Sphere(jnp.asarray(centre), jnp.asarray(radius), **always(friction), **options)


def sampled_ball(centre=(0.5, 0.5, 0.5), radius=0.2, spacing=0.05, friction=0.0, shift=0.0, **options):
    """The same ball as samples of its distance, 4 beyond its surface."""
    first = np.floor((np.asarray(centre) - radius) / spacing).astype(int) - 4
    count = int(2 * radius / spacing) + 10
    origin = (first + shift) * spacing
    nodes = np.stack(np.meshgrid(*[o + spacing * np.arange(count) for o in origin], indexing="ij"), -1)
    phi = np.linalg.norm(nodes - np.asarray(centre), axis=-1) - radius
    return SignedDistance(
        jnp.asarray(phi), jnp.asarray(origin), spacing=spacing, **always(friction), **options
    )


def crate(centre=(0.5, 0.5, 0.5), half=(0.1, 0.2, 0.1), friction=0.0, **options):
    return Box(jnp.asarray(centre), jnp.asarray(half), **always(friction), **options)


@partial(jax.jit, static_argnames="steps")
def record(model, state, steps):
    """Positions and velocities after every step, shapes (steps, n, 3)."""

    def advance(state, _):
        state = step(model, state)
        return state, (state.x, state.v)

    return jax.lax.scan(advance, state, None, length=steps)[1]


def simulate_block(obstacles, velocity=(0, 0, 0), *, low, g=G, steps=300, **options):
    """Positions and velocities, as NumPy arrays, of a small block that was thrown at some obstacles."""
    model, state = block(
        (2, 2, 2),
        low=low,
        dtype=np.float64,
        gravity=-g * UP,
        boundaries=obstacles,
        **{"size": 0.8, "grid_cells": 16, "youngs_modulus": 2e4, **options},
    )
    v = jnp.broadcast_to(jnp.asarray(velocity, state.v.dtype), state.v.shape)
    x, v = record(model, dataclasses.replace(state, v=v), steps)
    return np.asarray(state.x), np.asarray(x), np.asarray(v)


@jax.jit
def applied(obstacle, field, grid, time):
    return obstacle.apply(field, grid, time)


def at_nodes(obstacle, velocity, grid, time=0.0):
    """The result of one velocity at every node, and the nodes' positions."""
    field = jnp.broadcast_to(jnp.asarray(velocity), (*grid.shape, 3))
    nodes = np.stack(np.broadcast_arrays(*grid.node_positions(field.dtype)), axis=-1)
    return np.asarray(applied(obstacle, field, grid, jnp.asarray(time))), nodes


# --- moving obstacles --------------------------------------------------------------------------------


@pytest.mark.parametrize("contact", list(Contact))
@pytest.mark.parametrize("make", [ball, crate, sampled_ball])
def test_contact_looks_the_same_from_a_moving_frame(make, contact, x64):
    """At the time at which it set out, a moving obstacle differs from one at rest by its velocity alone."""
    grid, carried = Grid.whole(1.0, 20), jnp.array([0.3, -0.4, 0.2])
    velocity = jax.random.normal(jax.random.key(0), (*grid.shape, 3), jnp.float64)
    at_rest = applied(make(friction=0.4, contact=contact), velocity, grid, jnp.asarray(0.0))
    moving = make(friction=0.4, contact=contact, velocity=carried)
    seen = applied(moving, velocity + carried, grid, jnp.asarray(0.0))
    np.testing.assert_allclose(seen, at_rest + carried, atol=1e-14)
    assert (np.asarray(at_rest) != np.asarray(velocity)).any()


@pytest.mark.parametrize("make", [ball, crate, sampled_ball])
def test_a_moving_obstacle_is_where_its_velocity_takes_it(make, x64):
    grid, velocity = Grid.whole(1.0, 20), jnp.array([0.2, 0.0, -0.1])
    sticky = dict(contact=Contact.STICKY)
    later, _ = at_nodes(make(velocity=velocity, **sticky), [0.0, 0.0, 9.0], grid, time=0.5)
    there, _ = at_nodes(make(centre=(0.6, 0.5, 0.45), **sticky), [0.0, 0.0, 9.0], grid)
    np.testing.assert_array_equal(later[..., 2] < 9, there[..., 2] < 9)
    inside = later[later[..., 2] < 9]
    np.testing.assert_allclose(inside, np.broadcast_to(velocity, inside.shape), atol=1e-15)


def floor(mu, velocity):
    velocity = jnp.asarray(velocity, jnp.float64)
    return HalfSpace(jnp.array([0.0, 0.0, 0.2]), jnp.asarray(UP), **always(mu), velocity=velocity)


def test_a_conveyor_belt_drags_by_friction_until_the_block_rides_with_it(x64):
    """Coulomb: v = mu g t while it slips, then the belt's speed; friction sees the relative velocity."""
    speed, mu = 0.5, 0.3
    _, _, v = simulate_block((floor(mu, [speed, 0, 0]),), low=(0.2, 0.3, 0.2))
    np.testing.assert_allclose(v[99, :, 0].mean(), mu * G * 0.1, rtol=0.03)
    np.testing.assert_allclose(v[250:, :, 0].mean(), speed, rtol=0.02)


def test_a_rising_floor_lifts_at_its_own_speed(x64):
    _, x, _ = simulate_block((floor(0.0, [0, 0, 0.5]),), low=(0.3, 0.3, 0.2), youngs_modulus=2e5)
    np.testing.assert_allclose((x[299] - x[99])[:, 2].mean(), 0.5 * 0.2, rtol=0.03)


def test_a_block_thrown_off_a_plane_flies_as_if_there_were_none(x64):
    """No adhesion at all: the exact discrete parabola to the last digit."""
    start, x, v = simulate_block((floor(0.5, [0, 0, 0]),), [0.3, 0.0, 1.0], low=(0.2, 0.3, 0.2))
    n, dt = 100, 1e-3
    flown = n * dt * np.array([0.3, 0, 1.0]) - G * UP * dt**2 * n * (n + 1) / 2
    np.testing.assert_allclose(x[n - 1], start + flown, atol=1e-13)


# --- spheres -----------------------------------------------------------------------------------------


def test_a_ball_takes_only_the_normal_part_inside_it(x64):
    grid, velocity = Grid.whole(1.0, 20), np.array([0.2, -1.0, 0.5])
    after, nodes = at_nodes(ball(radius=0.23), velocity, grid)
    offset = nodes - 0.5
    distance = np.linalg.norm(offset, axis=-1)
    normal = offset / np.maximum(distance, 1e-12)[..., None]
    inwards = np.minimum(normal @ velocity, 0) * (distance <= 0.23)
    off_centre = distance > 1e-6  # where there is no normal
    np.testing.assert_allclose(
        after[off_centre], (velocity - inwards[..., None] * normal)[off_centre], atol=1e-12
    )


def test_a_node_on_the_surface_is_in_contact():
    """In single precision too: a sphere about a node, through nodes."""
    after, nodes = at_nodes(ball(radius=0.3, contact=Contact.STICKY), [0.0, 0.0, -1.0], Grid.whole(1.0, 20))
    distance = np.linalg.norm(nodes - 0.5, axis=-1)
    np.testing.assert_array_equal(after[..., 2] == 0, distance < 0.3 + 1e-5)


@pytest.mark.parametrize("make", [ball, sampled_ball])
def test_matter_that_falls_on_a_ball_does_not_enter_it(make, x64):
    centre = np.array([0.42, 0.38, 0.25])
    _, x, _ = simulate_block((make(centre=centre, radius=0.2),), low=(0.35, 0.35, 0.47))
    nearest = np.linalg.norm(x - centre, axis=-1).min()
    assert 0.18 < nearest < 0.22  # it came down on it, and at most two fifths of a cell deep


def test_a_frictionless_bowl_is_a_pendulum(x64):
    """A block that slides down a spherical bowl gains sqrt(2 g h), and stays in."""
    radius, centre = 0.45, 0.55
    bowl = ball(centre=(centre, centre, centre), radius=radius, container=True)
    start, x, v = simulate_block(
        (bowl,), low=(0.179, 0.525, 0.325), size=1.1, grid_cells=44, steps=500, youngs_modulus=1e5
    )
    bottom = int(np.argmax(x[:, :, 0].mean(1) > centre))
    assert bottom > 0
    fallen = (start - x[bottom])[:, 2].mean()
    assert fallen > 0.2
    np.testing.assert_allclose(np.linalg.norm(v[bottom].mean(0)), np.sqrt(2 * G * fallen), rtol=0.06)
    assert np.linalg.norm(x - centre, axis=-1).max() < radius


# --- boxes -------------------------------------------------------------------------------------------


def test_the_nearest_face_of_a_box_gives_the_normal():
    grid = Grid.whole(1.0, 20)
    obstacle = crate(half=(0.11, 0.21, 0.16))
    after, nodes = at_nodes(obstacle, [-1.0, -2.0, -3.0], grid)
    at = {
        tuple(np.round(node, 3)): v
        for node, v in zip(nodes.astype(float).reshape(-1, 3), after.reshape(-1, 3))
    }
    np.testing.assert_allclose(at[0.6, 0.5, 0.5], [0, -2, -3])  # under the +x face
    np.testing.assert_allclose(at[0.5, 0.7, 0.5], [-1, 0, -3])  # under the +y face
    np.testing.assert_allclose(at[0.5, 0.5, 0.65], [-1, -2, 0])  # under the +z face
    np.testing.assert_allclose(at[0.4, 0.5, 0.5], [-1, -2, -3])  # leaving through the -x face
    np.testing.assert_allclose(at[0.65, 0.5, 0.5], [-1, -2, -3])  # outside
    np.testing.assert_allclose(at[0.5, 0.5, 0.7], [-1, -2, -3])


@pytest.mark.parametrize(("axis", "low"), [(0, (0.55, 0.35, 0.35)), (2, (0.35, 0.35, 0.55))])
def test_a_box_stops_what_comes_from_any_side_and_lets_it_slide_along(axis, low, x64):
    obstacle = crate(centre=(0.4, 0.4, 0.4), half=(0.1, 0.1, 0.1))
    towards = -0.5 * np.eye(3)[axis] + np.array([0.0, 0.1, 0.0])
    start, x, _ = simulate_block((obstacle,), towards, low=low, g=0.0)
    assert 0.495 < x[:, :, axis].min() < 0.55  # within a cell of the face
    np.testing.assert_allclose((x[-1] - start)[:, 1].mean(), 0.1 * 0.3, rtol=1e-2)


def test_the_corners_of_a_container_are_tight(x64):
    hollow = crate(centre=(0.4, 0.4, 0.4), half=(0.25, 0.25, 0.25), container=True)
    _, x, _ = simulate_block((hollow,), [0.8, 0.8, 0.8], low=(0.5, 0.5, 0.5), g=0.0)
    assert 0.59 < x.max() < 0.655  # it did get there, and no farther


# --- signed distances --------------------------------------------------------------------------------


def test_interpolated_distance_and_normal_are_second_order(x64):
    """Near a sphere, at points that are no samples."""
    points = np.linspace(0.21, 0.83, 23)
    nodes = np.stack(np.meshgrid(points, points, points, indexing="ij"), axis=-1)
    shape = [(23, 1, 1), (1, 23, 1), (1, 1, 23)]
    offset = nodes - 0.5
    exact = np.linalg.norm(offset, axis=-1) - 0.2
    near = np.abs(exact) < 0.06
    errors = []
    for spacing in (0.05, 0.025, 0.0125):
        obstacle = sampled_ball(spacing=spacing, shift=0.37)
        phi, normal = jax.jit(type(obstacle).distance_and_normal)(
            obstacle, tuple(jnp.asarray(points).reshape(s) for s in shape), jnp.asarray(0.0)
        )
        true_normal = offset / np.linalg.norm(offset, axis=-1, keepdims=True)
        errors.append(
            (np.abs(phi - exact)[near].max(), np.linalg.norm(normal - true_normal, axis=-1)[near].max())
        )
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert (orders[-1] > 1.75).all(), orders
    assert errors[1][0] < 0.1 * 0.025


def test_samples_on_the_nodes_act_as_the_shape_itself(x64):
    """Samples that lie on the nodes leave only the normal approximate."""
    grid = Grid.whole(1.0, 20)
    velocity = jax.random.normal(jax.random.key(1), (*grid.shape, 3), jnp.float64)
    radius = 0.23
    ours = applied(sampled_ball(radius=radius, friction=0.3), velocity, grid, jnp.asarray(0.0))
    exact = applied(ball(radius=radius, friction=0.3), velocity, grid, jnp.asarray(0.0))
    nodes = np.stack(np.broadcast_arrays(*grid.node_positions(jnp.float64)), axis=-1)
    distance = np.linalg.norm(nodes - 0.5, axis=-1)
    np.testing.assert_array_equal((ours == velocity).all(-1)[distance > radius], True)
    shell = (distance <= radius) & (distance > radius - 0.06)
    assert np.abs(ours - exact)[shell].mean() < 0.02


def test_a_block_rebounds_from_a_sampled_ball_as_from_a_ball(x64):
    centre = (0.42, 0.38, 0.25)
    exact = ball(centre=centre, radius=0.2)
    finer = sampled_ball(centre=centre, radius=0.2, spacing=0.025, shift=0.3)
    (_, x, v), (_, y, w) = (simulate_block((o,), -UP, low=(0.37, 0.37, 0.5), g=0.0) for o in (exact, finer))
    assert v[-1, :, 2].mean() > 0.1  # it came back
    np.testing.assert_allclose(y[-1].mean(0), x[-1].mean(0), atol=2e-3)
    np.testing.assert_allclose(w[-1].mean(0), v[-1].mean(0), atol=2e-2)


def test_beyond_its_samples_a_signed_distance_is_what_it_is_at_their_edge():
    after, nodes = at_nodes(
        sampled_ball(radius=0.1, contact=Contact.STICKY), [1.0, 1.0, 1.0], Grid.whole(4.0, 80)
    )
    distance = np.linalg.norm(nodes - 0.5, axis=-1)
    np.testing.assert_array_equal(after[..., 0] == 0, distance < 0.1 + 1e-5)


# --- all of them -------------------------------------------------------------------------------------

SHAPES = {
    "half space": HalfSpace(jnp.full(3, 0.4), jnp.array([0.0, 0.6, 0.8]), **always(), contact=Contact.STICKY),
    "sphere": ball(contact=Contact.STICKY),
    "hollow sphere": ball(contact=Contact.STICKY, container=True),
    "box": crate(contact=Contact.STICKY),
    "hollow box": crate(contact=Contact.STICKY, container=True),
    "signed distance": sampled_ball(contact=Contact.STICKY),
    "cuboid": Cuboid(jnp.full(3, 0.5), jnp.full(3, 0.2), jnp.zeros(3), jnp.zeros(()), jnp.asarray(1e9)),
}


@pytest.mark.parametrize("name", SHAPES)
def test_windows_open_at_their_start_and_close_before_their_end(name):
    obstacle = dataclasses.replace(SHAPES[name], start=jnp.asarray(0.25), end=jnp.asarray(0.5))
    for time, active in (
        (0.0, False),
        (0.2499, False),
        (0.25, True),
        (0.4999, True),
        (0.5, False),
        (9.0, False),
    ):
        after, _ = at_nodes(obstacle, [0.0, 1.0, 0.0], Grid.whole(1.0, 10), time)
        assert (after[..., 1] != 1).any() == active, time


@pytest.mark.parametrize("name", SHAPES)
def test_velocities_keep_the_particles_precision(name):
    after, _ = at_nodes(SHAPES[name], jnp.array([0.0, 1.0, 0.0], jnp.float32), Grid.whole(1.0, 10))
    assert after.dtype == np.float32 and np.isfinite(after).all()


# --- gradients ---------------------------------------------------------------------------------------


def test_gradients_through_contact_agree_with_finite_differences(x64):
    """By friction, the belt's velocity, the throw and gravity: on a belt that the block has not caught up with."""
    model, state = block(
        (2, 2, 2), low=(0.2, 0.3, 0.2), dtype=np.float64, size=0.8, grid_cells=16, youngs_modulus=2e4
    )

    def outcome(parameters):
        mu, belt, thrown, g = parameters
        obstacles = (dataclasses.replace(floor(0.0, [0, 0, 0]), friction=mu, velocity=belt * jnp.eye(3)[0]),)
        driven = model.replace(boundaries=obstacles, gravity=-g * jnp.asarray(UP))
        v = jnp.broadcast_to(thrown * jnp.array([0.2, 0.1, -1.0]), state.v.shape)
        begun = dataclasses.replace(state, v=v)
        end = jax.lax.scan(lambda s, _: (step(driven, s), None), begun, None, length=60)[0]
        return (end.v.mean(0) @ jnp.array([3.0, 1.0, 2.0])) + (end.x[0] ** 2).sum()

    at = jnp.array([0.3, 0.8, 0.4, 9.8])
    reverse, many = jax.jit(jax.grad(outcome))(at), jax.jit(jax.vmap(outcome))
    eps = 1e-6 * jnp.eye(4)
    difference = (many(at + eps) - many(at - eps)) / 2e-6
    assert (np.abs(difference) > 1e-3).all()
    np.testing.assert_allclose(reverse, difference, rtol=1e-5)


@pytest.mark.parametrize("contact", list(Contact))
@pytest.mark.parametrize("name", ["sphere", "box", "signed distance"])
def test_gradients_by_an_obstacles_own_numbers_are_finite_at_rest(name, contact):
    """No velocity at all, a node at the centre of the ball: nothing is divided by zero."""
    grid = Grid.whole(1.0, 10)
    obstacle = dataclasses.replace(SHAPES[name], contact=contact, velocity=jnp.zeros(3))

    def total(obstacle, field):
        return (obstacle.apply(field, grid, jnp.asarray(0.1)) * jnp.arange(3.0)).sum()

    gradients = jax.jit(jax.grad(total, argnums=(0, 1)))(obstacle, jnp.zeros((*grid.shape, 3)))
    assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(gradients))


def test_the_normals_derivative_by_the_samples_is_right(x64):
    """Shape optimisation needs it: d velocity / d phi against finite differences."""
    grid, spacing = Grid.whole(1.0, 10), 0.1
    obstacle = sampled_ball(radius=0.27, spacing=spacing, shift=0.3, friction=0.2)
    velocity = jax.random.normal(jax.random.key(2), (*grid.shape, 3), jnp.float64)
    weights = jax.random.normal(jax.random.key(3), velocity.shape, jnp.float64)
    bump = jax.random.normal(jax.random.key(4), obstacle.values.shape, jnp.float64)

    @jax.jit
    def total(size):
        changed = dataclasses.replace(obstacle, values=obstacle.values + size * bump)
        return (changed.apply(velocity, grid, jnp.asarray(0.0)) * weights).sum()

    difference = (total(1e-7) - total(-1e-7)) / 2e-7
    np.testing.assert_allclose(jax.grad(total)(0.0), difference, rtol=1e-6)
    assert abs(difference) > 0.1
