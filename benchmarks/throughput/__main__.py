"""`python -m benchmarks.throughput [--quick] --json OUT [--markdown MD]`: seconds per substep and per job.

The same particles in ours and in every peer that is available, each in a process of its own, in interleaved rounds
of warm substeps: medians and spreads. Parts, each a section of the JSON (those not asked for are kept):

- materials: law by law at 200k particles, one thread and all.
- sizes: 2k to 1M particles.
- grids: 64 to 128 cells along the domain.
- stages: ours, stage by stage.
- memory: peak resident memory.
- job: a clip of 2 s with the automatic step, against the fixed one of the peers.
- error: how far the clip is from one on a finer grid; Warp's 10,000 substeps take half an hour or more.

A peer that is missing or refuses is a row with its reason. Genesis is looked for in the interpreter that PEER_PYTHON
names.
"""

from __future__ import annotations

import dataclasses
import json
import sys
import time
from pathlib import Path
from typing import Literal

import tyro
from rich.console import Console

from benchmarks.machine import circumstances
from benchmarks.throughput import job, parts
from benchmarks.throughput.markdown import PARTS, document
from physagent_jax.core.files import write_text

Part = Literal["materials", "sizes", "grids", "stages", "memory", "job", "error"]
_MEASURE = {
    "materials": parts.materials,
    "sizes": parts.growth,
    "grids": parts.grids,
    "stages": parts.stages,
    "memory": parts.memory,
    "job": job.job,
    "error": job.error,
}
console = Console(stderr=True)


@dataclasses.dataclass(frozen=True)
class Command:
    """Measure what substeps and jobs cost, ours and peers'."""

    json: Path
    """File to write; sections of other parts that it holds are kept."""
    markdown: Path | None = None
    """Also write the tables here (docs/throughput.md)."""
    parts: tuple[Part, ...] = PARTS  # type: ignore[assignment]
    """Which parts to measure; none = only write the tables."""
    quick: bool = False
    """Few particles, short rounds, fewer rows: two minutes or three, and no figure to quote."""


def main() -> int:
    """Runs the command line."""
    command = tyro.cli(Command)
    result = json.loads(command.json.read_text()) if command.json.is_file() else {}
    sizes = parts.QUICK if command.quick else parts.Sizes()
    for part in command.parts:
        console.rule(part)
        begun, rows = time.perf_counter(), []
        result[part] = section = {**circumstances(), "quick": command.quick, "complete": False, "rows": rows}
        for group in _MEASURE[part](sizes, _tell):
            rows += group
            if part == "job":
                job.ratios(rows)
            section["seconds"] = round(time.perf_counter() - begun, 1)
            write_text(command.json, json.dumps(result, indent=1) + "\n")
        section["complete"] = True
        write_text(command.json, json.dumps(result, indent=1) + "\n")
    if command.markdown is not None:
        write_text(command.markdown, document(result, command.json, command.markdown))
    print(command.json)
    return 0


def _tell(text: str) -> None:
    console.print(text, highlight=False, markup=False, soft_wrap=True)


if __name__ == "__main__":
    sys.exit(main())
