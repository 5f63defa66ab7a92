"""The shared part of chat models that run in this process, from files."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from pydantic import Field

from physagent_jax.chat.base import Generation, Messages, ModelError, Schema
from physagent_jax.chat.completions import read_completion
from physagent_jax.core.reading import shorten
from physagent_jax.core.strict import Strict


class FileOptions(Strict):
    """Options of models that run in process.

    Attributes:
        path: The model's file or folder.
        max_tokens: Longest answer [tokens].
        timeout: Longest time for one answer [s].
    """

    path: Path
    max_tokens: int = Field(default=2_000, ge=1, le=1_000_000)
    timeout: float = Field(default=600.0, ge=0.01, le=86_400)


class FileModel:
    """A chat model without eyes that is loaded from files; adapters complete it."""

    has_eyes = False

    def __init__(self, adapter: str, label: str, timeout: float):
        self.name, self._label, self._timeout = f"{adapter}:{label}", label, timeout

    def generate(self, messages: Messages, schema: Schema | None = None) -> Generation:
        """Answer ``messages``; see `ChatModel`."""
        begun = time.monotonic()
        try:
            completion = self._complete(messages, schema)
            return read_completion(completion, self._label, time.monotonic() - begun)
        except TimeoutError:
            why = f"no answer within {self._timeout:g} s"
        except (RuntimeError, ValueError, IndexError) as error:  # memory, context, a refused schema or role
            why = shorten(error)
        waited = time.monotonic() - begun
        raise ModelError(f"{self.name} gave no answer: {why}", latency_seconds=waited, failures=(why,))

    def _complete(self, messages: Messages, schema: Schema | None) -> dict[str, Any]:
        """A chat completion, in the wire format."""
        raise NotImplementedError
