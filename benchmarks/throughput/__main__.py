"""`python -m benchmarks.throughput [--quick] [--json OUT] [--markdown MD]`: seconds per substep and per job.

The same particles in ours and in every peer that is available, each in a process of its own, in interleaved rounds
of warm substeps: medians and spreads. Parts, each a section of the JSON (those not asked for are kept):

- same_law: substeps of one law with equal threads, sorted and unsorted particles for every code.
- same_job: a whole clip likewise, at the customary step and at each code's own bound, with its error.
- materials: law by law at 200k particles, one thread and all.
- sizes: 2k to 1M particles.
- grids: 64 to 128 cells along the domain.
- stages: ours, stage by stage.
- memory: peak resident memory.
- job: a clip of 2 s with the automatic step, against the fixed one of the peers.
- error: how far the clip is from one on a finer grid; Warp's 10,000 substeps take half an hour or more.

A peer that is missing or refuses is a row with its reason. Peers that this interpreter lacks are looked for in the one
that PEER_PYTHON names.
"""

from __future__ import annotations

import dataclasses
import sys
from functools import partial
from pathlib import Path
from typing import Literal

import tyro

from benchmarks import harness
from benchmarks.harness import RAW
from benchmarks.throughput import job, parts, same_job
from benchmarks.throughput.markdown import PAGE, PARTS

Part = Literal["same_law", "same_job", "materials", "sizes", "grids", "stages", "memory", "job", "error"]
_JOBS = {
    "same_law": parts.same_law,
    "materials": parts.materials,
    "sizes": parts.growth,
    "grids": parts.grids,
    "stages": parts.stages,
    "memory": parts.memory,
    "job": job.job,
    "error": job.error,
}


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Measure what substeps and jobs cost, ours and peers'."""

    json: Path = RAW / "throughput.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Part, ...] = PARTS  # type: ignore[assignment]
    """Parts to measure; none = only write the tables."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    sizes = parts.QUICK if command.quick else parts.Sizes()
    jobs = {part: partial(make, sizes) for part, make in _JOBS.items()}
    jobs["same_job"] = lambda: same_job.jobs(sizes, command.json)
    return harness.main(command, jobs, PAGE)


if __name__ == "__main__":
    sys.exit(main())
