"""`python -m benchmarks.agents [--quick] [--json OUT] [--markdown MD]`: agents that ask chat models.

`adversarial` lets a real HTTP server on loopback answer badly in every way there is: each call of an agent has to end
in a valid answer or one clear error, with every exchange in the trace, no key in any file, and nothing left open.
"""

from __future__ import annotations

import dataclasses
import sys
from functools import partial
from pathlib import Path
from typing import Literal

import tyro

from benchmarks import harness
from benchmarks.agents.adversarial import measure_kind
from benchmarks.agents.markdown import PAGE, PARTS
from benchmarks.agents.replies import Kind, list_kinds
from benchmarks.agents.roles import ROLES
from benchmarks.harness import RAW, Job, Row

VARIANTS = 2


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Measure agents that ask chat models, or write the tables of an earlier run."""

    json: Path = RAW / "agents.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Literal["adversarial"], ...] = PARTS
    """Parts to measure."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)

    def list_adversarial() -> list[Job]:
        return [Job(kind.name, partial(measure_replies, kind, command.quick)) for kind in list_kinds()]

    return harness.main(command, {"adversarial": list_adversarial}, PAGE)


def measure_replies(kind: Kind, quick: bool) -> list[Row]:
    """Replies of one kind to every agent, in variants; quick: one."""
    roles, variants = (ROLES[:1], 1) if quick else (ROLES, VARIANTS)
    return [measure_kind(kind, role, variant) for role in roles for variant in range(variants)]


if __name__ == "__main__":
    sys.exit(main())
