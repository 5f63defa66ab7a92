"""A published table is made whole on one revision: what is stale is measured again, the rest is kept."""

import dataclasses
import json
import math

import pytest

from baselines.suite import commit_seed
from baselines.tasks import TaskSpec, load_tasks, make_task
from benchmarks.harness import Job
from benchmarks.headtohead import leaderboard, reproduce
from benchmarks.headtohead.__main__ import TASKS
from benchmarks.headtohead.jobs import verify
from benchmarks.headtohead.markdown import condense, write_tables

NAME, RELEASE = next(iter(reproduce.RELEASES.items()))
MARK = {"mark": 30.0, "success": True, "error": 0.5}


class World:
    """A release of two tasks and one method, its code, and the jobs that were done."""

    def __init__(self, path):
        self.path, self.code, self.done = path, "new", list[str]()
        self.specs: list[TaskSpec] = list(load_tasks(TASKS)[:2])

    def change(self, place):
        """A task that is no longer as it was."""
        self.specs[place] = self.specs[place].model_copy(update={"task_hash": "changed"})

    def fit(self, spec):
        self.done.append(spec.name)
        told = dict(label="rules", family="drop", split="test", seed=0, oracle=False, spent=1.0, seconds=1.0)
        return [told | {"task": spec.name, "task_hash": spec.task_hash, "marks": [MARK]}]

    def list_fits(self, specs, *_):
        return [Job(f"{spec.name} / rules / 0", lambda spec=spec: self.fit(spec)) for spec in specs]


@pytest.fixture
def made(tmp_path, monkeypatch):
    world = World(tmp_path / "rows.json")
    monkeypatch.setattr(reproduce, "list_fits", world.list_fits)
    monkeypatch.setattr(reproduce, "draw", lambda *_: world.specs)
    monkeypatch.setattr(reproduce, "hash_code", lambda: world.code)
    world.path.write_text(json.dumps({"verify": {"runs": [], "complete": True, "rows": []}}))
    return world


def run(world, *options):
    world.done.clear()
    return reproduce.main(["--release", NAME, "--json", str(world.path), *options])


def test_stale_cells_are_measured_again_and_the_others_kept(made, capsys):
    names = [spec.name for spec in made.specs]
    assert run(made, "--check") == 1 and not made.done
    assert capsys.readouterr().out.splitlines() == [f"missing {name} / rules / 0" for name in names]
    assert run(made) == 0 and made.done == names
    assert run(made) == 0 and not made.done
    made.change(1)
    assert run(made, "--check") == 1
    assert capsys.readouterr().out.splitlines()[-1] == f"stale {names[1]} / rules / 0"
    assert run(made) == 0 and made.done == names[1:]
    made.code = "newer"
    assert run(made) == 0 and made.done == names and run(made, "--check") == 0
    result = json.loads(made.path.read_text())
    assert set(result) == {"verify", "suite"} and result["suite"]["complete"]
    assert [row["code_hash"] for row in result["suite"]["rows"]] == ["newer"] * 2
    assert "| rules |" in write_tables(condense({"suite": result["suite"]}))["suite"]


def test_the_seed_is_the_one_that_was_committed(tmp_path, monkeypatch, capsys):
    secret = dataclasses.replace(RELEASE, seed=None, commitment=commit_seed(7))
    monkeypatch.setattr(reproduce, "RELEASES", {NAME: secret})
    command = ["--release", NAME, "--out", str(tmp_path), "--json", str(tmp_path / "rows.json")]
    for more, message in (([], "is not told yet"), (["--seed", "8"], "not the one that was committed")):
        assert reproduce.main([*command, *more]) == 2
        assert message in capsys.readouterr().err
    assert reproduce.main(["--release", "2020-01", "--json", str(tmp_path / "rows.json")]) == 2
    assert NAME in capsys.readouterr().err


@pytest.mark.parametrize("family", ["drop", "recovery"])
def test_lines_of_the_published_board_are_judged_again_as_they_say(family, tmp_path):
    """Its best and its worst line of a family, whose tasks are those of the told seed."""
    folder = TASKS / "suites" / NAME
    told = json.loads((folder / "suite.json").read_text())
    assert (
        commit_seed(told["seed"]) == told["commitment"] == RELEASE.commitment and told["seed"] == RELEASE.seed
    )
    specs = {spec.name: spec for spec in load_tasks(folder) if spec.family == family}
    assert len(specs) == RELEASE.count // 7
    lines = [each for each in leaderboard.read(folder / "board.jsonl") if each.task in specs]
    assert len(lines) == len(specs) * len(RELEASE.methods) and {each.split for each in lines} == {"test"}
    lines.sort(key=lambda each: math.inf if each.error is None else each.error)
    for line in (lines[0], lines[-1]):
        task = make_task(specs[line.task], tmp_path)
        assert verify(leaderboard.as_row(line), task)[0]["good"]


def test_a_row_without_a_hash_of_its_code_is_stale(made):
    first, second = made.specs
    row = {"task": first.name, "task_hash": first.task_hash, "code_hash": "new"}
    assert reproduce.is_fresh(row, made.specs, "new")
    assert not reproduce.is_fresh(row | {"code_hash": None}, made.specs, "new")
    assert not reproduce.is_fresh(row | {"task_hash": second.task_hash}, made.specs, "new")
