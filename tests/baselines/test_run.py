"""Methods that play the real simulator, and the command that leaves a run folder."""

import json

import numpy as np
import pytest

from baselines.brief import make_scene_brief
from baselines.methods import METHODS, make_method
from baselines.methods.direction_only import forget_skills
from baselines.protocol import Budget
from baselines.run import TASKS, main, read_options
from baselines.task_files import stamp, write_tasks
from baselines.tasks import load_tasks
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField
from physagent_jax.metrics.targets import Distance, Target
from tests.baselines.tiny import act

LEFT = act("translation", (-1, 0, 0), 0.9)


@pytest.mark.parametrize("name, budget", [("levenberg_marquardt", 20), ("lbfgs", 25)])
def test_a_hidden_push_is_recovered(tiny, name, budget):
    result = make_method(name).fit(tiny, Budget(budget))
    assert result.oracle and result.find_incumbent().objective < 1e-4
    found, hidden = result.incumbent_at().actions[0], tiny.spec.hidden.actions[0]
    assert found.magnitude == pytest.approx(hidden.magnitude, abs=0.02)
    np.testing.assert_allclose(found.vector, hidden.vector, atol=0.02)


def test_agents_play_rounds_that_are_charged_and_see_no_truth(tiny):
    result = make_method("rules").fit(tiny, Budget(3))
    assert not result.oracle and result.spent == len(result.evaluations) <= 3
    first = result.evaluations[0].force_field.actions[0]
    assert first.action_type == "translation" and first.vector == (-1.0, 0.0, 0.0)
    assert all(each.objective is not None for each in result.evaluations)
    open_loop = make_method("rules", dict(rounds=1)).fit(tiny, Budget(3))
    assert [each.force_field for each in open_loop.evaluations] == [result.evaluations[0].force_field]


def test_the_hybrid_goes_on_from_the_agents_force_field(tiny):
    result = make_method("hybrid", dict(rounds=1)).fit(tiny, Budget(20))
    assert result.oracle and result.evaluations[0].note == "round 1"
    assert result.evaluations[1].force_field == result.evaluations[0].force_field
    assert result.find_incumbent().objective < 1e-3


def test_the_expert_is_played_once(tiny):
    result = make_method("expert").fit(tiny, Budget(5))
    assert result.spent == 1 and result.incumbent_at() == tiny.spec.expert and not result.oracle


def test_agents_are_told_what_the_scene_is(tiny):
    brief = make_scene_brief(tiny.build(tiny.start))
    assert (brief.frame_count, brief.frames_fixed, brief.world, brief.anchored) == (8, True, "free", None)
    assert brief.directions.left == (-1.0, 0.0, 0.0) and brief.object_kind == "jelly"


def test_without_skills_there_are_pushes_of_one_strength():
    two = ForceField(
        default_drop=True,
        actions=(*act("torque", (0, 0, 1), -1.5, (2, 5)).actions, *act("impulse", (0, 0, 1), -0.7).actions),
    )
    plain = forget_skills(two)
    assert plain == ForceField(default_drop=True, actions=act("translation", (0, 0, 1), -1.0).actions)


@pytest.fixture(scope="module")
def tasks(tmp_path_factory):
    """A folder with one task, of eight frames."""
    target = Target(clauses=(Distance(window=(0, 7), along=(-1, 0, 0), target=0.3, tolerance=0.1),))
    task = dict(
        name="a-small-push",
        sentence="push the jelly to the left",
        family="impulse",
        object="jelly",
        scene=dict(world="free", frame_count=8),
        target=target.model_dump(mode="json"),
        expert=LEFT.model_dump(mode="json"),
    )
    folder = tmp_path_factory.mktemp("tasks")
    write_tasks(folder / "impulse.json", [stamp(task)])
    return folder


def run(tasks, out, *more) -> int:
    return main(["--task", "a-small-push", "--tasks", str(tasks), "--out", str(out), *more])


def test_a_run_folder_is_left(tasks, tmp_path, capsys):
    out = tmp_path / "run"
    assert run(tasks, out, "--method", "rules", "--budget", "1", "--options", "rounds=1") == 0
    printed = capsys.readouterr().out
    assert printed.splitlines()[0].split() == ["spent", "seconds", "objective", "what", "for"]
    assert "round 1" in printed and "error" in printed and "report:" in printed
    fit = json.loads((out / "fit.json").read_text())
    assert fit["method"] == "rules" and len(fit["evaluations"]) == fit["spent"] == 1
    assert fit["judgement"]["clauses"][0]["wanted"] == 0.3
    names = {path.name for path in out.iterdir()}
    assert {"manifest.json", "scene.json", "video.mp4", "motion.npz", "report.html", "fit.json"} <= names
    assert run(tasks, out, "--method", "rules", "--budget", "1", "--options", "rounds=1") == 0
    assert "is complete" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--method", "adm"], "adam"),
        (["--method", "adam", "--budget", "0"], "forward_equivalents"),
        (["--method", "adam", "--seconds", "-1"], "seconds"),
        (["--method", "adam", "--options", "starts"], "name=value"),
        (["--method", "adam", "--options", "starts=0"], "starts"),
        (["--method", "adam", "--options", "colour=1"], "colour"),
    ],
)
def test_bad_options_are_refused_in_one_line(tasks, tmp_path, capsys, options, message):
    assert run(tasks, tmp_path / "x", *options) == 2
    error = capsys.readouterr().err
    assert message in error and len(error.splitlines()) == 1


def test_unknown_tasks_are_refused(tasks, tmp_path, capsys):
    assert main(["--method", "adam", "--task", "a-smal-push", "--tasks", str(tasks)]) == 2
    assert "a-small-push" in capsys.readouterr().err


OWN = """
import dataclasses
from baselines.protocol import Method

@dataclasses.dataclass(frozen=True)
class Start(Method):
    name = "own_start"

    def search(self, evaluator):
        evaluator.play(evaluator.task.start, "begun")

class Nothing:
    pass
"""


def test_a_method_of_ones_own_is_named_by_its_file_or_module(tiny, tmp_path, monkeypatch):
    """No line of this repository is edited for it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    for file in ("own_by_file.py", "own_by_module.py"):
        (tmp_path / file).write_text(OWN)
    for name in ("own_by_file.py:Start", "own_by_module:Start"):
        result = make_method(name).fit(tiny, Budget(3))
        assert result.method == "own_start" and result.spent == 1
    for name, message in (
        ("own_by_module:Nothing", "is not a method"),
        ("own_by_module:Other", "no such method"),
        ("missing.py:Start", "no file"),
        ("missing:Start", "not installed"),
    ):
        with pytest.raises(UserError, match=message):
            make_method(name)


@pytest.mark.parametrize("name", ["nonsense", "adams"])
def test_a_method_that_there_is_not_lists_those_that_there_are(tmp_path, capsys, name):
    assert main(["--method", name, "--task", "any"]) == 2
    error = capsys.readouterr().err
    assert all(known in error for known in METHODS.entries) and len(error.splitlines()) == 1
    assert ("Did you mean `adam`" in error) == (name == "adams")


def test_a_task_that_there_is_not_lists_those_that_there_are(capsys):
    assert main(["--method", "adam", "--task", "qqq"]) == 2
    error = capsys.readouterr().err
    assert all(spec.name in error for spec in load_tasks(TASKS)) and "Did you mean" not in error


def test_options_are_read_as_json_or_text():
    assert read_options(("starts=4", "types=enumerated", "windows=true")) == dict(
        starts=4, types="enumerated", windows=True
    )
    with pytest.raises(UserError):
        read_options(("=3",))
