"""A simulation replayed by its schedule: the same motion, and derivatives that agree with differences."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.forces.terms import UniformAcceleration
from physagent_jax.mpm import Schedule, find_smallest_window, replay, rollout, simulate
from tests.mpm.blocks import block, sums_in_order

pytestmark = pytest.mark.usefixtures(
    "least_optimised"
)  # derivatives of small scenes: to compile takes longest

FRAMES, FRAME_DT = 3, 0.05


def thrown_block():
    """A block thrown at the floor and along it, in a window that follows; in the last frame something pushes it."""
    push = UniformAcceleration(jnp.array([40.0, 0, 0]), jnp.array(0.051), jnp.array(1.0))
    model, state = block(
        (3, 3, 3),
        size=2.0,
        grid_cells=40,
        low=(0.3, 0.4, 0.15),
        youngs_modulus=4e5,
        dtype=np.float64,
        gravity=jnp.array(
            [60.0, 0, -9.8]
        ),  # so that it is faster, and its window larger, in the second frame
        forces=(push,),
    )
    shuffled = np.random.default_rng(0).permutation(len(state.x))  # so that sorting them pays
    v = jnp.broadcast_to(jnp.array([4.0, 0, -3.0]), state.x.shape)
    state = dataclasses.replace(state, x=state.x[shuffled], v=v)
    return model.replace(grid=find_smallest_window(model.grid.dx * model.grid.cells, model.grid.cells)), state


@pytest.fixture(scope="module")
def thrown():
    """The model, its state, the frames simulated, and their schedule."""
    with jax.enable_x64(True):
        model, state = thrown_block()
        frames = list(simulate(model, state, frame_count=FRAMES, frame_dt=FRAME_DT))
        return model, state, frames, Schedule.of(model, frames)


@sums_in_order
def test_it_is_the_motion_that_was_simulated(thrown, x64):
    """A window that grows, sorted particles, a part that does not act in every frame, contact with the floor."""
    model, state, frames, schedule = thrown
    first, second = schedule.frames
    assert first.grid.shape != second.grid.shape and min(first.substeps, second.substeps) > 32
    assert first.order is not None and (first.acting.forces, second.acting.forces) == ((), (0,))
    for got, frame in zip(replay(model, state, schedule), frames[1:], strict=True):
        for name in ("x", "v", "C", "F"):
            np.testing.assert_allclose(
                getattr(got, name), getattr(frame.state, name), rtol=1e-9, atol=1e-9, err_msg=name
            )
    assert float(frames[-1].state.v[:, 2].mean()) > -1.0  # it has met the floor


def test_joined_it_is_the_same_motion_with_one_set_of_what_acts(thrown, x64):
    """A force that does not act yet adds nothing."""
    model, state, _, schedule = thrown
    joined = schedule.joined()
    assert [frame.acting.forces for frame in joined.frames] == [(0,), (0,)]
    for one, other in zip(replay(model, state, joined), replay(model, state, schedule), strict=True):
        np.testing.assert_allclose(one.x, other.x, rtol=1e-12)


def test_gradients_agree_with_central_differences_however_little_is_kept(thrown, x64):
    """By gravity, stiffness, a force's magnitude, mass and the initial velocity."""
    model, state, _, schedule = thrown
    weight = jnp.asarray(np.random.default_rng(1).normal(size=state.x.shape))

    def respond(p, memory=2e9):
        law, force = model.materials[0], model.forces[0]
        changed = model.replace(
            gravity=model.gravity * p[0],
            materials=(dataclasses.replace(law, mu=law.mu * p[1], lam=law.lam * p[1]),),
            forces=(dataclasses.replace(force, value=force.value * p[2]),),
            mass=model.mass * (1 + 0.1 * p[3] * weight[:, 0]),
        )
        begun = dataclasses.replace(state, v=state.v * p[4])
        middle, end = replay(changed, begun, schedule, memory=memory)
        return (weight * end.x).sum() + (middle.F[:, 0, 2] ** 2).sum()

    at, h = jnp.ones(5), 1e-6
    slopes = jax.grad(respond)(at)
    few = jax.grad(lambda p: respond(p, memory=2e7))(at)
    differences = [(respond(at.at[i].add(h)) - respond(at.at[i].add(-h))) / (2 * h) for i in range(5)]
    np.testing.assert_allclose(slopes, differences, rtol=1e-6)
    np.testing.assert_allclose(few, slopes, rtol=1e-10)


def test_what_leaves_its_window_is_not_answered(thrown, x64):
    model, state, _, schedule = thrown
    faster = dataclasses.replace(state, v=20 * state.v)
    assert np.isnan(replay(model, faster, schedule)[-1].x).all()


def test_what_cannot_be_replayed_is_refused(thrown):
    model, state, frames, schedule = thrown
    with pytest.raises(UserError, match="all frames from the first on"):
        Schedule.of(model, frames[2:])
    with (
        jax.enable_x64(True),
        pytest.raises(UserError, match="a reverse pass through .* needs .* GB at least"),
    ):
        replay(model, state, schedule, memory=1e5)


def test_what_is_stopped_at_a_wall_has_the_derivative_of_differences(x64):
    """By the speed with which single particles fly at either wall; no boundary acts before the last line of defence."""
    model, state = block((2, 2, 2), low=(0.4, 0.4, 0.85), dtype=np.float64, boundaries=())
    weight = jnp.asarray(np.random.default_rng(2).normal(size=state.x.shape))

    def respond(speed):
        begun = dataclasses.replace(state, v=state.v + speed)
        end, _ = rollout(model, begun, frame_count=1, substeps=10)
        return (weight * end.x).sum() + (weight * end.v).sum(), end.stopped

    at, h = jnp.array([0.3, 0.0, 2.0]), 1e-6
    slope, stopped = jax.grad(respond, has_aux=True)(at)
    assert stopped > 0
    differences = [(respond(at + e)[0] - respond(at - e)[0]) / (2 * h) for e in h * jnp.eye(3)]
    np.testing.assert_allclose(slope, differences, rtol=1e-6, atol=1e-7)


@sums_in_order
def test_a_horizon_is_the_beginning_of_the_whole(thrown, x64):
    model, state, _, schedule = thrown
    (first,) = replay(model, state, schedule, horizon=1)
    whole = replay(model, state, schedule)
    np.testing.assert_array_equal(first.x, whole[0].x)
    for horizon in (0, 3):
        with pytest.raises(UserError, match="`horizon` must be within 1..2"):
            replay(model, state, schedule, horizon=horizon)


@sums_in_order
def test_a_truncated_gradient_takes_the_state_at_each_cut_as_given(thrown, x64):
    """Cut after every frame it is the sum of the frames' own gradients, each from the state that it begins with."""
    model, state, _, schedule = thrown
    weight = jnp.asarray(np.random.default_rng(1).normal(size=state.x.shape))

    def change(p):
        law = model.materials[0]
        softer = dataclasses.replace(law, mu=law.mu * p[0], lam=law.lam * p[0])
        return model.replace(gravity=model.gravity * p[1], materials=(softer,))

    def respond(p, **options):
        begun = dataclasses.replace(state, v=state.v * p[2])
        return sum((weight * each.x).sum() for each in replay(change(p), begun, schedule, **options))

    at = jnp.ones(3)
    full, cut = jax.grad(respond)(at), jax.grad(lambda p: respond(p, truncate=1))(at)
    np.testing.assert_array_equal(jax.grad(lambda p: respond(p, truncate=2))(at), full)
    (middle, _) = replay(model, state, schedule)
    rest = dataclasses.replace(schedule, frames=schedule.frames[1:])

    def respond_apart(p):
        begun = dataclasses.replace(state, v=state.v * p[2])
        (first,) = replay(change(p), begun, schedule, horizon=1)
        (second,) = replay(change(p), middle, rest)
        return (weight * first.x).sum() + (weight * second.x).sum()

    np.testing.assert_allclose(cut, jax.grad(respond_apart)(at), rtol=1e-10)
    assert np.abs(cut - full).max() > 0.1 * np.abs(full).max()
    with pytest.raises(UserError, match="`truncate` must be at least 1"):
        replay(model, state, schedule, truncate=0)


def test_all_frames_share_two_programs_of_a_gradient(caplog):
    """One there, one back: also the first, whose state has no tangents, and the last, of which positions are seen."""
    model, state = block((3, 3, 3), low=(0.4, 0.4, 0.4), gravity=jnp.array([0, 0, -1.0]), boundaries=())
    frames = list(simulate(model, state, frame_count=5, frame_dt=0.004))
    schedule = Schedule.of(model, frames)
    assert len({frame.grid.shape for frame in schedule.frames}) == 1

    def respond(gravity):
        return replay(model.replace(gravity=gravity), state, schedule)[-1].x.sum()

    with jax.log_compiles(), caplog.at_level("WARNING"):
        slope = jax.grad(respond)(model.gravity)
    compiled = [m for m in caplog.messages if "Finished XLA compilation of jit(_advance)" in m]
    assert len(compiled) == 2, compiled
    (dt,), count = {frame.dt for frame in schedule.frames}, schedule.substeps
    fall = dt**2 * count * (count + 1) / 2  # free, velocities first: sum of k dt^2
    np.testing.assert_allclose(slope, len(state.x) * fall, rtol=1e-4)
