"""The compliance of held bars, against the theory of bars, and the resulting pushes."""

import dataclasses

import numpy as np
import pytest
import trimesh

from physagent_jax.forces import calibration
from physagent_jax.forces.holding import OVERSHOOT, find_blow_scale, find_frequency, find_push_scale
from physagent_jax.forces.scaling import make_closed_form_scaling
from physagent_jax.forces.schema import ForceField, Holding
from physagent_jax.report.force_cards import make_force_cards, read_setting
from physagent_jax.scene.compliance import measure_compliance
from physagent_jax.scene.config import Anchor, Material
from physagent_jax.simulation.simulate import simulate_frames
from tests.scene.test_equilibrium import scene_of
from tests.scene.test_standing import template_of

E, RHO, WIDTH = 2e5, 300.0, 0.24
BASE = Anchor(kind="base", fraction=0.1)


@pytest.fixture(scope="module")
def bar(tmp_path_factory):
    path = tmp_path_factory.mktemp("bar") / "thing.obj"
    trimesh.creation.box((WIDTH, WIDTH, 1.0)).export(path)
    return path


@pytest.fixture(scope="module")
def found(bar):
    _, body, _ = template_of(bar, overrides={"max_particles": 8000, "cells": 96})
    material = Material(youngs_modulus=E, poissons_ratio=0.0, density=RHO)
    found = measure_compliance(body, material, BASE)
    assert found is not None
    return found


@pytest.fixture(scope="module")
def compliance(found):
    return np.array(found.mean)


def test_along_its_axis_it_gives_way_as_a_bar_does(compliance):
    free = 0.9
    assert compliance[2, 2] == pytest.approx(RHO * free**2 / (3 * E), rel=0.25)  # the grid is coarse


def test_across_its_axis_it_bends_as_a_beam_does(compliance):
    free = 0.9
    bending = 12 * RHO * free**4 / (20 * E * WIDTH**2)
    shear = RHO * free**2 / (3 * (5 / 6) * (E / 2))  # Timoshenko's, of a square section
    for axis in (0, 1):
        assert compliance[axis, axis] == pytest.approx(bending + shear, rel=0.2)
    assert np.abs(compliance - np.diag(np.diag(compliance))).max() < 0.05 * compliance[0, 0]


def test_it_swings_at_the_pace_of_a_beam(found):
    """The lowest mode of a cantilever, 3.516 / L^2 sqrt(E I / rho A); along itself pi / 2 L sqrt(E / rho)."""
    free = 0.9
    beam = 3.516 / free**2 * np.sqrt(E * WIDTH**2 / 12 / RHO)
    bar = np.pi / (2 * free) * np.sqrt(E / RHO)
    holding = Holding(compliance=found.mean, square=found.square, shift=0.17, least=0.5, most=33.0)
    x, _, z = np.eye(3)
    assert find_frequency(holding, x) == pytest.approx(beam, rel=0.15)  # of a thick beam it is lower
    assert find_frequency(holding, z) == pytest.approx(bar, rel=0.15)


def test_the_softest_matter_that_can_be_given_has_a_compliance_that_can_be_written(bar):
    """Linear elasticity: the compliance goes with rho / E."""
    _, body, _ = template_of(bar, overrides={"max_particles": 500, "cells": 16})
    soft, firm = (
        np.array(
            measure_compliance(body, Material(youngs_modulus=e, poissons_ratio=0.0, density=rho), BASE).mean
        )
        for e, rho in ((1e-3, 1e6), (1e5, 1e3))
    )
    np.testing.assert_allclose(soft, firm * 1e11, rtol=1e-6, atol=1e-3 * np.abs(soft).max())
    Holding(compliance=tuple(map(tuple, soft.tolist())), shift=0.1, least=1.0, most=2.0)


def test_nothing_held_or_all_of_it_has_none(bar):
    _, body, _ = template_of(bar)
    material = Material(youngs_modulus=E, poissons_ratio=0.3, density=RHO)
    assert measure_compliance(body, material, Anchor(kind="none")) is None
    everything = Anchor(kind="box", point=(2, 2, 2), half_size=(2, 2, 2))
    assert measure_compliance(body, material, everything) is None


def test_a_push_is_what_moves_it_so_far_within_limits():
    holding = Holding(
        compliance=((0.02, 0, 0), (0, 0.001, 0), (0, 0, 1e-6)), shift=0.17, least=0.5, most=33.0
    )
    x, y, z = np.eye(3)
    assert find_push_scale(holding, 1.0, x) == pytest.approx(0.17 / (OVERSHOOT * 0.02))
    assert find_push_scale(holding, 1.0, z) == 33.0
    assert find_push_scale(None, 1.0, x) == 1.0
    assert find_blow_scale(holding, 1.0, x) == pytest.approx(0.17 / np.sqrt(0.02))
    assert find_blow_scale(holding, 1.0, z) == pytest.approx(np.sqrt(0.17 * 33.0))
    assert find_blow_scale(None, 1.0, y) == 1.0


def test_the_report_shows_the_push_that_acts():
    holding = Holding(
        compliance=((0.02, 0, 0), (0, 0.001, 0), (0, 0, 1e-6)), shift=0.17, least=0.5, most=33.0
    )
    scaling = make_closed_form_scaling(
        extent=1.0, youngs_modulus=E, density=RHO, duration=0.7, holding=holding
    )
    field = ForceField.model_validate(
        {"actions": [{"action_type": "translation", "vector": [1, 0, 0], "magnitude": 1.0}]}
    )

    def show(scaling):
        return str(make_force_cards(field, dataclasses.replace(read_setting(None), scaling=scaling)))

    assert "1 means 5.3" in show(scaling)  # 0.17 / (1.6 x 0.02), not 2 / 0.7^2 = 4.1
    free = make_closed_form_scaling(extent=1.0, youngs_modulus=E, density=RHO, duration=0.7)
    assert "1 means 4.08" in show(free)


@pytest.mark.parametrize(
    "kind, youngs_modulus",
    [
        ("translation", 6e4),
        ("impulse", 6e5),
        pytest.param("translation", 6e5, marks=pytest.mark.slow),
        pytest.param("impulse", 6e4, marks=pytest.mark.slow),
    ],
)
def test_soft_and_stiff_bars_are_bent_alike(bar, kind, youngs_modulus):
    window = {} if kind == "translation" else {"active_time": (0, 2)}
    field = ForceField.model_validate(
        {"actions": [{"action_type": kind, "vector": [-1, 0, 0], "magnitude": 1.0, **window}]}
    )
    scene, _ = scene_of(
        bar,
        frames=40,
        cells=64,
        field=field,
        world="free",
        anchor={"kind": "base"},
        material={"youngs_modulus": youngs_modulus, "density": RHO},
    )
    rest = np.asarray(scene.state.x)
    way = max(-(np.asarray(frame.state.x) - rest)[:, 0].mean() for frame in simulate_frames(scene))
    # A blow of two frames is as long as a stiff bar takes to swing: it does less than one in an instant.
    assert 0.55 < way / calibration.EXPECTED_HELD_SHIFT < 1.35


@pytest.mark.parametrize(
    "youngs_modulus, half",
    [
        (6e4, 3),
        (6e5, 12),
        pytest.param(6e5, 3, marks=pytest.mark.slow),
        pytest.param(6e5, 6, marks=pytest.mark.slow),
    ],
)
def test_soft_and_stiff_bars_sway_alike_at_every_pace(bar, youngs_modulus, half):
    """Far below, near and far above their own pace: an oscillator answers each push otherwise."""
    edges = [0, *(half / 2 + half * i for i in range(5))]
    pushes = [
        {"action_type": "translation", "vector": [(-1) ** i, 0, 0], "magnitude": 1.0, "active_time": span}
        for i, span in enumerate(zip(edges, edges[1:]))
    ]
    field = ForceField.model_validate({"actions": pushes})
    scene, _ = scene_of(
        bar,
        frames=int(edges[-1]) + 1,
        cells=64,
        field=field,
        world="free",
        anchor={"kind": "base"},
        material={"youngs_modulus": youngs_modulus, "density": RHO},
    )
    rest = np.asarray(scene.state.x)
    way = np.ptp([(np.asarray(frame.state.x) - rest)[:, 0].mean() for frame in simulate_frames(scene)]) / 2
    assert 0.7 < way / calibration.EXPECTED_SWAY < 1.8
