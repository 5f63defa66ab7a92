"""`python -m benchmarks.perception [--json OUT] [--markdown OUT] [--quick]`: how right is what perception says?"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Literal

import tyro

from benchmarks import harness
from benchmarks.harness import RAW, Job, Row, number
from benchmarks.perception.markdown import PAGE
from benchmarks.perception.measure import measure
from benchmarks.perception.motions import MOTIONS
from benchmarks.perception.scenes import BACKGROUNDS, DISTANCES, NOISES, OBJECTS, compose, film

QUICK = (
    "nothing",
    "right 0.5",
    "in the plane 45",
    "about the vertical 45",
    "squeezed down 0.65",
    "sways across",
)


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Show perception motions that are known."""

    json: Path = RAW / "perception.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Literal["clips"], ...] = ("clips",)
    """There is one."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    return harness.main(command, {"clips": lambda: make_jobs(command.quick)}, PAGE)


def make_jobs(quick: bool) -> list[Job]:
    """One per motion and object; quick: six motions, one object each."""
    pairs = [(m, o) for m in MOTIONS for o in OBJECTS]
    if quick:
        pairs = [(m, OBJECTS[i % len(OBJECTS)]) for i, m in enumerate(QUICK)]
    mixed = sorted(
        range(len(pairs)), key=lambda k: 29 * k % len(pairs)
    )  # what is stopped early is a fair sample
    return [Job(f"{o}: {m}", partial(show, m, o)) for m, o in (pairs[k] for k in mixed)]


def show(motion: str, name: str) -> Iterable[Row]:
    """The rows of one motion and object: each background once; distances and noise take turns."""
    i, j = list(MOTIONS).index(motion), OBJECTS.index(name)
    rows = []
    for b, background in enumerate(BACKGROUNDS):
        distance = list(DISTANCES)[(i + i // 3 + 2 * j + b) % len(DISTANCES)]
        noise = NOISES[(i + j + b) % len(NOISES)]
        sight = film(name, MOTIONS[motion], DISTANCES[distance])
        row = {
            "motion": motion,
            "object": name,
            "distance": distance,
            "background": background,
            "noise": noise,
        }
        rgb, depth = compose(sight, background, noise, seed=100 * i + 10 * j + b)
        rows.append(row | measure(sight, MOTIONS[motion], rgb, depth))
    harness.say(f"{name}: {motion}: " + "; ".join(map(_summarise, rows)))
    return rows


def _summarise(row: Row) -> str:
    errors = [f"{key} {number(row[key]) or 'n. o.'}" for key in ("displacement", "rotation", "stretch")]
    return f"{row['background']}, {row['noise']}, {row['distance']}: {', '.join(errors)}"


if __name__ == "__main__":
    sys.exit(main())
