"""The protocol of chat models: messages in, text out, with an optional JSON schema."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import decode_json


@dataclass(frozen=True)
class ChatMessage:
    """One message to a chat model; pictures are PNG files, for models that have eyes."""

    role: Literal["system", "user", "assistant"]
    text: str
    pictures: tuple[bytes, ...] = ()


Messages = Sequence[ChatMessage]
Schema = Mapping[str, Any]
"""A JSON schema."""


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
        failures: Why earlier attempts gave no answer, a sentence each.
        cut: Whether the answer ends at the limit of tokens.
    """

    text: str
    parsed: Any | None
    usage: Usage
    latency_seconds: float
    model: str
    failures: tuple[str, ...] = ()
    cut: bool = False


class ModelError(UserError):
    """A chat model gave no answer, after bounded retries: ``failures`` says why, a sentence for each attempt."""

    def __init__(
        self, what: str, *, latency_seconds: float = 0.0, failures: tuple[str, ...] = (), **told: Any
    ):
        super().__init__(what, **told)
        self.latency_seconds, self.failures = latency_seconds, failures


class ChatModel(Protocol):
    """A language model that answers messages.

    Attributes:
        name: The adapter and the model, like "openai:NAME": another name is another run.
        has_eyes: Whether it takes pictures.
    """

    name: str
    has_eyes: bool

    def generate(self, messages: Messages, schema: Schema | None = None) -> Generation:
        """Answer ``messages``, by the JSON schema where the model can be held to one.

        Raises:
            ModelError: There is no answer.
        """
        ...

    def close(self) -> None:
        """Free what the model holds; it answers nothing afterwards."""
        ...


def read_json_or_none(text: str) -> Any | None:
    """The value that a JSON text stands for; None for a text that is no JSON within bounds."""
    try:
        return decode_json(text.encode(), "the answer")
    except ValueError:
        return None


def make_writable(text: str) -> str:
    """The text with a mark for each half of a surrogate pair, which no file and no request can hold."""
    return text.encode("utf-8", "replace").decode()
