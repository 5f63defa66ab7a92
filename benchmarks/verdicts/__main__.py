"""`python -m benchmarks.verdicts [--quick] --json OUT [--markdown MD]`: does the planner say what a person would?

Clips of right and wrong motions are simulated and rendered (once: they are kept in ``--clips``), and each is judged for
its sentence by the offline agents, with the true trajectories in place of perception, and from its pictures. Fails if
more verdicts are false than is allowed.
"""

from __future__ import annotations

import dataclasses
import json
import multiprocessing
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from pathlib import Path
from typing import Literal

import tyro

from benchmarks import harness
from benchmarks.harness import Job, Row
from benchmarks.verdicts.catalogue import list_clips
from benchmarks.verdicts.clip import Clip
from benchmarks.verdicts.figures import SIGHTS, find_excess
from benchmarks.verdicts.judging import judge
from benchmarks.verdicts.markdown import document
from benchmarks.verdicts.recording import find_file, record
from benchmarks.verdicts.sheets import write_sheets
from benchmarks.verdicts.things import THINGS, list_things


JOBS = 16  # of each part


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Simulate clips and judge them, or write the tables of an earlier run."""

    parts: tuple[Literal["clips", "truth", "pictures"], ...] = ("clips", "truth", "pictures")
    """clips: make those that are missing; truth: judge the true motion; pictures: judge what is seen."""
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
    """Runs the command line."""
    command = tyro.cli(Command)
    clips = list_clips(command.data, command.quick)
    works: dict[str, Callable[[Clip, Path, Path | None], Row]] = {"clips": make}
    works |= {sight: partial(judge, sight=sight) for sight in SIGHTS}
    parts = {part: partial(_list_jobs, command, clips, part, work) for part, work in works.items()}
    missing = sorted(THINGS.keys() - set(list_things(command.data)))
    code = harness.main(command, parts, document, {"left_out": missing})
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


def make(clip: Clip, clips: Path, data: Path | None) -> Row:
    """Simulates and renders a clip, if it has not been."""
    held = record(clip.thing, clip.motion, clips, data)
    return {"clip": clip.name, "frames": len(held.rgb), "particles": held.particles.shape[1]}


def _list_jobs(command: Command, clips: list[Clip], part: str, work: Callable) -> list[Job]:
    """Each has a fair sample of all clips, so that a run that is stopped has one too."""
    chosen = [[clip for clip in clips if clip.turn % JOBS == number] for number in range(JOBS)]
    return [
        Job(f"sample {number:02d}", partial(_do, command, mine, part, work))
        for number, mine in enumerate(chosen)
        if mine
    ]


def _do(command: Command, clips: list[Clip], part: str, work: Callable) -> list[Row]:
    """The rows of a job."""
    ready = partial(_attempt, work, command.clips, command.data, command.made)
    clips = sorted(clips, key=lambda clip: clip.name)
    # What the truth shows is judged in no time.
    apart = command.workers > 1 and part != "truth"
    rows = _start_workers(command.workers).map(ready, clips) if apart else map(ready, clips)
    return [row for row in rows if row is not None]


@cache
def _start_workers(count: int) -> ProcessPoolExecutor:
    """Processes of their own: JAX does not survive a fork."""
    return ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn"))


def _attempt(work: Callable, folder: Path, data: Path | None, made: bool, clip: Clip) -> Row | None:
    """The row of a clip; None if it has not been made and is not to be."""
    if made and not find_file(clip.thing, clip.motion, folder, data).is_file():
        return None
    return work(clip, clips=folder, data=data)


if __name__ == "__main__":
    sys.exit(main())
