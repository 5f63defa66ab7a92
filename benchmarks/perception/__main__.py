"""`python -m benchmarks.perception [--perception NAMES] [--json OUT] [--quick]`: how right is what perception says?"""

from __future__ import annotations

import dataclasses
import json
import re
import sys
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks import harness
from benchmarks.harness import RAW, Job, Row, number
from benchmarks.perception.markdown import PAGE
from benchmarks.perception.measure import measure
from benchmarks.perception.motions import MOTIONS
from benchmarks.perception.scenes import BACKGROUNDS, DISTANCES, NOISES, OBJECTS, compose, film
from physagent_jax.perception.backends import make_backends, parse_choice
from physagent_jax.perception.protocols import PerceptionBackends
from physagent_jax.run import models

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
    parts: Annotated[tuple[str, ...], tyro.conf.arg(name="perception")] = ("rgbd", "rgb")
    """Choices of backends, as `physagent run --perception` takes them; each is a part of the rows, without paths."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    known = json.loads(command.json.read_text()) if command.json.is_file() else {}
    choices = dict.fromkeys(known) | {re.sub(":[^,]*", "", each): each for each in command.parts}
    parts = tuple(name for name, choice in choices.items() if choice)
    return harness.main(
        dataclasses.replace(command, parts=parts),
        {name: partial(make_jobs, choice or name, command.quick) for name, choice in choices.items()},
        PAGE,
    )


def make_jobs(perception: str, quick: bool) -> list[Job]:
    """One per motion and object; quick: six motions, one object each."""
    chosen = {role: models.parse_choice(role, text) for role, text in parse_choice(perception).items()}
    backends = make_backends(
        **{role: (each["name"], each.get("options", {})) for role, each in chosen.items()}
    )
    pairs = [(m, o) for m in MOTIONS for o in OBJECTS]
    if quick:
        pairs = [(m, OBJECTS[i % len(OBJECTS)]) for i, m in enumerate(QUICK)]
    mixed = sorted(
        range(len(pairs)), key=lambda k: 29 * k % len(pairs)
    )  # what is stopped early is a fair sample
    return [Job(f"{o}: {m}", partial(show, backends, m, o)) for m, o in (pairs[k] for k in mixed)]


def show(backends: PerceptionBackends, motion: str, name: str) -> Iterable[Row]:
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
        rows.append(row | measure(sight, MOTIONS[motion], rgb, depth, backends, background == "room"))
    harness.say(f"{name}: {motion}: " + "; ".join(map(_summarise, rows)))
    return rows


def _summarise(row: Row) -> str:
    errors = [f"{key} {number(row[key]) or 'n. o.'}" for key in ("displacement", "rotation", "stretch")]
    return f"{row['background']}, {row['noise']}, {row['distance']}: {', '.join(errors)}"


if __name__ == "__main__":
    sys.exit(main())
