"""Prescribed particle motions: exact paths, firm clamps, windows."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
from scipy.spatial.transform import Rotation

from physagent_jax.mpm import PrescribedMotion, step
from tests.mpm.blocks import block


def run(model, state, steps):
    return jax.jit(lambda s: jax.lax.fori_loop(0, steps, lambda _, s: step(model, s), s))(state)


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
    held = np.flatnonzero(np.asarray(state.x[:, 0]) < 0.4)
    clamped = model.replace(constraints=(PrescribedMotion.fixed(jnp.asarray(held), jnp.float64),))
    end = run(clamped, state, 800)
    np.testing.assert_array_equal(end.x[held], state.x[held])
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
