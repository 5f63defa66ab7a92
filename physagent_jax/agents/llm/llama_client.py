"""A chat model in process from a GGUF file, by llama.cpp's package `xllamacpp`."""

from __future__ import annotations

import os
import secrets
import threading
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from pydantic import Field

from physagent_jax.agents.llm.base import ChatMessage, Generation, ModelError, import_package
from physagent_jax.agents.llm.completions import format_message, format_schema, read_completion
from physagent_jax.core.reading import check_regular, shorten
from physagent_jax.core.strict import Strict

_LARGEST_FILE = 2**41  # bytes


class LlamaOptions(Strict):
    """Options of the adapter `llama`.

    Attributes:
        path: The GGUF file.
        threads: Threads that compute; None = one for each core that nothing else uses now.
        context: Longest prompt and answer together [tokens].
        max_tokens: Longest answer [tokens].
        timeout: Longest wait for one answer [s].
    """

    path: Path
    threads: int | None = Field(default=None, ge=1, le=1024)
    context: int = Field(default=8192, ge=128, le=2**20)
    max_tokens: int = Field(default=2_000, ge=1, le=1_000_000)
    timeout: float = Field(default=600.0, ge=0.01, le=86_400)


class LlamaModel:
    """A model of a GGUF file, greedy; a JSON schema is enforced token by token.

    llama.cpp also listens on a loopback port; a random key keeps others out of it.

    Args:
        options: Those of `LlamaOptions`.

    Attributes:
        url, key: Address and key of that port.
    """

    def __init__(self, **options: Any):
        self._options = LlamaOptions(**options)
        path = self._options.path
        check_regular(path, most=_LARGEST_FILE, what="the model's file")
        xllamacpp = import_package("xllamacpp", "llama", "llama")
        self.name, self.has_eyes = f"llama:{path.stem}", False
        self.key = secrets.token_hex(16)
        params = xllamacpp.CommonParams()
        params.model.path = str(path)
        params.n_ctx, params.n_parallel, params.api_keys = self._options.context, 1, [self.key]
        threads = self._options.threads or count_free_cores()
        params.cpuparams.n_threads = params.cpuparams_batch.n_threads = threads
        params.verbosity, params.warmup, params.cache_ram_mib = 0, False, 0
        try:
            self._server: Any = xllamacpp.Server(params)
        except RuntimeError as error:
            raise ModelError(f"the model's file {shorten(path)} cannot be loaded", got=error) from None
        self.url = f"{self._server.listening_address}/v1"

    def close(self) -> None:
        """Stop the threads of llama.cpp and free the memory; they stop with the process otherwise."""
        self._server = None

    def generate(
        self, messages: Sequence[ChatMessage], schema: Mapping[str, Any] | None = None
    ) -> Generation:
        """Answer ``messages``; see `ChatModel`."""
        request = {
            "messages": [format_message(each) for each in messages],
            "max_tokens": self._options.max_tokens,
            "temperature": 0.0,
            "stream": True,
            "stream_options": {"include_usage": True},
        }
        if schema is not None:
            request["response_format"] = format_schema(schema)
        begun = time.monotonic()
        try:
            completion = self._stream(request)
            return read_completion(completion, self._options.path.stem, time.monotonic() - begun)
        except (TimeoutError, RuntimeError, ValueError) as error:
            late = isinstance(error, TimeoutError)
            why = f"no answer within {self._options.timeout:g} s" if late else shorten(error)
            seconds = time.monotonic() - begun
            raise ModelError(
                f"{self.name} gave no answer: {why}", latency_seconds=seconds, failures=(why,)
            ) from None

    def _stream(self, request: dict[str, Any]) -> dict[str, Any]:
        """Generate in a thread, which ends at the next token if this one is interrupted or waits too long."""
        chunks: list[dict[str, Any]] = []
        stop = threading.Event()

        def take(chunk: dict[str, Any]) -> bool:
            chunks.append(chunk)
            return stop.is_set()

        with ThreadPoolExecutor(1) as pool:
            try:
                pool.submit(self._server.handle_chat_completions, request, take).result(self._options.timeout)
            finally:
                stop.set()
        return _join(chunks)


def _join(chunks: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The completion that streamed chunks are parts of.

    Raises:
        RuntimeError: One of them is an error.
    """
    for chunk in chunks:
        if "error" in chunk:
            raise RuntimeError(chunk["error"].get("message", chunk["error"]))
    choices = [each["choices"][0] for each in chunks if each.get("choices")]
    text = "".join(each["delta"].get("content") or "" for each in choices)
    reason = next((each["finish_reason"] for each in reversed(choices) if each.get("finish_reason")), None)
    usage = next((each["usage"] for each in reversed(chunks) if each.get("usage")), None)
    return {"choices": [{"message": {"content": text}, "finish_reason": reason}], "usage": usage}


def count_free_cores() -> int:
    """Cores of this process that nothing else uses, by the load of the last minute; at least 1."""
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    return max(1, round(usable - load))
