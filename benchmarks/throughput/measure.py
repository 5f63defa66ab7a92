"""Child processes, and interleaved rounds of substeps over several of them."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Literal

from benchmarks.peers.base import PEERS, find
from benchmarks.peers.drop import CELLS, DT, drop, floor_as_wall
from benchmarks.peers.scene import Material, PeerScene
from physagent_jax.mpm import cell_order

_ROOT = Path(__file__).resolve().parents[2]
_MULTIPLE = 10  # Genesis advances by ten substeps at a time
_THREAD_VARIABLES = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "TI_CPU_MAX_NUM_THREADS", "QD_NUM_THREADS")


@dataclasses.dataclass(frozen=True)
class Contender:
    """One code with its options.

    Attributes:
        code: "ours" or the name of a peer.
        law: What it simulates.
        threads: Cores it may use.
        kernels: As in `Model`, of ours.
        order: "own" = particles in random order, which ours sorts first, as compiling a scene does; "sorted" = by
            cell, for whichever code; "random" = nobody sorts.
        floor: "own" = the sticky plane, or the domain's frictionless wall where planes are refused; "wall" = the wall.
        double: Whether ours computes in float64.
    """

    code: str
    law: Material
    threads: int
    kernels: Literal["auto", "reference"] = "auto"
    order: Literal["own", "sorted", "random"] = "own"
    floor: Literal["own", "wall"] = "own"
    double: bool = False

    @property
    def label(self) -> str:
        """As tables name it."""
        special = (
            ", reference path"
            if self.kernels == "reference"
            else ", unsorted"
            if self.order == "random"
            else ""
        )
        return self.code + special


@dataclasses.dataclass(frozen=True)
class Effort:
    """Effort of a measurement.

    Attributes:
        rounds: Each code's turns.
        round_seconds: A turn takes at least so long [s], if the code is fast.
        least: Substeps of a turn, at least.
        slowest: A code is skipped if one substep takes longer [s].
    """

    rounds: int = 5
    round_seconds: float = 1.0
    least: int = 20
    slowest: float = 3.0


class ChildError(Exception):
    """A child process cannot do what was asked; the message is the reason."""


class Child:
    """A code in a process of its own. Use `open_child`."""

    def __init__(self, process: subprocess.Popen, complaints: Any):
        self._process, self._complaints = process, complaints

    def ask(self, do: str, **arguments: Any) -> dict[str, Any]:
        """Send a request and wait for the answer.

        Raises:
            ChildError: The request failed, or the process is dead.
        """
        assert self._process.stdin is not None and self._process.stdout is not None
        try:
            self._process.stdin.write(json.dumps({"do": do, **arguments}) + "\n")
            self._process.stdin.flush()
            line = self._process.stdout.readline()
        except BrokenPipeError:
            line = ""
        if not line:
            self._complaints.seek(0)
            told = self._complaints.read().strip().splitlines()
            code = self._process.wait()
            raise ChildError(f"its process ended with code {code}: {' '.join(told[-3:])[-400:]}")
        answer = json.loads(line)
        if "error" in answer:
            raise ChildError(answer["error"])
        return answer


@contextlib.contextmanager
def open_child(contender: Contender) -> Iterator[Child]:
    """A process for ``contender``; ended on leaving.

    Peers that this interpreter lacks run in the one that ``PEER_PYTHON`` names.
    """
    command = [
        _find_python(contender.code) or sys.executable,
        "-m",
        "benchmarks.throughput.worker",
        "--code",
        contender.code,
    ]
    command += ["--threads", str(contender.threads), "--kernels", contender.kernels]
    command += [] if contender.order == "own" else ["--unsorted"]
    command += ["--double"] if contender.double else []
    threads = {name: str(contender.threads) for name in _THREAD_VARIABLES}
    with tempfile.TemporaryFile("w+") as complaints:
        process = subprocess.Popen(
            command,
            cwd=_ROOT,
            env={**os.environ, **threads},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=complaints,
            text=True,
        )
        try:
            yield Child(process, complaints)
        finally:
            assert process.stdin is not None and process.stdout is not None
            with contextlib.suppress(BrokenPipeError):
                process.stdin.close()
            try:
                process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            process.stdout.close()


@functools.cache
def _find_python(code: str) -> str | None:
    return find(code).python if code in PEERS else None


def store(folder: Path, contender: Contender, particles: int, cells: int) -> tuple[str, str]:
    """The file with the contender's scene, written once, and what is special about it."""
    refused = contender.code == "genesis" and contender.floor == "own"
    walls = refused or contender.floor == "wall"
    name = f"{contender.law.value}-{particles}-{cells}-{contender.order}{'-walls' if walls else ''}.npz"
    if not (path := folder / name).is_file():
        scene: PeerScene = drop(particles, contender.law, cells)
        if contender.order == "sorted":
            scene = scene.take(cell_order(scene.x, scene.dx))
        (floor_as_wall(scene) if walls else scene).save(path)
    return str(path), "the floor is the domain's frictionless wall: planes are refused" if refused else ""


def interleaved(
    contenders: list[Contender],
    particles: int,
    effort: Effort,
    cells: int = CELLS,
    tell: Callable[[str], None] = lambda text: None,
) -> list[dict[str, Any]]:
    """A row for each contender: all load one after the other, then take turns, round after round."""
    rows = [_make_blank_row(contender, particles, cells) for contender in contenders]
    with contextlib.ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        children: dict[int, Child] = {}
        for i, contender in enumerate(contenders):
            tell(f"loading {contender.label}, {contender.law.value}, {contender.threads} thread(s)")
            with _note_failure(rows[i]):
                child = stack.enter_context(open_child(contender))
                _load(child, rows[i], *store(folder, contender, particles, cells), effort)
                children[i] = child
        for _ in range(effort.rounds):
            for i, child in list(children.items()):
                if not rows[i]["message"]:
                    with _note_failure(rows[i]):
                        _run_turn(child, rows[i])
        for i, child in children.items():
            with _note_failure(rows[i]):
                rows[i]["peak_mb"] = round(child.ask("memory")["peak_mb"])
    for row in rows:
        _summarise(row)
    return rows


def _make_blank_row(contender: Contender, particles: int, cells: int) -> dict[str, Any]:
    figures = ("setup_seconds", "steps", "median_ms", "min_ms", "max_ms", "busy", "load_average", "peak_mb")
    return {
        "code": contender.label,
        "law": contender.law.value,
        "threads": contender.threads,
        "order": contender.order,
        "particles": particles,
        "cells": cells,
        "version": "",
        **dict.fromkeys(figures),
        "rounds_ms": [],
        "note": "",
        "message": "",
    }


@contextlib.contextmanager
def _note_failure(row: dict[str, Any]) -> Iterator[None]:
    """A code that fails keeps its row, with the reason."""
    try:
        yield
    except ChildError as error:
        row["message"] = row["message"] or " ".join(str(error).split())


def _load(child: Child, row: dict[str, Any], scene: str, note: str, effort: Effort) -> None:
    """Loads, and finds out how many substeps a turn has."""
    loaded = child.ask("load", scene=scene, dt=DT)
    row |= {
        "version": loaded["version"],
        "setup_seconds": round(loaded["seconds"], 2),
        "note": note,
        "used": 0.0,
    }
    child.ask("run", steps=_MULTIPLE)  # the first steps may still allocate
    trial = child.ask("run", steps=_MULTIPLE)
    substep = (trial["seconds"] - trial["compile_seconds"]) / _MULTIPLE
    if substep > effort.slowest:
        raise ChildError(f"skipped: one substep takes {substep:.1f} s")
    steps = max(effort.least, effort.round_seconds / substep)
    row["steps"] = _MULTIPLE * math.ceil(steps / _MULTIPLE)


def _run_turn(child: Child, row: dict[str, Any]) -> None:
    took = child.ask("run", steps=row["steps"])
    row["rounds_ms"].append(1e3 * (took["seconds"] - took["compile_seconds"]) / row["steps"])
    row["setup_seconds"] = round(row["setup_seconds"] + took["compile_seconds"], 2)
    row["used"] += took["processor_seconds"] / took["seconds"]
    row["load_average"] = round(os.getloadavg()[0], 2)


def _summarise(row: dict[str, Any]) -> None:
    rounds, used = row["rounds_ms"], row.pop("used", 0.0)
    row["rounds_ms"] = [round(value, 4) for value in rounds]
    if rounds:
        row |= {
            "median_ms": round(statistics.median(rounds), 4),
            "min_ms": round(min(rounds), 4),
            "max_ms": round(max(rounds), 4),
            "busy": round(used / len(rounds), 2),
        }


def compare(rows: list[dict[str, Any]]) -> None:
    """Add to each row its time over ours with as many threads: with the same law, and with our default jelly."""
    for row in rows:
        for name, law in (("over_ours", row["law"]), ("over_default", Material.NEO_HOOKEAN.value)):
            base = [
                ours["median_ms"]
                for ours in rows
                if ours["code"] == _name_counterpart(row)
                and ours["law"] == law
                and ours["threads"] == row["threads"]
            ]
            known = base and base[0] and row["median_ms"]
            row[name] = round(row["median_ms"] / base[0], 3) if known else None


def _name_counterpart(row: dict[str, Any]) -> str:
    """Row that a row is compared with: ours as the product runs, or unsorted where all particles are."""
    everybody = row["order"] == "random" and not row["code"].startswith("ours")
    return "ours, unsorted" if everybody else "ours"
