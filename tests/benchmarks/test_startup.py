"""What compilation adds to the first result, as the benchmark reports it."""

import pytest

from benchmarks.startup import document, summary


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


def test_compilation_is_what_cold_runs_take_longer():
    found = summary(ROWS)
    assert found["cold"] == {"median": 28.0, "range": [20.0, 30.0]}
    assert found["warm"] == {"median": 14.0, "range": [12.0, 16.0]}
    assert found["share_of_compilation"] == pytest.approx(0.5)


def test_the_document_shows_each_run_and_what_is_left_of_it():
    report = {
        "command": "command",
        "machine": "machine",
        "git_revision": "abc",
        "rows": ROWS,
        "summary": summary(ROWS),
    }
    lines = document(report).splitlines()
    assert "| 1 | cold | 7.5 | 15.0 | 7.5 | 30.0 |" in lines
    assert sum(line.startswith(("| 1 |", "| 2 |", "| 3 |")) for line in lines) == len(ROWS)
    assert any("50%" in line for line in lines)
