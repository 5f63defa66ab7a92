"""Answers of chat models that fit a schema: ask, read, check, and ask again with what was wrong."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from physagent_jax.agents.trace import AgentError, Message, Reply, Trace
from physagent_jax.chat.base import ChatMessage, ChatModel, Generation, ModelError
from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import decode_json, shorten

Value = TypeVar("Value", bound=BaseModel)

LONGEST_ANSWER = 100_000
"""Characters of an answer that are read; a longer one is refused."""
_LONGEST_KEPT = 20_000  # characters of one refused answer that the trace keeps
_LONGEST_QUOTED = 2_000  # characters of a refused answer that go back to the model
_MOST_FAULTS = 8  # that a model is told at once
_TAG = "(think|thinking|reasoning)>"
_THOUGHTS = re.compile(rf"<{_TAG}.*?</\1>", re.DOTALL | re.IGNORECASE)
_THOUGHT_ENDS = re.compile(rf"</{_TAG}", re.IGNORECASE)
_THOUGHT_BEGINS = re.compile(rf"\s*<{_TAG}", re.IGNORECASE)
_OBJECT_BEGINS = re.compile(r'\{\s*["}]')


class BadAnswers(AgentError):
    """A model has answered, and no answer of it can be used; a model that is away is another matter."""


def ask(
    model: ChatModel,
    messages: Sequence[ChatMessage],
    schema: type[Value],
    *,
    tries: int = 3,
    validate: Callable[[Value], object] | None = None,
    state_schema: bool = True,
) -> Reply[Value]:
    """An answer that fits ``schema``, and the exchange that led to it.

    The model is asked ``tries`` times at most. The JSON schema is asked of its server and, with ``state_schema``,
    written below the first message too. A `ValueError` of ``validate``, a check beyond the schema, refuses an answer.

    Raises:
        AgentError: The model gave no answer, or none that fits (`BadAnswers`); the error has the whole exchange.
    """
    described = json.loads(json.dumps(schema.model_json_schema()), object_hook=_drop_title)
    asked = list(messages)
    if state_schema:
        stated = json.dumps(described, separators=(",", ":"))
        order = f"Answer with one JSON object and nothing else. Its JSON schema: {stated}"
        asked[0] = replace(asked[0], text=f"{asked[0].text}\n\n{order}")
    trace = Trace(messages=tuple(_note(each) for each in asked))
    why = ""
    for attempt in range(tries):
        try:
            generation = model.generate(asked, described)
        except ModelError as error:
            trace = _extend(trace, validation_errors=error.failures, latency_seconds=error.latency_seconds)
            raise AgentError(error.what, trace=trace, got=error.got, do=error.do) from error
        trace = _add_answer(trace, generation)
        try:
            found, left_out = extract_object(generation.text)
            value = schema.model_validate_json(json.dumps(found))
            if validate is not None:
                validate(value)
            return Reply(value, add_repairs(trace, *left_out))
        except (ValueError, RecursionError) as error:
            why = explain_refusal(error)
        if generation.cut:
            why += " (it was cut at the limit of tokens: write less)"
        quoted = ChatMessage("assistant", _clip(trace.raw_reply, _LONGEST_QUOTED) or "(nothing)")
        again = "Answer again with one JSON object that fits the schema and nothing else."
        order = ChatMessage("user", f"That answer cannot be used: {why}. {again}")
        asked += [quoted, order]
        is_last = attempt + 1 == tries
        trace = _extend(trace, validation_errors=(why,), messages=() if is_last else (_note(order),))
    raise BadAnswers(
        f"{model.name} gave no usable answer in {tries} tries: {why}",
        trace=trace,
        do="Ask a larger model, or choose the agents that need none",
    )


def add_repairs(trace: Trace, *repairs: str) -> Trace:
    """The trace with what was changed in the reply, or done in its place."""
    return trace.model_copy(update=dict(repairs=(*trace.repairs, *repairs)))


def _note(message: ChatMessage) -> Message:
    return Message(role=message.role, text=message.text, pictures=len(message.pictures))


def _extend(trace: Trace, **more: Any) -> Trace:
    """The trace with more in it; the reply stays the last one, unless there is another."""
    return trace.followed_by(Trace(**{"raw_reply": trace.raw_reply, **more}))


def _add_answer(trace: Trace, generation: Generation) -> Trace:
    text = generation.text
    raw = text if len(text) <= LONGEST_ANSWER else _clip(text, _LONGEST_KEPT)
    return _extend(
        trace,
        model=generation.model,
        messages=(Message(role="assistant", text=raw),),
        raw_reply=raw,
        validation_errors=generation.failures,
        input_tokens=generation.usage.input_tokens or 0,
        output_tokens=generation.usage.output_tokens or 0,
        latency_seconds=generation.latency_seconds,
    )


def _drop_title(schema: dict[str, Any]) -> dict[str, Any]:
    """A part of a JSON schema without its title, which repeats the field's name."""
    return {key: each for key, each in schema.items() if key != "title" or not isinstance(each, str)}


def extract_object(text: str) -> tuple[dict[str, Any], tuple[str, ...]]:
    """The first JSON object of an answer, and what was left out around it, a sentence each.

    Raises:
        ValueError: There is no whole object, or a list stands in its place.
    """
    if len(text) > LONGEST_ANSWER:
        told = f"the answer has {len(text):,} characters"
        raise ValueError(f"{told}, more than {LONGEST_ANSWER:,} are not read")
    repairs = []
    said = _THOUGHTS.sub("", text)
    if ends := list(_THOUGHT_ENDS.finditer(said)):  # some servers leave the opening tag out
        said = said[ends[-1].end() :]
    if _THOUGHT_BEGINS.match(said):
        raise ValueError("the answer ends within its thoughts")
    if len(said) < len(text):
        repairs.append("Thoughts before the answer were left out.")
    begins = _OBJECT_BEGINS.search(said)
    if begins is None:
        raise ValueError("the answer holds no JSON object")
    start, end = begins.start(), _find_end(said, begins.start())
    if said[:start].rstrip().endswith("["):
        raise ValueError("the answer is a list of objects, and one object is asked for")
    value = decode_json(said[start:end].encode(), "the answer")
    rest = said[:start] + said[end:]
    if re.sub(r"```(?:json)?", "", rest).strip():
        more = "A second object" if _OBJECT_BEGINS.search(said, end) else "Text"
        repairs.append(f"{more} around the answer's first JSON object was left out.")
    return value, tuple(repairs)


def _find_end(text: str, start: int) -> int:
    """The place behind the object that begins at ``start``, by its brackets."""
    depth, inside = 0, False
    for found in re.finditer(r'\\.|["{}]', text[start:], re.DOTALL):
        mark = found[0]
        if mark == '"':
            inside = not inside
        elif not inside and mark in "{}":
            depth += 1 if mark == "{" else -1
            if depth == 0:
                return start + found.end()
    raise ValueError("the answer ends within its JSON object")


def explain_refusal(error: Exception) -> str:
    """One line about what is wrong with an answer, for the model and for people."""
    if isinstance(error, UserError):
        return shorten(error.what if error.got is None else f"{error.what} (got {error.got})", 500)
    if not isinstance(error, ValidationError):
        return shorten(error, 500).rstrip(".")
    faults = [
        f"{'.'.join(map(str, fault['loc'])) or 'the object'}: {fault['msg']}"[:300]
        for fault in error.errors(include_url=False, include_context=False, include_input=False)
    ]
    more = f"; and {len(faults) - _MOST_FAULTS} more" if len(faults) > _MOST_FAULTS else ""
    return "; ".join(faults[:_MOST_FAULTS]) + more


def _clip(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[:most]}[... {len(text) - most:,} more characters]"
