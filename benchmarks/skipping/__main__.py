"""`python -m benchmarks.skipping [--quick] --json OUT [--markdown MD] [--only NAME ...]`: what is not computed.

Every skip of the simulator runs twice, in interleaved warm rounds: once as the product runs, once with the work
forced in. A row says what that saves, and how far the two answers are apart; the command fails if they disagree.
Rows of the JSON that are not asked for are kept.
"""

from __future__ import annotations

import dataclasses
import json
import sys
import time
from pathlib import Path

import jax
import tyro
from rich.console import Console

from benchmarks.machine import circumstances
from benchmarks.skipping.base import QUICK, Sizes
from benchmarks.skipping.catalogue import SKIPS
from benchmarks.skipping.markdown import document
from benchmarks.skipping.measure import row
from physagent_jax.core.files import write_text

console = Console(stderr=True)


@dataclasses.dataclass(frozen=True)
class Command:
    """Measure what each skip saves, and check that it changes nothing."""

    json: Path
    """File to write."""
    markdown: Path | None = None
    """Also write the tables here (docs/skipping.md)."""
    only: tuple[str, ...] = ()
    """Names of the skips to run; none = all."""
    quick: bool = False
    """Few particles, short rounds: two minutes or three, and no figure to quote."""


def main() -> int:
    """Runs the command line."""
    command = tyro.cli(Command)
    unknown = sorted(set(command.only) - SKIPS.keys())
    if unknown:
        console.print(f"no skip named {', '.join(unknown)}; there are: {', '.join(SKIPS)}", highlight=False)
        return 2
    result = json.loads(command.json.read_text()) if command.json.is_file() else {"runs": [], "rows": []}
    rows = {entry["name"]: entry for entry in result["rows"]}
    begun = time.perf_counter()
    run = {**circumstances(), "quick": command.quick}
    result["runs"].append(run)
    bad = 0
    for name in command.only or SKIPS:
        jax.clear_caches()  # so that every row pays for its own compilation
        rows[name] = row(SKIPS[name], QUICK if command.quick else Sizes()) | {"run": len(result["runs"]) - 1}
        bad += not rows[name]["good"]
        _tell(rows[name])
        run["seconds"] = round(time.perf_counter() - begun, 1)
        result["rows"] = [rows[known] for known in SKIPS if known in rows]
        write_text(command.json, json.dumps(result, indent=1) + "\n")
    if command.markdown is not None:
        write_text(command.markdown, document(result, command.json, command.markdown))
    console.print(f"{bad} row(s) fail" if bad else "no row fails")
    print(command.json)
    return 1 if bad else 0


def _tell(entry: dict) -> None:
    text = entry["message"]
    if "saving" in entry:
        text = (
            f"{entry['lean_ms']:.3g} ms with, {entry['full_ms']:.3g} without: {entry['saving']:.2f} x "
            f"({entry['verdict']}) {text}"
        )
    mark = "ok" if entry["good"] else "FAIL"
    console.print(f"{mark:>5}  {entry['name']}: {text}", highlight=False, markup=False, soft_wrap=True)


if __name__ == "__main__":
    sys.exit(main())
