"""M = 1 shows on parts, and on what is held: measured responses against closed forms, and on simulated particles."""

import itertools

import numpy as np
import pytest
import trimesh

from physagent_jax.forces import calibration
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.forces.schema import ForceField
from physagent_jax.scene.config import Anchor, Material
from physagent_jax.scene.response import Setting, find_responses
from physagent_jax.simulation.simulate import simulate_frames
from tests.scene.test_equilibrium import scene_of
from tests.scene.test_standing import template_of

E, RHO, WIDTH = 2e5, 500.0, 0.4
TOP = dict(kind="half_space", point=(0.5, 0.5, 0.7), normal=(0, 0, 1))
SETTINGS = dict(free=dict(world="free"), stands={}, held=dict(anchor=dict(kind="base")))
MATTER = dict(soft=(1e5, 400.0), stiff=(5e6, 1000.0))


@pytest.fixture(scope="module")
def bar(tmp_path_factory):
    path = tmp_path_factory.mktemp("bar") / "thing.obj"
    trimesh.creation.box((WIDTH, WIDTH, 1.0)).export(path)
    return path


@pytest.fixture(scope="module")
def body(bar):
    return template_of(bar, overrides={"max_particles": 4000, "cells": 64})[1]


def field_of(kind, vector, region=TOP, group="actions", **more):
    name = "action_type" if group == "actions" else "constraint_type"
    entry = {name: kind, "vector": vector, "magnitude": 1.0, "region": region, **more}
    return ForceField.model_validate({group: [entry]})


def respond(body, field, *, E=E, rho=RHO, anchor="none", time=2.0):
    material = Material(youngs_modulus=E, poissons_ratio=0.0, density=rho)
    held = Anchor.model_validate(dict(kind=anchor, fraction=0.1))
    setting = Setting(body, material, held, False, False, None, time)
    (response,) = find_responses(setting, field)
    return response.k


def test_a_part_of_a_rigid_free_bar_takes_it_along(body):
    """The top of a uniform bar under a force at its own centre: a / k = m/M + m r^2 / I for the part's centre."""
    share, arm = 0.3, 0.35
    follows = share + share * arm**2 / ((1 + WIDTH**2) / 12)
    k = respond(body, field_of("translation", (1, 0, 0)), E=1e9)
    way = min(calibration.PART_SHIFT, calibration.PART_BEND * WIDTH)
    assert k == pytest.approx(2 * way / (follows * 2.0**2), rel=0.1)


def test_a_stretch_of_a_held_bar_is_that_of_bars(body):
    """A bar fixed at one end, pulled by a on its upper half and pushed down on its lower half."""
    k = respond(body, field_of("scale", (0, 0, 1), region=None), anchor="base")
    free = 0.9  # strain rho k (h - |z - middle|) / E, whose mean is rho k h / 4 E
    assert k == pytest.approx(4 * E * calibration.PART_STRAIN / (RHO * free), rel=0.35)


def test_k_goes_with_the_stiffness_where_only_that_resists(body):
    soft, stiff = (respond(body, field_of("torque", (0, 0, 1)), E=e, anchor="base") for e in (1e6, 1e8))
    assert stiff == pytest.approx(100 * soft, rel=0.05)


def test_nothing_is_measured_where_the_free_path_suffices(body):
    material = Material(youngs_modulus=E, poissons_ratio=0.3, density=RHO)
    setting = Setting(body, material, Anchor(kind="none"), False, False, None, 2.0)
    assert find_responses(setting, field_of("translation", (1, 0, 0), region=None)) == ()
    assert (
        find_responses(setting, field_of("enforce_particle_translation", (1, 0, 0), group="constraints"))
        == ()
    )


def move(path, setting, matter, field):
    """Largest way of the part along x, turn about z [degrees] and strain along z, and those of the rest."""
    e, rho = MATTER[matter]
    scene, _ = scene_of(
        path,
        frames=51,
        cells=40,
        particles=1200,
        field=field,
        material={"youngs_modulus": e, "density": rho, "name": "neo_hookean"},
        **SETTINGS[setting],
    )
    rest = np.asarray(scene.state.x, float)
    (entry,) = (*field.actions, *field.constraints)
    mask = make_region_mask(entry.region, rest)
    arm = rest[mask] - rest[mask].mean(0)
    ways, turns, strains = [], [], []
    for frame in simulate_frames(scene):
        x = np.asarray(frame.state.x, float)
        assert np.isfinite(x).all()
        ways.append((x - rest)[mask, 0].mean())
        now = x[mask] - x[mask].mean(0)
        across = (arm[:, 0] * now[:, 1] - arm[:, 1] * now[:, 0]).sum()
        turns.append(np.degrees(np.arctan2(across, (arm[:, :2] * now[:, :2]).sum())))
        strains.append(np.linalg.lstsq(arm, now, rcond=None)[0][2, 2] - 1)
    return tuple(max(each, key=abs) for each in (ways, turns, strains))


USUAL = [("free", "soft"), ("stands", "stiff"), ("held", "soft")]


@pytest.mark.parametrize(
    ("setting", "matter"),
    [
        pair if pair in USUAL else pytest.param(*pair, marks=pytest.mark.slow)
        for pair in itertools.product(SETTINGS, MATTER)
    ],
)
def test_a_push_of_a_part_shows(bar, setting, matter):
    way, _, _ = move(bar, setting, matter, field_of("translation", (1, 0, 0)))
    assert 0.13 < way < 0.7  # plain, for an end


@pytest.mark.parametrize(
    ("setting", "matter"),
    [
        pytest.param("free", "stiff", marks=pytest.mark.slow),
        ("stands", "stiff"),
        pytest.param("held", "soft", marks=pytest.mark.slow),
    ],
)
def test_a_turn_of_a_part_shows(bar, setting, matter):
    _, turn, _ = move(bar, setting, matter, field_of("torque", (0, 0, 1)))
    assert 20 < turn < 75


@pytest.mark.parametrize(("setting", "matter"), [("stands", "stiff"), ("held", "soft")])
def test_a_stretch_of_a_part_shows(bar, setting, matter):
    _, _, strain = move(bar, setting, matter, field_of("scale", (0, 0, 1)))
    assert 0.1 < strain < 0.55


@pytest.mark.parametrize("matter", ["soft", pytest.param("stiff", marks=pytest.mark.slow)])
def test_a_blow_on_a_part_of_what_is_held_shows(bar, matter):
    field = field_of("particle_impulse", (1, 0, 0), group="constraints", active_time=(0, 1))
    way, _, _ = move(bar, "held", matter, field)
    assert 0.13 < way < 0.7


def test_the_strongest_stretch_tears_nothing(tmp_path):
    path = tmp_path / "thing.obj"
    trimesh.creation.cylinder(0.5, 0.7).export(path)
    pull = {"action_type": "scale", "vector": (0, 0, 1), "magnitude": calibration.MAGNITUDE_MAX}
    scene, _ = scene_of(
        path,
        frames=26,
        cells=40,
        particles=3000,
        field=ForceField.model_validate({"actions": [pull]}),
        material={"youngs_modulus": 2e4, "density": 400.0, "name": "neo_hookean"},
        **SETTINGS["held"],
    )
    heights = np.array([np.ptp(np.asarray(frame.state.x)[:, 2]) for frame in simulate_frames(scene)])
    assert 1.15 < heights.max() / heights[0] < 1.6
