"""The frame driver adapts without changing the answer; the pure driver has exact gradients."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.forces.terms import UniformAcceleration
from physagent_jax.mpm import (
    DomainBox,
    Grid,
    NeoHookean,
    find_smallest_window,
    lame_parameters,
    rollout,
    simulate,
    stable_dt,
)
from physagent_jax.mpm.constraints import GradedTranslation
from tests.mpm.blocks import block


def isolated(poissons_ratio, courant):
    """Growth of a lone particle's small strain over 400 steps at ``courant`` times the stable bound."""
    model, state = block(youngs_modulus=1e5, poissons_ratio=poissons_ratio, dtype=np.float64, boundaries=())
    model = model.replace(
        mass=model.mass[:1],
        volume=model.volume[:1],
        materials=(NeoHookean(*(jnp.full(1, a) for a in lame_parameters(1e5, poissons_ratio))),),
    )
    state = jax.tree.map(lambda a: a[:1] if a.ndim else a, state)
    state = dataclasses.replace(state, F=state.F * (1 + 1e-6))
    model = model.replace(dt=courant * stable_dt(model, state))
    end, _ = rollout(model, state, frame_count=1, substeps=400)
    return float(jnp.abs(jnp.linalg.det(end.F) - 1).max())


@pytest.mark.parametrize("poissons_ratio", [0.0, 0.3, 0.45])
def test_the_bound_is_where_a_lone_particle_becomes_unstable(poissons_ratio, x64):
    assert isolated(poissons_ratio, 0.97) < 1e-3
    assert not isolated(poissons_ratio, 1.1) < 1e-3


def falling(frame_count=6, **options):
    model, state = block(
        gravity=jnp.array([0.0, 0.0, -9.8]),
        low=(0.4, 0.4, 0.45),
        dtype=np.float64,
        boundaries=(DomainBox(8),),
    )
    return list(simulate(model, state, frame_count=frame_count, frame_dt=0.02, **options))


def test_the_moving_window_changes_nothing(x64):
    model, state = block(gravity=jnp.array([3.0, 0.0, -9.8]), low=(0.3, 0.4, 0.5), dtype=np.float64)
    small = model.replace(grid=find_smallest_window(1.0, 20))
    whole = list(simulate(model, state, frame_count=8, frame_dt=0.02, substep_dt=1e-3))
    moving = list(simulate(small, state, frame_count=8, frame_dt=0.02, substep_dt=1e-3))
    assert np.prod(moving[-1].grid_shape) < 0.5 * np.prod(whole[-1].grid_shape)
    np.testing.assert_allclose(moving[-1].state.x, whole[-1].state.x, atol=1e-12)


def test_a_run_goes_on_from_any_of_its_frames(x64):
    """State and grid window are all that passes from frame to frame: what follows is the same to the last bit."""
    model, state = block(gravity=jnp.array([3.0, 0.0, -9.8]), low=(0.3, 0.4, 0.5), dtype=np.float64)
    model = model.replace(grid=find_smallest_window(1.0, 20))
    options = dict(frame_count=8, frame_dt=0.02, ledger=True)
    whole = list(simulate(model, state, **options))
    rest = list(simulate(model, state, **options, begin=whole[3]))
    assert [frame.index for frame in rest] == [4, 5, 6, 7]
    for one, other in zip(rest, whole[4:]):
        assert (one.substeps, one.dt, one.min_J, one.max_J) == (
            other.substeps,
            other.dt,
            other.min_J,
            other.max_J,
        )
        parts = [(frame.state, frame.grid, frame.exchange) for frame in (one, other)]
        assert all(np.array_equal(a, b) for a, b in zip(*map(jax.tree.leaves, parts)))


def test_frames_fit_exactly_and_start_with_the_initial_state(x64):
    frames = falling()
    assert [f.index for f in frames] == list(range(6))
    for frame in frames:
        np.testing.assert_allclose(float(frame.state.time), 0.02 * frame.index, rtol=1e-12)
    assert all(f.substeps * f.dt == pytest.approx(0.02) for f in frames[1:])


def test_an_explicit_step_above_the_bound_is_refused(x64):
    with pytest.raises(UserError, match="above the stable bound.*Use `substep_dt` <="):
        falling(substep_dt=0.01)


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Spring:
    """A uniform push that goes off once the block's centre has passed x = 0.311 m."""

    def acceleration(self, x, v, mass, time, dt):
        push = jnp.where(x[:, 0].mean() > 0.311, 3e3, 0.0)
        return jnp.stack([jnp.full(len(x), push), jnp.zeros(len(x)), jnp.zeros(len(x))], -1)

    def gradient(self, x, time, dt):
        return None


def test_a_failing_frame_is_redone_with_smaller_steps(x64):
    """A push that nothing announces cannot be foreseen when the frame's step is chosen."""
    model, state = block(youngs_modulus=2e4, dtype=np.float64, forces=(Spring(),), low=(0.2, 0.4, 0.4))
    state = dataclasses.replace(state, v=state.v.at[:, 0].set(1.0))
    frames = list(simulate(model, state, frame_count=3, frame_dt=0.01, safety=1.0))
    assert "cells in one substep" in frames[2].retries[0] and not frames[1].retries
    assert frames[2].substeps > frames[1].substeps
    fine = list(simulate(model, state, frame_count=3, frame_dt=0.01, substep_dt=1e-4))
    np.testing.assert_allclose(frames[2].state.v[:, 0].mean(), fine[2].state.v[:, 0].mean(), rtol=0.1)


def draw_out():
    """A block that is drawn ever longer: the stable step falls from frame to frame."""
    numbers = dict(start=0.0, end=1.0, speed=3.0, length=0.2)
    leaves = {name: jnp.asarray(value, np.float64) for name, value in numbers.items()}
    drawn = GradedTranslation(axis=jnp.array([1.0, 0, 0], np.float64), **leaves)
    return block(youngs_modulus=1e6, dtype=np.float64, constraints=(drawn,))


def test_a_frame_whose_stable_step_fell_is_redone_with_a_step_that_fits(x64):
    """Not with half of it: the bound at its end is known. The next frames expect that it falls on."""
    frames = list(simulate(*draw_out(), frame_count=4, frame_dt=0.04))
    redone = [frame for frame in frames if frame.retries]
    assert redone and all("lowered the stable bound" in frame.retries[0] for frame in redone)
    assert redone == [frames[1]] and frames[1].substeps < 1.4 * (frames[1].attempted - frames[1].substeps)
    assert frames[1].trend < 0.9 and frames[2].attempted == frames[2].substeps


def test_frames_beyond_the_substeps_that_may_be_taken_are_refused_before_they_are_tried(x64):
    model, state = draw_out()
    frames = list(simulate(model, state, frame_count=4, frame_dt=0.04))
    taken = sum(frame.attempted for frame in frames)
    again = list(simulate(model, state, frame_count=4, frame_dt=0.04, most_substeps=taken))
    assert [frame.substeps for frame in again] == [frame.substeps for frame in frames]
    done = []
    with pytest.raises(UserError, match="frame 3 would take"):
        for frame in simulate(model, state, frame_count=4, frame_dt=0.04, most_substeps=taken - 1):
            done.append(frame.index)
    assert done == [0, 1, 2]


def test_a_blow_within_the_frame_is_foreseen(x64):
    """Forces give their mean over the frame, so that the step fits the speed that is to come."""
    blow = UniformAcceleration(jnp.array([2e4, 0.0, 0.0]), jnp.array(0.0165), jnp.array(0.0175))
    model, state = block(youngs_modulus=2e4, dtype=np.float64, forces=(blow,), low=(0.2, 0.4, 0.4))
    frames = list(simulate(model, state, frame_count=3, frame_dt=0.01, safety=1.0))
    assert not frames[2].retries and frames[2].substeps > frames[1].substeps
    np.testing.assert_allclose(frames[2].state.v.mean(0), [20, 0, 0], atol=1e-9)


def test_a_hopeless_frame_ends_with_a_clear_error(x64):
    """A field that no step resolves: every retry sees the same, and the message says what."""
    model, state = block(dtype=np.float64, forces=(Hole(),))
    with pytest.raises(UserError, match="frame 1 cannot be simulated: a value is not finite"):
        list(simulate(model, state, frame_count=2, frame_dt=0.01))


@jax.tree_util.register_dataclass
@dataclasses.dataclass(frozen=True)
class Hole:
    """An acceleration that is not a number from 1 ms on."""

    def acceleration(self, x, v, mass, time, dt):
        return jnp.where(time > 1e-3, jnp.nan, 0.0) * jnp.ones_like(x)

    def gradient(self, x, time, dt):
        return None


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda m, s: (m, dataclasses.replace(s, v=s.v.at[5, 1].set(jnp.inf))), "not finite"),
        (lambda m, s: (m.replace(mass=m.mass.at[5].set(0.0)), s), "no mass or no volume"),
        (lambda m, s: (m.replace(volume=m.volume.at[5].set(-1.0)), s), "no mass or no volume"),
        (lambda m, s: (m, dataclasses.replace(s, F=s.F.at[5, 0, 0].set(-1.0))), "inside out"),
        (lambda m, s: (m, dataclasses.replace(s, x=s.x.at[5, 2].set(1.2))), "outside the domain"),
        (lambda m, s: (m.replace(mass=m.mass[:-1]), s), "same number of particles"),
        (
            lambda m, s: (m.replace(materials=(NeoHookean(-m.materials[0].mu, -m.materials[0].lam),)), s),
            "no time step",
        ),
    ],
)
def test_what_no_step_could_make_sense_of_is_refused(change, words, x64):
    model, state = change(*block(dtype=np.float64))
    with pytest.raises(UserError, match=words):
        list(simulate(model, state, frame_count=2, frame_dt=0.01))


@pytest.mark.parametrize("options", [dict(safety=2.0), dict(safety=0.0), dict(substep_dt=-1e-3)])
def test_steps_that_make_no_sense_are_refused(options, x64):
    with pytest.raises(UserError, match="must be positive"):
        list(simulate(*block(dtype=np.float64), frame_count=2, frame_dt=0.01, **options))


def test_more_substeps_than_anyone_would_wait_for_are_refused(x64):
    model, state = block(dtype=np.float64)
    fast = dataclasses.replace(state, v=state.v + 1e8)
    with pytest.raises(UserError, match="moves so fast"):
        list(simulate(model, fast, frame_count=2, frame_dt=0.01))


def test_a_step_above_the_bound_runs_only_if_forced(x64):
    model, state = block(dtype=np.float64)
    bound = float(stable_dt(model, state))
    options = dict(frame_count=2, frame_dt=4.4 * bound, substep_dt=1.1 * bound)
    with pytest.raises(UserError, match="force_substep"):
        list(simulate(model, state, **options))
    forced = list(simulate(model, state, force_substep=True, **options))
    assert bound < forced[1].dt <= 1.1 * bound and not forced[1].retries


def test_a_forced_step_that_fails_is_not_shortened(x64):
    model, state = block(dtype=np.float64, youngs_modulus=1e5)
    state = dataclasses.replace(state, F=state.F * 1.05)
    with pytest.raises(UserError, match="forced substep"):
        list(simulate(model, state, frame_count=9, frame_dt=0.1, substep_dt=0.02, force_substep=True))


def test_rollout_equals_the_frame_driver(x64):
    model, state = block(gravity=jnp.array([0.0, 0.0, -9.8]), dtype=np.float64, dt=1e-3)
    frames = list(simulate(model, state, frame_count=4, frame_dt=0.01, substep_dt=1e-3))
    end, path = rollout(model, state, frame_count=3, substeps=10)
    np.testing.assert_allclose(end.x, frames[-1].state.x, atol=1e-14)
    np.testing.assert_allclose(path.x[0], frames[1].state.x, atol=1e-14)


def test_rollout_out_of_its_window_is_nan_not_wrong(x64):
    model, state = block(dtype=np.float64, dt=1e-3)
    thrown = dataclasses.replace(state, v=jnp.broadcast_to(jnp.array([3.0, 0, 0]), state.v.shape))
    tight = Grid(jnp.array([4, 4, 4], jnp.int32), (12, 12, 12), 0.05, 20)
    end, path = rollout(model.replace(grid=tight), thrown, frame_count=10, substeps=10)
    whole, _ = rollout(model, thrown, frame_count=10, substeps=10)
    assert np.isfinite(np.asarray(path.x[0])).all() and np.isfinite(np.asarray(whole.x)).all()
    assert np.isnan(np.asarray(end.x)).all()


def test_gradients_match_central_differences(x64):
    """dLoss with respect to force, initial velocity, stiffness and density, over 60 steps from F = I."""
    model, state = block((3, 3, 3), dtype=np.float64, dt=1e-3, boundaries=())
    weight = jnp.asarray(np.random.default_rng(0).normal(size=(len(state.x), 3)))

    def loss(p):
        force = UniformAcceleration(p["a"], jnp.array(0.01), jnp.array(0.04), (state.x[:, 0] > 0.45) * 1.0)
        mu, lam = lame_parameters(jnp.exp(p["log_E"]), 0.3)
        count = len(state.x)
        changed = model.replace(
            forces=(force,),
            mass=model.mass * p["rho"],
            materials=(NeoHookean(jnp.full(count, mu), jnp.full(count, lam)),),
        )
        start = dataclasses.replace(state, v=state.v + p["v"])
        end, _ = rollout(changed, start, frame_count=6, substeps=10)
        return (weight * end.x).sum() + (end.x[:, 2] ** 2).sum()

    point = {
        "a": jnp.array([2.0, -1.0, 3.0]),
        "log_E": jnp.log(2e4),
        "rho": jnp.array(1.1),
        "v": jnp.array([0.1, 0.2, 0]),
    }
    gradient = jax.grad(loss)(point)
    h = 1e-5

    def shifted(name, index, amount):
        return {**point, name: point[name].at[index].add(amount)}

    for name, index in [("a", 0), ("a", 2), ("log_E", ()), ("rho", ()), ("v", 1)]:
        difference = (loss(shifted(name, index, h)) - loss(shifted(name, index, -h))) / (2 * h)
        np.testing.assert_allclose(gradient[name][index], difference, rtol=1e-6, atol=1e-9)
