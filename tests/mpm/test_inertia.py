"""Sharpened increments: answers in closed form, what they keep, and every path that carries them."""

import dataclasses
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from benchmarks.cases.bar import FreeBar
from benchmarks.cases.base import Numerics, run
from physagent_jax.core.errors import UserError
from physagent_jax.forces.terms import Torque, UniformAcceleration
from physagent_jax.mpm import (
    HalfSpace,
    NeoHookean,
    PrescribedMotion,
    Schedule,
    Sharpened,
    State,
    inertia,
    kernels,
    replay,
    rollout,
    simulate,
    stable_dt,
    step,
    transfer,
)
from physagent_jax.mpm.energy import angular_momentum, kinetic_energy, momentum
from physagent_jax.mpm.materials import viscous_stress
from tests.mpm.blocks import block
from tests.mpm.test_kernels import GRID, TOLERANCE, close, cloud, pulls_equal

# Small scenes, whose programs take longer to compile than to run.
pytestmark = pytest.mark.usefixtures("least_optimised")

UP, FOREVER = jnp.array([0.0, 0.0, 1.0]), jnp.asarray(1e9)
SHARP = Sharpened(0.2)


def advance(model, state, steps):
    return jax.jit(lambda s: jax.lax.fori_loop(0, steps, lambda _, s: step(model, s), s))(state)


def ringing(count=3, **options):
    """A block in an uneven motion of its own."""
    model, state = block((count,) * 3, dtype=np.float64, inertia=SHARP, **options)
    v = np.random.default_rng(0).normal(size=state.x.shape)
    return model, dataclasses.replace(state, v=jnp.asarray(0.2 * v + 0.05))


@pytest.mark.parametrize("beta", [0.15, 0.216])
def test_a_bar_swings_with_the_frequency_of_the_wave_equation(beta, x64):
    """But for second order: (beta - 0.216 + Cr^2 / 12) q^2 / 2, q = pi / 16 a cell; lumped masses are off by 0.29 %."""
    courant, case = 0.9, FreeBar()
    problem = case.problem(Numerics(16, ("courant", courant), dtype=np.float64, inertia=Sharpened(beta)))
    error = case.judge(problem, run(problem))["frequency"]
    predicted = 0.5 * (beta - 0.216 + courant**2 / 12) * (np.pi / 16) ** 2
    assert error == pytest.approx(predicted, abs=3e-4)


def test_linear_momentum_is_kept_to_roundoff(x64):
    """Of bodies of unequal particles too, of which the heaviest weigh a thousand times the lightest."""
    model, state = ringing()
    model = model.replace(mass=model.mass * jnp.logspace(0, 3, len(model.mass)), dt=model.dt / 2)
    end = advance(model, state, 100)
    np.testing.assert_allclose(momentum(model, end), momentum(model, state), rtol=1e-12)


def test_angular_momentum_is_kept_but_for_the_edges_torque(x64):
    """Bounded, in a turn and in more: the torque of the edges is that of an increment."""
    model, state = block((4, 4, 4), dtype=np.float64, dt=8e-4, inertia=SHARP)
    centre = state.x.mean(0)
    W = 4.0 * jnp.array([[0, -1.0, 0], [1.0, 0, 0], [0, 0, 0]])
    state = dataclasses.replace(state, v=(state.x - centre) @ W.T, C=jnp.broadcast_to(W, state.C.shape))
    for _ in range(2):
        begun, state = state, advance(model, state, 500)
        before, after = (angular_momentum(model, each, centre)[2] for each in (begun, state))
        assert float(after) == pytest.approx(float(before), rel=3e-4)


def grow(share, form, heavy):
    """The rate of strain in a substep, ``share`` of the bound, after 400 from a strain of 1e-6."""
    count, rng = 27, np.random.default_rng(2)
    sites = np.stack(np.meshgrid(*[np.arange(3)] * 3, indexing="ij"), -1).reshape(-1, 3)
    cells = 4.1 + 3.7 * sites + rng.uniform(-0.19, 0.19, sites.shape)  # none shares a node with another
    x = 0.05 * np.vstack(
        [cells[:-1], [[11.46] * 3]]
    )  # the last one next to where the classical form is least stable
    box = dict(size=0.8, grid_cells=16, low=(0.3,) * 3, boundaries=())
    model, state = block((3, 3, 3), dtype=np.float64, inertia=SHARP, **box)
    mu, lam = model.materials[0].mu, model.materials[0].lam
    if heavy:  # one particle, a hundred times as heavy and stiff, among 215: light ones do not hold it
        more = jnp.ones(216).at[100].set(100.0)
    else:
        state, more = State.at_rest(jnp.asarray(x)), jnp.ones(count)
    size = len(more)
    model = model.replace(mass=model.mass[:size] * more, volume=model.volume[:size], stress_form=form)
    model = model.replace(materials=(NeoHookean(mu[:size] * more, lam[:size] * more),))
    strain = 1e-6 * jnp.asarray(rng.uniform(-1, 1, (size, 3, 3)))
    state = dataclasses.replace(state, F=state.F + strain)
    model = model.replace(dt=share * stable_dt(model, state))
    return float(jnp.abs(advance(model, state, 400).C).max() * model.dt)


@pytest.mark.parametrize("form", ["mls", "gradient"])
def test_the_critical_step_of_lone_particles_stays(form, x64):
    """As of lumped masses, 0.95 of the bound is stable and 1.1 is not; so is a heavy particle among light ones."""
    assert grow(0.95, form, heavy=False) < 1e-4
    assert not grow(1.1, form, heavy=False) < 1e-3
    assert grow(0.95, form, heavy=True) < 1e-4


def test_a_heavy_particle_among_light_ones_counts_as_alone():
    w, mass = np.array([0.4, 3.0]), np.array([1.0, 1e-3])  # the light ones: many
    count = inertia.count_particles(
        jnp.asarray([w @ mass]), jnp.asarray([w @ mass**2]), jnp.asarray(1.0), jnp.asarray(1e-3)
    )
    assert float(count[0]) == pytest.approx(0.4, rel=0.02)


def test_a_quadratic_field_gains_its_second_difference(x64):
    """In a bulk of full nodes; a linear one gains nothing, and a node with one particle has no part in it."""
    i, one = jnp.arange(6.0), jnp.asarray(1.0)
    x = jnp.broadcast_to(i[:, None, None], (6, 4, 4))
    full = jnp.full((6, 4, 4), 8.0)
    for field, second in ((3 * x, 0.0), (x**2, 2.0)):
        v = jnp.stack([field, 0 * field, 0 * field], axis=-1)
        gained = inertia.sharpen(0.2, v, full, full, one, one)
        np.testing.assert_allclose(gained[1:-1, ..., 0], -0.2 * second, atol=1e-14)
        np.testing.assert_allclose(gained.sum((0, 1, 2)), 0, atol=1e-12)
    lone = inertia.sharpen(0.2, v, full, full.at[3].set(1e30), one, one)
    assert np.abs(lone[3]).max() < 1e-20 < 1e-2 < np.abs(lone[1]).max()


@pytest.mark.parametrize("opposes", [False, True])
@pytest.mark.parametrize("shape", [(3, 4, 3), (4, 6, 17), (5, 3, 10)])
def test_the_stencil_and_its_adjoint_equal_the_reference(shape, opposes, x64):
    """Rows shorter than a batch of lanes and longer, empty nodes, neighbours of equal mass."""
    rng, limits = np.random.default_rng(1), [jnp.asarray(each) for each in (0.7, 0.5, 1e-9)]
    nodes = rng.normal(size=(*shape, 8))
    nodes[..., 3] = rng.choice([0, 0.5, 0.8, 1.0], size=shape)
    nodes[..., 7] = 0.7 * nodes[..., 3] ** 2 / rng.uniform(0.3, 5, size=shape)
    velocity = jnp.asarray(rng.normal(size=(*shape, 3)))
    operands = (jnp.asarray(nodes), velocity) if opposes else (jnp.asarray(nodes),)

    def bind(sharpened_velocity):
        return lambda nodes, opposed=None: sharpened_velocity(0.2, nodes, opposed, *limits)

    kernel, reference = map(bind, (kernels.load_cpu_kernels().sharpened_velocity, inertia.sharpened_velocity))
    close(kernel(*operands), reference(*operands), 1e-13)
    pulls_equal(kernel, reference, operands)


def p2g_cases():
    c, rng = cloud(501), np.random.default_rng(2)
    mu, lam, eta = (jnp.asarray(rng.uniform(1e3, 2e3, 501)) for _ in range(3))
    push, rate = jnp.asarray(rng.normal(size=(501, 3))), jnp.asarray(rng.normal(size=(501, 3, 3)))
    dv, unit, dt = jnp.asarray([0.3, -0.2, 0.1]), jnp.asarray(0.5), jnp.asarray(1e-3)
    x, v, C, tau, F, mass, volume = (c[name] for name in ("x", "v", "C", "tau", "F", "mass", "volume"))

    def make(push, tau, *law):
        return x, v, C, tau, mass, volume, dv, push, unit, dt, *law

    return dict(
        given=(make(push, tau), lambda tau: tau, lambda: (None, None)),
        alone=(make(jnp.zeros((1, 3)), tau), lambda tau: tau, lambda: (None, None)),
        elastic=(
            make(push, F, mu, lam),
            lambda F, mu, lam: NeoHookean(mu, lam).stress(F),
            lambda mu, lam: ((mu, lam), None),
        ),
        viscous=(
            make(push, F, mu, lam, eta, rate),
            lambda F, mu, lam, eta, rate: NeoHookean(mu, lam).stress(F) + viscous_stress(eta, rate, F),
            lambda mu, lam, eta, rate: ((mu, lam), (eta, rate)),
        ),
    )


def both_ways(case, form):
    """The kernel, the reference and what both take: the unit of mass, a constant, apart."""
    operands, stress, law = p2g_cases()[case]
    unit = operands[8]

    def kernel(x, v, C, tau, mass, volume, dv, push, dt, *rest):
        last = mass, volume, dv, push, unit.astype(x.dtype), dt
        return kernels.load_cpu_kernels().p2g_apart(form, GRID, x, v, C, tau, *law(*rest), *last)

    def reference(x, v, C, tau, mass, volume, dv, push, dt, *rest):
        last = mass, volume, dv, push, unit, dt
        return transfer.p2g_apart(form, GRID, x, v, C, stress(tau, *rest), *last), x, tau

    return kernel, reference, operands[:8] + operands[9:]


CASES = ["given", "alone", "elastic", "viscous"]


@pytest.mark.parametrize("form", ["mls", "gradient"])
@pytest.mark.parametrize("case", CASES)
def test_the_kernel_equals_the_reference(case, form, x64):
    """In both precisions, each grid to round-off of its own numbers."""
    kernel, reference, operands = both_ways(case, form)
    expected, _, _ = jax.jit(reference)(*operands)
    for dtype, tolerance in TOLERANCE.items():
        got, _, _ = jax.jit(kernel)(*(each.astype(dtype) for each in operands))
        close(got[..., :4], expected[..., :4], tolerance)
        close(got[..., 4:], expected[..., 4:], tolerance)


SHORT = {("elastic", "mls"), ("viscous", "gradient")}
"""Adjoints that hold the parts of the others too: each compiles for half a minute."""


@pytest.mark.parametrize(
    ("case", "form"),
    [
        pytest.param(case, form, marks=[] if (case, form) in SHORT else [pytest.mark.slow])
        for case in CASES
        for form in ("mls", "gradient")
    ],
)
def test_its_adjoint_equals_the_derivatives_of_the_reference(case, form, x64):
    """By every operand, the step and what pushes among them."""
    kernel, reference, operands = both_ways(case, form)
    pulls_equal(kernel, reference, operands)


def thrown(choice, form="mls"):
    """A block on a floor with friction, a corner of it held, pushed and turned."""
    floor = HalfSpace(0.4 * UP, UP, jnp.asarray(0.3), jnp.zeros(()), FOREVER)
    grip = dataclasses.replace(PrescribedMotion.fixed(jnp.arange(4), jnp.float64), velocity=0.1 * UP)
    forces = (
        UniformAcceleration(jnp.array([4.0, 0.0, 0.5]), jnp.zeros(()), FOREVER),
        Torque(UP, jnp.asarray(5.0), jnp.zeros(()), FOREVER),
    )
    rest = dict(forces=forces, boundaries=(floor,), constraints=(grip,), stress_form=form, kernels=choice)
    return ringing(gravity=-9.8 * UP, viscosity=jnp.full(216, 2.0), damping_rate=0.5, **rest)


@pytest.mark.parametrize(
    ("form", "choices"),
    [
        ("mls", ("cpu",)),
        pytest.param("mls", ("reference",), marks=pytest.mark.slow),
        pytest.param("gradient", ("cpu",), marks=pytest.mark.slow),
    ],
)
def test_gradients_of_a_rollout_agree_with_differences_on_every_path(form, choices, x64):
    """Differences of the same program, which costs most to compile."""
    weight = jnp.asarray(np.random.default_rng(1).normal(size=(216, 3)))

    def loss(p, choice):
        model, state = thrown(choice, form)
        law, force = model.materials[0], model.forces[0]
        model = model.replace(
            materials=(dataclasses.replace(law, mu=law.mu * p[0]),),
            forces=(dataclasses.replace(force, value=force.value * p[1]), *model.forces[1:]),
            mass=model.mass * (1 + 0.1 * p[2] * weight[:, 0]),
        )
        end, _ = rollout(model, dataclasses.replace(state, v=state.v * p[3]), frame_count=1, substeps=6)
        return (weight * end.x).sum() + (end.F[:, 0, 1] ** 2).sum()

    at, h = jnp.array([1.0, 1.1, 0.3, 0.9]), 1e-6
    values = []
    for choice in choices:
        respond = jax.jit(jax.value_and_grad(partial(loss, choice=choice)))
        value, slopes = respond(at)
        differences = [
            float(respond(at.at[k].add(h))[0] - respond(at.at[k].add(-h))[0]) / (2 * h) for k in range(4)
        ]
        np.testing.assert_allclose(slopes, differences, rtol=1e-5, atol=1e-7)
        values.append(float(value))
    np.testing.assert_allclose(values, values[0], rtol=1e-12)


def test_the_ledger_balances_with_walls_a_grip_and_forces(x64):
    """Momentum to round-off; what a push does to a free block is its work, and no boundary's."""
    model, state = thrown("auto")
    frames = list(simulate(model, state, frame_count=3, frame_dt=0.01, ledger=True))
    total = frames[1].exchange + frames[2].exchange
    change = momentum(model, frames[-1].state) - momentum(model, state)
    np.testing.assert_allclose(change, total.force_impulse + total.boundary_impulse, atol=1e-12)
    push = UniformAcceleration(jnp.array([2.0, 0.0, 0.5]), jnp.zeros(()), FOREVER)
    model, state = block((3, 3, 3), dtype=np.float64, forces=(push,), inertia=SHARP)
    *_, last = simulate(model, state, frame_count=2, frame_dt=0.01, ledger=True)
    np.testing.assert_allclose(kinetic_energy(model, last.state), last.exchange.force_work, rtol=1e-9)
    assert abs(float(last.exchange.boundary_work)) < 1e-12
    schedule = Schedule.of(model, [last])
    np.testing.assert_allclose(replay(model, state, schedule)[-1].x, last.state.x, rtol=1e-12)


def test_what_is_held_in_equilibrium_stays(x64):
    """A bar under tension whose ends are held: what the grip opposes is no increment that its neighbours could lack."""
    ends = []
    for held in (True, False):
        model, state = block(
            (8, 2, 2), low=(0.3, 0.4, 0.4), poissons_ratio=0.0, dtype=np.float64, inertia=SHARP
        )
        along = np.asarray(state.x)[:, 0]
        grip = PrescribedMotion.fixed(jnp.asarray(np.flatnonzero(np.abs(along - 0.5) > 0.1)), jnp.float64)
        model = model.replace(constraints=(grip,) if held else ())
        ends.append(advance(model, dataclasses.replace(state, F=state.F.at[:, 0, 0].set(1.05)), 1))
    assert float(jnp.abs(ends[0].v).max()) < 1e-13 < 1e-2 < float(jnp.abs(ends[1].v).max())


def test_what_makes_no_sense_is_refused():
    for beta in (0.0, 0.3, float("nan")):
        with pytest.raises(UserError, match="beta"):
            Sharpened(beta)
    model, _ = block((2, 2, 2))
    with pytest.raises(UserError, match="inertia"):
        model.replace(inertia=0.18)
