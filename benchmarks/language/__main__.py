"""`python -m benchmarks.language [--quick] [--json OUT] [--markdown MD]`: sentences read as a person reads them.

What a sentence says was written by hand before the grammar was made to read it. No rule is made for sentences of the
test split, and they are not looked at one by one.
"""

from __future__ import annotations

import dataclasses
import sys
from functools import partial
from pathlib import Path
from typing import Literal

import tyro

from benchmarks import harness
from benchmarks.harness import RAW, Job, Row
from benchmarks.language.markdown import PAGE, PARTS
from benchmarks.language.notation import SPLITS, Sentence, read_split
from benchmarks.language.score import get_answer, make_scene, score
from benchmarks.language.totals import count_outcomes, describe_shares, is_met
from physagent_jax.agents.context import AgentContext
from physagent_jax.agents.grammar.semantic import GrammarSemanticAgent
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.core.errors import UserError
from physagent_jax.forces.description import describe_skills
from physagent_jax.motion.schema import SceneBrief


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Read the sentences, or write the tables of an earlier run."""

    json: Path = RAW / "language.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Literal["sentences"], ...] = PARTS


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    return harness.main(command, {"sentences": partial(_list_jobs, command.quick)}, PAGE)


def _list_jobs(quick: bool) -> list[Job]:
    return [Job(split, partial(read_all, split, read_split(split)[:: 4 if quick else 1])) for split in SPLITS]


def read_all(split: str, sentences: list[Sentence]) -> list[Row]:
    """A row for each sentence of a split; where the split is not as required, those that are not right fail."""
    rows = [read_one(sentence) for sentence in sentences]
    count = count_outcomes(rows)
    harness.say(f"{split}: {describe_shares(count)}")
    met = is_met(split, count)
    return [row | {"good": met or not row["wrong"]} for row in rows]


def read_one(sentence: Sentence) -> Row:
    """Row of a sentence: the answer of the grammar beside that of a person."""
    brief = make_scene(sentence.object_name)
    reply = compile_sentence(sentence.text, brief)
    fields = score(sentence, reply, brief)
    wrong = [name for name, right in fields if not right]
    return {
        "sentence": sentence.text,
        "author": sentence.author,
        "split": sentence.split,
        "object": sentence.object_name,
        "group": sentence.group,
        "expected": sentence.expected,
        "answer": get_answer(reply),
        "fields": len(fields),
        "wrong": wrong,
        "silent": bool(wrong) and get_answer(reply) == "motion",
        "named": [] if reply is None else list(reply.not_understood),
        "read": [] if reply is None else [describe(motion) for motion in reply.expectations],
    }


def compile_sentence(text: str, brief: SceneBrief) -> SemanticReply | None:
    """The grammar's reply; None if it refuses."""
    try:
        return GrammarSemanticAgent().compile(AgentContext(text, brief, describe_skills())).value
    except UserError:
        return None


def describe(motion) -> str:
    """A motion in a line."""
    return motion.model_dump_json(exclude_defaults=True)


if __name__ == "__main__":
    sys.exit(main())
