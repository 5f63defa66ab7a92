"""A captured object stands in the scene: its stiffness bears its weight, or it is held."""

import dataclasses

import pytest
import trimesh

from physagent_jax.forces.calibration import GRAVITY
from physagent_jax.run.resolve import resolve
from physagent_jax.run.spec import RunSpec
from physagent_jax.scene import standing
from physagent_jax.scene.body import make_body
from physagent_jax.scene.compliance import measure_lean
from physagent_jax.scene.config import Material
from physagent_jax.scene.standing import MOST_LEAN, find_bearing_modulus, make_stand
from tests.scene.test_equilibrium import farthest, scene_of


def export_table(path, leg=0.2):
    """A slab on four legs that are half of the object's height."""
    parts = [trimesh.creation.box((1.0, 0.6, 0.3))]
    for x, y in ((-0.4, -0.2), (-0.4, 0.2), (0.4, -0.2), (0.4, 0.2)):
        parts.append(trimesh.creation.box((leg, leg, 0.4)).apply_translation((x, y, -0.25)))
    trimesh.util.concatenate(parts).export(path)
    return path


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    return export_table(tmp_path_factory.mktemp("table") / "cow.obj")


def template_of(path, **parts):
    spec = {
        "object": {"path": str(path), "up": "+z"},
        "prompt": "x",
        "overrides": {"max_particles": 6000, "cells": 96},
        **parts,
    }
    run = resolve(RunSpec.model_validate(spec))
    template = run.template
    body = make_body(template.source, template.preset.filling, template.preset.domain, ".")
    return template, body, run.spec.material.says_stiffness


def test_a_prism_is_strained_by_its_weight_as_a_bar_is(tmp_path):
    trimesh.creation.box((0.4, 0.4, 1.0)).export(tmp_path / "pillar.obj")
    _, body, _ = template_of(tmp_path / "pillar.obj")
    material = Material(youngs_modulus=5e4, poissons_ratio=0.0, density=700.0)
    strain = 0.95 * 700 * GRAVITY * 1.0 / 5e4  # at the height below which a twentieth of it is
    lean = measure_lean(body, material)
    assert 0.9 < lean / strain < 1.8  # cells are coarse, and their edges softer
    assert find_bearing_modulus(body, material) == pytest.approx(lean / MOST_LEAN * 5e4, rel=0.05)
    stiffer = Material(youngs_modulus=1e5, poissons_ratio=0.0, density=1400.0)
    assert measure_lean(body, stiffer) == pytest.approx(lean, rel=0.02)


def test_thin_legs_need_more(table, tmp_path):
    template, thick, _ = template_of(table)
    _, thin, _ = template_of(export_table(tmp_path / "cow.obj", leg=0.14))
    material = template.material
    assert find_bearing_modulus(thin, material) > 1.5 * find_bearing_modulus(thick, material)


def test_a_prior_too_soft_for_its_legs_is_made_stiffer_and_says_so(table):
    template, body, chosen = template_of(table)
    standing, notes = make_stand(template, body, keep_material=chosen)
    assert standing.material.youngs_modulus == find_bearing_modulus(body, template.material)
    assert standing.material.youngs_modulus > template.material.youngs_modulus
    assert len(notes) == 1 and "bears its weight" in notes[0] and notes[0] in standing.material.reason


def test_a_chosen_stiffness_stays_and_what_follows_is_said(table):
    template, body, chosen = template_of(table, material={"youngs_modulus": 3e4})
    standing, notes = make_stand(template, body, keep_material=chosen)
    assert standing == template and len(notes) == 1 and "sag" in notes[0]


@pytest.mark.parametrize(
    "parts", [{"world": "free"}, {"anchor": {"kind": "base"}}, {"material": {"name": "sand"}}]
)
def test_what_floats_is_held_or_flows_bears_nothing(table, parts):
    template, body, _ = template_of(table, **parts)
    assert make_stand(template, body) == (template, ())


def test_on_its_own_legs_it_does_not_move(table):
    scene, notes = scene_of(table, cells=96, particles=6000)
    assert notes and farthest(scene) < 0.01


def test_an_object_is_weighed_once_for_each_material(table, monkeypatch):
    """Scenes of it differ in what acts, and there may be hundreds."""
    template, body, _ = template_of(table)
    weighed, measure = [], standing.measure_lean
    monkeypatch.setattr(standing, "measure_lean", lambda *given: weighed.append(given) or measure(*given))
    first = make_stand(template, body)
    assert make_stand(template, body) == first and len(weighed) == 1
    other = dataclasses.replace(template, material=template.material.changed(density=50.0))
    assert make_stand(other, body)[0].material.youngs_modulus < first[0].material.youngs_modulus
    assert len(weighed) == 2
