"""`python -m benchmarks.accuracy [--quick] --json OUT [--plot PNG] [--markdown MD]`: error against wall time.

Three tables. "verification": every case at the resolution its bar holds for. "work_precision": grid size x step
policy, then transfer, stress form and precision at the middle grid, for the cases with a smooth error, and the
same problems on the peers that are installed, in the same run. Wall times are warm; compilation is apart.
"quadrature": what the number of particles per cell does to bending.
"""

from __future__ import annotations

import dataclasses
import json
import math
import sys
from pathlib import Path
from typing import Literal

import tyro
from rich.console import Console

from benchmarks.accuracy.markdown import document
from benchmarks.accuracy.peers import theirs
from benchmarks.accuracy.study import (
    NEAR_BOUND,
    QUADRATURE_CASE,
    QUADRATURE_ERROR,
    REFERENCE_DT,
    Row,
    ours,
    quadrature,
    rule_words,
    work_precision,
)
from benchmarks.cases.catalogue import CASES, EXPENSIVE, STUDIED, Studied
from benchmarks.machine import circumstances
from benchmarks.peers.base import Found, find
from physagent_jax.core.files import write_text
from physagent_jax.mpm.timestep import CLASSICAL_SHARE

console = Console(stderr=True)
_PEERS = (
    "warp_classical",
    "genesis",
)  # other algorithms than ours; the rest of `peers.base` is about run time
_PEER_STEP = ("bound", round(NEAR_BOUND[1] * CLASSICAL_SHARE, 3))  # as near the classical form's own bound


@dataclasses.dataclass(frozen=True)
class Command:
    """Measure error against wall time."""

    json: Path
    """File to write."""
    plot: Path | None = None
    """Also draw the work-precision plot here (PNG)."""
    markdown: Path | None = None
    """Also write the tables here (docs/accuracy.md)."""
    parts: tuple[Literal["verification", "work_precision", "quadrature"], ...] = (
        "verification",
        "work_precision",
        "quadrature",
    )
    """Which tables to measure; the file's others are kept."""
    quick: bool = False
    """Coarse grids and cheap cases only: a few minutes."""
    only: str = ""
    """Only cases whose name contains this."""
    repeats: int = 3
    """Timed runs of each work-precision row; the median counts."""


def main() -> int:
    """Runs the command line."""
    command = tyro.cli(Command)
    result = json.loads(command.json.read_text()) if command.json.is_file() else {}
    for part in command.parts:
        rows: list[dict] = []
        result[part] = section = {**circumstances(), "rows": rows}
        if part == "verification":
            found = ((row, None) for row in _verification(command))
        elif part == "quadrature":
            found = ((row, QUADRATURE_ERROR) for row in _quadrature(command))
        else:
            section["peers"], usable = _peers()
            found = _studies(command, usable)
        for row, primary in found:
            rows.append(_shown(row, primary))
            write_text(command.json, json.dumps(result, indent=1) + "\n")
    _present(command, result)
    rows = result.get("verification", {}).get("rows", [])
    failing = [row["case"] for row in rows if not row["within"]]
    console.print(f"{len(rows)} cases verified, outside their bar: {', '.join(failing) or 'none'}")
    print(command.json)
    return 0


def _verification(command: Command):
    """A row for every case."""
    for verified in CASES:
        name = verified.case.name
        if command.only in name and not (command.quick and name in EXPENSIVE):
            numerics = verified.coarse if command.quick else verified.fine
            yield ours(verified.case, verified.note, numerics, judged=True)


def _quadrature(command: Command):
    """A row for every density of particles, grid and stress form."""
    for numerics in quadrature((4,) if command.quick else (4, 8)):
        label = f"{numerics.stress_form}, {numerics.per_axis} per axis"
        yield ours(QUADRATURE_CASE, label, numerics)


def _peers() -> tuple[dict[str, str], dict[str, Found]]:
    """Version of each peer, or why it cannot run; and where those are that can."""
    found = {name: find(name) for name in _PEERS}
    for name, where in found.items():
        if where.reason:
            console.print(f"peer {name} is left out: {where.reason}")
    words = {name: where.reason or where.version for name, where in found.items()}
    return words, {name: where for name, where in found.items() if where.reason is None}


def _studies(command: Command, peers: dict[str, Found]):
    """(row, the error that it is about) of every studied case."""
    for studied in STUDIED:
        if command.only in studied.case.name:
            for row in _study(studied, command, peers):
                yield row, studied.error


def _study(studied: Studied, command: Command, peers: dict[str, Found]):
    """Rows of one case: ours, and each peer at two steps where ours is near the bound."""
    case, repeats = studied.case, 1 if command.quick else command.repeats
    resolutions = studied.resolutions[:2] if command.quick else studied.resolutions
    for label, numerics in work_precision(resolutions, studied.base):
        yield ours(case, label, numerics, repeats=repeats)
        if label == rule_words(NEAR_BOUND):
            for name, found in peers.items():
                for rule in (_PEER_STEP, ("fixed", REFERENCE_DT)):
                    yield theirs(
                        case, rule_words(rule), dataclasses.replace(numerics, step=rule), name, found
                    )


def _shown(row: Row, primary: str | None = None) -> dict:
    """The row for the JSON, told on the way."""
    names = [primary] if primary else list(row.bars) or list(row.errors)
    errors = ", ".join(f"{name} {row.errors[name]:.3g}" for name in names if name in row.errors)
    verdict = row.failed or ("within" if row.within else "OUTSIDE") if row.bars or row.failed else ""
    console.print(
        f"{row.case:>16} {row.resolution:>4}  {row.code}, {row.label}: {errors}  "
        f"[{row.particles} particles, {row.steps} steps, {row.wall:.3g} s] {verdict}",
        highlight=False,
        markup=False,
        soft_wrap=True,
    )
    data = dataclasses.asdict(row) | {"within": row.within}
    numbers = {key: value for key, value in data.items() if isinstance(value, float)}
    return data | {key: None for key, value in numbers.items() if not math.isfinite(value)}


def _present(command: Command, result: dict) -> None:
    """The plot and the document, as far as they are asked for."""
    primary = {studied.case.name: studied.error for studied in STUDIED}
    if command.plot is not None and "work_precision" in result:
        from benchmarks.accuracy.plot import plot

        plot(result["work_precision"]["rows"], primary, command.plot)
    if command.markdown is not None:
        write_text(command.markdown, document(result, command.json, command.plot, primary, command.markdown))


if __name__ == "__main__":
    sys.exit(main())
