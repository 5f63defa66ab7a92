"""`python -m benchmarks.first_results [--parts SET ...] --data DIR [--sheets DIR] [--stills DIR]`: ordinary sentences.

Runs the command-line job for each sentence in a process of its own and gathers what was asked, simulated, perceived and
true, what the planner says of each, and what is odd. What a viewer sees is written by hand (`seen.json`): ``--stills``
writes pictures to look at, and a list of the remarks that are to be written. Objects that are not bundled and cannot be
made are looked for in ``--data``; those that are missing are left out and named.
"""

from __future__ import annotations

import dataclasses
import json
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Literal

import tyro

from benchmarks import harness
from benchmarks.first_results.cases import Case
from benchmarks.first_results.catalogue import SETS, THINGS, name_cases
from benchmarks.first_results.markdown import PAGE
from benchmarks.first_results.running import run_case
from benchmarks.first_results.sheets import write_sheets, write_stills
from benchmarks.first_results.viewing import list_unseen, read_remarks
from benchmarks.harness import RAW, Job, Row
from benchmarks.harness.machine import circumstances
from physagent_jax.core.errors import UserError
from physagent_jax.core.files import write_text
from physagent_jax.scene.presets import PresetName

ROOT = Path(__file__).resolve().parents[2]


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Run the sentences, or write the page of an earlier run."""

    json: Path = RAW / "first-results.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Literal[*SETS], ...] = ("sentences",)  # pyright: ignore[reportInvalidTypeForm]
    """Sets of sentences to run; no names = run none, for the page, the sheets and the stills of earlier runs."""
    out: Path = Path("runs/first")
    """Folder for the runs."""
    data: Path | None = None
    """Folder with guitar_sh0.ply, spot.obj and bunny.obj, or of `benchmarks.first_results.objects`."""
    sheets: Path | None = None
    """Write contact sheets of the runs in ``--out`` here."""
    stills: Path | None = None
    """Write large frames of the runs that nobody has looked at here, and the remarks to be written."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    try:
        return measure(command)
    except UserError as error:
        harness.say(str(error))
        return 2


def measure(command: Command) -> int:
    """Run what the command asks for, and write pictures of it; return the exit code."""
    jobs: dict[str, list[Job]] = {}
    left_out: set[str] = set()
    for group in command.parts:
        jobs[group], missing = list_jobs(command, group)
        left_out |= missing
    about = {
        "left_out": sorted(left_out),
        "command": hide_folders(str(circumstances()["command"]), command),
    }
    code = harness.main(command, {group: partial(jobs.__getitem__, group) for group in SETS}, PAGE, about)
    if code == 2:  # nothing was run
        return code
    write_pictures(command, command.parts or tuple(SETS))
    return code


def list_jobs(command: Command, group: str) -> tuple[list[Job], set[str]]:
    """The runs of a set, and the names of the objects that there are no files of."""
    chosen = name_cases(group)
    if command.quick:
        fast = [name for name, case in chosen.items() if case.preset is PresetName.FAST]
        chosen = {name: chosen[name] for name in fast[::6]}
    things = {case.thing for case in chosen.values()}
    files = {name: THINGS[name].find_file(command.data, command.out) for name in things}
    jobs = [
        Job(f"{name}: {case.sentence}", partial(_run, command, name, case, file))
        for name, case in chosen.items()
        if (file := files[case.thing]) is not None
    ]
    return jobs, {name for name, file in files.items() if file is None}


def write_pictures(command: Command, groups: Sequence[str]) -> None:
    """Write contact sheets, and what a person needs who looks at the videos."""
    result = json.loads(command.json.read_text()) if command.json.is_file() else {}
    rows = {group: result[group]["rows"] for group in groups if group in result}
    if command.sheets is not None:
        for group in rows:
            write_sheets(command.sheets, rows[group], command.out, group)
    if command.stills is not None:
        every = [row for group in rows for row in rows[group]]
        unseen = list_unseen(every, read_remarks())
        write_stills(command.stills, [row for row in every if row["case"] in unseen], command.out)
        write_text(command.stills / "remarks.json", json.dumps(unseen, indent=1) + "\n")


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
