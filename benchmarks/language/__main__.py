"""`python -m benchmarks.language [--quick] [--json OUT] [--markdown MD]`: sentences read as a person reads them.

What a sentence says was written by hand before the parser was made to read it. A third of the first author's
sentences and half of the others', by their hash, are test splits: no rule is made for them, and they are not looked at
one by one.
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
from benchmarks.language.notation import FILES, LIMIT, Sentence, read_sentences
from benchmarks.language.score import get_answer, make_scene, score
from physagent_jax.agents.context import AgentContext
from physagent_jax.agents.grammar.semantic import GrammarSemanticAgent
from physagent_jax.agents.schema import SceneBrief, SemanticReply
from physagent_jax.core.errors import UserError
from physagent_jax.forces.description import describe_skills


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Read the sentences, or write the tables of an earlier run."""

    json: Path = RAW / "language.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Literal["sentences", "own_words"], ...] = PARTS
    """own_words: without the readings that second readers added to the first, the second and the seventh author's."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    parts = {part: partial(_list_jobs, command.quick, part == "own_words") for part in PARTS}
    return harness.main(command, parts, PAGE)


def _list_jobs(quick: bool, own_words: bool) -> list[Job]:
    jobs = []
    for author in FILES:
        sentences = read_sentences(author, own_words)[:: 4 if quick else 1]
        for split in ("development", "test"):
            chosen = [sentence for sentence in sentences if sentence.split == split]
            if chosen:
                jobs.append(Job(f"{author} author, {split}", partial(read_split, chosen)))
    return jobs


def read_split(sentences: list[Sentence]) -> list[Row]:
    """A row for each sentence; those that are misread without a word fail where there are more than `LIMIT`."""
    rows = [read_one(sentence) for sentence in sentences]
    share = sum(row["silent"] for row in rows) / len(rows)
    return [row | {"good": not row["silent"] or share <= LIMIT} for row in rows]


def read_one(sentence: Sentence) -> Row:
    """Row of a sentence: the answer of the parser beside that of a person."""
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
    """The parser's reply; None if it refuses."""
    try:
        return GrammarSemanticAgent().compile(AgentContext(text, brief, describe_skills())).value
    except UserError:
        return None


def describe(motion) -> str:
    """A motion in a line."""
    return motion.model_dump_json(exclude_defaults=True)


if __name__ == "__main__":
    sys.exit(main())
