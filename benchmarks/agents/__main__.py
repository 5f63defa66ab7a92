"""`python -m benchmarks.agents [--quick] [--parts PART ...] [--models NAME=PLACE ...] [--json OUT]`: agents and models.

`adversarial` lets a real HTTP server on loopback answer badly in every way there is: each call of an agent has to end
in a valid answer or one clear error, with every exchange in the trace, no key in any file, and nothing left open.
`reading` has sentences of the corpus read by the grammar and by models, in each form; `judging` has motion reports
judged by the rules and by models. Both go on where they were stopped with `--resume`.
"""

from __future__ import annotations

import dataclasses
import sys
from functools import partial
from pathlib import Path
from typing import Literal

import tyro

from benchmarks import harness
from benchmarks.agents import judging, reading
from benchmarks.agents.adversarial import measure_kind
from benchmarks.agents.markdown import PAGE
from benchmarks.agents.replies import Kind, list_kinds
from benchmarks.agents.roles import ROLES
from benchmarks.chat_models import Asked, close_all
from benchmarks.harness import RAW, Job, Row
from benchmarks.verdicts.judging import Sight
from physagent_jax.agents.llm.semantic import FORMS, Form

VARIANTS = 2
QUICK_SAMPLE = 8


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Measure agents that ask chat models, or write the tables of an earlier run."""

    json: Path = RAW / "agents.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Literal["adversarial", "reading", "judging"], ...] = ("adversarial",)
    """Parts to measure."""
    models: tuple[str, ...] = ()
    """Models that read and judge, NAME=PLACE each: a GGUF file, a cassette, or URL#MODEL of a server."""
    forms: tuple[Form, ...] = FORMS
    """Forms that models fill in when they read."""
    split: str = "test"
    """Split of the corpus that is read."""
    sample: int = 60
    """Sentences and clips, drawn by the seed; all there are if it is larger."""
    seed: int = 40
    """Seed of the sample."""
    sight: Sight = "truth"
    """Source of the reports that are judged: the true trajectories, or what perception sees in pictures."""
    clips: Path = Path("runs/verdicts")
    """Folder of the clips that are judged; those that are missing are made."""
    data: Path | None = None
    """Folder of captured objects; none of them is needed."""
    cassettes: Path = Path("runs/agents")
    """Folder where the models' answers are kept."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    models = tuple(Asked(text, command.cassettes) for text in command.models)
    sample = QUICK_SAMPLE if command.quick else command.sample

    def list_adversarial() -> list[Job]:
        return [Job(kind.name, partial(measure_replies, kind, command.quick)) for kind in list_kinds()]

    def list_reading() -> list[Job]:
        sentences = reading.draw_sample(command.split, sample, command.seed)
        return reading.list_jobs(sentences, models, command.forms)

    def list_judging() -> list[Job]:
        source = judging.Source(command.sight, command.clips, command.data)
        return judging.list_jobs(source, models, sample, command.seed)

    parts = {"adversarial": list_adversarial, "reading": list_reading, "judging": list_judging}
    try:
        return harness.main(command, parts, PAGE)
    finally:
        close_all(models)


def measure_replies(kind: Kind, quick: bool) -> list[Row]:
    """Replies of one kind to every agent, in variants; quick: one."""
    roles, variants = (ROLES[:1], 1) if quick else (ROLES, VARIANTS)
    return [measure_kind(kind, role, variant) for role in roles for variant in range(variants)]


if __name__ == "__main__":
    sys.exit(main())
