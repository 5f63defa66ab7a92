"""The harness: which jobs are done, what is kept of a file, and how tables look."""

import dataclasses
import importlib
import json
import os
import sys
import time
from functools import partial

import pytest

from benchmarks import harness
from benchmarks.harness import Job, Page, provenance, table
from benchmarks.harness.machine import circumstances
from benchmarks.harness.workers import call_all


class Bench:
    """A benchmark of two parts whose jobs note that they were done."""

    def __init__(self, path):
        self.path, self.done, self.broken, self.documents = path, [], None, 0

    def jobs(self, part):
        return [Job(f"{part} {i}", lambda i=i: self.measure(part, i)) for i in range(3)]

    def measure(self, part, i):
        if (part, i) == self.broken:
            raise KeyboardInterrupt
        self.done.append(f"{part} {i}")
        return [{"value": len(self.done), "good": i < 2}]

    def run(self, **options):
        """The exit code; `done` holds what this run did."""
        self.done.clear()
        options = {"parts": ("slow", "fast")} | options
        command = harness.Command(json=self.path, markdown=self.path.with_suffix(".md"), **options)
        return harness.main(
            command,
            {part: lambda part=part: self.jobs(part) for part in ("slow", "fast")},
            Page("bench", "bench", self.write_tables),
        )

    def write_tables(self, result):
        self.documents += 1
        return {"runs": provenance(result, ("slow", "fast", "absent"))}

    @property
    def result(self):
        return json.loads(self.path.read_text())


@pytest.fixture
def bench(tmp_path):
    return Bench(tmp_path / "out.json")


def test_all_jobs_of_all_parts_are_done_and_failing_rows_are_told(bench):
    assert bench.run() == 1
    assert bench.done == [f"{part} {i}" for part in ("slow", "fast") for i in range(3)]
    section = bench.result["slow"]
    assert section["complete"] and [row["job"] for row in section["rows"]] == ["slow 0", "slow 1", "slow 2"]
    (run,) = section["runs"]
    assert {"machine", "load_average", "versions", "git_revision", "command", "seconds", "quick"} <= set(run)


def test_a_command_is_recorded_without_where_folders_lie_on_this_machine(tmp_path, monkeypatch):
    """Paths within the repository are part of it, as are files that are not there."""
    home, elsewhere = tmp_path / "repository", tmp_path / "data"
    (home / "runs").mkdir(parents=True)
    elsewhere.mkdir()
    monkeypatch.chdir(home)
    words = [
        "--data",
        str(elsewhere),
        "--also",
        "../data",
        "--weights",
        "runs",
        "--only",
        "a b",
        "--json",
        "x.json",
        "--out",
        str(elsewhere / "not-yet" / "rows.json"),
        f"big={elsewhere / 'model.gguf'}",
        str(home / "runs" / "own.json"),
    ]
    monkeypatch.setattr("sys.argv", ["bench", *words])
    command = str(circumstances()["command"])
    assert command.endswith(
        "--data DIR --also DIR --weights runs --only 'a b' --json x.json "
        "--out DIR/rows.json big=DIR/model.gguf runs/own.json"
    )


def test_a_run_that_was_stopped_is_gone_on_with(bench):
    bench.broken = ("slow", 1)
    with pytest.raises(KeyboardInterrupt):
        bench.run()
    assert not bench.result["slow"]["complete"] and len(bench.result["slow"]["rows"]) == 1
    bench.broken = None
    bench.run(resume=True)
    assert bench.done == ["slow 1", "slow 2", "fast 0", "fast 1", "fast 2"]
    section = bench.result["slow"]
    assert section["complete"] and [row["run"] for row in section["rows"]] == [0, 1, 1]
    bench.run(resume=True)
    assert bench.done == [] and len(bench.result["slow"]["runs"]) == 2


def test_a_row_is_a_line_of_the_file(bench):
    bench.run()
    lines = [line.rstrip(",") for line in bench.path.read_text().splitlines()]
    for section in bench.result.values():
        for item in (*section["runs"], *section["rows"]):
            assert json.dumps(item) in lines
    bench.run(parts=("fast",), only=("fast 1",))
    after = [line.rstrip(",") for line in bench.path.read_text().splitlines()]
    assert len(set(lines) - set(after)) <= 2 and len(after) == len(lines) + 1  # a run more, and its row


def test_two_commands_never_write_the_same_rows(bench, capsys):
    """The one that starts while another is at work is refused; different files do not hinder each other."""
    seen = []

    def measure(part, i):
        if (part, i) == ("slow", 1):
            seen.append((Bench(bench.path).run(resume=True), Bench(bench.path.with_name("other.json")).run()))
        return [{"value": 1}]

    bench.measure = measure
    assert bench.run() == 0 and seen == [(2, 1)]
    said = " ".join(capsys.readouterr().err.split())
    assert "another process is writing" in said and "or choose another --json" in said
    assert len(bench.result["slow"]["rows"]) == 3
    assert sorted(path.name for path in bench.path.parent.iterdir()) == [
        f"{name}.{end}" for name in ("other", "out") for end in ("json", "md")
    ]


def test_single_jobs_are_done_anew_beside_the_others(bench):
    bench.run()
    assert bench.run(only=("slow 1",)) == 0
    assert bench.done == ["slow 1"]
    rows = bench.result["slow"]["rows"]
    assert [row["job"] for row in rows] == ["slow 0", "slow 1", "slow 2"]
    assert [row["run"] for row in rows] == [0, 1, 0] and bench.result["slow"]["complete"]
    assert len(bench.result["fast"]["rows"]) == 3


def test_a_part_without_such_a_job_is_left_alone(bench):
    bench.run(only=("slow 1",))
    assert list(bench.result) == ["slow"] and not bench.result["slow"]["complete"]


def test_without_either_a_part_begins_anew_and_the_others_are_kept(bench):
    bench.run()
    bench.run(parts=("fast",))
    assert bench.done == ["fast 0", "fast 1", "fast 2"]
    assert [len(bench.result[part]["runs"]) for part in ("slow", "fast")] == [1, 1]


def test_quick_rows_and_others_do_not_mix(bench):
    bench.run(quick=True)
    bench.run(resume=True)
    assert len(bench.done) == 6 and not bench.result["slow"]["runs"][0]["quick"]


def test_no_parts_only_write_the_tables(bench):
    bench.run()
    assert bench.run(parts=()) == 0 and bench.done == [] and bench.documents == 2


def test_what_there_is_not_is_refused_before_anything_is_done(bench, capsys):
    assert bench.run(parts=("fast", "none")) == 2
    assert bench.run(only=("slow 1", "slow9")) == 2
    assert bench.done == [] and not bench.path.exists()
    told = " ".join(capsys.readouterr().err.split())
    assert "none of 6 jobs has 'slow9' in its name; the nearest are: slow" in told
    assert told.count("fast") == 2 + 1  # five names of six, and the parts there are


def test_the_document_says_where_its_rows_come_from(bench):
    bench.run(quick=True)
    text = bench.path.with_suffix(".md").read_text()
    assert text.startswith("<!-- table: runs -->\n| part | rows | seconds |")
    assert "| slow (quick: not to be quoted) | 3 |" in text and "Not measured yet: absent." in text


def test_a_part_that_was_stopped_says_so_and_rows_of_two_runs_name_both():
    run = dict(command="c", machine="m", load_average=[1.5], git_revision="r", quick=False, seconds=2.0)
    rows = [{"run": 0}, {"run": 2}]
    later = run | {"git_revision": None, "remark": "Busy."}
    section = {"runs": [run, run, later], "complete": False, "rows": rows}
    text = provenance({"part": section}, ("part",), {"both": len})
    assert (
        "| part (stopped before its end) | 2 | 2 | 4.0 | A; 1.5; r; then A; 1.5; revision not recorded. Busy. |"
        in text
    )
    assert text.endswith("\nA: m.\n")


def test_loads_and_revisions_of_one_machine_stand_together():
    run = dict(command="c", machine="m", quick=False, seconds=2.0)
    runs = [
        run | {"load_average": [load], "git_revision": name} for load, name in zip((2.0, 0.5, 1.0), "abb")
    ]
    section = {"runs": runs, "complete": True, "rows": [{"run": index} for index in range(3)]}
    other = section | {"runs": [each | {"machine": "n"} for each in runs]}
    text = provenance({"one": section, "two": other}, ("one", "two"))
    assert (
        "| one | 3 | 6.0 | A; 0.5 to 2.0; a, b |" in text
        and "| two | 3 | 6.0 | B; 0.5 to 2.0; a, b |" in text
    )
    assert text.endswith("\nA: m.\n\nB: n.\n")


def test_many_revisions_are_counted_and_those_that_were_not_kept_are_told():
    def name(*revisions):
        run = dict(command="c", machine="m", quick=False, seconds=2.0, load_average=[1.0])
        runs = [run | {"git_revision": revision} for revision in revisions]
        rows = [{"run": index} for index in range(len(runs))]
        return provenance({"one": {"runs": runs, "complete": True, "rows": rows}}, ("one",))

    assert "A; 1.0; a, b |" in name("a", "b", "a") and "A; 1.0; revision not recorded |" in name(None)
    assert "A; 1.0; 4 revisions, the last d, revision not recorded |" in name("a", "b", None, "c", "d")


def test_a_summary_says_how_many_rows_were_measured():
    run = dict(command="c", machine="m", load_average=[1.5], git_revision="r", quick=False, seconds=2.0)
    section = {"runs": [run, run], "complete": True, "rows": [{"run": 1} for _ in range(5)]}
    summary = harness.condense_section(section, [{"all": 5}])
    assert summary == {"runs": [run], "complete": True, "measured": 5, "rows": [{"all": 5}]}
    assert "| part | 5 | 2.0 |" in provenance({"part": summary}, ("part",))


def test_tables_are_as_wide_as_their_columns():
    assert table(("a", "b"), [(1, "x")]) == "\n| a | b |\n|---|---|\n| 1 | x |\n"


def test_numbers_have_three_figures():
    numbers = (None, 0.0012345, 12.345, 12345.6)
    assert [harness.number(value) for value in numbers] == ["", "0.00123", "12.3", "12,346"]


def test_every_benchmark_has_the_same_options():
    from benchmarks.accuracy.__main__ import Command as Accuracy
    from benchmarks.stability.__main__ import Command as Stability
    from benchmarks.throughput.__main__ import Command as Throughput

    common = {field.name for field in dataclasses.fields(harness.Command)}
    for command in (Accuracy, Stability, Throughput):
        assert common <= {field.name for field in dataclasses.fields(command)}


@pytest.mark.parametrize(
    ("module", "option"),
    [
        ("headtohead.__main__", "--plots"),
        ("distillation", "--plots"),
        ("accuracy.__main__", "--plot"),
        ("inverse.__main__", "--images"),
    ],
)
def test_figures_without_matplotlib_are_refused_before_anything_is_measured(
    tmp_path, monkeypatch, capsys, module, option
):
    main = importlib.import_module(f"benchmarks.{module}").main
    rows = tmp_path / "rows.json"
    monkeypatch.setitem(sys.modules, "matplotlib", None)  # an import of it fails
    monkeypatch.setattr(harness, "main", lambda *_, **__: pytest.fail("something was measured"))
    monkeypatch.setattr(sys, "argv", ["bench", "--json", str(rows), option, str(tmp_path / "images")])
    assert main() == 2 and "plots need matplotlib" in " ".join(capsys.readouterr().err.split())
    assert not rows.exists()


def test_workers_return_what_calls_one_after_another_return(tmp_path):
    """In whatever order; each prepared first."""
    (tmp_path / "here").touch()
    calls = [partial(range, count) for count in range(5)] + [partial(os.listdir, ".")]
    found = dict(call_all(calls, 2, partial(os.chdir, tmp_path)))
    assert found == {**{place: list(range(place)) for place in range(5)}, 5: ["here"]}
    assert dict(call_all(calls[:5])) == {place: found[place] for place in range(5)}


@pytest.mark.skipif(len(getattr(os, "sched_getaffinity", lambda _: ())(0)) < 2, reason="needs two cores")
def test_workers_do_not_share_cores():
    calls = [partial(os.sched_getaffinity, 0)] * 6
    shares = {tuple(sorted(cores)) for _, cores in call_all(calls, 2)}
    assert sum(map(len, shares)) == len(set().union(*shares)) <= len(os.sched_getaffinity(0))


def test_a_group_is_done_by_one_worker_until_the_other_has_nothing_left(tmp_path):
    """In its order; only its last calls are taken over.

    The other worker waits until the group's second call has begun, and that one until its fourth was taken over.
    """
    begun, taken = tmp_path / "begun", tmp_path / "taken"
    calls = [partial(meet, None, None) for _ in range(6)]
    calls[1], calls[3], calls[4] = (
        partial(meet, begun, taken),
        partial(meet, taken, None),
        partial(meet, None, begun),
    )
    done = list(call_all(calls, 2, groups=["one"] * 4 + ["two", "three"]))
    assert sorted(place for place, _ in done) == list(range(6))
    by = {place: who for place, (who,) in done}
    assert by[0] == by[1] != by[4] == by[5] == by[3]
    own = [place for place, _ in done if by[place] == by[0]]
    assert own == sorted(own)


def test_what_fails_in_a_worker_is_raised(tmp_path):
    with pytest.raises(FileNotFoundError):
        list(call_all([partial(os.listdir, tmp_path / "absent")], 2))


def meet(made, wanted):
    """Make a file, wait for another, and say who did: found by its name in another process."""
    if made is not None:
        made.touch()
    while wanted is not None and not wanted.exists():
        time.sleep(0.01)
    return [os.getpid()]


def make_rows(value):
    """Rows of a job of several workers: found by its name in another process."""
    return [{"value": value}]


NOTHING = Page("nothing", "nothing", lambda result: {})


def test_rows_of_workers_are_kept_in_the_jobs_order(tmp_path):
    """And a run that was stopped is gone on with, by however many."""
    path = tmp_path / "out.json"
    jobs = [Job(f"job {i}", partial(make_rows, i)) for i in range(4)]
    command = harness.Command(json=path, parts=("part",), only=("job 2",))
    assert harness.main(command, {"part": lambda: jobs}, NOTHING) == 0
    command = harness.Command(json=path, parts=("part",), resume=True)
    assert harness.main(command, {"part": lambda: jobs}, NOTHING, workers=2) == 0
    section = json.loads(path.read_text())["part"]
    assert [(row["job"], row["value"], row["run"]) for row in section["rows"]] == [
        ("job 0", 0, 1),
        ("job 1", 1, 1),
        ("job 2", 2, 0),
        ("job 3", 3, 1),
    ]
    assert [run.get("workers") for run in section["runs"]] == [None, 2] and section["complete"]
