"""`python -m benchmarks.stability [--quick] --json OUT [--markdown MD]`: attempts to break the simulator.

Parts, each a section of the JSON (those not asked for are kept, so that parts can be run one by one):

- critical: the measured critical step of every material over the closed-form bound.
- matrix: every material x force x magnitude with the automatic step.
- pairwise: every pair of values of the remaining axes (stiffness, step rule, particles per cell, walls, ...).
- stiffness: E from 1e3 to 1e9 Pa with the automatic step.
- degenerate: inputs that should not be, and runs that must agree.

Every run passes, is refused in words, or fails; a wrong result without a word is a failure.
"""

from __future__ import annotations

import dataclasses
import json
import math
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Literal

import jax
import tyro
from rich.console import Console

from benchmarks.machine import circumstances
from benchmarks.stability import matrix
from benchmarks.stability.criteria import Result, examine
from benchmarks.stability.dt_crit import CONFIGURATIONS, FORMS, SUBJECTS, measure
from benchmarks.stability.markdown import PARTS, document
from benchmarks.stability.scenario import Scenario
from physagent_jax.core.files import write_text
from physagent_jax.kernels import programs

Part = Literal["critical", "matrix", "pairwise", "stiffness", "degenerate"]
_QUICK = {"critical": 2, "matrix": 12, "pairwise": 6, "stiffness": 3, "degenerate": 8}  # rows of a quick look
console = Console(stderr=True)


@dataclasses.dataclass(frozen=True)
class Command:
    """Try to break the simulator, and write down what happened."""

    json: Path
    """File to write; sections of other parts that it holds are kept."""
    markdown: Path | None = None
    """Also write the tables here (docs/stability.md)."""
    parts: tuple[Part, ...] = PARTS  # type: ignore[assignment]
    """Which parts to run."""
    quick: bool = False
    """A spread of rows of each part only: about a minute."""
    resume: bool = False
    """Go on where a run of the same parts was stopped; parts that are complete are left alone."""


def main() -> int:
    """Runs the command line."""
    command = tyro.cli(Command)
    result = json.loads(command.json.read_text()) if command.json.is_file() else {}
    bad = 0
    for part in command.parts:
        section = _section(result.get(part), command)
        result[part], rows, before = section, section["rows"], section.get("seconds", 0.0)
        begun = time.perf_counter()
        for row in _rows(part, command.quick, len(rows)):
            rows.append(row)
            _tell(part, row)
            section["seconds"] = round(before + time.perf_counter() - begun, 1)
            section["counts"] = dict(Counter(row["verdict"] for row in rows))
            write_text(command.json, json.dumps(result, indent=1) + "\n")
        section["complete"] = True
        bad += sum(not row["good"] for row in rows)
    write_text(command.json, json.dumps(result, indent=1) + "\n")
    if command.markdown is not None:
        write_text(command.markdown, document(result, command.json, command.markdown))
    console.print(f"{bad} row(s) fail" if bad else "no row fails")
    print(command.json)
    return 0


def _section(held: dict | None, command: Command) -> dict:
    """A new section, or the one that is to be gone on with; the circumstances of the later run are kept beside."""
    new = {**circumstances(), "quick": command.quick, "complete": False, "rows": []}
    if not command.resume or held is None or held["quick"] != command.quick:
        return new
    if not held["complete"]:
        held["taken_up"] = [*held.get("taken_up", []), circumstances()]
    return held


def _rows(part: Part, quick: bool, skipped: int) -> Iterator[dict]:
    """The rows of a part, without the first ones."""
    if part == "critical":
        for subject, form, configuration in _some(_critical(), part, quick)[skipped:]:
            with jax.enable_x64(True):
                found = measure(subject, configuration, form)
            verdict = "pass" if found.good else "FAIL"
            yield dataclasses.asdict(found) | {"verdict": verdict, "good": found.good}
        return
    for row in _some(_runs(part), part, quick)[skipped:]:
        yield _plain(row())
        programs.bound()


def _critical() -> list[tuple[str, str, str]]:
    return [(subject, form, place) for subject in SUBJECTS for form in FORMS for place in CONFIGURATIONS]


def _runs(part: Part) -> list[Callable[[], Result]]:
    if part == "degenerate":
        return matrix.degenerate()
    scenarios = {"matrix": matrix.matrix, "pairwise": matrix.pairwise, "stiffness": matrix.stiffness}[part]()
    return [lambda scenario=scenario: _examined(scenario) for scenario in scenarios]


def _examined(scenario: Scenario) -> Result:
    with jax.enable_x64(scenario.dtype == "float64"):
        return examine(scenario)


def _some(rows: list, part: Part, quick: bool) -> list:
    """All rows, or an even spread of them."""
    if not quick or len(rows) <= _QUICK[part]:
        return rows
    stride = len(rows) / _QUICK[part]
    return [rows[int(i * stride)] for i in range(_QUICK[part])]


def _plain(result: Result) -> dict:
    row = dataclasses.asdict(result)
    row["good"] = result.verdict != "FAIL"
    row["figures"] = {
        name: None if isinstance(value, float) and not math.isfinite(value) else value
        for name, value in result.figures.items()
    }
    return row


def _tell(part: Part, row: dict) -> None:
    if part == "critical":
        limit = "at least " if row["unlimited"] else ""
        text = (
            f"{row['subject']}, {row['configuration']}, {row['form']}: {limit}{row['ratio']:.3f} of the bound"
        )
    else:
        text = f"{row['name']}{': ' if row['message'] else ''}{row['message']}"
    console.print(f"{row['verdict']:>8}  {text}", highlight=False, markup=False, soft_wrap=True)


if __name__ == "__main__":
    sys.exit(main())
