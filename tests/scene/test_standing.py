"""A captured object stands in the scene: its stiffness bears its weight, or it is held."""

import dataclasses

import numpy as np
import pytest
import trimesh

from physagent_jax.forces.calibration import GRAVITY
from physagent_jax.forces.schema import ForceField
from physagent_jax.run.resolve import resolve
from physagent_jax.run.spec import RunSpec
from physagent_jax.scene import burden
from physagent_jax.scene import standing as standing_module
from physagent_jax.scene.anchor import select_anchored
from physagent_jax.scene.body import make_body
from physagent_jax.scene.burden import measure_burden
from physagent_jax.scene.fuse import fuse
from physagent_jax.scene.materials.cost import AFFORDABLE_RATE, count_substeps
from physagent_jax.scene.standing import (
    LANDING,
    Support,
    find_bearing_modulus,
    find_own_burden,
    find_own_firmness,
    hold_upright,
    make_stand,
)
from tests.scene.quiet_objects import export
from tests.scene.test_equilibrium import farthest, scene_of
from tests.scene.test_named_parts import write_glb


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
    used = burden.share
    assert 0.85 < used <= 1.0


def test_thin_legs_need_more(table, tmp_path):
    template, thick, _ = template_of(table)
    _, thin, _ = template_of(export_table(tmp_path / "cow.obj", leg=0.14))
    assert find_bearing_modulus(template, thin) > 1.5 * find_bearing_modulus(template, thick)


def test_a_prior_too_soft_for_its_legs_is_made_stiffer_and_says_so(table):
    template, body, chosen = template_of(table)
    standing, notes = make_stand(template, body, Support(keep_material=chosen))
    assert standing.material.youngs_modulus == template.material.youngs_modulus
    needed = find_bearing_modulus(template, body) / template.material.youngs_modulus
    assert 1.0 < needed < 1.5 * standing.bearing.most
    assert standing.bearing.most == find_own_firmness(standing, body).max()
    assert standing.world == template.world
    assert len(notes) == 1 and "own weight" in notes[0] and notes[0] in standing.material.reason
    assert "Pa" not in notes[0]


@pytest.mark.parametrize(("name", "kind"), [("mushroom", "object"), ("plant", "plant")])
def test_only_the_parts_that_bear_become_stiffer_and_then_they_do(name, kind, tmp_path):
    """A heavy crown on a thin stem: the stem is stiffened, and the crown stays soft."""
    stem = trimesh.creation.cylinder(0.09, 0.75).apply_translation((0, 0, 0.375))
    crown = trimesh.creation.icosphere(radius=0.4).apply_scale((1, 1, 0.5)).apply_translation((0, 0, 0.8))
    foot = trimesh.creation.cylinder(0.16, 0.05).apply_translation((0, 0, 0.02))
    trimesh.util.concatenate([stem, crown, foot]).export(tmp_path / "thing.obj")
    template, body, _ = template_of(
        tmp_path / "thing.obj", object={"path": str(tmp_path / "thing.obj"), "up": "+z", "kind": kind}
    )
    standing, _ = make_stand(template, body)
    firmness, height = (
        find_own_firmness(standing, body),
        body.particles.x[:, 2] - body.particles.x[:, 2].min(),
    )
    in_stem, above = (0.3 < height) & (height < 0.45), height > 0.85
    assert np.median(firmness[in_stem]) > 3 * np.median(firmness[above])
    assert np.median(firmness[above]) < 1.5
    firm = measure_burden(
        body,
        standing.material,
        standing.anchor,
        ground=standing.bearing.ground,
        dx=standing.preset.domain.dx,
        firmness=firmness,
    )
    assert standing.bearing.weight * firm.share < 1.05


def test_a_thin_neck_that_would_tear_is_found(tmp_path):
    """Few particles are in the neck, and most of the object hangs on it."""
    neck = trimesh.creation.cylinder(0.05, 0.2).apply_translation((0, 0, 0.8))
    head, trunk = (trimesh.creation.box((side, side, 0.6 * side)) for side in (0.2, 0.8))
    parts = [neck, head.apply_translation((0, 0, 0.94)), trunk.apply_translation((0, 0, 0.48))]
    trimesh.util.concatenate(parts).export(tmp_path / "cow.obj")
    template, body, _ = template_of(tmp_path / "cow.obj", anchor={"kind": "top"})
    standing, notes = make_stand(template, body)
    assert notes and standing.bearing.most > 2.0


def test_what_is_to_get_up_where_it_lands_bears_more_than_its_weight(table):
    """A rabbit of jelly that just bore its weight stayed as flat as its fall had pressed it."""
    template, body, _ = template_of(table)
    stands, lands = (make_stand(template, body, Support(lands=lands))[0] for lands in (False, True))
    assert lands.bearing.weight == LANDING > stands.bearing.weight == 1.0
    assert lands.bearing.most == pytest.approx(LANDING * stands.bearing.most, rel=0.1)
    chosen = make_stand(template, body, Support(keep_material=True, lands=True))[0]
    assert chosen.bearing is None and chosen.material == template.material


def test_what_is_to_land_limp_need_not_stand(table):
    """A rubber sword that "flops" was as stiff as one that stands on its hilt."""
    template, body, _ = template_of(table)
    stands, flops = (make_stand(template, body, Support(flops=flops))[0] for flops in (False, True))
    assert flops.bearing is None or flops.bearing.most < 0.3 * stands.bearing.most


def test_less_weight_acts_where_a_chosen_stiffness_does_not_bear_it(table):
    template, body, chosen = template_of(table, material={"youngs_modulus": 3e4})
    standing, notes = make_stand(template, body, Support(keep_material=chosen))
    assert standing.material == template.material and standing.bearing is None
    needed = find_bearing_modulus(template, body)
    assert standing.world.gravity == "down" and standing.world.ground
    assert standing.world.weight == pytest.approx(3e4 / needed, rel=0.1)
    assert find_own_burden(standing, body).share * standing.world.weight <= 1.0
    assert len(notes) == 1 and f"`material.youngs_modulus` {needed:.2g} carries it" in notes[0]
    assert "% of its weight acts" in notes[0] and "Pa" not in notes[0]


def test_what_is_to_fall_keeps_its_weight_and_what_follows_is_said(table):
    template, body, chosen = template_of(table, material={"youngs_modulus": 3e4})
    standing, notes = make_stand(template, body, Support(keep_material=chosen, keep_weight=True))
    assert standing == template and len(notes) == 1 and "sag or collapse" in notes[0]


def test_what_no_affordable_stiffness_carries_bears_as_much_of_its_weight_as_it_can(tmp_path):
    template, body, _ = template_of(tmp_path, object=export("lamp", tmp_path))
    standing, notes = make_stand(template, body)
    assert standing.world.gravity == "down" and 0 < standing.world.weight < 1
    assert len(notes) == 2 and "slowly" in notes[1] and "% of its weight acts" in notes[1]
    assert standing.anchor.kind == "base" and "feet are held" in notes[0]  # else it would float off
    assert make_stand(template, body, Support(let_go=True))[0].anchor.kind == "none"
    dx, E = template.preset.domain.dx, template.material.youngs_modulus * standing.bearing.most
    stiffest = template.material.changed(youngs_modulus=E)
    assert count_substeps(stiffest, dx, 10.0) == pytest.approx(10 * AFFORDABLE_RATE, rel=0.1)
    assert fuse(standing, body, ForceField()).gravity[2] == -GRAVITY * standing.world.weight
    assert fuse(standing, body, ForceField(default_drop=True)).gravity[2] == -GRAVITY


COARSE = {"overrides": {"max_particles": 1500, "cells": 48}}


def export_leaning(path, lean):
    """A slab on a foot, its mass centre ``lean`` beyond the middle of the foot."""
    foot = trimesh.creation.box((0.3, 0.3, 0.6)).apply_translation((0, 0, 0.3))
    slab = trimesh.creation.box((0.5, 0.4, 0.4)).apply_translation((lean, 0, 0.8))
    trimesh.util.concatenate([foot, slab]).export(path)
    return path


def test_feet_are_held_only_of_what_would_fall_over(tmp_path):
    template, body, _ = template_of(export_leaning(tmp_path / "thing.obj", 0.05), **COARSE)
    assert hold_upright(template, body) == (template, ())
    template, body, _ = template_of(export_leaning(tmp_path / "other.obj", 0.35), **COARSE)
    standing, notes = make_stand(template, body)
    assert standing.anchor.kind == "base" and standing.world.ground and standing.world.gravity == "down"
    assert "feet are held" in notes[0] and standing.anchor.reason == notes[0]
    free, notes = make_stand(template, body, Support(let_go=True))
    assert free.anchor.kind == "none" and free.world.gravity == "none" and "without weight" in notes[0]
    falling = make_stand(template, body, Support(let_go=True, keep_weight=True))[0]
    assert falling.anchor.kind == "none" and falling.world == template.world
    opposition = fuse(falling, body, ForceField()).scaling.opposition
    assert opposition.tipping > 1.0  # [1/s^2], which a tip to the other side overcomes


@pytest.mark.parametrize(
    ("width", "struck", "held"), [(0.04, None, True), (0.3, None, False), (0.3, (0.0, 0.0, -1.0), True)]
)
def test_feet_are_held_of_what_a_touch_or_the_blow_would_topple(width, struck, held, tmp_path):
    """A pole that stands on so little, and a pillar only where it is hit from above."""
    trimesh.creation.box((width, width, 1.0)).export(tmp_path / "thing.obj")
    template, body, _ = template_of(tmp_path / "thing.obj", **COARSE)
    assert (hold_upright(template, body, Support(struck=struck))[0].anchor.kind == "base") is held
    assert hold_upright(template, body, Support(struck=struck, let_go=True)) == (template, ())


def test_what_is_rigid_is_not_held_for_what_its_stand_in_would_bear(tmp_path, monkeypatch):
    monkeypatch.setattr(standing_module, "LIGHT", 2.0)  # of its weight: nothing bears so much
    template, body, _ = template_of(export_leaning(tmp_path / "thing.obj", 0.05), **COARSE)
    assert hold_upright(template, body)[0].anchor.kind == "base"
    assert hold_upright(template, body, Support(rigid=True)) == (template, ())


def test_the_half_behind_is_held_of_what_is_dented(tmp_path):
    """Held at its feet alone, a truck was torn off its wheels."""
    trimesh.creation.box((1.0, 0.5, 0.5)).export(tmp_path / "thing.obj")
    template, body, _ = template_of(tmp_path / "thing.obj", **COARSE)
    anchor = hold_upright(template, body, Support(struck=(1.0, 0.0, 0.0)))[0].anchor
    held = select_anchored(anchor, body.particles.x, body.particles.gaussian_index, ".")
    x = body.particles.x[:, 0]
    assert held.any() and (held == (x > x.mean())).mean() > 0.95


@pytest.mark.parametrize("parts", [{"world": "free"}, {"material": {"name": "sand"}}])
def test_what_floats_or_flows_bears_nothing(table, parts):
    template, body, _ = template_of(table, **parts)
    assert make_stand(template, body) == (template, ())


def test_on_its_own_legs_it_does_not_move(table):
    scene, notes = scene_of(table, cells=64, particles=3000)
    assert notes and farthest(scene) < 0.01


def test_an_object_is_weighed_once_for_each_material(table, monkeypatch):
    """Scenes of it differ in what acts, and there may be hundreds."""
    template, body, _ = template_of(table)
    weighed, measure = [], burden.measure_burden
    monkeypatch.setattr(
        burden, "measure_burden", lambda *given, **more: weighed.append(given) or measure(*given, **more)
    )
    first = make_stand(template, body)
    assert make_stand(template, body) == first and len(weighed) == 2  # before and after it is made stiffer
    other = dataclasses.replace(template, material=template.material.changed(density=50.0))
    assert find_bearing_modulus(other, body) < find_bearing_modulus(template, body)
    assert len(weighed) == 3


def test_the_pot_of_a_plant_is_held_up_to_its_rim(tmp_path):
    """It bent with the plant in the wind: only a fifth of the height was held."""
    pot = trimesh.creation.cylinder(0.3, 0.5)
    plant = trimesh.creation.cylinder(0.12, 0.6).apply_translation((0, 0, 0.5))
    path = write_glb(tmp_path / "cactus.glb", {"pot": pot, "plant": plant})
    template, body, _ = template_of(path, object={"path": str(path), "kind": "plant"})
    held, _ = hold_upright(template, body)
    assert held.anchor.fraction == pytest.approx(0.5 / 1.05, abs=0.06)
    assert held.anchor.fraction > template.anchor.fraction
    table = dataclasses.replace(template, source=template.source.model_copy(update={"kind": "furniture"}))
    assert hold_upright(table, body)[0].anchor == template.anchor
