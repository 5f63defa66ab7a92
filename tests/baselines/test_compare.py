"""The front for methods, tasks and objects of one's own: nothing of this repository is edited for them."""

import csv
import importlib.util
import io
import json
import re
from pathlib import Path

import pytest

from baselines import compare
from baselines.compare import main
from baselines.objects import OBJECTS
from baselines.tables import format_csv, format_latex, format_markdown, summarise_methods
from physagent_jax.gaussians.formats.ply import write_ply
from physagent_jax.scene.procedural import PROCEDURAL

METHOD = """
import dataclasses
from baselines.protocol import Method

@dataclasses.dataclass(frozen=True)
class Begin(Method):
    name = "begin"
    oracle = True

    def search(self, evaluator):
        evaluator.score(evaluator.task.start)
"""

TASK = dict(
    name="blob-to-the-right",
    sentence="push the blob to the right",
    object="own-blob",
    scene=dict(world="free", frame_count=8),
    target=dict(clauses=[dict(kind="distance", window=[0, 7], along=[1, 0, 0], target=0.03, tolerance=0.01)]),
)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A method, a task and an object in files of their own."""
    monkeypatch.setattr("baselines.objects.OBJECTS", OBJECTS)
    monkeypatch.delitem(OBJECTS, "own-blob", raising=False)
    (tmp_path / "method.py").write_text(METHOD)
    (tmp_path / "task.json").write_text(json.dumps(TASK))
    write_ply(tmp_path / "blob.ply", PROCEDURAL["jelly"](0, count=400))
    yield tmp_path
    OBJECTS.pop("own-blob", None)


def run(folder, *more) -> int:
    own = [f"{folder}/method.py:Begin", "expert", "--task", f"{folder}/task.json"]
    about = f"own-blob={folder}/blob.ply,kind=jelly,up=+z,cells=24,particles=200,youngs_modulus=2e4"
    return main([*own, "--object", about, "--budget", "2", "--out", str(folder / "out"), *more])


def test_a_method_a_task_and_an_object_of_ones_own_get_into_the_tables(folder, capsys, monkeypatch):
    assert run(folder) == 0
    printed = capsys.readouterr().out
    assert "1/2  blob-to-the-right" in printed and "refused: " in printed  # by the expert: it has none
    with (folder / "out" / "methods.csv").open(newline="") as file:
        begin, expert = csv.DictReader(file)
    assert begin["method"] == "Begin (oracle)" and begin["other"] in ("0/1", "1/1") and begin["spent"] == "1"
    assert expert["method"] == "expert" and expert["refused"] == "1" and not expert["solved"]
    latex = (folder / "out" / "methods.tex").read_text()
    assert latex.startswith(r"\begin{tabular}{l") and r"share [\%]" in latex and latex.count(r"\\") == 3
    with (folder / "out" / "fits.csv").open(newline="") as file:
        marks = list(csv.DictReader(file))
    assert [row["mark"] for row in marks] == ["1.0", "2.0", ""] and {row["family"] for row in marks} == {
        "other"
    }
    assert (folder / "out" / "success.svg").is_file() == bool(importlib.util.find_spec("matplotlib"))

    monkeypatch.setattr(compare, "measure_fit", None)  # nothing is measured twice
    before = (folder / "out" / "fits.jsonl").read_text()
    (folder / "out" / "fits.jsonl").write_text(before + before[:40])  # stopped while it was written
    assert run(folder) == 0 and (folder / "out" / "fits.jsonl").read_text() == before


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["rul"], "rules"),
        (["rules", "--task", "no-such-task"], "There are: "),
        (["rules", "--task", "missing.json"], "missing.json"),
        (["rules", "--split", "all"], "development or test"),
        (["rules", "--seeds", "0"], "at least one seed"),
        (["rules", "--budget", "0"], "above 0"),
        (["rules,colour=red"], "does not take"),
        (["rules", "--object", "vase"], "NAME=FILE"),
        (["rules", "--object", "vase=missing.ply"], "no file"),
    ],
)
def test_what_is_not_known_is_refused_before_anything_is_measured(tmp_path, capsys, options, message):
    assert main([*options, "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert message in error and len(error.splitlines()) == 1 and not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (dict(object="unknown"), "unknown"),
        (dict(task_hash="abc"), "was changed"),
        (dict(target=dict(clauses=[])), "clauses"),
        (dict(sentence=3), "sentence"),
    ],
)
def test_a_task_that_is_none_is_refused(folder, capsys, change, message):
    (folder / "task.json").write_text(json.dumps(TASK | change))
    assert run(folder) == 2
    error = capsys.readouterr().err
    assert message in error and len(error.splitlines()) == 1


def test_a_field_that_objects_have_not_and_a_name_that_is_taken_are_refused(folder, capsys):
    for about, message in (
        (f"new={folder}/blob.ply,colour=red", "Fields: "),
        (f"jelly={folder}/blob.ply", "another"),
    ):
        assert main(["rules", "--object", about, "--out", str(folder / "out")]) == 2
        assert message in capsys.readouterr().err
    assert "new" not in OBJECTS and not OBJECTS["jelly"].digest


def make_row(label, task, seed, success, error, seconds):
    mark = {"mark": 10.0, "success": success, "error": error}
    told = {"label": label, "task": task, "family": "drop", "seed": seed, "oracle": False, "model_calls": 2}
    return told | {"spent": 4.0, "seconds": seconds, "evaluations": 4, "trace": [], "marks": [mark]}


def test_the_table_averages_seeds_and_tells_medians():
    rows = [make_row("a", "t1", seed, seed == 0, 2.0 * seed, 3.0 + seed) for seed in (0, 1)]
    rows += [make_row("a", "t2", seed, True, 0.0, 9.0) for seed in (0, 1)]
    head, line = summarise_methods(rows)
    told = dict(zip(head, line))
    assert told["drop"] == told["solved"] == "1.5/2" and told["refused"] == 0
    assert told["share [%]"].startswith("75 (") and told["spent"] == "4" and told["model calls"] == "2"
    assert (
        told["error [tolerances]"].startswith("0.00 (") and told["seconds"] == "9"
    )  # the middle half: 0 and 0


def test_cells_are_escaped_as_each_format_asks():
    cells = [["name", "share [%]"], [r'a_b & "c", d|e\f', "5 (1–9)"]]
    assert list(csv.reader(io.StringIO(format_csv(cells)))) == cells
    assert r"a\_b \& " in format_latex(cells) and r"\textbackslash{}f" in format_latex(cells)
    assert r"5 (1--9) \\" in format_latex(cells) and format_markdown(cells).splitlines()[2].count("|") == 3


def test_the_how_to_page_does_what_it_says(folder, capsys):
    """Its method and its task, as they stand there."""
    page = (Path(__file__).parents[2] / "docs" / "compare.md").read_text(encoding="utf-8")
    method, task = re.findall(r"```(?:python|json)\n(.*?)```", page, re.DOTALL)
    assert len(method.splitlines()) <= 25 and len(task.splitlines()) <= 10
    (folder / "my_es.py").write_text(method)
    (folder / "my_task.json").write_text(task)
    about = f"vase={folder}/blob.ply,cells=24,particles=200"
    command = [f"{folder}/my_es.py:OnePlusOne", "--task", f"{folder}/my_task.json", "--object", about]
    assert main([*command, "--budget", "2", "--out", str(folder / "out")]) == 0
    assert "| OnePlusOne (oracle) | 2 | " in capsys.readouterr().out
    OBJECTS.pop("vase")
