"""Runs of the command line in processes of their own, and what is asked of what they leave."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.fuzz import seeds
from tests.fuzz.contract import half_written

REPOSITORY = Path(__file__).resolve().parents[2]
LIMIT = 240.0  # [s] for a process, compilation included
PROMPT = "push the robot hard to the left"
RUN = ("--frames", "3", "--particles", "60", "--resolution", "32", "--max-iterations", "2", "--seed", "1")
RUN += ("--video-size", "64x48")
COSTS = {
    "stages",
    "first_clip",
    "agents",
    "command",
}  # of a manifest: what depends on the clock, or on how often a run was started


def environment(base: Path, **changes: str) -> dict[str, str]:
    """Of a process: its caches lie in ``base``."""
    kept = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("PHYSAGENT", "NUMBA", "JAX", "XLA"))
    }
    ours = {"PYTHONPATH": str(REPOSITORY), "XDG_CACHE_HOME": str(base / "caches"), "JAX_PLATFORMS": "cpu"}
    ours["JAX_DISABLE_MOST_OPTIMIZATIONS"] = "1"  # compiling takes longer than running
    return {**kept, **ours, **changes}


def start(
    base: Path, arguments: list, *, what="none", at=0, marker="", prefix=(), env=None, **options
) -> subprocess.Popen:
    """A process of the command line (`tests.fuzz.interrupted`), in a session of its own."""
    line = [*prefix, sys.executable, "-m", "tests.fuzz.interrupted", what, at, marker, "--", *arguments]
    return subprocess.Popen(
        list(map(str, line)), cwd=base, env=env or environment(base), stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True,
        start_new_session=True, **options,
    )  # fmt: skip


def ended(process: subprocess.Popen, limit: float = LIMIT) -> tuple[int, str]:
    """Exit code and standard error; a process that does not end is killed with its children, and the test fails."""
    try:
        _, errors = process.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        pytest.fail(f"no end after {limit:g} s: {process.args}")
    return process.returncode, errors


def run(base: Path, out: Path, **options) -> tuple[int, str]:
    """The run of these tests into ``out``; what happens to it is in ``options``."""
    arguments = ["run", "--object", base / seeds.OBJECT, "--prompt", PROMPT, "--out", out, *RUN]
    return ended(start(base, arguments, **options))


def said(errors: str) -> list[str]:
    """The lines that begin with `physagent:`; there must be no traceback."""
    assert "Traceback" not in errors, errors[-2000:]
    return [line for line in errors.splitlines() if line.startswith("physagent: ")]


def whole(out: Path) -> None:
    """Every file in a folder can be read; temporary ones are allowed while a run is not finished."""
    for path in out.rglob("*"):
        if not path.name.startswith("."):
            assert half_written(path) == "", path


def contents(out: Path) -> dict[str, object]:
    """The files of a finished run, by name: bytes, or JSON where the clock is part of it."""
    found: dict[str, object] = {}
    for path in sorted(p for p in out.rglob("*") if p.is_file()):
        name = str(path.relative_to(out))
        if name == "manifest.json":
            manifest = json.loads(path.read_text())
            found[name] = {key: value for key, value in manifest.items() if key not in COSTS}
        elif name == "report.html":  # shows wall times
            found[name] = path.read_text(encoding="utf-8").rstrip().endswith("</html>")
        else:
            found[name] = path.read_bytes()
    return found


def same(out: Path, undisturbed: Path) -> None:
    """Both runs left the same; nothing temporary is among it."""
    got, expected = contents(out), contents(undisturbed)
    assert got.keys() == expected.keys()
    assert got["manifest.json"] == expected["manifest.json"]
    differing = [name for name, value in expected.items() if got[name] != value]
    assert not differing


def children_of_session(session: int) -> list[str]:
    """Processes of a session that are still there."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if int(fields[3]) == session and fields[0] != "Z":
            found.append(stat.parent.name)
    return found
