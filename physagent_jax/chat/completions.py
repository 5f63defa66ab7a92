"""The wire format of chat completions, which servers and llama.cpp share: requests and answers."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Any

from physagent_jax.chat.base import ChatMessage, Generation, Usage, make_writable, read_json_or_none
from physagent_jax.core.reading import shorten

_MOST_TOKENS = 10**9  # that an answer can have cost


def format_message(message: ChatMessage) -> dict[str, Any]:
    """A message as servers take it; pictures are data URLs."""
    written = make_writable(message.text)
    if not message.pictures:
        return {"role": message.role, "content": written}
    urls = (f"data:image/png;base64,{base64.b64encode(each).decode()}" for each in message.pictures)
    pictures = [{"type": "image_url", "image_url": {"url": url}} for url in urls]
    return {"role": message.role, "content": [{"type": "text", "text": written}, *pictures]}


def format_schema(schema: Mapping[str, Any]) -> dict[str, Any]:
    """The request for an answer by a JSON schema; strict where the schema is as OpenAI's strict mode demands."""
    named = {"name": "answer", "schema": dict(schema), "strict": _is_closed(schema)}
    return {"type": "json_schema", "json_schema": named}


def _is_closed(schema: Any) -> bool:
    """Return whether every object of a JSON schema needs all of its fields and takes no others."""
    if isinstance(schema, list):
        return all(map(_is_closed, schema))
    if not isinstance(schema, Mapping):
        return True
    fields = schema.get("properties")
    if isinstance(fields, Mapping):
        if schema.get("additionalProperties") is not False or set(fields) != set(schema.get("required", ())):
            return False
    return all(map(_is_closed, schema.values()))


def read_completion(
    completion: Any, model: str, seconds: float, failures: tuple[str, ...] = ()
) -> Generation:
    """The answer in a decoded chat completion of ``model``, after ``seconds`` [s] and ``failures``.

    Raises:
        ValueError: It is no chat completion.
    """
    try:
        choice, usage, told = completion["choices"][0], completion.get("usage"), completion.get("model")
        text, cut = make_writable(_read_content(choice["message"])), choice.get("finish_reason") == "length"
    except (LookupError, TypeError, AttributeError):
        raise ValueError("it has no text") from None
    counts = usage if isinstance(usage, dict) else {}
    tokens = Usage(*(_check_count(counts.get(name)) for name in ("prompt_tokens", "completion_tokens")))
    model = shorten(told) if isinstance(told, str) and told else model
    return Generation(text, read_json_or_none(text), tokens, seconds, model, failures, cut)


def _read_content(message: Mapping[str, Any]) -> str:
    """Text of a message: a string, a list of parts, or a refusal."""
    content = message.get("content")
    if isinstance(content, list):
        content = "".join(part["text"] for part in content if part.get("type") == "text")
    if content is None:
        content = message.get("refusal") or ""
    if not isinstance(content, str):
        raise TypeError("the content is no text")
    return content


def _check_count(count: Any) -> int | None:
    return count if type(count) is int and 0 <= count <= _MOST_TOKENS else None
