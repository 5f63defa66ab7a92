"""A model and a state of any precision give what their numbers say; what does not fit is refused in words."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.core.pytree import register_dataclass
from physagent_jax.kernels import programs
from physagent_jax.mpm import (
    DomainBox,
    FixedCorotated,
    Grid,
    Model,
    NeoHookean,
    State,
    VonMises,
    kernels,
    rollout,
    simulate,
    step,
)
from physagent_jax.mpm.conform import conform
from physagent_jax.mpm.kernels import load_cpu_kernels
from physagent_jax.mpm.linalg import kernels as linalg_kernels

N, DT, STEPS = 27, 1e-3, 10
FALL = -9.8 * DT**2 * STEPS * (STEPS + 1) / 2  # of the leapfrog scheme, exactly
PATHS = ["reference"] + ["cpu"] * kernels.use_cpu()


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Weight:
    """Somebody's force, in whatever precision NumPy has."""

    numbers: jax.Array

    def acceleration(self, x, v, mass, time, dt):
        return self.numbers

    def gradient(self, x, time, dt):
        return None


def things(path="auto", state=np.float32, model=np.float32, **changes):
    """Free matter at rest under gravity; arrays of NumPy, so that nothing has been converted yet."""
    x = np.stack(np.meshgrid(*[np.linspace(0.4, 0.6, 3)] * 3), -1).reshape(-1, 3).astype(state)
    one = np.ones(N, model)
    law = NeoHookean(4 * one, 6 * one)
    start = State.at_rest(jnp.asarray(x))
    gravity = np.array([0, 0, -9.8], np.float64 if np.dtype(model).kind == "i" else model)
    made = Model(Grid.whole(1.0, 12), model(1) * DT, gravity, one, one, (law,), kernels=path)
    return made.replace(**changes), start


def fallen(model, state):
    end, _ = rollout(model, state, frame_count=1, substeps=STEPS)
    assert end.x.dtype == state.x.dtype
    return np.asarray(end.x - state.x)


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize(
    "state, model",
    [(np.float32, np.float64), (np.float64, np.float32), (np.float32, np.int64)],
    ids=lambda dtype: dtype.__name__,
)
def test_what_is_in_another_precision_is_converted(path, state, model, x64):
    """Before, kernels took double for single precision: nothing fell, or was NaN."""
    moved = fallen(*things(path, state, model))
    np.testing.assert_allclose(moved, np.broadcast_to([0, 0, FALL], (N, 3)), atol=2e-6)


@pytest.mark.parametrize("path", PATHS)
def test_a_force_may_answer_in_another_precision(path, x64):
    """Even as whole numbers, or as one for all particles."""
    for numbers in (np.array([0, 0, -9.8]), np.tile([0.0, 0.0, -9.8], (N, 1))):
        moved = fallen(*things(path, gravity=None, forces=(Weight(numbers),)))
        np.testing.assert_allclose(moved[:, 2], FALL, atol=2e-6)


@pytest.mark.parametrize("path", PATHS)
def test_a_window_may_be_in_other_integers(path, x64):
    model, state = things(path)
    grid = dataclasses.replace(model.grid, origin=np.zeros(3, np.int64))
    np.testing.assert_allclose(fallen(model.replace(grid=grid), state)[:, 2], FALL, atol=2e-6)


def test_lists_and_numbers_are_arrays_too():
    model, state = things(gravity=[0, 0, -9.8], dt=DT)
    np.testing.assert_allclose(fallen(model, state)[:, 2], FALL, atol=2e-6)


def test_frames_and_steps_are_converted_as_rollouts_are(x64):
    """`simulate` and `step` against `rollout`."""
    model, state = things(model=np.float64)
    *_, last = simulate(model, state, frame_count=2, frame_dt=DT, substep_dt=DT, force_substep=True)
    end, _ = rollout(model, state, frame_count=1, substeps=1)
    for other in (last.state, step(model, state)):
        assert other.x.dtype == np.float32
        np.testing.assert_allclose(other.x, end.x, atol=1e-7)


def test_derivatives_pass_through_a_conversion(x64):
    """By a gravity in double precision, of a fall in single precision."""
    model, state = things()

    def height(gravity):
        return rollout(model.replace(gravity=gravity), state, frame_count=1, substeps=STEPS)[0].x[:, 2].mean()

    slope = jax.grad(height)(jnp.array([0, 0, -9.8], jnp.float64))
    assert slope.dtype == np.float64
    np.testing.assert_allclose(slope, [0, 0, FALL / -9.8], atol=1e-8)


def test_what_fits_is_left_alone_and_nothing_is_compiled():
    model, state = jax.device_put(things())
    before = programs.compiled_count
    same = conform(model, state)
    assert programs.compiled_count == before
    assert all(one is other for one, other in zip(jax.tree.leaves((model, state)), jax.tree.leaves(same)))


WRONG = {
    "mass": lambda m, s: (m.replace(mass=m.mass[:5]), s),
    "mass: 1": lambda m, s: (m.replace(mass=np.ones((N, 2))), s),
    "gravity": lambda m, s: (m.replace(gravity=np.ones(2)), s),
    "`model.gravity` must be an array": lambda m, s: (m.replace(gravity="down"), s),
    "complex": lambda m, s: (m.replace(volume=np.ones(N, complex)), s),
    "state.C": lambda m, s: (m, dataclasses.replace(s, C=jnp.zeros((N, 9)))),
    "state.v": lambda m, s: (m, dataclasses.replace(s, v=jnp.zeros((N, 2)))),
    "single or double": lambda m, s: (m, dataclasses.replace(s, x=s.x.astype(jnp.float16))),
    "single or double precision": lambda m, s: (m, dataclasses.replace(s, x=s.x.astype(jnp.int32))),
    "model.dt": lambda m, s: (m.replace(dt=np.ones(3)), s),
    r"lam` must have one": lambda m, s: (m.replace(materials=(NeoHookean(np.ones(N), np.ones(4)),)), s),
    "one number per particle": lambda m, s: (m.replace(materials=(NeoHookean(1.0, 1.0),)), s),
    "whole numbers": lambda m, s: (m.replace(grid=dataclasses.replace(m.grid, origin=np.zeros(3))), s),
    "three nodes": lambda m, s: (m.replace(grid=dataclasses.replace(m.grid, shape=(9, 2, 9))), s),
    "accelerations of Weight": lambda m, s: (m.replace(forces=(Weight(np.ones((5, 3))),)), s),
    "accelerations of Weight must": lambda m, s: (m.replace(forces=(Weight(np.ones((N, 3), bool)),)), s),
}


@pytest.mark.parametrize("told", WRONG)
def test_what_does_not_fit_is_refused(told):
    told_of = told.replace("mass: 1", "model.mass")
    model, state = WRONG[told](*things())
    with pytest.raises(UserError, match=told_of):
        rollout(model, state, frame_count=1, substeps=1)


def test_memories_of_another_size_are_refused():
    law = VonMises.__new__(VonMises)
    fields = {field.name: np.ones(N, np.float32) for field in dataclasses.fields(VonMises)}
    for name, value in fields.items():
        object.__setattr__(law, name, value)
    model, state = things(materials=(law,))
    state = dataclasses.replace(state, history=(np.zeros(4, np.float32),))
    with pytest.raises(UserError, match="state.history"):
        rollout(model, state, frame_count=1, substeps=1)


@pytest.mark.skipif("cpu" not in PATHS, reason="no CPU kernels here")
def test_kernels_refuse_what_they_would_misread(x64):
    """As they are traced, whoever calls them: memory beyond an array's end is not read."""
    cpu, (model, state) = load_cpu_kernels(), jax.device_put(things(model=np.float64))
    grid, dt, dv = model.grid, model.dt, jnp.zeros(3, jnp.float32)
    x, v, C, F = state.x, state.v, state.C, state.F
    good = model.mass.astype(jnp.float32)
    node = jnp.zeros((*grid.shape, 3), jnp.float32)
    narrow, origin = (
        dataclasses.replace(grid, shape=(13, 13, 2)),
        dataclasses.replace(grid, origin=jnp.zeros(3, int)),
    )
    calls = {
        "mass": lambda: cpu.p2g("mls", grid, x, v, C, F, model.mass, good, dv, dt),
        "volume": lambda: cpu.p2g("mls", grid, x, v, C, F, good, good[:3], dv, dt),
        "dv": lambda: cpu.p2g("mls", grid, x, v, C, F, good, good, jnp.zeros((N, 3), jnp.float32), dt),
        "origin": lambda: cpu.p2g("mls", origin, x, v, C, F, good, good, dv, dt),
        "three nodes": lambda: cpu.p2g("mls", narrow, x, v, C, F, good, good, dv, dt),
        "lam": lambda: cpu.p2g_neo_hookean("mls", grid, x, v, C, F, good, good[0], good, good, dv, dt),
        "velocity": lambda: cpu.g2p("mls", 1, grid, x, v, C, F, node[:-1], dt),
        "`F`": lambda: cpu.g2p("mls", 1, grid, x, v, C, F.astype(jnp.float64), node, dt),
        "basis": lambda: linalg_kernels.load_cpu_kernels().compose(
            jnp.zeros((1, 2, 3), jnp.float32), F, None, None
        ),
    }
    for told, call in calls.items():
        with pytest.raises(UserError, match=told):
            jax.eval_shape(call)


@pytest.mark.parametrize(
    "field, value, told",
    [
        ("kernels", "jax", "not known"),
        ("kernels", "referense", "Did you mean `reference`"),
        ("transfer", "APIC ", "Did you mean `apic`"),
        ("stress_form", "MPM", "`Model.stress_form`"),
        ("rpic_damping", 1.5, "within"),
        ("rpic_damping", float("nan"), "within"),
        ("damping_rate", -1.0, "not negative"),
        ("damping_rate", float("inf"), "finite"),
        ("wall", 0, "1 or more"),
    ],
)
def test_options_of_a_model_have_their_ranges(field, value, told):
    with pytest.raises(UserError, match=told):
        things(**{field: value})


@pytest.mark.parametrize("J", [1e-7, 94.0])
def test_matter_that_starts_extreme_is_warned_of(J):
    model, state = things()
    F = state.F.at[3].multiply(J ** (1 / 3))
    with pytest.warns(UserWarning, match=f"1 of {N} particles .* {J:.3g}"):
        next(simulate(model, dataclasses.replace(state, F=F), frame_count=1, frame_dt=DT))


def test_soft_matter_that_is_crushed_is_told_by_how_much_it_is_too_soft():
    """Fixed-corotated matter with E = 1 kPa and 0.2 m high under 500 g: rho g L = 980 kPa, 3 lam + 2 mu = 2.5 kPa."""
    model, state = things(gravity=np.array([0, 0, -4900.0]))
    one = np.ones(N, np.float32)
    law = FixedCorotated(385 * one, 577 * one)
    model = model.replace(materials=(law,), volume=1e-3 * one, boundaries=(DomainBox(),))
    with pytest.raises(UserError, match=r"pressure of some [\d.]+e\+05 Pa.*2.5e\+03 Pa.*times as stiff"):
        for _ in simulate(model, state, frame_count=50, frame_dt=0.002):
            pass
