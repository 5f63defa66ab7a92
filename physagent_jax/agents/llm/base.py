"""The protocol of chat models: messages in, text out, with an optional JSON schema."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from physagent_jax.core.errors import UserError


@dataclass(frozen=True)
class ChatMessage:
    """One message to a chat model.

    Attributes:
        role: Who speaks.
        text: What is said.
        pictures: PNG files that go with it; for models that have eyes.
    """

    role: Literal["system", "user", "assistant"]
    text: str
    pictures: tuple[bytes, ...] = ()


@dataclass(frozen=True)
class Usage:
    """Tokens of one exchange, as the provider counts them; None = it does not say."""

    input_tokens: int | None = None
    output_tokens: int | None = None


@dataclass(frozen=True)
class Generation:
    """A chat model's answer.

    Attributes:
        text: The answer as it came.
        parsed: The JSON value that the whole text is; None if it is none.
        usage: Tokens.
        latency_seconds: Waited for the answer, retries included [s].
        model: Identifier of the model that answered, as its provider reports it.
    """

    text: str
    parsed: Any | None
    usage: Usage
    latency_seconds: float
    model: str


class ModelError(UserError):
    """A chat model gave no answer, after bounded retries.

    Args:
        what: What is wrong, without any key.
        got: The offending value, if showing it helps.
        do: What to do about it.
        latency_seconds: Waited in vain [s].
    """

    def __init__(self, what: str, *, got: object = None, do: str = "", latency_seconds: float = 0.0):
        super().__init__(what, got=got, do=do)
        self.latency_seconds = latency_seconds


class ChatModel(Protocol):
    """A language model that answers messages."""

    @property
    def name(self) -> str:
        """The adapter and the model, like "openai:NAME": another name is another run."""
        ...

    @property
    def has_eyes(self) -> bool:
        """Whether it takes pictures."""
        ...

    def generate(
        self, messages: Sequence[ChatMessage], schema: Mapping[str, Any] | None = None
    ) -> Generation:
        """Answer ``messages``, by the JSON schema where the model can be held to one.

        Raises:
            ModelError: There is no answer.
        """
        ...

    def close(self) -> None:
        """Free what the model holds; it answers nothing afterwards."""
        ...


def read_json(text: str) -> Any:
    """The value that a JSON text stands for.

    Raises:
        ValueError: It is no JSON, nests too deeply, names a key twice, or has NaN or an infinity.
    """
    try:
        return json.loads(text, object_pairs_hook=_build_object, parse_constant=_refuse_constant)
    except RecursionError:
        raise ValueError("the JSON nests too deeply") from None


def read_json_or_none(text: str) -> Any | None:
    """`read_json`, or None for a text that is no JSON."""
    try:
        return read_json(text)
    except ValueError:
        return None


def _build_object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    built = dict(pairs)
    if len(built) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"the key {twice[:80]!r} stands twice in one object")
    return built


def _refuse_constant(text: str) -> float:
    raise ValueError(f"{text} is no number of JSON")
