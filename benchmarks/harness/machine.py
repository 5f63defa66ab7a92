"""Provenance of figures, kept beside them in every JSON."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from pathlib import Path

from physagent_jax.run.provenance import describe_platform, read_git_revision, read_versions


def circumstances() -> dict[str, object]:
    """Machine, load, versions, revision and command."""
    return {
        "machine": f"{_read_processor()}, {os.cpu_count()} cores; {describe_platform()}",
        "load_average": [round(load, 2) for load in os.getloadavg()],
        "versions": read_versions(),
        "git_revision": _read_revision(),
        "command": "python -m " + shlex.join([_find_module(), *map(_name_argument, sys.argv[1:])]),
    }


def _read_revision() -> str | None:
    """The checkout's revision; results and documents that a benchmark has rewritten do not make it "-dirty"."""
    found = read_git_revision()
    if found is None or not found.endswith("-dirty"):
        return found
    command = ["git", "status", "--porcelain", "--untracked-files=no", "--", ":/"]
    command += [":(top,exclude)benchmarks/results", ":(top,exclude)docs"]
    changed = subprocess.run(
        command, cwd=Path(__file__).parent, capture_output=True, text=True, check=True
    ).stdout
    return found if changed.strip() else found.removesuffix("-dirty")


def _find_module() -> str:
    spec = sys.modules["__main__"].__spec__
    return spec.name.removesuffix(".__main__") if spec else sys.argv[0]


def _name_argument(argument: str) -> str:
    """As it was given; DIR for a folder elsewhere, there yet or not, and DIR/FILE for a file there."""
    name, equals, path = argument.rpartition("=")  # "q15=FILE" too
    absolute = os.path.isabs(path)
    there = absolute or os.path.isdir(path)
    if not there:
        return argument
    if Path(path).resolve().is_relative_to(Path.cwd()):
        return f"{name}{equals}{os.path.relpath(path)}"
    is_file = absolute and bool(Path(path).suffix) and not os.path.isdir(path)
    return f"{name}{equals}DIR{f'/{Path(path).name}' if is_file else ''}"


def _read_processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return "unknown processor"
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else "unknown processor"
