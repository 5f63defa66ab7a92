"""`python -m benchmarks.accuracy [--quick] [--json OUT] [--plot PNG] [--markdown MD]`: error against wall time.

Six tables. "verification": every case at the resolution its bar holds for. "work_precision": grid size x step
policy, then transfer, stress form and precision at the middle grid, for the cases with a smooth error, and the
same problems on the peers that are installed, in the same run. Wall times are warm; compilation is apart.
"quadrature": what the number of particles per cell does to bending. "price": what sharpened increments and aggregated
nodes cost. "strength" and "aggregation": how strong they are best.
"""

from __future__ import annotations

import dataclasses
import json
import math
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Literal

import tyro

from benchmarks import harness
from benchmarks.accuracy import price
from benchmarks.accuracy.markdown import PAGE, PARTS
from benchmarks.accuracy.peers import theirs
from benchmarks.accuracy.study import (
    NEAR_BOUND,
    QUADRATURE_CASE,
    QUADRATURE_ERROR,
    REFERENCE_DT,
    Row,
    aggregations,
    ours,
    quadrature,
    rule_words,
    strengths,
    work_precision,
)
from benchmarks.cases.catalogue import CASES, EXPENSIVE, STUDIED, Studied
from benchmarks.harness import RAW, Job
from benchmarks.peers.base import Found, find
from physagent_jax.kernels.threads import thread_count
from physagent_jax.mpm.timestep import CLASSICAL_SHARE

_PEERS = (
    "warp_classical",
    "genesis",
)  # other algorithms than ours; the rest of `peers.base` is about run time
_PEER_STEP = ("bound", round(NEAR_BOUND[1] * CLASSICAL_SHARE, 3))  # as near the classical form's own bound


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Measure error against wall time."""

    json: Path = RAW / "accuracy.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[
        Literal["verification", "work_precision", "quadrature", "price", "strength", "aggregation"], ...
    ] = PARTS
    """Tables to measure; the file's others are kept."""
    plot: Path | None = None
    """Also draw the work-precision plot here (PNG)."""
    repeats: int = 3
    """Timed runs of each work-precision row; the median counts."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    if command.plot is not None and not harness.can_plot():
        return 2
    peers = {name: find(name) for name in _PEERS} if "work_precision" in command.parts else {}
    usable = {name: found for name, found in peers.items() if found.reason is None}
    parts = {
        "verification": lambda: _list_verification(command),
        "work_precision": lambda: _list_studies(command, usable),
        "quadrature": lambda: _list_quadrature(command),
        "price": lambda: _list_prices(command),
        "strength": lambda: _list_strengths(command),
        "aggregation": lambda: _list_aggregations(command),
    }
    about = {"peers": {name: found.reason or found.version for name, found in peers.items()}}
    primary = {studied.case.name: studied.error for studied in STUDIED}

    code = harness.main(command, parts, PAGE, about)
    work = json.loads(command.json.read_text()).get("work_precision") if command.plot else None
    if command.plot and work:
        from benchmarks.accuracy.plot import plot

        plot(work["rows"], primary, command.plot)
    return code


def _list_verification(command: Command) -> Iterator[Job]:
    """A row for every case."""
    for verified in CASES:
        case, numerics = verified.case, verified.coarse if command.quick else verified.fine
        if command.quick and case.name in EXPENSIVE:
            continue
        name = f"{case.name}, {verified.note}" if verified.note else case.name
        yield _make_job(name, None, partial(ours, case, verified.note, numerics, judged=True))


def _list_quadrature(command: Command) -> Iterator[Job]:
    """A row for every density of particles, grid and stress form."""
    for numerics in quadrature((4,) if command.quick else (4, 8)):
        nodes = "aggregated" if numerics.inertia.aggregation else "lumped"
        label = f"{numerics.stress_form}, {nodes}, {rule_words(numerics.step)}, {numerics.per_axis} per axis"
        work = partial(ours, QUADRATURE_CASE, label, numerics)
        yield _make_job(f"{label}, {numerics.resolution} cells", QUADRATURE_ERROR, work)


def _list_aggregations(command: Command) -> Iterator[Job]:
    """A row for every case and share of mass below which nodes follow others."""
    for verified in CASES[::6] if command.quick else CASES:
        for label, numerics in aggregations(verified.coarse):
            name = f"{verified.case.name}, {verified.note}" if verified.note else verified.case.name
            work = partial(ours, verified.case, f"{name}: {label}", numerics, judged=True)
            yield _make_job(f"{name}, aggregation {label}", None, work)


def _list_strengths(command: Command) -> Iterator[Job]:
    """A row for every strength, step and grid of the cases that are studied."""
    for studied in STUDIED:
        for resolution in studied.resolutions[:1] if command.quick else studied.resolutions:
            base = dataclasses.replace(studied.base, resolution=resolution)
            for label, numerics in strengths(studied.case, base):
                work = partial(ours, studied.case, label, numerics)
                yield _make_job(f"{studied.case.name}, {resolution} cells, {label}", studied.error, work)


def _list_prices(command: Command) -> Iterator[Job]:
    """A row for every number of particles and of threads."""
    for particles, substeps in price.CASES[:1] if command.quick else price.CASES:
        for threads in dict.fromkeys((1, thread_count())):
            work = partial(price.measure_price, particles, substeps, threads, 3 if command.quick else 9)
            yield Job(f"{particles} particles, {threads} thread(s)", work)


def _list_studies(command: Command, peers: dict[str, Found]) -> Iterator[Job]:
    for studied in STUDIED:
        yield from _list_study(studied, command, peers)


def _list_study(studied: Studied, command: Command, peers: dict[str, Found]) -> Iterator[Job]:
    """Rows of one case: ours, and each peer at two steps where ours is near the bound."""
    case, repeats = studied.case, 1 if command.quick else command.repeats
    resolutions = studied.resolutions[:2] if command.quick else studied.resolutions
    for label, numerics in work_precision(resolutions, studied.base):
        name = f"{case.name}, {numerics.resolution} cells"
        yield _make_job(
            f"{name}, ours, {label}", studied.error, partial(ours, case, label, numerics, repeats=repeats)
        )
        if label != rule_words(NEAR_BOUND):
            continue
        for peer, found in peers.items():
            for rule in (_PEER_STEP, ("fixed", REFERENCE_DT)):
                theirs_too = dataclasses.replace(numerics, step=rule)
                work = partial(theirs, case, rule_words(rule), theirs_too, peer, found)
                yield _make_job(f"{name}, {peer}, {rule_words(rule)}", studied.error, work)


def _make_job(name: str, primary: str | None, work) -> Job:
    return Job(name, lambda: [_show(work(), primary)])


def _show(row: Row, primary: str | None = None) -> dict:
    """The row for the JSON, told on the way; ``primary`` is the error that it is about, None = all."""
    names = [primary] if primary else list(row.bars) or list(row.errors)
    errors = ", ".join(f"{name} {row.errors[name]:.3g}" for name in names if name in row.errors)
    verdict = row.failed or ("within" if row.within else "OUTSIDE") if row.bars or row.failed else ""
    harness.say(
        f"{row.case:>16} {row.resolution:>4}  {row.code}, {row.label}: {errors}  "
        f"[{row.particles} particles, {row.steps} steps, {row.wall:.3g} s] {verdict}"
    )
    data = dataclasses.asdict(row) | {"within": row.within, "good": row.within or primary is not None}
    numbers = {key: value for key, value in data.items() if isinstance(value, float)}
    return data | {key: None for key, value in numbers.items() if not math.isfinite(value)}


if __name__ == "__main__":
    sys.exit(main())
