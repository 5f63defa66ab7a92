"""Time that compilation adds to the first result and that an iteration takes, as the benchmark reports it."""

import pytest

from benchmarks.startup import iteration, summary, write_tables


def row(number, state, seconds):
    stages = {"compile": 0.25 * seconds, "simulate": 0.5 * seconds}
    return {"round": number, "programs": state, "seconds": seconds, "stages": stages}


ROWS = [
    row(0, "cold", 30.0),
    row(0, "warm", 12.0),
    row(1, "cold", 20.0),
    row(1, "warm", 16.0),
    row(2, "cold", 28.0),
]


def repeat(number, simulate):
    stages = {
        "compile": 9.0,
        "simulate": simulate,
        "render": 1.0,
        "perceive": 2.0,
        "agents": 0.5,
        "write": 7.0,
    }
    return {"round": number, "stages": stages, "particles": 20000, "frames": 50, "substeps": 1300}


ITERATIONS = [repeat(0, 3.0), repeat(1, 5.0), repeat(2, 4.0)]


def test_compilation_is_what_cold_runs_take_longer():
    found = summary(ROWS)
    assert found["cold"] == {"median": 28.0, "range": [20.0, 30.0]}
    assert found["warm"] == {"median": 14.0, "range": [12.0, 16.0]}
    assert found["share_of_compilation"] == pytest.approx(0.5)


def test_an_iteration_is_its_four_stages_without_compiling_and_writing():
    found = iteration(ITERATIONS)
    assert (found["median"], found["range"], found["particles"]) == (7.5, [6.5, 8.5], 20000)


def section(rows):
    run = dict(command="c", machine="m", git_revision="abc", load_average=[0.1], quick=False, seconds=1.0)
    return {"runs": [run], "complete": True, "rows": [row | {"run": 0, "job": "j"} for row in rows]}


def test_the_tables_show_each_run_and_what_is_left_of_it():
    tables = write_tables({"first": section(ROWS), "iteration": section(ITERATIONS)})
    stages = tables["stages"].splitlines()
    assert "| 1 | cold | 7.5 | 15.0 | 7.5 | 30.0 |" in stages
    assert sum(line.startswith(("| 1 |", "| 2 |", "| 3 |")) for line in stages) == len(ROWS)
    assert "| 2 | 9.0 | 5.0 | 1.0 | 2.0 | 0.5 | 7.0 | 1300 |" in tables["iteration"]
    assert "**7.5 s** (6.5 to 8.5" in tables["iteration"] and "50%" in tables["first"]
