"""Answers of chat models that fit a schema: ask, read, check, and ask again with what was wrong."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from physagent_jax.agents.llm.base import ChatMessage, ChatModel, Generation, ModelError
from physagent_jax.agents.trace import AgentError, Message, Reply, Trace
from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import decode_json, shorten

Value = TypeVar("Value", bound=BaseModel)

LONGEST_ANSWER = 100_000
"""Characters of an answer that are read; a longer one is refused."""
_LONGEST_KEPT = 20_000  # characters of one refused answer that the trace keeps
_LONGEST_QUOTED = 2_000  # characters of a refused answer that go back to the model
_MOST_FAULTS = 8  # that a model is told at once
_THOUGHTS = re.compile(r"<(think|thinking|reasoning)>.*?</\1>", re.DOTALL | re.IGNORECASE)
_THOUGHT_ENDS = re.compile(r"</(think|thinking|reasoning)>", re.IGNORECASE)
_THOUGHT_BEGINS = re.compile(r"\s*<(think|thinking|reasoning)>", re.IGNORECASE)
_OBJECT_BEGINS = re.compile(r'\{\s*["}]')


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

    Args:
        model: The model that is asked.
        messages: The prompt.
        schema: Class of the answer; its JSON schema is also asked of the model's server.
        tries: How often the model is asked at most.
        validate: Check beyond the schema; what it raises, a `ValueError`, refuses the answer.
        state_schema: Whether the JSON schema is written below the first message too.

    Raises:
        AgentError: The model gave no answer, or none that fits; the error has the whole exchange.
    """
    described = drop_titles(schema.model_json_schema())
    exchange = _Exchange(list(state(messages, described) if state_schema else messages))
    for attempt in range(tries):
        try:
            generation = model.generate(exchange.messages, described)
        except ModelError as error:
            exchange.seconds += error.latency_seconds
            exchange.refusals += error.failures
            raise AgentError(error.what, trace=exchange.trace(), got=error.got, do=error.do) from error
        exchange.add(generation)
        try:
            found, left_out = extract_object(generation.text)
            value = schema.model_validate_json(json.dumps(found))
            if validate is not None:
                validate(value)
        except (ValueError, RecursionError) as error:
            cut = " (it was cut at the limit of tokens: write less)" if generation.cut else ""
            exchange.refuse(explain_refusal(error) + cut, again=attempt + 1 < tries)
            continue
        exchange.repairs += left_out
        return Reply(value, exchange.trace())
    last = exchange.refusals[-1]
    raise AgentError(
        f"{model.name} gave no usable answer in {tries} tries: {last}",
        trace=exchange.trace(),
        do="Ask a larger model, or choose the agents that need none",
    )


def state(messages: Sequence[ChatMessage], schema: dict[str, Any]) -> list[ChatMessage]:
    """The messages with the JSON schema below the first one."""
    text = json.dumps(schema, separators=(",", ":"))
    first, *others = messages
    asked = f"{first.text}\n\nAnswer with one JSON object and nothing else. Its JSON schema: {text}"
    return [ChatMessage(first.role, asked, first.pictures), *others]


def drop_titles(schema: Any) -> Any:
    """A JSON schema without the titles of its fields, which repeat their names."""
    if isinstance(schema, list):
        return [drop_titles(each) for each in schema]
    if not isinstance(schema, dict):
        return schema
    kept = {key: each for key, each in schema.items() if key != "title" or not isinstance(each, str)}
    return {key: drop_titles(each) for key, each in kept.items()}


def extract_object(text: str) -> tuple[dict[str, Any], tuple[str, ...]]:
    """The first JSON object of an answer, and what was left out around it, a sentence each.

    Raises:
        ValueError: There is no whole object, or a list stands in its place.
    """
    if len(text) > LONGEST_ANSWER:
        raise ValueError(
            f"the answer has {len(text):,} characters, more than {LONGEST_ANSWER:,} are not read"
        )
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
    if said[: begins.start()].rstrip().endswith("["):
        raise ValueError("the answer is a list of objects, and one object is asked for")
    start = begins.start()
    end = _find_end(said, start)
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


@dataclass
class _Exchange:
    """The exchange so far, for the model and for the trace."""

    messages: list[ChatMessage]
    said: list[Message] = field(default_factory=list)
    refusals: list[str] = field(default_factory=list)
    repairs: tuple[str, ...] = ()
    raw: str = ""
    model: str = ""
    input_tokens: int = 0
    output_tokens: int = 0
    seconds: float = 0.0

    def __post_init__(self):
        self.said = [Message(role=m.role, text=m.text, pictures=len(m.pictures)) for m in self.messages]

    def add(self, generation: Generation) -> None:
        """Note an answer."""
        text = generation.text
        self.raw = text if len(text) <= LONGEST_ANSWER else _clip(text, _LONGEST_KEPT)
        self.refusals += generation.failures
        self.model = generation.model
        self.input_tokens += generation.usage.input_tokens or 0
        self.output_tokens += generation.usage.output_tokens or 0
        self.seconds += generation.latency_seconds
        self.said.append(Message(role="assistant", text=self.raw))

    def refuse(self, why: str, again: bool) -> None:
        """Note why the last answer cannot be used, and tell the model if it is asked again."""
        self.refusals.append(why)
        if not again:
            return
        asked = (
            f"That answer cannot be used: {why}. "
            "Answer again with one JSON object that fits the schema and nothing else."
        )
        quoted = _clip(self.raw, _LONGEST_QUOTED) or "(nothing)"
        self.messages += [ChatMessage("assistant", quoted), ChatMessage("user", asked)]
        self.said.append(Message(role="user", text=asked))

    def trace(self) -> Trace:
        """The exchange so far."""
        return Trace(
            model=self.model,
            messages=tuple(self.said),
            raw_reply=self.raw,
            validation_errors=tuple(self.refusals),
            repairs=self.repairs,
            input_tokens=self.input_tokens,
            output_tokens=self.output_tokens,
            latency_seconds=self.seconds,
        )


def _clip(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[:most]}[... {len(text) - most:,} more characters]"
