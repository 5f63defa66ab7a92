"""Tasks that are drawn: each can be done, is told from wrong clips, and depends on its seed and number alone."""

import json

import numpy as np
import pytest

from baselines.suite import CELLS, commit_seed, draw_task
from baselines.suite import __main__ as suite
from baselines.suite.drawing import hash_suite, list_cells
from baselines.suite.templates import AXES, DRAFTS, Unfit, see
from baselines.tasks import FAMILIES, check_spec, load_tasks, load_witnesses, make_task
from physagent_jax.metrics.clips import Clip


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return draw_task(5, 0, tmp_path_factory.mktemp("made"), "test")


def check(drawn, folder, seed, number, split):
    """Its witness is a success, and the force field against it is none."""
    spec, task = drawn.spec, make_task(drawn.spec, folder)
    check_spec(spec, "drawn")  # its hash, and its window
    assert spec.split == split and spec.family == FAMILIES[number % len(FAMILIES)]
    assert task.judge(task.simulate(drawn.witness)).error < 1
    other = [each.model_copy(update=dict(vector=[-c for c in each.vector])) for each in drawn.witness.actions]
    opposite = drawn.witness.model_copy(update=dict(actions=tuple(other)))
    if spec.family != "stretch":  # along an axis, which has two ends
        assert not task.judge(task.simulate(opposite)).success
    again = draw_task(seed, number, folder, split)
    assert again == drawn and again.spec.task_hash == spec.task_hash


def test_a_drawn_task_can_be_done_and_is_drawn_again(made, tmp_path):
    check(made, tmp_path, 5, 0, "test")
    assert " %" in made.spec.sentence


@pytest.mark.slow  # each family has programs of its own
@pytest.mark.parametrize("number", range(14))
def test_tasks_of_every_family_can_be_done(tmp_path, number):
    split = ("development", "test")[number // 7]
    check(draw_task(11, number, tmp_path, split), tmp_path, 11, number, split)


def test_twins_are_in_one_split_and_both_have_every_family():
    parts = [list_cells(split) for split in ("development", "test")]
    for family in FAMILIES:
        one, other = (set(part[family]) for part in parts)
        assert one and other and not one & other
        assert len(one | other) == sum(cell.family == family for cell in CELLS)
    assert len({cell.name for cell in CELLS}) == len(CELLS) >= 50


@pytest.mark.parametrize("family", sorted(set(DRAFTS) - {"recovery"}))
def test_what_hardly_moves_is_no_task(family):
    x = np.random.default_rng(0).normal(size=(40, 60, 3))
    x[1:] = x[0]
    clip = Clip(x, np.ones(60), 0.04)
    draft = DRAFTS[family](np.random.default_rng(1), "sideways", "the jelly")
    with pytest.raises(Unfit):
        draft.ask(None, clip)  # type: ignore[arg-type]


def test_amounts_are_those_of_the_clip():
    x = np.random.default_rng(0).normal(size=(26, 60, 3))
    way = np.linspace(0, 1, 26)[:, None, None] * np.array(AXES["sideways"])
    x = x[:1] + 0.5 * float(np.ptp(x[0], axis=0).max()) * way
    clip = Clip(x, np.ones(60), 0.04)
    for seed in range(8):  # to either side
        draft = DRAFTS["impulse"](np.random.default_rng(seed), "sideways", "the jelly")
        if draft.field.actions[0].vector[0] < 0:
            with pytest.raises(Unfit):
                draft.ask(None, clip)  # type: ignore[arg-type]
            continue
        sentences, clauses = draft.ask(None, clip)  # type: ignore[arg-type]
        assert all("to the right" in each and ("50 %" in each or "0.50" in each) for each in sentences)
        assert clauses[1]["target"] == 0.5 and clauses[1]["tolerance"] == pytest.approx(0.5 / 3, abs=1e-4)
        assert see(clip, kind="distance", window=(0, 25), along=(1, 0, 0)) == pytest.approx([0.5], abs=1e-5)


def test_a_folder_goes_on_and_is_one_suite(made, tmp_path, capsys, monkeypatch):
    out = tmp_path / "suite"
    command = ["--out", str(out), "--count", "1", "--seed", "5", "--split", "test"]
    asked = []

    def draw(seed, number, folder, split):
        asked.append((seed, number, split))
        return made

    monkeypatch.setattr(suite, "draw_task", draw)
    assert suite.main(command) == 0 and asked == [(5, 0, "test")]
    with (out / "drawn.jsonl").open("a") as file:
        file.write('{"spec"')  # stopped while it was written
    assert suite.main([*command, "--commitment", commit_seed(5)]) == 0 and len(asked) == 1
    assert load_tasks(out) == (made.spec,) and load_witnesses(out) == {made.spec.name: made.witness}
    about = json.loads((out / "suite.json").read_text())
    assert about["hash"] == hash_suite([made.spec]) and about["commitment"] == commit_seed(5)
    capsys.readouterr()
    for change, message in (
        (["--seed", "6"], "another suite"),
        (["--commitment", "abc"], "not the one that was committed"),
        (["--count", "0"], "at least one"),
        (["--seed", "-1"], "from 0"),
    ):
        assert suite.main([*command, *change]) == 2
        error = capsys.readouterr().err
        assert message in error and len(error.splitlines()) == 1


def test_a_secret_seed_is_drawn_once(made, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(suite, "draw_task", lambda *_: made)
    for _ in range(2):
        assert suite.main(["--out", str(tmp_path / "suite"), "--count", "1"]) == 0
    first, *_, last = (line for line in capsys.readouterr().out.splitlines() if line.startswith("commitment"))
    assert first == last
