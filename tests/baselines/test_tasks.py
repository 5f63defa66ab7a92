"""Benchmark tasks: their files are complete and guarded, none is impossible, and wrong clips fail."""

import dataclasses
import json
import shutil
import warnings
from pathlib import Path

import numpy as np
import pytest

from baselines.objects import OBJECTS, find_file
from baselines.record import main as record_again
from baselines.recovery import compare_fields, measure_identifiability
from baselines.task_files import record_target, stamp, write_tasks
from baselines.tasks import FAMILIES, START, load_tasks, load_witnesses, make_task, split_available
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField

FOLDER = Path(__file__).resolve().parents[2] / "benchmarks" / "tasks"
DATA = FOLDER.parents[2] / "shared" / "data"
ALL = load_tasks(FOLDER)
WITNESSES = load_witnesses(FOLDER)
HERE = {spec.name: spec for spec in split_available(ALL, None)[0]}
QUICK = ("twist-robot-quarter", "recovery-jelly-push")
"""Tasks of which the default suite plays the witness; the slow one plays all."""

LATE = 4  # of the clip that a late clip begins after: one part of so many
BURST = 3.0  # times its size


def spread(x):
    """Displacements from the rest pose, shape (T, n, 3)."""
    return x - x[:1]


def delay(x):
    """The same motion a quarter of the clip later."""
    wait = len(x) // LATE
    return np.concatenate([np.repeat(x[:1], wait, axis=0), x[: len(x) - wait]])


def explode(x):
    """The same motion while the particles fly apart."""
    growth = np.linspace(0, BURST - 1, len(x))[:, None, None]
    return x + growth * (x[:1] - x[:1].mean(1, keepdims=True))


WRONG = {
    "still": lambda x: np.repeat(x[:1], len(x), axis=0),
    "mirrored": lambda x: x[:1] - spread(x),  # every particle goes the other way
    "late": delay,
    "half": lambda x: x[:1] + 0.5 * spread(x),
    "twice": lambda x: x[:1] + 2.0 * spread(x),
    "exploded": explode,
}
RIGHT_ALL_THE_SAME: dict[str, tuple[str, ...]] = {}
"""Tasks for which a wrong clip is not wrong: none so far; what is listed here is not counted."""


def test_there_are_enough_tasks_of_every_family_on_enough_objects():
    for family in FAMILIES:
        of_family = [spec for spec in ALL if spec.family == family]
        assert len(of_family) >= 8, family
        assert {spec.split for spec in of_family} == {"development", "test"}, family
    used = {spec.object for spec in ALL}
    assert len(used) >= 5 and sum(OBJECTS[name].captured is not None for name in used) >= 3
    assert len({spec.sentence for spec in ALL}) == len(ALL)


def test_splits_and_families_can_be_asked_for():
    test = load_tasks(FOLDER, split="test")
    assert {*test, *load_tasks(FOLDER, split="development")} == {*ALL} and 0 < len(test) < len(ALL)
    assert {spec.family for spec in load_tasks(FOLDER, families=("drop", "sway"))} == {"drop", "sway"}
    with pytest.raises(UserError, match="unknown family"):
        load_tasks(FOLDER, families=("dance",))


def test_smooth_tasks_are_those_without_contact_to_come():
    smooth = {spec.name for spec in ALL if spec.smooth}
    assert {spec.name for spec in ALL if spec.scene.world == "free"} <= smooth
    assert (
        "drop-robot" not in smooth
        and "impulse-jelly-held" in smooth
        and "multi-jelly-drop-then-push" not in smooth
    )


def test_what_needs_a_folder_of_data_is_left_out_by_name(tmp_path):
    kept, missing = split_available(ALL, None)
    assert {spec.object for spec in kept} == {name for name in OBJECTS if OBJECTS[name].data is None}
    assert len(kept) + len(missing) == len(ALL) and any("guitar" in name for name in missing)
    spec = next(spec for spec in ALL if spec.name in missing)
    with pytest.raises(UserError, match="needs the file"):
        make_task(spec, tmp_path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda task: task["target"]["clauses"][0].update(tolerance=0.2), "was changed"),
        (lambda task: task["target"]["clauses"].pop(), "was changed"),
        (lambda task: task.update(task_hash="0" * 64), "was changed"),
        (lambda task: task.update(sentence="Do something else."), "was changed"),
        (lambda task: task["scene"].update(frame_count=150), "was changed"),
        (lambda task: task.update(object="loaf" if task["object"] != "loaf" else "jelly"), "was changed"),
        (lambda task: task.update(object="teapot"), "teapot"),
        (lambda task: task.update(family="sway"), "of the family sway"),
        (lambda task: task.update(colour="red"), "colour"),
        (lambda task: task.update(hidden={"default_drop": True}), "hidden"),
    ],
)
def test_a_tampered_file_is_refused(change, message, tmp_path):
    shutil.copytree(FOLDER, tmp_path / "tasks")
    path = tmp_path / "tasks" / "twist.json"
    tasks = json.loads(path.read_text())
    change(tasks[0])
    path.write_text(json.dumps(tasks))
    with pytest.raises(UserError, match=message):
        load_tasks(tmp_path / "tasks")


def test_a_task_is_that_of_its_object_and_its_file(tmp_path, monkeypatch):
    """Another stiffness, or another file under the same name, is noticed."""
    softer = dataclasses.replace(OBJECTS["bunny"], youngs_modulus=1.0)
    (tmp_path / "bunny.obj").write_text("v 0 0 0\n")
    with pytest.raises(UserError, match="not the one that its tasks were made with"):
        find_file("bunny", tmp_path, tmp_path)
    monkeypatch.setitem(OBJECTS, "bunny", softer)
    with pytest.raises(UserError, match="was changed"):
        load_tasks(FOLDER)


def test_a_task_twice_is_refused(tmp_path):
    path = tmp_path / "drop.json"
    tasks = json.loads((FOLDER / "drop.json").read_text())
    path.write_text(json.dumps([*tasks, tasks[0]]))
    with pytest.raises(UserError, match="there twice"):
        load_tasks(tmp_path)


def test_files_are_as_the_writer_writes_them(tmp_path):
    """So that a change of a task is a change of its lines, and what is written is read again."""
    for family in FAMILIES:
        path = tmp_path / f"{family}.json"
        write_tasks(path, [spec for spec in ALL if spec.family == family])
        assert path.read_text() == (FOLDER / f"{family}.json").read_text()
    assert load_tasks(tmp_path) == ALL


def test_every_task_has_a_witness():
    assert set(WITNESSES) == {spec.name for spec in ALL}
    for spec in ALL:
        if spec.hidden is not None:
            assert WITNESSES[spec.name] == spec.hidden


def check_witness(spec, folder, data=None):
    """The witness is a success with its clip, and none of the wrong clips is."""
    task = make_task(spec, folder, data)
    x = task.simulate(WITNESSES[spec.name])
    seen = task.judge(x)
    assert seen.success, (spec.name, [clause for clause in seen.clauses if clause.margin < 0])
    passed = [name for name, change in WRONG.items() if task.judge(change(x)).success]
    assert passed == list(RIGHT_ALL_THE_SAME.get(spec.name, ())), (spec.name, passed)
    effort = task.measure_effort(WITNESSES[spec.name], x)
    assert effort > 0 or not (WITNESSES[spec.name].actions or WITNESSES[spec.name].constraints)
    return task


@pytest.mark.parametrize("name", QUICK)
def test_a_witness_succeeds_and_wrong_clips_fail(name, tmp_path):
    task = check_witness(HERE[name], tmp_path)
    assert task.mass.shape == task.simulate(START).shape[1:2]


@pytest.mark.slow
@pytest.mark.parametrize("spec", ALL, ids=lambda spec: spec.name)
def test_every_witness_succeeds_and_wrong_clips_fail(spec, tmp_path_factory):
    if spec.name not in HERE and not DATA.is_dir():
        pytest.skip(f"`{spec.object}` needs a folder of data")
    folder = tmp_path_factory.getbasetemp() / "objects"
    task = check_witness(spec, folder, DATA)
    assert not task.judge(task.simulate(task.start)).success, "it is solved before it begins"


def test_all_force_fields_meet_the_same_scene(tmp_path):
    task = make_task(HERE["twist-robot-quarter"], tmp_path)
    one, other = (task.build(field) for field in (START, WITNESSES["twist-robot-quarter"]))
    np.testing.assert_array_equal(one.state.x, other.state.x)
    np.testing.assert_array_equal(one.model.mass, other.model.mass)
    assert one.config.camera == other.config.camera
    different = {name for name in type(one.config).model_fields
                 if getattr(one.config, name) != getattr(other.config, name)}  # fmt: skip
    assert different == {"force_field"}


def test_a_hidden_force_is_told_by_its_motion_and_errors_are_from_it(tmp_path):
    spec = HERE["recovery-jelly-push"]
    task = make_task(spec, tmp_path)
    again = record_target(task, spec.hidden, spec.target.clauses[0].tolerance)
    stored, now = (
        np.array([place.centres for place in target.clauses[0].places]) for target in (spec.target, again)
    )
    np.testing.assert_allclose(stored, now, atol=2e-3)
    seen = measure_identifiability(task, spec.hidden)
    assert seen.identified == 3 and seen.condition < 10
    assert compare_fields(spec.hidden, spec.hidden, task.frame_count).magnitude_percent == 0
    errors = compare_fields(spec.hidden, spec.begin, task.frame_count)
    angle = np.degrees(np.arccos(np.dot(spec.hidden.actions[0].vector, spec.begin.actions[0].vector)))
    assert errors.direction_degrees == pytest.approx(angle)
    assert errors.magnitude_percent == pytest.approx(100 * abs(0.8 - 1.3) / 1.3)


def test_recovery_paths_are_recorded_again_from_their_hidden_force(tmp_path, capsys):
    name = "recovery-jelly-push"
    old = HERE[name]
    weaker = old.hidden.actions[0].model_copy(update=dict(magnitude=0.9))
    changed = old.model_copy(update=dict(hidden=ForceField(actions=(weaker,))))
    write_tasks(tmp_path / "recovery.json", [changed])
    assert record_again([name, "--tasks", str(tmp_path)]) == 0
    (new,) = load_tasks(tmp_path)
    way, before = (np.array(each.target.clauses[0].places[0].centres)[-1] for each in (new, old))
    ratio = 0.9 / old.hidden.actions[0].magnitude
    np.testing.assert_allclose(way, ratio * before, atol=2e-3)
    shutil.copy(FOLDER / "twist.json", tmp_path)
    assert record_again(["twist-robot-quarter", "--tasks", str(tmp_path)]) == 2
    assert "no hidden force field" in capsys.readouterr().err


def test_a_window_that_is_the_whole_clip_may_be_unsaid():
    whole = ForceField.model_validate(
        {"actions": [{"action_type": "translation", "vector": [1, 0, 0], "active_time": [0, 25]}]}
    )
    unsaid = ForceField.model_validate({"actions": [{"action_type": "translation", "vector": [1, 0, 0]}]})
    assert compare_fields(whole, unsaid, 26).actions[0].window_percent == 0


def test_a_new_task_is_stamped_with_its_hash(tmp_path):
    clauses = [{"kind": "rest", "window": [0, 20]}]
    spec = stamp({"name": "new-task", "sentence": "Stay where you are.", "family": "drop", "object": "loaf",
                  "target": {"clauses": clauses}})  # fmt: skip
    write_tasks(tmp_path / "drop.json", [spec])
    assert load_tasks(tmp_path) == (spec,)


@pytest.fixture(autouse=True)
def quiet():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        yield
