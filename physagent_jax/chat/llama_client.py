"""A chat model in process from a GGUF file, by llama.cpp's package `xllamacpp`."""

from __future__ import annotations

import os
import secrets
import threading
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from pydantic import Field

from physagent_jax.chat.base import Messages, ModelError, Schema
from physagent_jax.chat.completions import format_message, format_schema
from physagent_jax.chat.in_process import FileModel, FileOptions
from physagent_jax.core.packages import import_package
from physagent_jax.core.reading import check_regular, shorten

_LARGEST_FILE = 2**41  # bytes


class LlamaOptions(FileOptions):
    """Options of the adapter `llama`, beside those of `FileOptions`; the path is that of a GGUF file.

    Attributes:
        threads: Threads that compute; None = one for each core that nothing else uses now.
        context: Longest prompt and answer together [tokens].
        prompt_cache: Memory for prompts that were read before [MiB]. Agents ask in turn, each with a long prompt of its
            own: what a prompt has in common with an earlier one is not read again.
    """

    threads: int | None = Field(default=None, ge=1, le=1024)
    context: int = Field(default=8192, ge=128, le=2**20)
    prompt_cache: int = Field(default=1024, ge=0, le=2**20)


class LlamaModel(FileModel):
    """A model of a GGUF file, with `LlamaOptions`, greedy; a JSON schema is enforced token by token.

    llama.cpp also listens on a loopback port, at ``url``; a random ``key`` keeps others out of it.
    """

    def __init__(self, **options: Any):
        self._options = chosen = LlamaOptions(**options)
        super().__init__("llama", chosen.path.stem, chosen.timeout)
        check_regular(chosen.path, most=_LARGEST_FILE, what="the model's file")
        xllamacpp = import_package("xllamacpp", "the chat model `llama`", "llama")
        self.key = secrets.token_hex(16)
        params = xllamacpp.CommonParams()
        params.model.path = str(chosen.path)
        params.n_ctx, params.n_parallel, params.api_keys = chosen.context, 1, [self.key]
        threads = chosen.threads or count_free_cores()
        params.cpuparams.n_threads = params.cpuparams_batch.n_threads = threads
        params.verbosity, params.warmup, params.cache_ram_mib = 0, False, chosen.prompt_cache
        try:
            self._server: Any = xllamacpp.Server(params)
        except RuntimeError as error:
            raise ModelError(f"the model's file {shorten(chosen.path)} cannot be loaded", got=error) from None
        self.url = f"{self._server.listening_address}/v1"

    def close(self) -> None:
        """Stop the threads of llama.cpp and free the memory; they stop with the process otherwise."""
        self._server = None

    def _complete(self, messages: Messages, schema: Schema | None) -> dict[str, Any]:
        """Generate in a thread, which ends at the next token if this one is interrupted or waits too long."""
        request = {
            "messages": [format_message(each) for each in messages],
            "max_tokens": self._options.max_tokens,
            "temperature": 0.0,
            "stream": True,
            "stream_options": {"include_usage": True},
        }
        if schema is not None:
            request["response_format"] = format_schema(schema)
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
    """The completion that streamed chunks are parts of; a `RuntimeError` if one of them is an error."""
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
    from physagent_jax.kernels.threads import core_count  # brings jax

    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    return max(1, round(core_count() - load))
