"""Every example runs as its first lines say, and finds what it says; its own assertions are the test."""

import os
import subprocess
import sys

import pytest

from tests.conftest import REPOSITORY

EXAMPLES = sorted((REPOSITORY / "examples").glob("*.py"))


def test_there_are_examples_and_each_is_short():
    assert len(EXAMPLES) >= 8
    for path in EXAMPLES:
        lines = path.read_text().splitlines()
        assert 20 <= len(lines) <= 90, path.name
        assert f"python examples/{path.name}" in "\n".join(lines[:6])


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_finds_what_it_says(path, tmp_path):
    environment = {**os.environ, "PYTHONPATH": str(REPOSITORY)}
    done = subprocess.run(
        [sys.executable, str(path)],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.strip()
