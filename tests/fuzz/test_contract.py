"""The fuzzing itself: a planted fault of each kind is seen and counted as what it is."""

from __future__ import annotations

import contextlib
import io
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.fuzz.campaign import examine
from tests.fuzz.classes import CLASSES, shares
from tests.fuzz.classes.planted import DEADLY, PLANTED
from tests.fuzz.contract import Fault, Outcome, not_finite
from tests.fuzz.drawing import Draw, altered, damaged, of_schema

REPOSITORY = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("index", range(len(PLANTED)), ids=[what for what, _, _ in PLANTED])
def test_a_planted_fault_is_counted_as_what_it_is(index):
    what, column, _ = PLANTED[index]
    said, result = examine("planted", 0, index)
    assert said == what
    assert result.column == column, result
    assert (result.outcome is Outcome.FAILED) == (column not in ("accepted", "refused"))


def test_every_kind_of_fault_is_planted():
    assert {str(fault) for fault in Fault} <= {column for _, column, _ in PLANTED}


def test_the_place_in_the_code_is_told():
    """The innermost line of all, where none is the product's."""
    _, result = examine("planted", 0, [what for what, _, _ in PLANTED].index("an exception"))
    assert "planted.py" in result.place and "missing" in result.detail


def run(*arguments, **options) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, *arguments], cwd=REPOSITORY, capture_output=True, text=True, timeout=300, **options
    )


def test_processes_that_die_are_counted_and_the_others_go_on(tmp_path):
    """The whole command: counts per column, one entry per failure, exit code 1; a crash costs one case only."""
    crashes = len(PLANTED) + 2
    done = run(
        "-m",
        "tests.fuzz",
        "--only",
        "planted",
        "--cases",
        str(crashes),
        "--jobs",
        "2",
        "--json",
        tmp_path / "o.json",
    )
    assert done.returncode == 1, done.stderr
    written = json.loads((tmp_path / "o.json").read_text())
    expected: dict[str, int] = {}
    for _, column, _ in (*PLANTED, *DEADLY[:2]):
        expected[column] = expected.get(column, 0) + 1
    assert written["counts"]["planted"] == expected
    assert len(written["failures"]) == crashes - expected["accepted"] - expected["refused"]
    for column in expected:
        assert column in done.stdout
    assert "python -m tests.fuzz --only planted --seed 0 --index" in done.stdout


def test_a_hang_that_no_signal_ends_ends_the_process_with_its_traceback():
    index = len(PLANTED) + [what for what, _, _ in DEADLY].index("a hang that no signal ends")
    code = (
        "from tests.fuzz import campaign, contract\n"
        f"contract.PATIENCE = 0.3\ncampaign.examine('planted', 0, {index})"
    )
    done = run("-c", code)
    assert done.returncode == 1 and "planted.py" in done.stderr and "Timeout" in done.stderr


def test_another_process_makes_the_same_cases():
    """Whatever it has imported, drawn or hashed before."""
    code = (
        "import hashlib\nfrom tests.fuzz.classes import CLASSES\n"
        "for name, each in reversed(CLASSES.items()):\n"
        "    cases = [each.case(3, index) for index in range(6)]\n"
        "    files = [sorted(case.files.items()) for case in cases]\n"
        "    text = repr([case.what for case in cases] + files)\n"
        "    print(name, hashlib.sha256(text.encode('utf-8', 'backslashreplace')).hexdigest())\n"
    )
    seed = "2" if os.environ.get("PYTHONHASHSEED") == "1" else "1"  # another one than this process has
    one = run("-c", code, env={**os.environ, "PYTHONHASHSEED": seed})
    assert one.returncode == 0, one.stderr
    assert one.stdout.count("\n") == len(CLASSES)
    here = io.StringIO()
    with contextlib.redirect_stdout(here):
        exec(compile(code, "cases", "exec"), {})
    assert here.getvalue() == one.stdout


def test_cases_are_shared_out_as_in_the_default_run():
    assert sum(shares(10_000, ["scenes", "prompts"]).values()) == 10_000
    assert all(count >= 1 for count in shares(1, ["scenes", "prompts"]).values())


def test_not_finite_names_the_place():
    assert not_finite({"a": [1.0, {"b": np.array([0.0, np.inf])}]}).startswith("['a'][1]['b'] has 1 of 2")
    assert not_finite({"a": [1.0, None, "nan", 3]}) == ""


def test_draws_depend_on_the_key_alone():
    schema = {"type": "object", "properties": {"a": {"type": "number"}}, "required": ["a"]}

    def everything(key):
        draw = Draw(0, key)
        return (
            damaged(draw, b"x 12 y" * 9),
            altered(draw, {"a": [1, {"b": 2.0}]}),
            of_schema(draw, schema),
        )

    assert repr(everything("k")) == repr(everything("k"))
    assert len({repr(everything(key)) for key in range(9)}) > 5
