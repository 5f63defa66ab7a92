"""`python -m benchmarks.gpu [--json OUT] [--markdown OUT] [--quick]`: milliseconds per substep on a GPU.

The dropped cube of `benchmarks.throughput`, neo-Hookean, its floor the domain's frictionless wall: the same law, grid
and particles for every code, sorted by cell and in random order. Ours by its CUDA kernels and by pure JAX, and Warp,
all in one process on one device; every code has four turns of up to a hundred substeps, one after the other. What the
host does between frames is within the times: fitting the grid window, and looking at the health.
"""

from __future__ import annotations

import dataclasses
import statistics
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any, Literal

import jax
import tyro

from benchmarks import harness
from benchmarks.harness import RAW, Job, Page, Row, number, provenance, table
from benchmarks.peers.base import make_peer
from benchmarks.peers.drop import DT, drop, floor_as_wall
from benchmarks.peers.ours import Ours
from benchmarks.peers.scene import Material
from physagent_jax.core.errors import UserError
from physagent_jax.mpm import cell_order

SIZES = (20_000, 200_000, 1_000_000)
TURNS, SUBSTEPS = 4, 100
ORDERS = ("sorted", "random")


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Measure what a substep costs on a GPU."""

    json: Path = RAW / "gpu.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Literal["substeps"], ...] = ("substeps",)
    """There is one."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    return harness.main(command, {"substeps": lambda: _list_jobs(command)}, PAGE)


def _list_jobs(command: Command) -> list[Job]:
    sizes = (2_000,) if command.quick else SIZES
    return [Job(f"{count} particles", partial(measure_substeps, count)) for count in sizes]


def measure_substeps(particles: int) -> list[Row]:
    """A row for each code and order.

    Raises:
        UserError: There is no GPU.
    """
    if jax.default_backend() != "gpu":
        raise UserError(
            "there is no GPU", got=f"JAX computes on {jax.default_backend()}", do="Install the extra `cuda`"
        )
    random = floor_as_wall(drop(particles, Material.NEO_HOOKEAN))
    scenes = dict(zip(ORDERS, (random.take(cell_order(random.x, random.dx)), random)))
    rows: list[Row] = []
    peers: list[Any] = []
    for code in ("ours", "ours, pure JAX", "warp_classical"):
        for order, scene in scenes.items():
            kernels = "reference" if code == "ours, pure JAX" else "auto"
            peer = Ours(kernels, sort=False) if code.startswith("ours") else make_peer(code)
            row: Row = {"code": code, "order": order, "particles": particles, "turns_ms": [], "message": ""}
            rows.append(row)
            try:
                peer.load(scene, DT)
                peer.run(10)
                row["version"] = peer.version()
                peers.append(peer)
            except Exception as error:  # whatever a peer makes of this machine
                row["message"] = f"{type(error).__name__}: {error}"
                peers.append(None)
    for _ in range(TURNS):
        for row, peer in zip(rows, peers):
            if peer is not None:
                row["turns_ms"].append(_time_turn(peer))
    for row, peer in zip(rows, peers):
        row["height"] = None if peer is None else float(peer.x()[:, 2].mean(dtype=float))
        harness.say(str(row))
    return rows


def _time_turn(peer: Any) -> float:
    """Milliseconds per substep; compiling for a larger window apart."""
    compiled, begun = getattr(peer, "compile_seconds", 0.0), time.perf_counter()
    peer.run(SUBSTEPS)
    seconds = time.perf_counter() - begun - (getattr(peer, "compile_seconds", 0.0) - compiled)
    return 1e3 * seconds / SUBSTEPS


def write_tables(result: harness.Result) -> harness.Tables:
    """The tables of docs/gpu.md."""
    rows = result["substeps"]["rows"] if "substeps" in result else []
    ours = {(row["particles"], row["order"]): row for row in rows if row["code"] == "ours"}
    lines = []
    for row in rows:
        if not row["turns_ms"]:
            lines.append([f"{row['particles']:,}", row["code"], row["order"], row["message"], "", ""])
            continue
        best = min(_find_median(ours[row["particles"], order]) for order in ORDERS)
        same = _find_median(ours[row["particles"], row["order"]])
        median = _find_median(row)
        spread = f"{number(median)} ({number(min(row['turns_ms']))} to {number(max(row['turns_ms']))})"
        figures = [spread, number(median / same), number(median / best)]
        lines.append([f"{row['particles']:,}", row["code"], row["order"], *figures])
    titles = ("particles", "code", "order", "substep [ms]", "over ours, same order", "over our best")
    return {"substeps": table(titles, lines), "runs": provenance(result, ("substeps",))}


def _find_median(row: Row) -> float:
    return statistics.median(row["turns_ms"])


PAGE = Page("gpu", "python -m benchmarks.gpu", write_tables, ("physagent_jax/mpm", "physagent_jax/kernels"))

if __name__ == "__main__":
    sys.exit(main())
