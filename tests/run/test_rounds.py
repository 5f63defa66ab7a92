"""The end of the rounds: success, the cap, no improvement, nothing left to try; a resumed run ends alike."""

import json

import pytest

from physagent_jax.agents.protocols import ExecutorAgent
from physagent_jax.agents.schema import Rewrite
from physagent_jax.agents.trace import Reply
from physagent_jax.cli import main
from physagent_jax.report.html import write_report
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
