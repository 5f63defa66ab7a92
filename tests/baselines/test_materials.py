"""Materials that tasks are given: what the scene is made of, what is refused, and that a run says which it was."""

import json
from pathlib import Path

import numpy as np
import pytest

from baselines.materials import SETTINGS, choose_material
from baselines.objects import OBJECTS
from baselines.run import Command, solve
from baselines.tasks import load_tasks, make_task
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import Action, ActionType, ForceField
from physagent_jax.scene.priors import choose_material as choose_prior

TASKS = Path(__file__).parents[2] / "benchmarks" / "tasks"


def make(folder, material):
    (spec,) = [spec for spec in load_tasks(TASKS) if spec.name == "stretch-jelly-wide"]
    return make_task(spec, folder, None, material)


@pytest.mark.parametrize(
    ("setting", "youngs_modulus"),
    [
        ("own", 2e4),
        ("softer", 2e4 / 3),
        ("stiffer", 6e4),
        ("omniphysgs", 2e6),
        ('{"youngs_modulus": 1e5}', 1e5),
    ],
)
def test_the_scene_is_made_of_what_is_asked_for(setting, youngs_modulus, tmp_path):
    task = make(tmp_path, setting)
    material = task.build(task.start).config.material
    assert material.youngs_modulus == pytest.approx(youngs_modulus) and material.density == 400.0


def test_what_the_kind_implies_is_what_a_user_gets_who_says_nothing(tmp_path):
    task = make(tmp_path, "implied")
    material, prior = task.build(task.start).config.material, choose_prior("jelly")
    assert (material.youngs_modulus, material.density) == (prior.youngs_modulus, prior.density)
    assert choose_material("wet_sand", OBJECTS["jelly"]) == "wet_sand"


def test_the_target_is_the_same_and_the_motion_is_not(tmp_path):
    """A soft object is stretched more by the same force field."""
    soft, stiff = make(tmp_path, "softer"), make(tmp_path, "stiffer")
    assert soft.target == stiff.target
    pull = ForceField(actions=(Action(action_type=ActionType.SCALE, vector=(1, 0, 0), magnitude=0.6),))
    pulled = [np.ptp(task.simulate(pull)[:, :, 0], axis=1).max() for task in (soft, stiff)]
    assert pulled[0] > pulled[1] + 0.005


@pytest.mark.parametrize("setting", ["sofer", "{bad", '{"youngs": 1}'])
def test_unknown_materials_are_refused(setting, tmp_path):
    with pytest.raises(UserError):
        make(tmp_path, setting)


def test_a_run_says_which_material_it_was_and_is_not_taken_for_another(tmp_path):
    command = Command(
        method="random", task="stretch-jelly-wide", budget=1.0, material="softer", out=tmp_path / "run"
    )
    solve(command)
    assert "6666" in json.dumps(json.loads((tmp_path / "run" / "scene.json").read_text()))
    with pytest.raises(UserError, match="another run"):
        solve(Command(method="random", task="stretch-jelly-wide", budget=1.0, out=tmp_path / "run"))


def test_every_setting_has_a_material_of_every_object():
    for thing in OBJECTS.values():
        assert len({str(setting(thing)) for setting in SETTINGS.values()}) == len(SETTINGS)
