"""The front door: a handful of verbs, imported when they are asked for, that give what the command line gives."""

import subprocess
import sys
import time

import numpy as np
import pytest

import physagent_jax as pa
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import Action, ActionType, ForceField
from physagent_jax.output.motion_file import Motion
from physagent_jax.run.finished import open_run
from tests.run.specs import LEFT, small

SMALL = dict(frame_count=6, width=64, height=64)


def test_importing_it_is_quick_and_loads_neither_jax_nor_numpy():
    """A few modules of its own and of Python, and no other package: seconds would depend on the machine."""
    code = (
        "import sys; before = set(sys.modules); import physagent_jax; new = set(sys.modules) - before\n"
        "packages = {name.split('.')[0] for name in new} - set(sys.stdlib_module_names)\n"
        "print(len(new), *packages)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    count, *packages = run.stdout.split()
    assert packages == ["physagent_jax"] and int(count) < 60


def test_every_name_is_there_and_no_other():
    for name in pa.__all__:
        assert getattr(pa, name) is not None
    assert set(pa.__all__) <= set(dir(pa))
    with pytest.raises(AttributeError, match="no attribute 'simulate_sceen'"):
        pa.simulate_sceen  # type: ignore[attr-defined]  # noqa: B018


@pytest.fixture(scope="module")
def robot(robot_path):
    with pytest.warns(UserWarning, match="thinly filled"):
        return pa.load_object(robot_path, max_particles=600, cells=48)


@pytest.fixture(scope="module")
def pushed(robot):
    return pa.simulate_scene(pa.build_scene(robot, LEFT, **SMALL))


def test_a_sentence_becomes_motion(pushed):
    """To the viewer's left, which is -x for a camera in front."""
    moved = pushed.gaussians[-1].mean(0) - pushed.gaussians[0].mean(0)
    assert moved[0] < -0.3 and np.abs(moved[1:]).max() < 0.1


def test_the_scene_is_the_one_of_a_run(robot_path, robot, tmp_path):
    """A finished run, opened as an object, has the same scene, file names of the prompt apart."""
    spec = small(robot_path, LEFT, frames=6, particles=600, resolution=64, rounds=1)
    run = pa.synthesize(spec, tmp_path / "run")
    scene = pa.build_scene(robot, LEFT, **SMALL)
    assert run.scene == scene.config
    assert run.spec == spec and run.report is not None and run.best is not None
    assert run.frames().shape == (6, 64, 64, 3)
    motion = run.motion()
    assert isinstance(motion, Motion) and motion.x.shape[0] == 6
    assert run.best.judgement is not None and run.best.simulation is not None
    assert open_run(run.folder) == run
    recording = pa.simulate_scene(scene)
    np.testing.assert_allclose(motion.x, recording.x[:, scene.back], atol=1e-3)
    np.testing.assert_array_less(np.abs(run.frames().astype(int) - recording.rgb).mean(), 6)


def test_a_force_field_in_place_of_a_sentence(robot):
    up = {"actions": [{"action_type": "translation", "vector": [0, 0, 1], "magnitude": 1.0}]}
    recording = pa.simulate_scene(pa.build_scene(robot, force_field=up, **SMALL))
    moved = recording.gaussians[-1].mean(0) - recording.gaussians[0].mean(0)
    assert moved[2] > 0.3
    still = pa.simulate_scene(pa.build_scene(robot, **SMALL))
    assert np.abs(still.x[-1] - still.x[0]).max() < 1e-6


def test_scenes_of_a_loaded_object_do_not_read_its_file_again(robot, monkeypatch):
    """Optimisation makes hundreds."""
    read = []
    monkeypatch.setattr("physagent_jax.run.resolve.level", lambda *given: read.append(given))
    push = Action(action_type=ActionType.TRANSLATION, vector=(1, 0, 0), magnitude=0.4)
    scene = pa.build_scene(robot, force_field=ForceField(actions=(push,)), anchor="none", **SMALL)
    assert scene.config.source == robot.source and not read


def test_choices_are_those_of_a_spec(robot):
    scene = pa.build_scene(robot, material="muscle", anchor="top", camera={"azimuth_degrees": 90.0}, **SMALL)
    assert scene.config.material.reason and scene.anchored > 0
    assert scene.config.camera.azimuth_degrees == 90.0


def test_pictures_from_another_camera(pushed):
    np.testing.assert_array_equal(pa.render_recording(pushed), pushed.rgb)
    camera = pa.look_at((6, 2, 2), (2, 2, 2), (0, 0, 1), fov_degrees=40, width=48, height=32)
    pictures = pa.render_recording(pushed, camera, frames=[0, -1], background=(0, 0, 0))
    assert pictures.shape == (2, 32, 48, 3) and pictures.dtype == np.uint8
    assert pictures[0].max() > 50 and (pictures[0, 0, 0] == 0).all()
    # From +x, what moves to -x goes away: it gets smaller.
    assert (pictures[1].max(-1) > 30).sum() < (pictures[0].max(-1) > 30).sum()
    with pytest.raises(UserError, match="frames that there are not"):
        pa.render_recording(pushed, frames=[6])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (dict(prompt="push it left", force_field={}), "both say what acts"),
        (dict(prompt="colourless green ideas"), "understood|nothing"),
        (dict(force_field={"actions": [{"action_type": "pushh"}]}), "pushh|action_type"),
        (dict(material="jely"), "jelly"),
        (dict(anchor="bottom"), "anchor.kind"),
        (dict(frame_count=0), "frame_count"),
        (dict(camera={"azimut": 3}), "azimuth_degrees"),
    ],
)
def test_what_makes_no_sense_is_refused(options, words, robot):
    with pytest.raises(UserError, match=words):
        pa.build_scene(robot, **options)


def test_a_spec_file_is_a_run(tmp_path, robot_path):

    path = tmp_path / "spec.json"
    path.write_text(small(robot_path, frames=3, particles=300, resolution=32, rounds=1).model_dump_json())
    begun = time.time()
    run = pa.synthesize(path, tmp_path / "run")
    assert run.report is not None and run.report.stat().st_mtime >= begun - 1
    assert pa.synthesize(path, tmp_path / "run") == run  # it is there already
