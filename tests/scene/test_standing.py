"""A captured object stands in the scene: its stiffness bears its weight, or it is held."""

import dataclasses

import pytest
import trimesh

from physagent_jax.run.resolve import resolve
from physagent_jax.run.spec import RunSpec
from physagent_jax.scene import burden
from physagent_jax.scene.body import make_body
from physagent_jax.scene.config import Anchor
from physagent_jax.scene.fuse import find_own_burden
from physagent_jax.scene.materials.cost import AFFORDABLE_RATE, count_substeps
from physagent_jax.scene.standing import MOST_BUCKLING, MOST_STRAIN, find_bearing_modulus, make_stand
from tests.scene.quiet_objects import export
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


def test_the_modulus_that_bears_meets_both_limits(table):
    template, body, _ = template_of(table)
    stiff = template.material.changed(youngs_modulus=find_bearing_modulus(template, body))
    burden = find_own_burden(dataclasses.replace(template, material=stiff), body)
    used = max(burden.strain / MOST_STRAIN, burden.buckling / MOST_BUCKLING)
    assert 0.85 < used <= 1.0


def test_thin_legs_need_more(table, tmp_path):
    template, thick, _ = template_of(table)
    _, thin, _ = template_of(export_table(tmp_path / "cow.obj", leg=0.14))
    assert find_bearing_modulus(template, thin) > 1.5 * find_bearing_modulus(template, thick)


def test_a_prior_too_soft_for_its_legs_is_made_stiffer_and_says_so(table):
    template, body, chosen = template_of(table)
    standing, notes = make_stand(template, body, keep_material=chosen)
    assert standing.material.youngs_modulus == find_bearing_modulus(template, body)
    assert standing.material.youngs_modulus > template.material.youngs_modulus
    assert standing.world == template.world
    assert len(notes) == 1 and "own weight" in notes[0] and notes[0] in standing.material.reason
    assert "Pa" not in notes[0]


def test_a_chosen_stiffness_stays_and_the_weight_is_left_out_instead(table):
    template, body, chosen = template_of(table, material={"youngs_modulus": 3e4})
    standing, notes = make_stand(template, body, keep_material=chosen)
    assert standing.material == template.material and standing.world.gravity == "none"
    needed = f"{find_bearing_modulus(template, body):.2g}"
    assert len(notes) == 1 and f"`material.youngs_modulus` {needed} carries it" in notes[0]
    assert "in the air" in notes[0] and "Pa" not in notes[0]
    held, notes = make_stand(
        dataclasses.replace(template, anchor=Anchor(kind="base", fraction=0.1)), body, keep_material=chosen
    )
    assert held.world.gravity == "none" and held.world.ground and "its weight is left out" in notes[0]


def test_what_is_to_fall_keeps_its_weight_and_what_follows_is_said(table):
    template, body, chosen = template_of(table, material={"youngs_modulus": 3e4})
    standing, notes = make_stand(template, body, keep_material=chosen, keep_weight=True)
    assert standing == template and len(notes) == 1 and "sag or collapse" in notes[0]


def test_what_no_affordable_stiffness_carries_is_held_without_weight(tmp_path):
    template, body, _ = template_of(tmp_path, object=export("lamp", tmp_path))
    standing, notes = make_stand(template, body)
    assert standing.world.gravity == "none" and len(notes) == 1 and "slowly" in notes[0]
    dx = template.preset.domain.dx
    assert count_substeps(standing.material, dx, 10.0) == pytest.approx(10 * AFFORDABLE_RATE, rel=0.01)


@pytest.mark.parametrize("parts", [{"world": "free"}, {"material": {"name": "sand"}}])
def test_what_floats_or_flows_bears_nothing(table, parts):
    template, body, _ = template_of(table, **parts)
    assert make_stand(template, body) == (template, ())


def test_on_its_own_legs_it_does_not_move(table):
    scene, notes = scene_of(table, cells=96, particles=6000)
    assert notes and farthest(scene) < 0.01


def test_an_object_is_weighed_once_for_each_material(table, monkeypatch):
    """Scenes of it differ in what acts, and there may be hundreds."""
    template, body, _ = template_of(table)
    weighed, measure = [], burden.measure_burden
    monkeypatch.setattr(
        burden, "measure_burden", lambda *given, **more: weighed.append(given) or measure(*given, **more)
    )
    first = make_stand(template, body)
    assert make_stand(template, body) == first and len(weighed) == 1
    other = dataclasses.replace(template, material=template.material.changed(density=50.0))
    assert make_stand(other, body)[0].material.youngs_modulus < first[0].material.youngs_modulus
    assert len(weighed) == 2
