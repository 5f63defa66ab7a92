"""Prescribed particle motions: exact paths, firm clamps, windows."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physagent_jax.mpm import PrescribedMotion, RigidBody, step
from physagent_jax.mpm.constraints import GradedTranslation, rotate
from tests.mpm.blocks import block

# Small blocks, whose programs take longer to compile than to run.
pytestmark = pytest.mark.usefixtures("least_optimised")


@jax.jit
def run(model, state, steps):
    return jax.lax.fori_loop(0, steps, lambda _, s: step(model, s), state)


def motion(particles, velocity=(0, 0, 0), angular=(0, 0, 0), center=(0.5, 0.5, 0.5), start=0.0, end=1e9):
    return PrescribedMotion(
        jnp.asarray(particles, jnp.int32),
        *(jnp.asarray(a, jnp.float64) for a in (velocity, angular, center, start, end)),
    )


def test_fixed_particles_never_move_and_hold_the_rest(x64):
    model, state = block(
        (8, 2, 2),
        low=(0.3, 0.45, 0.45),
        youngs_modulus=1e6,
        dt=5e-4,
        dtype=np.float64,
        gravity=jnp.array([0.0, 0.0, -1.0]),
    )
    root = np.flatnonzero(np.asarray(state.x[:, 0]) < 0.4)
    clamped = model.replace(constraints=(PrescribedMotion.fixed(jnp.asarray(root), jnp.float64),))
    end = run(clamped, state, 800)
    np.testing.assert_array_equal(end.x[root], state.x[root])
    sag = float((end.x - state.x)[:, 2].min())
    assert -0.08 < sag < 0  # the free block would have fallen 0.08 m
    # Euler-Bernoulli tip deflection q L^4 / 8 EI of the free length 0.3, at most doubled dynamically.
    static = 1000 * 0.1 * 0.1 * 1.0 * 0.3**4 / (8 * 1e6 * 0.1**4 / 12)
    assert 0.3 * static < -sag < 2.5 * static


def test_translation_is_exact_and_ends_with_its_window(x64):
    model, state = block(dtype=np.float64, dt=1e-3)
    particles = np.arange(len(state.x))
    moved = run(model.replace(constraints=(motion(particles, velocity=(0.2, 0, 0.1), end=0.1),)), state, 100)
    np.testing.assert_allclose(moved.x - state.x, np.broadcast_to([0.02, 0, 0.01], state.x.shape), atol=1e-12)
    np.testing.assert_allclose(moved.F, np.broadcast_to(np.eye(3), moved.F.shape), atol=1e-12)


def test_velocities_follow_each_other_in_equal_parts_of_the_window(x64):
    model, state = block(dtype=np.float64, dt=1e-3)
    paces = [[0.2, 0, 0], [0, 0, 0.1], [0, -0.3, 0], [0.1, 0, 0]]
    led = motion(np.arange(len(state.x)), velocity=paces, start=0.02, end=0.1)
    for steps, way in ((20, 0), (40, [0.004, 0, 0]), (50, [0.004, 0, 0.001]), (100, [0.006, -0.006, 0.002])):
        moved = run(model.replace(constraints=(led,)), state, steps)
        np.testing.assert_allclose(moved.x - state.x, np.broadcast_to(way, state.x.shape), atol=1e-12)
    before = np.asarray(led.prescribe(model, state.x))
    np.testing.assert_allclose(before, np.broadcast_to(paces[0], before.shape))


def test_a_turn_about_some_of_the_particles_leaves_these_where_they_are(x64):
    model, state = block(dtype=np.float64, dt=1e-3)
    edge = np.asarray(state.x[:, 2] == state.x[:, 2].min())
    turn = dataclasses.replace(
        motion(np.arange(len(edge)), angular=(1.0, 0, 0)), center=None, about=jnp.asarray(edge, jnp.float64)
    )
    turned = run(model.replace(constraints=(turn,)), state, 100)
    stayed, moved = ((turned.x - state.x)[each].mean(0) for each in (edge, ~edge))
    np.testing.assert_allclose(stayed, 0, atol=1e-12)
    height = float(state.x[~edge, 2].mean() - state.x[edge, 2].mean())
    np.testing.assert_allclose(moved, [0, -height * np.sin(0.1), height * (np.cos(0.1) - 1)], atol=1e-12)


@pytest.mark.parametrize("kind", [motion, RigidBody])
def test_an_index_beyond_the_last_particle_stands_for_none(kind, x64):
    """Right beside the last particle, whose mass and motion a careless lookup would take for that of none."""
    model, state = block((3, 2, 2), dtype=np.float64, dt=1e-3, gravity=jnp.array([0.0, 0.0, -10.0]))
    state, count = dataclasses.replace(state, v=20 * (state.x - 0.45)[:, ::-1]), len(state.x)
    indices = np.arange(count - 12, count - 2)
    lists = indices, np.append(indices, [count] * 6)
    exact, filled = (
        run(model.replace(constraints=(kind(jnp.asarray(places, jnp.int32)),)), state, 40) for places in lists
    )
    assert np.abs(exact.x - run(model, state, 40).x).max() > 1e-4
    np.testing.assert_allclose(filled.x, exact.x, rtol=0, atol=1e-15)
    np.testing.assert_allclose(filled.F, exact.F, rtol=0, atol=1e-14)


def test_rotation_follows_the_circle_exactly(x64):
    model, state = block(dtype=np.float64, dt=1e-3)
    particles, omega = np.arange(len(state.x)), np.array([0.0, 0.0, 3.0])
    end = run(model.replace(constraints=(motion(particles, angular=omega),)), state, 500)
    centre = np.full(3, 0.5)
    exact = Rotation.from_rotvec(omega * 0.5).apply(np.asarray(state.x) - centre) + centre
    np.testing.assert_allclose(end.x, exact, atol=1e-10)
    interior = np.linalg.norm(np.asarray(state.x) - centre, axis=1) < 0.05
    R = Rotation.from_rotvec(omega * 0.5).as_matrix()
    # F is integrated with I + dt grad v, which inflates a rotation by omega^2 dt^2 / 2 per step.
    np.testing.assert_allclose(
        np.asarray(end.F)[interior], np.broadcast_to(R, end.F[interior].shape), atol=3e-3
    )


def test_opposed_translations_stretch_the_block(x64):
    model, state = block((8, 3, 3), low=(0.3, 0.42, 0.42), dtype=np.float64, dt=5e-4, youngs_modulus=1e4)
    x = np.asarray(state.x[:, 0])
    ends = (
        motion(np.flatnonzero(x < 0.35), velocity=(-0.2, 0, 0)),
        motion(np.flatnonzero(x > 0.65), velocity=(0.2, 0, 0)),
    )
    end = run(model.replace(constraints=ends), state, 400)
    middle = np.abs(x - 0.5) < 0.05
    stretch = float(end.F[middle, 0, 0].mean())
    assert 1.2 < stretch < 1.36  # 0.08 m over a free length of 0.3 m: 1.27
    np.testing.assert_allclose(float(end.x.mean() - state.x.mean()), 0, atol=2e-5)


def test_inactive_constraints_change_nothing(x64):
    model, state = block(dtype=np.float64, dt=1e-3)
    state = dataclasses.replace(state, v=0.1 * jnp.sin(9 * state.x))
    late = model.replace(constraints=(motion(np.arange(20), start=5.0),))
    np.testing.assert_allclose(run(late, state, 50).x, run(model, state, 50).x, atol=1e-15)


# --- release one after another ------------------------------------------------------------------------

RELEASED_AFTER = np.array([40, 80, 120])  # steps
GAP = 0.2  # four cells: the layers share no node


def three_layers(dt=1e-3, g=2.0):
    """Three layers that share no node, held by one constraint with a release time per particle."""
    model, state = block(
        (6, 2, 9), low=(0.3, 0.45, 0.4), dtype=np.float64, dt=dt, gravity=jnp.array([0, 0, -g])
    )
    x = np.asarray(state.x)
    layer = np.round((x[:, 2] - 0.4125) / GAP).astype(int)
    keep = np.flatnonzero(np.abs(x[:, 2] - 0.4125 - GAP * layer) < 0.03)
    solid = jax.tree.map(lambda a: a[keep], model.materials[0])
    model = model.replace(mass=model.mass[keep], volume=model.volume[keep], materials=(solid,))
    state = dataclasses.replace(state, **{name: getattr(state, name)[keep] for name in ("x", "v", "C", "F")})
    layer = layer[keep]
    ends = (RELEASED_AFTER[layer] - 0.5) * dt
    release = motion(np.arange(len(keep)), end=ends)
    return model.replace(constraints=(release,)), state, layer


def test_each_layer_falls_exactly_from_its_release_on(x64):
    model, state, layer = three_layers()
    assert sorted(set(layer)) == [0, 1, 2]
    end = run(model, state, 160)
    free_steps = (160 - RELEASED_AFTER)[layer]
    fall = 2.0 * 1e-3**2 * free_steps * (free_steps + 1) / 2
    np.testing.assert_allclose(np.asarray(state.x - end.x)[:, 2], fall, atol=1e-12)
    np.testing.assert_allclose(end.v[:, 2], -2.0 * 1e-3 * free_steps, atol=1e-11)
    partway = run(model, state, 100)  # the last layer is still where it was
    np.testing.assert_array_equal(partway.x[layer == 2], state.x[layer == 2])


def test_one_constraint_with_release_times_is_as_good_as_one_per_layer(x64):
    model, state, layer = three_layers()
    single = model.constraints[0]
    split = tuple(
        motion(np.flatnonzero(layer == i), end=np.asarray(single.end)[layer == i][0]) for i in range(3)
    )
    np.testing.assert_allclose(
        run(model.replace(constraints=split), state, 160).x, run(model, state, 160).x, atol=1e-14
    )


def test_particles_let_go_no_longer_clamp_the_nodes_they_share(x64):
    """Holding half of a block is the same whether the other half was let go before or never held."""
    model, state = block(dtype=np.float64, dt=5e-4, gravity=jnp.array([0.0, 0.0, -3.0]))
    everything, low = np.arange(len(state.x)), np.asarray(state.x)[:, 2] < 0.5
    released = motion(everything, end=np.where(low, 1e9, 0.0))
    half = motion(everything[low])
    ends = [run(model.replace(constraints=(c,)), state, 100) for c in (released, half)]
    np.testing.assert_allclose(ends[0].x, ends[1].x, atol=1e-15)
    assert float(jnp.abs(ends[0].x - state.x).max()) > 1e-4  # the upper half did sag


# --- rotations ---------------------------------------------------------------------------------------


def test_rotations_agree_with_scipy_at_any_angle(x64):
    x = np.random.default_rng(0).normal(size=(5, 3))
    for angle in (0.0, 1e-9, 1e-3, 0.00999, 0.01001, 0.5, 3.0, 7.0):
        vector = angle * np.array([0.6, 0.0, -0.8])
        np.testing.assert_allclose(
            rotate(jnp.asarray(x), jnp.asarray(vector)), Rotation.from_rotvec(vector).apply(x), atol=2e-15
        )


def test_a_rotation_of_zero_has_the_derivative_of_a_small_one(x64):
    x = jnp.array([1.0, 2.0, 3.0])
    for at in (jnp.zeros(3), jnp.array([0.004, 0.003, -0.005]), jnp.array([0.3, -1.0, 0.2])):
        derivative = jax.jacfwd(rotate, argnums=1)(x, at)
        eps = 1e-6
        for k, unit in enumerate(np.eye(3)):
            difference = (rotate(x, at + eps * unit) - rotate(x, at - eps * unit)) / (2 * eps)
            np.testing.assert_allclose(derivative[:, k], difference, atol=1e-8)


def test_what_is_rigid_is_not_strained_by_what_it_leaves_behind(x64):
    """Half of a block is lifted off the other half, which is held, and turned; F^T F stays the identity in both."""
    model, state = block((4, 4, 4), dtype=np.float64, dt=1e-3)
    upper = np.asarray(state.x)[:, 2] > float(state.x[:, 2].mean())
    turned = np.array([0.0, 0.0, 2.0])
    for rigid in (True, False):
        lifted = dataclasses.replace(
            motion(np.flatnonzero(upper), velocity=(0, 0, 1.0), angular=turned), rigid=rigid
        )
        held = PrescribedMotion.fixed(jnp.asarray(np.flatnonzero(~upper)), jnp.float64, rigid=rigid)
        end = run(model.replace(constraints=(lifted, held)), state, 100)
        strain = np.abs(np.swapaxes(end.F, 1, 2) @ np.asarray(end.F) - np.eye(3)).max()
        assert strain < 1e-12 if rigid else strain > 0.1
        if rigid:
            wanted = Rotation.from_rotvec(turned * 0.1).as_matrix()
            np.testing.assert_allclose(end.F[upper], np.broadcast_to(wanted, end.F[upper].shape), atol=1e-12)


def test_what_is_carried_turns_on_what_flies(x64):
    """A limb turns by its angle about a joint that goes with the body, and the two fall together."""
    model, state = block(
        (8, 2, 2), low=(0.3, 0.45, 0.45), dtype=np.float64, dt=1e-3, gravity=jnp.array([0, 0, -9.8])
    )
    state = dataclasses.replace(state, v=jnp.broadcast_to(jnp.asarray([0.3, 0.0, 0.5]), state.v.shape))
    x, limb = np.asarray(state.x), np.asarray(state.x[:, 0]) > 0.5
    joint = np.array([0.5, 0.5, 0.5]) - x[~limb].mean(0)
    end = jnp.where(limb, 1e9, 0.0)
    turn = motion(np.arange(len(x)), angular=(0, 3.0, 0), center=joint, end=end)
    turn = dataclasses.replace(turn, about=jnp.asarray(~limb, jnp.float64), carried=True)
    moved = run(model.replace(constraints=(turn,)), state, 100)
    middle = np.asarray(moved.x)[~limb].mean(0)
    turned = Rotation.from_rotvec([0, 0.3, 0]).apply(x[limb] - x[~limb].mean(0) - joint) + joint
    np.testing.assert_allclose(np.asarray(moved.x)[limb] - middle, turned, atol=1e-9)
    assert middle[0] - x[~limb].mean(0)[0] == pytest.approx(0.03, abs=0.01)
    assert np.asarray(moved.v)[limb, 2].mean() < 0.5 - 0.5 * 9.8 * 0.1


def test_what_is_carried_turns_with_what_turns(x64):
    """Without a motion of its own it goes as if it were a piece of the rest."""
    model, state = block((8, 2, 2), low=(0.3, 0.45, 0.45), youngs_modulus=1e6, dt=1e-3, dtype=np.float64)
    spin, limb = [0.3, 0.0, 2.0], np.asarray(state.x[:, 0]) > 0.55
    led, rest = np.flatnonzero(limb), np.flatnonzero(~limb)
    pivot, order = jnp.asarray([0.55, 0.5, 0.5]), np.concatenate([led, rest])
    mean = np.asarray(state.x)[rest].mean(0)
    carried = dataclasses.replace(
        motion(order, center=pivot - mean, end=np.where(np.arange(len(order)) < len(led), 1e9, -1.0)),
        about=jnp.asarray(np.arange(len(order)) >= len(led), jnp.float64),
        turns=jnp.asarray([[*spin, 0.0, 0.05]]),
        carried=True,
    )
    whole = motion(np.arange(len(state.x)), angular=spin, end=0.05)
    moved = run(model.replace(constraints=(whole, carried)), state, 50)
    plain = run(model.replace(constraints=(whole,)), state, 50)
    np.testing.assert_allclose(moved.x, plain.x, atol=1e-4)


def test_particles_go_with_their_share(x64):
    """Each turns about the centre by its share of the angle, exactly; what has none of it is held."""
    model, state = block((8, 2, 2), low=(0.3, 0.45, 0.45), dtype=np.float64, dt=1e-3)
    share = np.linspace(0.0, 1.0, len(state.x))
    turn = motion(np.arange(len(state.x)), angular=(0, 0, 4.0))
    moved = run(model.replace(constraints=(dataclasses.replace(turn, share=jnp.asarray(share)),)), state, 100)
    expected = [
        Rotation.from_rotvec([0, 0, 0.4 * s]).apply(x - 0.5) + 0.5 for s, x in zip(share, np.asarray(state.x))
    ]
    np.testing.assert_allclose(moved.x, expected, atol=1e-9)
    np.testing.assert_array_equal(moved.x[0], state.x[0])


@pytest.mark.parametrize(("stretching", "rate"), [(3.0, 0.5), (0.2, 0.2), (-1.0, -1.0)])
def test_a_limit_of_growth_makes_it_even_and_no_faster(stretching, rate, x64):
    """Whatever trembles beside that is taken out in both senses, so that it is not held down."""
    model, state = block((4, 4, 8), dtype=np.float64, dt=1e-3)
    numbers = dict(start=0.0, end=1.0, speed=0.5 * 0.2, length=0.2)
    low = state.x.min(0)
    limit = GradedTranslation(
        axis=jnp.array([0.0, 0, 1]), point=low, limits=True, **{k: jnp.asarray(v) for k, v in numbers.items()}
    )
    nodes = model.grid.place_nodes(jnp.float64)
    arm = (nodes - low)[..., 2]
    mass = jnp.where((arm >= 0) & (arm <= 0.2), 1.0, 0.0)
    tremble = jnp.where(jnp.arange(arm.shape[2]) % 2 == 0, 0.4, -0.4) * mass
    even = (mass * arm * tremble).sum() / (mass * arm**2).sum()
    velocity = jnp.zeros_like(nodes).at[..., 2].set((stretching - even) * arm + tremble)
    change = limit.find_change(nodes, velocity, low, jnp.asarray(0.0), mass)
    np.testing.assert_allclose((velocity + change)[..., 2], rate * arm, atol=1e-9)
