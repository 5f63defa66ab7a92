"""`python -m benchmarks.headtohead.reproduce --release NAME`: a published table, made whole on one revision.

A release is a suite that is drawn from a seed, the methods of its table, and a budget. The hash of the seed is
published while the methods may still change; the seed is told afterwards, and draws the same tasks for anybody. A cell
is stale if its task or the code is not as it was: stale cells are measured again, the others are kept.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path

import tyro

import physagent_jax as pa
from baselines.suite.__main__ import Command as Suite
from baselines.suite.__main__ import draw_suite
from baselines.tasks import TaskSpec
from benchmarks import harness
from benchmarks.harness import Job, Row
from benchmarks.harness.command import format_result
from benchmarks.harness.sources import hash_sources
from benchmarks.headtohead import leaderboard
from benchmarks.headtohead.__main__ import MARKS, TASKS, choose_entrants
from benchmarks.headtohead.jobs import list_fits
from benchmarks.headtohead.markdown import PAGE, PARTS, SUITE
from physagent_jax.core.errors import UserError
from physagent_jax.core.files import write_text
from physagent_jax.core.names import explain_unknown_name


@dataclasses.dataclass(frozen=True)
class Release:
    """A table that is made whole.

    Attributes:
        commitment: Hash of the seed, which was published before.
        seed: Seed of the suite; None while it is secret.
        count: Number of tasks, all of the test split; a multiple of seven has as many of each family.
        methods: Labels of the rows.
        budget: Forward-equivalents of each fit.
        seeds: Seeds of what is random.
    """

    commitment: str
    count: int
    methods: tuple[str, ...]
    budget: float
    seeds: int = 1
    seed: int | None = None


RELEASES: Mapping[str, Release] = {
    "2026-11": Release(
        commitment="7f84746e0eb53b41a7224785ebbe7ed53834afe74552f58963561b55100ae421",
        count=35,
        methods=(
            "direction_only",
            "random",
            "rules",
            "cma",
            "levenberg_marquardt, all types",
            "levenberg_marquardt, responses",
        ),
        budget=30.0,
        seed=7836075371827439267,
    ),
}


@dataclasses.dataclass(frozen=True)
class Command:
    """Make a published table again: draw its suite, and measure what is missing or stale."""

    release: str
    """Name of the release."""
    seed: int | None = None
    """The seed, where the release does not tell it yet."""
    out: Path | None = None
    """Folder of the suite. Default: benchmarks/tasks/suites/NAME."""
    json: Path = PAGE.raw
    """File of the raw rows; those of other parts are kept."""
    leaderboard: Path | None = None
    """File of JSON lines, one per fit, to which the fits are added."""
    workers: int = 1
    """Fits side by side, each on its share of the cores: for what is counted, not for seconds to quote."""
    check: bool = False
    """Only list the cells that are missing or stale; the exit code is 1 if there are any."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    command = tyro.cli(Command, prog="python -m benchmarks.headtohead.reproduce", args=arguments)
    pa.enable_compile_cache()
    try:
        return reproduce(command)
    except UserError as error:
        print(f"reproduce: {error}", file=sys.stderr)
        return 2


def reproduce(command: Command) -> int:
    """Draw the suite, drop the stale rows of its part, and measure what the file lacks; return the exit code.

    Raises:
        UserError: There is no such release, or the seed is not the one that was committed.
    """
    if command.release not in RELEASES:
        raise explain_unknown_name("release", command.release, RELEASES)
    release, code = RELEASES[command.release], hash_code()
    specs = draw(command, release)
    jobs = list_cells(release, specs, code)
    content = json.loads(command.json.read_text()) if command.json.is_file() else {}
    rows = content.get(SUITE, {}).get("rows", [])
    fresh = [row for row in rows if is_fresh(row, specs, code)]
    stale = [row["job"] for row in rows if row not in fresh]
    missing = sorted({job.name for job in jobs} - {row["job"] for row in rows})
    harness.say(f"{len(jobs)} cells, of which {len(missing)} are missing and {len(stale)} stale")
    if command.check:
        print("\n".join([*(f"missing {name}" for name in missing), *(f"stale {name}" for name in stale)]))
        return 1 if missing or stale else 0
    if stale:
        content[SUITE]["rows"] = fresh
        write_text(command.json, format_result(content) + "\n")
    options = harness.Command(json=command.json, parts=(SUITE,), resume=True)
    parts: dict[str, Callable[[], list[Job]]] = {part: list for part in PARTS}  # their rows are kept
    parts[SUITE] = lambda: jobs
    about = {"release": command.release, "budget": release.budget}
    failed = harness.main(options, parts, PAGE, about, command.workers, pa.enable_compile_cache)
    if command.leaderboard is not None and command.json.is_file():
        leaderboard.merge(command.leaderboard, json.loads(command.json.read_text()))
    return failed


def draw(command: Command, release: Release) -> tuple[TaskSpec, ...]:
    """The tasks of a release, which are drawn where the folder does not hold them yet.

    Raises:
        UserError: The seed is not told, or is another.
    """
    seed = release.seed if release.seed is not None else command.seed
    if seed is None:
        raise UserError(f"the seed of {command.release} is not told yet", do="Give it with --seed")
    out = command.out or TASKS / "suites" / command.release
    return draw_suite(Suite(out, seed, release.count, "test", release.commitment))


def list_cells(release: Release, specs: Sequence[TaskSpec], code: str) -> list[Job]:
    """A job for each method, task and seed; its rows have the hash of the code."""
    marks = (*(mark for mark in MARKS if mark < release.budget), release.budget)
    entrants = choose_entrants(release.methods, None)
    fits = list_fits(specs, entrants, marks, release.budget, release.seeds, None)
    return [dataclasses.replace(job, measure=partial(measure_cell, job.measure, code)) for job in fits]


def measure_cell(measure: Callable[[], Iterable[Row]], code: str) -> list[Row]:
    """The rows of a job, with the hash of the code."""
    return [row | {"code_hash": code} for row in measure()]


def is_fresh(row: Row, specs: Sequence[TaskSpec], code: str) -> bool:
    """Return whether a row is of these tasks and of this code."""
    return row.get("code_hash") == code and (row["task"], row["task_hash"]) in {
        (spec.name, spec.task_hash) for spec in specs
    }


def hash_code() -> str:
    """A hash over the sources that figures of the page depend on; tasks have hashes of their own."""
    sources = [source for source in PAGE.sources if source != "benchmarks/tasks"]
    return hashlib.sha256(json.dumps(hash_sources(sources)).encode()).hexdigest()[:16]


if __name__ == "__main__":
    sys.exit(main())
