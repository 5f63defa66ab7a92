"""Sentences read by the grammar and by models.

Each model reads each sentence of a sample in each form; a row says what became of it, in the words of
`benchmarks.language`. Rows of held-back sentences hold a hash in place of the sentence, and only totals are printed.
A model's reading alone is scored, without the grammar that a run falls back to; "both" is the grammar's reading with
the doubts that the model's reading adds.
"""

from __future__ import annotations

import hashlib
import random
from collections.abc import Iterable
from functools import partial

from benchmarks.chat_models import Asked
from benchmarks.harness import Job, Row, Rows, number, table
from benchmarks.language.notation import Sentence, read_split
from benchmarks.language.score import get_answer, make_scene, score
from benchmarks.language.totals import OUTCOMES, count_outcomes
from physagent_jax.agents.context import AgentContext
from physagent_jax.agents.llm.semantic import FORMS, Form, NoMotion, find_disagreements, read_with_model
from physagent_jax.agents.llm.structured import BadAnswers
from physagent_jax.agents.registry import make_agents
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.agents.trace import Trace
from physagent_jax.core.errors import UserError
from physagent_jax.forces.description import describe_skills
from physagent_jax.motion.schema import SceneBrief

CHUNK = 4  # sentences of a job
PART = "reading"


def draw_sample(split: str, size: int, seed: int) -> list[Sentence]:
    """Sentences of a split in the order of a shuffle: a smaller sample is the beginning of a larger one."""
    sentences = sorted(read_split(split), key=lambda each: (each.text, each.object_name))
    random.Random(seed).shuffle(sentences)
    return sentences[:size]


def list_jobs(sentences: list[Sentence], models: Iterable[Asked], forms: Iterable[Form] = FORMS) -> list[Job]:
    """The grammar's job, and one for every few sentences of a model and a form."""
    jobs = [Job("grammar", partial(_read_all, sentences))]
    chunks = [sentences[start : start + CHUNK] for start in range(0, len(sentences), CHUNK)]
    for index, chunk in enumerate(chunks):  # in turn, so that a run that is stopped has a fair share of each
        for model in models:
            for form in forms:
                name = f"{model.name}, {form}, sentences {index * CHUNK + 1}-{index * CHUNK + len(chunk)}"
                jobs.append(Job(name, partial(_ask_all, chunk, model, form)))
    return jobs


def _read_all(sentences: list[Sentence]) -> list[Row]:
    return [_make_row(sentence, "grammar", "", read_with_grammar(sentence)) for sentence in sentences]


def _ask_all(sentences: list[Sentence], model: Asked, form: Form) -> list[Row]:
    return [row for sentence in sentences for row in _ask_one(sentence, model, form)]


def read_with_grammar(sentence: Sentence) -> SemanticReply | None:
    """The grammar's reply; None if it refuses."""
    context = _make_context(sentence)
    try:
        return make_agents().semantic.compile(context).value
    except UserError:
        return None


def _make_context(sentence: Sentence) -> AgentContext:
    return AgentContext(sentence.text, make_scene(sentence.object_name), describe_skills())


def _ask_one(sentence: Sentence, asked: Asked, form: Form) -> list[Row]:
    """Rows of the model's reading alone, and of the grammar's with the model's doubts."""
    model, context = asked.open(), _make_context(sentence)
    reply, trace, unusable = None, Trace(), False
    try:
        answer = read_with_model(model, context, form)
        reply, trace = answer.value, answer.trace
    except (NoMotion, BadAnswers) as error:  # from a server that is away, nothing was measured
        trace, unusable = error.trace, isinstance(error, BadAnswers)
    cost = {
        "seconds": round(trace.latency_seconds, 3),
        "input_tokens": trace.input_tokens,
        "output_tokens": trace.output_tokens,
        "asked again": len(trace.validation_errors),
        "unusable": unusable,
    }
    mine = read_with_grammar(sentence)
    both = mine if unusable or mine is None else _doubt(mine, reply, asked.name, context.brief)
    return [
        _make_row(sentence, asked.name, form, reply) | cost,
        _make_row(sentence, f"grammar and {asked.name}", form, both) | cost,
    ]


def _doubt(mine: SemanticReply, other: SemanticReply | None, name: str, brief: SceneBrief) -> SemanticReply:
    doubts = ["it finds no motion"] if other is None else find_disagreements(mine, other, name, brief)
    return mine.model_copy(update=dict(unsure=(*mine.unsure, *doubts)))


def _make_row(sentence: Sentence, reader: str, form: str, reply: SemanticReply | None) -> Row:
    brief = make_scene(sentence.object_name)
    fields = score(sentence, reply, brief)
    digest = hashlib.sha256(f"{sentence.object_name} {sentence.text}".encode()).hexdigest()[:16]
    shown = {} if sentence.split == "test" else {"text": sentence.text, "expected": sentence.expected}
    return {
        "reader": reader,
        "form": form,
        "sentence": digest,
        **shown,
        "author": sentence.author,
        "split": sentence.split,
        "answer": get_answer(reply),
        "fields": len(fields),
        "wrong": [name for name, right in fields if not right],
        "motion right": _is_motion_right(fields),
    }


def _is_motion_right(fields: list[tuple[str, bool]]) -> bool:
    """Return whether kinds and directions are right, whatever is marked."""
    named = [right for name, right in fields if name in ("kind", "direction")]
    return all(named) if named else all(right for _, right in fields)


def condense_reading(rows: Rows) -> Rows:
    """Counts by reader, form and split."""
    groups: dict[tuple[str, str, str], Rows] = {}
    for row in rows:
        groups.setdefault((row["reader"], row["form"], row["split"]), []).append(row)
    return [
        {
            "reader": reader,
            "form": form,
            "split": split,
            "sentences": len(mine),
            **count_outcomes(mine),
            "motion right": sum(row["motion right"] for row in mine),
            "unusable": sum(row.get("unusable", False) for row in mine),
            **{
                name: round(sum(row.get(name, 0) for row in mine) / len(mine), 3)
                for name in ("seconds", "input_tokens", "output_tokens", "asked again")
            },
        }
        for (reader, form, split), mine in groups.items()
    ]


def write_reading(counts: Rows) -> str:
    """The table of readers: shares of outcomes, and the cost of a sentence."""
    shown, costs = ("motion right", *OUTCOMES, "unusable"), ("seconds", "input_tokens", "output_tokens")
    head = ["reader", "form", "split", "sentences", *shown, "s", "tokens in", "tokens out"]
    rows = []
    for row in counts:
        shares = [f"{100 * row.get(name, 0) / row['sentences']:.0f} %" for name in shown]
        cost = [number(row[name]) for name in costs]
        rows.append([row["reader"], row["form"], row["split"], str(row["sentences"]), *shares, *cost])
    return table(head, rows)
