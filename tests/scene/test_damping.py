"""Damping ratios: an object's lowest mode, what the simulation makes of them, and what that costs."""

import dataclasses
import math

import numpy as np
import pytest
from pydantic import ValidationError

from benchmarks.cases.bar import FreeBar
from benchmarks.cases.base import Numerics, fit_damped_cosine, run
from benchmarks.cases.cantilever import CantileverSwing, first_frequency
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField
from physagent_jax.mpm import stable_dt
from physagent_jax.run.resolve import resolve
from physagent_jax.run.spec import RunSpec
from physagent_jax.scene import config as c
from physagent_jax.scene.body import make_body
from physagent_jax.scene.compile import compile_scene
from physagent_jax.scene.cost import estimate_cost, find_stable_step
from physagent_jax.scene.damping import (
    MOST_SLOWER,
    Mode,
    compute_drag,
    compute_viscosity,
    find_affordable_ratio,
    find_lowest_mode,
    find_slowdown,
)
from physagent_jax.scene.fuse import fuse
from physagent_jax.scene.priors import PRIORS
from physagent_jax.scene.standing import damp

JELLY = c.Material(youngs_modulus=6e4, poissons_ratio=0.42, density=1000.0)
MU = 6e4 / 2.84


def bar(length, side, per_side=8):
    """Particles of a bar of square section along z that ends at z = 0, and their volumes."""
    size = side / per_side
    axes = [(np.arange(round(extent / size)) + 0.5) * size for extent in (side, side, length)]
    x = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    return x, np.full(len(x), size**3)


def mode_of(x, volume, held=None, material=JELLY):
    return find_lowest_mode(x, volume, np.zeros(len(x), bool) if held is None else held, material)


def test_a_slender_held_beam_has_the_frequency_of_a_cantilever():
    """1.8751^2 sqrt(E I / (rho A L^4)), held at its foot or its top."""
    x, volume = bar(1.0, 0.05)
    exact = 1.87510**2 * math.sqrt(6e4 / 1000 * 0.05**2 / 12)
    for held in (x[:, 2] < 0.1, x[:, 2] > 0.9):
        mode = mode_of(x, volume, held)
        assert mode.held and mode.frequency == pytest.approx(exact / 0.9**2, rel=0.01)


def test_a_held_block_shears_as_well_as_it_bends():
    """A cube on a plate: softer than by bending alone (1.015 c / L) or by shear alone (pi / 2 sqrt(5 / 6) c_s / L)."""
    x, volume = bar(1.0, 0.875, per_side=14)
    w = mode_of(x, volume, x[:, 2] < 0.125).frequency * 0.875 / math.sqrt(60)
    bending, shear = 1.015, 0.5 * math.pi * math.sqrt(5 / 6 / 2.84)
    assert w == pytest.approx((bending**-2 + shear**-2) ** -0.5, rel=0.03)  # Dunkerley


def test_free_objects_bend_if_slender_and_twist_if_not():
    x, volume = bar(1.0, 0.05)
    mode = mode_of(x, volume)
    assert mode.bends and not mode.held
    assert mode.frequency == pytest.approx(4.73004**2 * math.sqrt(6e4 / 1000 * 0.05**2 / 12), rel=0.01)
    x, volume = bar(1.0, 1.0)
    mode = mode_of(x, volume)
    assert not mode.bends and mode.frequency == pytest.approx(math.pi * math.sqrt(MU / 1000), rel=0.01)


def test_a_mode_does_not_depend_on_how_an_object_is_turned_or_sampled():
    x, volume = bar(1.0, 0.2)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    held = x[:, 2] < 0.2
    assert mode_of(x @ turn, volume).frequency == pytest.approx(mode_of(x, volume).frequency)
    assert mode_of(x @ turn, volume, held).frequency == pytest.approx(mode_of(x, volume, held).frequency)
    fine, small = bar(1.0, 0.2, per_side=12)
    assert mode_of(fine, small).frequency == pytest.approx(mode_of(x, volume).frequency, rel=0.01)
    close = mode_of(fine, small, fine[:, 2] < 0.2).frequency
    assert close == pytest.approx(mode_of(x, volume, held).frequency, rel=0.02)


@pytest.mark.parametrize("count", [1, 2])
def test_what_has_next_to_no_shape_has_some_mode(count):
    """A single particle, and two of which one is held."""
    x, volume = np.arange(3.0 * count).reshape(-1, 3), np.ones(count)
    for held in (np.zeros(count, bool), np.arange(count) == 0, np.ones(count, bool)):
        assert 0 < mode_of(x, volume, held).frequency < math.inf


@pytest.mark.parametrize("bends", [True, False])
def test_viscosity_gives_the_mode_its_loss_factor(bends):
    """2 zeta = Im M / Re M of the complex modulus at the mode's frequency, E = 9 K mu / (3 K + mu) of bending."""
    mode, ratio = Mode(12.0, bends, held=False), 1e-3
    mu = MU + 1j * 12.0 * compute_viscosity(ratio, JELLY, mode)
    K = 6e4 / (3 * (1 - 0.84))
    modulus = 9 * K * mu / (3 * K + mu) if bends else mu
    assert modulus.imag / modulus.real == pytest.approx(2 * ratio, rel=1e-4)
    assert compute_drag(0.1, mode) == pytest.approx(2.4)


# --- decay, against the exact damped oscillator ---------------------------------------------------------


@pytest.mark.parametrize("ratio", [0.02, 0.1])
def test_a_free_bar_dies_out_at_its_damping_ratio(ratio, x64):
    """Kelvin-Voigt in the first axial mode: exp(-zeta w t), beside what the scheme itself takes; in 3 %."""
    problem = FreeBar().problem(Numerics(16, dtype=np.float64, step=("courant", 0.1)))
    w = 2 * math.pi * problem.exact["f"]
    material = c.Material(youngs_modulus=1e5, poissons_ratio=0.0, density=1000.0)
    eta = compute_viscosity(ratio, material, Mode(w, bends=True, held=False))
    damped = problem.model.replace(viscosity=np.full(len(problem.model.mass), eta))
    decays = []
    for model in (problem.model, damped):
        signal = run(dataclasses.replace(problem, model=model))
        decays.append(fit_damped_cosine(signal.t, signal.values[:, 0], problem.exact["f"]))
    (_, own), (frequency, decay) = decays
    assert decay - own == pytest.approx(ratio * w, rel=0.03)
    assert frequency == pytest.approx(problem.exact["f"] * math.sqrt(1 - ratio**2), rel=0.01)


def test_a_held_beam_dies_out_at_its_damping_ratio(x64):
    """Drag of a cantilever that swings under sudden gravity, in 3 %."""
    case, ratio, w = CantileverSwing(), 0.05, 2 * math.pi * first_frequency()
    problem = case.problem(Numerics(4, dtype=np.float64, step=("courant", 0.6)))
    rate = compute_drag(ratio, Mode(w, bends=True, held=True))
    damped = dataclasses.replace(problem, model=problem.model.replace(damping_rate=rate))
    own, decay = (case.judge(each, run(each))["decay per period"] for each in (problem, damped))
    assert decay - own == pytest.approx(2 * math.pi * ratio, rel=0.03)


# --- in scenes ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def source(robot_path):
    return c.Source(path=str(robot_path), name="robot", kind="robot", up="-y")


@pytest.fixture(scope="module")
def body(source):
    return make_body(source, c.Filling(max_particles=1500), c.Domain(size=4.0, cells=48), ".")


def compiled(source, body, **parts):
    parts = (
        dict(source=source, domain=c.Domain(size=4.0, cells=48), filling=c.Filling(max_particles=1500))
        | parts
    )
    return compile_scene(c.SceneConfig(**parts), body)


def test_what_is_free_becomes_viscous_and_costs_what_was_said(source, body):
    material = c.Material(damping_ratio=0.04)
    plain, viscous = (compiled(source, body, material=each) for each in (c.Material(), material))
    mode = mode_of(body.particles.x, body.particles.volume, material=material)
    eta = compute_viscosity(0.04, material, mode)
    np.testing.assert_allclose(viscous.model.viscosity, eta, rtol=1e-3)
    assert plain.model.viscosity is None and viscous.model.damping_rate is None
    slower = float(stable_dt(plain.model, plain.state) / stable_dt(viscous.model, viscous.state))
    assert slower == pytest.approx(find_slowdown(eta, material, 4 / 48), rel=1e-3) and slower > 1.1
    costs = [estimate_cost(scene.config, body).substeps for scene in (plain, viscous)]
    assert costs[1] / costs[0] == pytest.approx(slower, rel=1e-3)


def test_what_is_held_is_dragged_and_costs_nothing(source, body):
    held = dict(anchor=c.Anchor(kind="base", fraction=0.2), material=c.Material(damping_ratio=0.1))
    scene = compiled(source, body, **held)
    x = body.particles.x
    mode = mode_of(x, body.particles.volume, x[:, 2] <= x[:, 2].min() + 0.2 * np.ptp(x[:, 2]))
    mode = dataclasses.replace(
        mode, frequency=mode.frequency * math.sqrt(1e5 / 200 / 60)
    )  # its modulus and density
    assert scene.model.viscosity is None
    assert float(scene.model.damping_rate) == pytest.approx(0.2 * mode.frequency, rel=0.05)
    assert scene.substeps == compiled(source, body, anchor=held["anchor"]).substeps
    windy = compiled(source, body, **held, transfer=c.Transfer(damping_rate=50.0))
    assert float(windy.model.damping_rate) == 50.0  # what the air takes is part of it


def test_a_ratio_of_zero_is_none(source, body):
    for anchor in (c.Anchor(), c.Anchor(kind="base")):
        model = compiled(source, body, anchor=anchor, material=c.Material(damping_ratio=0.0)).model
        assert model.viscosity is None and model.damping_rate is None


@pytest.mark.parametrize("values, told", [
    (dict(damping_ratio=-0.1), "greater than or equal to 0"),
    (dict(damping_ratio=1.1), "less than or equal to 1"),
    (dict(damping_ratio=0.1, viscosity=2.0), "give one of them"),
    (dict(damping_ratio=0.1, model="fluid"), "no meaning for `fluid`"),
])  # fmt: skip
def test_what_makes_no_sense_is_refused(values, told):
    with pytest.raises(ValidationError, match=told):
        c.Material(**values)


# --- what nobody has chosen -----------------------------------------------------------------------------


def resolved(path, kind=None, **parts):
    values = dict(
        object={"path": str(path), "kind": kind}, prompt="x", overrides=dict(max_particles=800), **parts
    )
    return resolve(RunSpec.model_validate(values))


def test_every_ratio_has_its_source():
    for prior in PRIORS.values():
        assert (0 < prior.damping_ratio <= 0.2) == bool(prior.damping_source)


def test_an_affordable_ratio_takes_as_many_substeps_as_it_may():
    mode, dx = Mode(15.0, bends=False, held=False), 1 / 24
    most = find_affordable_ratio(0.5, JELLY, mode, dx)
    assert find_slowdown(compute_viscosity(most, JELLY, mode), JELLY, dx) == pytest.approx(
        MOST_SLOWER, rel=0.02
    )
    assert find_affordable_ratio(0.5 * most, JELLY, mode, dx) == 0.5 * most
    assert find_affordable_ratio(0.5, JELLY, dataclasses.replace(mode, held=True), dx) == 0.5


def test_a_run_takes_its_kinds_ratio_as_far_as_that_costs_little(robot_path, body):
    """The robot's is cheap, a larger one is cut and said so, and what is asked for is done, whatever it costs."""
    material, note = damp(resolved(robot_path).template, body)
    assert material.damping_ratio == PRIORS["robot"].damping_ratio and note is None
    assert PRIORS["robot"].damping_source in material.reason
    template = dataclasses.replace(resolved(robot_path).template, damping_ratio=0.3)
    material, note = damp(template, body)
    assert (
        0.01 < material.damping_ratio < 0.3
        and "`material.damping_ratio` 0.3" in note
        and note in material.reason
    )
    assert fuse(template, body, ForceField()).material == material
    chosen = resolved(robot_path, material={"damping_ratio": 0.3}).template
    material, note = damp(chosen, body)
    assert material == chosen.material and material.damping_ratio == 0.3 and "times as many substeps" in note
    held = dataclasses.replace(template, anchor=c.Anchor(kind="base"))
    material, note = damp(held, body)
    assert material.damping_ratio == 0.3 and note is None


@pytest.mark.parametrize("parts", [
    {"preset": "paper"}, {"material": {"name": "rubber"}}, {"material": {"damping_ratio": 0}}, {"kind": "sand"},
])  # fmt: skip
def test_presets_with_drag_named_materials_and_what_flows_have_none_unless_asked(parts, robot_path, body):
    assert not damp(resolved(robot_path, **parts).template, body)[0].damping_ratio


@pytest.mark.parametrize("name", ["water", "dry_sand", "rigid"])
def test_a_ratio_for_what_has_no_swing_is_refused_by_name(name, robot_path):
    with pytest.raises(UserError, match="`material.damping_ratio`"):
        resolved(robot_path, material={"name": name, "damping_ratio": 0.1})


def test_a_ratio_may_be_asked_for_in_the_papers_preset(robot_path, body):
    run = resolved(robot_path, preset="paper", material={"damping_ratio": 0.02})
    assert fuse(run.template, body, ForceField()).material.damping_ratio == 0.02


def test_the_papers_step_is_fitted_to_what_is_too_stiff_for_it(robot_path, body):
    """0.2 ms where that is stable; nobody has chosen it, so that what is stiffer is not refused for it."""
    run = resolved(robot_path, preset="paper")
    assert fuse(run.template, body, ForceField()).timing.substep_dt == 2e-4
    run = resolved(robot_path, preset="paper", material={"youngs_modulus": 1e7})
    with pytest.warns(UserWarning, match="substep of 0.0002 s is too long for this material"):
        config = fuse(run.template, body, ForceField())
    assert config.timing.substep_dt == "auto" and find_stable_step(config, body) < 2e-4
