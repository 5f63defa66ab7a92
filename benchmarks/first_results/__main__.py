"""`python -m benchmarks.first_results [--json OUT] --data DIR [--sheets DIR] [--markdown MD]`: twenty-four sentences.

Runs the command-line job for each sentence in a process of its own and gathers what was asked, simulated, perceived and
true, what the planner says of each, and what is odd. What a viewer sees is written by hand (`seen.json`). Objects that
are not bundled and cannot be made are looked for in ``--data``; those that are missing are left out and named.
"""

from __future__ import annotations

import dataclasses
import json
import sys
from functools import partial
from pathlib import Path
from typing import Literal

import tyro

from benchmarks import harness
from benchmarks.first_results.catalogue import CASES, THINGS, Case, name_case
from benchmarks.first_results.markdown import PAGE
from benchmarks.first_results.running import run_case
from benchmarks.first_results.sheets import write_sheets
from benchmarks.harness import RAW, Job, Row
from benchmarks.harness.machine import circumstances
from physagent_jax.scene.presets import PresetName

ROOT = Path(__file__).resolve().parents[2]


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Run the sentences, or write the page of an earlier run."""

    json: Path = RAW / "first-results.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Literal["sentences"], ...] = ("sentences",)
    """There is one; give no names to write the page alone."""
    out: Path = Path("runs/first")
    """Folder for the runs."""
    data: Path | None = None
    """Folder with guitar_sh0.ply, spot.obj and bunny.obj."""
    sheets: Path | None = None
    """Write contact sheets of the runs in ``--out`` here."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    files = {name: thing.find_file(command.data, command.out) for name, thing in THINGS.items()}
    left_out = sorted(name for name, file in files.items() if file is None)
    chosen = {name_case(number, case): case for number, case in enumerate(CASES, 1)}
    if command.quick:
        fast = [name for name, case in chosen.items() if case.preset is PresetName.FAST]
        chosen = {name: chosen[name] for name in fast[::6]}
    jobs = [
        Job(f"{name}: {case.sentence}", partial(_run, command, name, case, file))
        for name, case in chosen.items()
        if (file := files[case.thing]) is not None
    ]
    about = {"left_out": left_out, "command": hide_folders(str(circumstances()["command"]), command)}
    code = harness.main(command, {"sentences": lambda: jobs}, PAGE, about)
    if command.sheets is not None:
        write_sheets(command.sheets, json.loads(command.json.read_text())["sentences"]["rows"], command.out)
    return code


def _run(command: Command, name: str, case: Case, file: Path) -> list[Row]:
    row = run_case(case, name, ["--object", str(file), *THINGS[case.thing].options], command.out)
    return [json.loads(hide_folders(json.dumps(row), command))]


def hide_folders(text: str, command: Command) -> str:
    """``text`` without the places of folders on this machine."""
    for folder, name in ((command.data, "DIR"), (command.out, "OUT"), (ROOT, ".")):
        for spelling in {str(folder), str(folder.resolve())} if folder else ():
            if Path(spelling).is_absolute():
                text = text.replace(spelling, name)
    return text


if __name__ == "__main__":
    sys.exit(main())
