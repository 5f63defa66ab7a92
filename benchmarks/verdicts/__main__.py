"""`python -m benchmarks.verdicts [--quick] [--json OUT] [--markdown MD]`: does the planner say what a person would?

Clips of right and wrong motions are simulated and rendered (once: they are kept in ``--clips``), and each is judged for
its sentence by the offline agents, with the true trajectories in place of perception, and from its pictures. Fails if
more verdicts are false than is allowed.
"""

from __future__ import annotations

import dataclasses
import json
import sys
from functools import partial
from pathlib import Path

import tyro

from benchmarks import harness
from benchmarks.harness import RAW, Job
from benchmarks.verdicts.catalogue import list_clips
from benchmarks.verdicts.clip import Clip
from benchmarks.verdicts.figures import SIGHTS, find_excess
from benchmarks.verdicts.markdown import PAGE
from benchmarks.verdicts.sheets import write_sheets
from benchmarks.verdicts.things import THINGS, list_things
from benchmarks.verdicts.work import Part, do_all

JOBS = 16  # of each part


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Simulate clips and judge them, or write the tables of an earlier run."""

    json: Path = RAW / "verdicts.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Part, ...] = ("clips", "truth", "pictures")
    """clips: make those that are missing, and measure whether they move as labelled; truth: judge the true motion;
    pictures: judge what is seen."""
    clips: Path = Path("runs/verdicts")
    """Folder where clips are kept."""
    data: Path | None = None
    """Folder with guitar_sh0.ply, spot.obj, bunny.obj and coffee.png; none of them is needed."""
    workers: int = 1
    """Processes that simulate and look at pictures."""
    made: bool = False
    """Only judge clips that have been made."""
    sheets: Path | None = None
    """Write contact sheets of the misjudged clips here."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    clips = list_clips(command.data, command.quick)
    every: tuple[Part, ...] = ("clips", "truth", "pictures")
    parts = {part: partial(_list_jobs, command, clips, part) for part in every}
    missing = sorted(THINGS.keys() - set(list_things(command.data)))
    code = harness.main(command, parts, PAGE, {"left_out": missing})
    result = json.loads(command.json.read_text()) if command.json.is_file() else {}
    if command.sheets is not None:
        by_name = {clip.name: clip for clip in clips}
        rows = [row for part in SIGHTS for row in result.get(part, {"rows": []})["rows"] if not row["right"]]
        shown = [(by_name[row["clip"]], row) for row in rows if row["clip"] in by_name]
        write_sheets(command.sheets, shown, command.clips, command.data)
    excess = find_excess(result)
    for text in excess:
        harness.say(text)
    return code or bool(excess)


def _list_jobs(command: Command, clips: list[Clip], part: Part) -> list[Job]:
    """Each has a fair sample of all clips, so that a run that is stopped has one too."""
    jobs = []
    for number in range(JOBS):
        mine = sorted((clip for clip in clips if clip.turn % JOBS == number), key=lambda clip: clip.name)
        options = {"workers": command.workers, "made": command.made}
        work = partial(do_all, part, mine, command.clips, command.data, **options)
        jobs += [Job(f"sample {number:02d}", work)] if mine else []
    return jobs


if __name__ == "__main__":
    sys.exit(main())
