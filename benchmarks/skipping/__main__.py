"""`python -m benchmarks.skipping [--quick] [--json OUT] [--markdown MD] [--only NAME ...]`: what is not computed.

Every skip of the simulator runs twice, in interleaved warm rounds: once as the product runs, once with the work
forced in. A row says what that saves, and how far the two answers are apart; the command fails if they disagree.
"""

from __future__ import annotations

import dataclasses
import sys
from functools import partial
from pathlib import Path

import jax
import tyro

from benchmarks import harness
from benchmarks.harness import RAW, Job
from benchmarks.skipping.base import QUICK, Sizes, Skip
from benchmarks.skipping.catalogue import GROUPS
from benchmarks.skipping.markdown import PAGE
from benchmarks.skipping.measure import row


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Measure what each skip saves, and check that it changes nothing."""

    json: Path = RAW / "skipping.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[str, ...] = tuple(GROUPS)
    """Groups of skips, by their title."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    sizes = QUICK if command.quick else Sizes()
    parts = {title: partial(_list_jobs, skips, sizes) for title, skips in GROUPS.items()}
    return harness.main(command, parts, PAGE)


def _list_jobs(skips: tuple[Skip, ...], sizes: Sizes) -> list[Job]:
    return [Job(skip.name, partial(_measure_row, skip, sizes)) for skip in skips]


def _measure_row(skip: Skip, sizes: Sizes) -> list[dict]:
    jax.clear_caches()  # so that every row pays for its own compilation
    entry = row(skip, sizes)
    text = entry["message"]
    if "saving" in entry:
        text = (
            f"{entry['lean_ms']:.3g} ms with, {entry['full_ms']:.3g} without: {entry['saving']:.2f} x "
            f"({entry['verdict']}) {text}"
        )
    harness.say(f"{'ok' if entry['good'] else 'FAIL':>5}  {entry['name']}: {text}")
    return [entry]


if __name__ == "__main__":
    sys.exit(main())
