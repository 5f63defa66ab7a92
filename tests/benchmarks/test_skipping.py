"""Skipping changes nothing, says what it saves, and is caught when it does change something."""

import dataclasses
import json

import numpy as np
import pytest

from benchmarks.skipping import __main__ as command
from benchmarks.skipping.base import Pair, Sizes, Skip, State, Way, disagreement
from benchmarks.skipping.catalogue import GROUPS, SKIPS
from benchmarks.skipping.markdown import write_tables
from benchmarks.skipping.measure import FEWEST, NOT_MEASURABLE, answers, judge, row, verdict

pytestmark = pytest.mark.usefixtures("module_least_optimised")  # each runs once or twice

TINY = Sizes(
    particles=500,
    cells=20,
    substeps=6,
    rounds=2,
    seconds=0.0,
    sample=0.0,
    bar_per_axis=1,
    clip_particles=150,
    clip_frames=2,
    clip_pixels=32,
)


@pytest.mark.parametrize("name", SKIPS)
def test_skipping_changes_nothing(name):
    skip = SKIPS[name]
    judged = judge(skip, *answers(skip.pair(TINY)))
    assert judged["good"], judged["message"]


def test_names_are_unique_and_whoever_tolerates_more_says_why():
    assert len(SKIPS) == sum(map(len, GROUPS.values()))
    for skip in SKIPS.values():
        assert skip.tolerance <= 1e-6 or skip.reason, skip.name


def test_the_answers_say_how_matter_moved():
    """Answers that are empty or at rest would agree whatever is skipped."""
    lean, full = answers(SKIPS["forces"].pair(TINY))
    assert set(lean) == {"x", "v", "F", "trusted"} and lean["trusted"] == full["trusted"] == 1
    assert np.abs(lean["F"] - np.eye(3)).max() > 0.01 and np.abs(lean["v"]).max() > 0.1


def test_a_difference_is_relative_to_the_largest_value():
    one = {"x": np.array([1.0, 200.0]), "v": 1.0}
    assert disagreement(one, one) == (0.0, "")
    assert disagreement({**one, "x": np.array([1.0, 201.0])}, one) == (pytest.approx(1 / 200), "x")
    assert disagreement({"x": np.zeros(2)}, {"x": np.zeros(2)}) == (0.0, "")
    assert disagreement({"x": np.full(2, 1e-3)}, {"x": np.zeros(2)})[0] == pytest.approx(1e-3)
    for other in (one | {"v": np.nan}, one | {"x": np.ones(3)}, {"x": one["x"]}):
        assert disagreement(other, one)[0] == np.inf
    assert disagreement({"file": b"ab"}, {"file": b"ab"})[0] == 0
    assert disagreement({"file": b"ab"}, {"file": b"ac"})[0] == np.inf


def test_a_saving_within_noise_is_none():
    assert verdict([1.2, 1.3, 1.1, 1.25, 1.2, 1.1]) == "saves"
    assert verdict([0.8, 0.9, 0.85, 0.8, 0.7, 0.9]) == "costs"
    assert verdict([1.2, 0.9, 1.1, 1.25, 0.95, 1.2]) == NOT_MEASURABLE
    assert verdict([1.004, 1.003, 1.005, 1.002, 1.004, 1.003]) == NOT_MEASURABLE  # sure, but nothing
    assert verdict([1.5] * 8 + [0.2]) == "saves"  # one round was disturbed
    assert verdict([1.5] * 5) == NOT_MEASURABLE  # too few to tell
    assert verdict([1.5] * FEWEST) == "saves"


def constant(value):
    return Way(lambda: np.full(3, value), lambda array: {"x": array})


def made_up(name, lean=1.0, full=1.0, **options):
    pair = Pair(constant(lean), constant(full), particles=3)
    return Skip(name, "a thing", "the thing", lambda sizes: pair, **options)


def unbuildable(sizes):
    raise ValueError("cannot | be built")


ROWS = {
    "same": made_up("same"),
    "astray": made_up("astray", lean=1.001, state=State.MISSING),
    "broken": dataclasses.replace(made_up("broken"), pair=unbuildable),
}


def test_a_row_has_its_times_and_its_difference():
    found = row(ROWS["same"], dataclasses.replace(TINY, rounds=5))
    assert found["good"] and found["disagreement"] == 0 and found["rounds"] == 5
    low, high = found["lean_range_ms"]
    assert low <= found["lean_ms"] <= high and found["lean_compile_seconds"] >= 0
    json.dumps(found)


def test_a_skip_that_changes_something_fails_its_row():
    found = row(ROWS["astray"], TINY)
    assert not found["good"] and found["disagreement"] == pytest.approx(1e-3)
    assert found["message"] == "`x` differs by 0.001, more than 1e-06"
    assert not row(made_up("lost", lean=np.nan), TINY)["good"]


def test_errors_are_judged_by_their_bar():
    skip = dataclasses.replace(SKIPS["automatic step against 0.0001 s"], tolerance=0.1)
    assert judge(skip, {"error": 0.05}, {"error": 0.3})["good"]
    judged = judge(skip, {"error": 0.2}, {"error": 0.3})
    assert not judged["good"] and judged["message"] == "the error 0.2 exceeds 0.1"


def run(monkeypatch, skips, *arguments):
    """The command line with ``skips`` for a catalogue; its exit code."""
    monkeypatch.setattr(command, "GROUPS", {"Made up": tuple(skips.values())})
    monkeypatch.setattr(command.jax, "clear_caches", lambda: None)  # other tests would have to compile again
    monkeypatch.setattr("sys.argv", ["skipping", "--quick", "--parts", "Made up", *map(str, arguments)])
    return command.main()


def test_the_command_fails_with_its_worst_row_and_keeps_the_others(monkeypatch, tmp_path):
    out = tmp_path / "out.json"
    assert run(monkeypatch, ROWS, "--json", out, "--only", "same") == 0
    assert run(monkeypatch, ROWS, "--json", out, "--only", "nothing") == 2
    assert run(monkeypatch, ROWS, "--json", out, "--only", "astray", "broken") == 1
    result = json.loads(out.read_text())
    rows = result["Made up"]["rows"]
    assert [entry["name"] for entry in rows] == ["same", "astray", "broken"]
    assert [entry["run"] for entry in rows] == [0, 1, 1]
    assert [entry["good"] for entry in rows] == [True, False, False]
    monkeypatch.setattr("benchmarks.skipping.markdown.GROUPS", {"Made up": tuple(ROWS.values())})
    text = "\n".join(write_tables(result).values())
    assert text.count("quick: not to be quoted") == 1
    assert "3 rows. Failing: astray, broken." in text
    assert "Not skipped yet: astray." in text and "Not measured yet: gravity" in text
    assert "| broken | skipped |  |  | **failed**: ValueError: cannot / be built |" in text
    assert "**FAILS**: `x` differs by 0.001" in text


def test_every_line_of_the_tables_has_as_many_columns(monkeypatch):
    names = ["same", "astray", "broken"]
    rows = [row(ROWS[name], TINY) | {"run": 0, "job": name} for name in names]
    rows.append(rows[0] | {"name": "error", "disagreement": None, "lean_error": 0.01, "full_error": 0.02})
    about = dict(quick=False, command="c", machine="m", git_revision="r", load_average=[0.1], seconds=1.0)
    skips = (*ROWS.values(), made_up("error"))
    monkeypatch.setattr("benchmarks.skipping.markdown.GROUPS", {"Made up": skips})
    section = {"runs": [about], "complete": True, "rows": rows}
    text = write_tables({"Made up": section})["made up"]
    lines = [line for line in text.splitlines() if line.startswith("|")]
    assert len(lines) == 2 + len(rows) and {line.count("|") for line in lines} == {11}
    assert "errors 0.01 and 0.02" in text and "- **same** leaves out a thing. Without: the thing." in text
