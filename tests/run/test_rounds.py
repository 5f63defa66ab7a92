"""The end of the rounds: success, the cap, no improvement, nothing left to try; a resumed run ends alike."""

import json

import pytest

from physagent_jax.agents.protocols import ExecutorAgent
from physagent_jax.agents.schema import Rewrite
from physagent_jax.agents.trace import Reply
from physagent_jax.cli import main
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.schema import Check, Judgement
from physagent_jax.report.html import write_report
from physagent_jax.run.stopping import explain_rest, find_stop
from tests.run.specs import made, small, with_rules
from tests.run.test_loop import ScriptedExecutor, ScriptedPlanner


class Stubborn(ExecutorAgent):
    """Changes nothing."""

    def rewrite(self, context, failed):
        return Reply(Rewrite(force_field=failed.force_field, changes=("Nothing left to try.",)))


class Interrupted(ScriptedExecutor):
    """Stops the run at a round."""

    def __init__(self, at):
        super().__init__()
        self.at = at

    def rewrite(self, context, failed):
        if len(context.rounds) == self.at:
            raise KeyboardInterrupt
        return super().rewrite(context, failed)


def spec(robot_path, rounds):
    return small(robot_path, frames=3, particles=200, resolution=64, rounds=rounds)


def ended(robot_path, out, scores, rounds, executor=None):
    agents = with_rules(ScriptedPlanner(scores), executor or ScriptedExecutor())
    manifest = made(spec(robot_path, rounds), out, agents).manifest
    return manifest.iterations, manifest.best_iteration, manifest.stopped


@pytest.mark.parametrize(
    ("scores", "rounds", "expected"),
    [
        ([0.2, 1.0], 3, (2, 1, "success")),
        ([0.2, 0.4], 2, (2, 1, "cap")),
        ([0.6, 0.5, 0.6], 8, (3, 0, "no improvement")),
        ([0.2, 0.4, 0.3, 0.405], 8, (4, 3, "no improvement")),
        ([0.2, 0.4, 0.3, 0.5, 1.0], 8, (5, 4, "success")),
    ],
)
def test_rounds_end_for_a_reason(tmp_path, robot_path, scores, rounds, expected):
    assert ended(robot_path, tmp_path / "run", scores, rounds) == expected


def test_an_executor_that_changes_nothing_ends_them(tmp_path, robot_path):
    assert ended(robot_path, tmp_path / "run", [0.2], 8, Stubborn()) == (1, 0, "nothing left to try")
    page = write_report(tmp_path / "run").read_text()
    assert "the executor has nothing left to try" in page


def test_a_resumed_run_ends_where_an_unbroken_one_ends(tmp_path, robot_path):
    out = tmp_path / "run"
    agents = with_rules(ScriptedPlanner([0.6, 0.5]), Interrupted(1))
    with pytest.raises(KeyboardInterrupt):
        made(spec(robot_path, 8), out, agents)
    assert json.loads((out / "manifest.json").read_text())["stopped"] is None
    agents = with_rules(ScriptedPlanner([0.55]), Interrupted(99))
    manifest = made(spec(robot_path, 8), out, agents).manifest
    assert (manifest.iterations, manifest.best_iteration, manifest.stopped) == (3, 0, "no improvement")


def test_the_command_line_takes_the_cap_and_tells_the_reason(tmp_path, robot_path, capsys):
    line = [
        "run",
        "--object",
        robot_path,
        "--prompt",
        "push it left",
        "--out",
        tmp_path / "run",
        "--rounds",
        1,
    ]
    line += ["--frames", 4, "--particles", 300, "--resolution", 64, "--video-size", "off", "--json"]
    assert main([str(each) for each in line]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["iterations"] == 1 and told["stopped"] in ("cap", "success")
    assert json.loads((tmp_path / "run" / "run.json").read_text())["rounds"] == 1


class Holder(ExecutorAgent):
    """Holds the object in the second round, with the same forces; then changes nothing."""

    def rewrite(self, context, failed):
        hold = None if context.rounds else "base"
        return Reply(Rewrite(force_field=failed.force_field, hold=hold, changes=("It is held.",)))


class Misplacer(ExecutorAgent):
    """Acts on a part that the object does not have."""

    def rewrite(self, context, failed):
        nowhere = {"kind": "box", "low": (5, 5, 5), "high": (6, 6, 6)}
        action = {"action_type": "translation", "vector": (0, 0, 1), "region": nowhere}
        return Reply(
            Rewrite(force_field=ForceField.model_validate({"actions": [action]}), changes=("There.",))
        )


def test_the_executor_may_change_the_hold(tmp_path, robot_path):
    """From the next round on; what the planner is told goes with it, and the same forces are no end of the rounds."""
    out = tmp_path / "run"
    assert ended(robot_path, out, [0.2, 0.3], 8, Holder()) == (2, 1, "nothing left to try")
    held = [json.loads((out / f"iterations/{k}/scene.json").read_text())["anchor"]["kind"] for k in range(2)]
    assert held == ["none", "base"]


def test_a_round_that_cannot_be_simulated_leaves_the_others(tmp_path, robot_path):
    """The best of them is the result, and the run says why it ended."""
    out = tmp_path / "run"
    assert ended(robot_path, out, [0.2], 8, Misplacer()) == (1, 0, "failed round")
    manifest = json.loads((out / "manifest.json").read_text())
    assert manifest["complete"] and any("round 2 is left out" in text for text in manifest["warnings"])


def test_rounds_that_cannot_help_are_not_made():
    """A sentence in doubt fails whatever the force is; so does what cannot be seen."""
    check = {"expectation": 0, "question": "?", "expected": "", "observed": "", "score": 0.0}
    failed = Judgement(verdict="FAIL", score=0.5, checks=(Check(passed=False, **check),))
    unseen = Judgement(verdict="FAIL", score=0.5, checks=(Check(passed=None, **check),))
    assert find_stop([failed], 3) is None and find_stop([failed], 3, doubts=True) == "doubts"
    assert find_stop([failed], 1, doubts=True) == "cap"
    assert (explain_rest(failed), explain_rest(unseen)) == ("nothing left to try", "not observable")
