"""A chat model in process from a folder of weights, by the package `transformers`."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from physagent_jax.agents.llm.base import (
    ChatMessage,
    Generation,
    ModelError,
    Usage,
    import_package,
    read_json_or_none,
)
from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import shorten
from physagent_jax.core.strict import Strict

_PACKAGES = ("torch", "transformers")


class TransformersOptions(Strict):
    """Options of the adapter `transformers`.

    Attributes:
        path: Folder with the configuration, the tokenizer and the weights as safetensors.
        device: Device of torch; "auto" = a GPU if there is one.
        max_tokens: Longest answer [tokens].
        timeout: Time after which an answer is cut [s].
        thinking: Whether the model may write its thoughts first, if its chat template asks that.
    """

    path: Path
    device: Annotated[str, Field(max_length=40)] = "auto"
    max_tokens: int = Field(default=2_000, ge=1, le=1_000_000)
    timeout: float = Field(default=600.0, ge=0.01, le=86_400)
    thinking: bool = False


class TransformersModel:
    """A model of a local folder, greedy; nothing is downloaded and no code of the folder is run.

    It is held to no schema: the prompt states it, and answers that break it are asked for again.

    Args:
        options: Those of `TransformersOptions`.
    """

    def __init__(self, **options: Any):
        self._options = TransformersOptions(**options)
        path = self._options.path
        if not (path / "config.json").is_file():
            raise UserError(
                f"there is no model in the folder {shorten(path)}", do="Name the one with config.json"
            )
        torch, transformers = (import_package(each, "transformers", "models") for each in _PACKAGES)
        self.name, self.has_eyes = f"transformers:{path.resolve().name}", False
        self._torch = torch
        device = self._options.device
        if device == "auto":
            device = "cuda" if torch.cuda.is_available() else "cpu"
        local = {"local_files_only": True, "trust_remote_code": False}
        try:
            self._tokenizer = transformers.AutoTokenizer.from_pretrained(path, **local)
            model = transformers.AutoModelForCausalLM.from_pretrained(
                path, dtype="auto", use_safetensors=True, **local
            )
            self._model: Any = model.to(device).eval()
        except (OSError, ValueError, KeyError, RuntimeError, ImportError) as error:
            raise ModelError(f"the model in {shorten(path)} cannot be loaded", got=shorten(error)) from None
        if not self._tokenizer.chat_template:
            raise UserError(f"the model in {shorten(path)} has no chat template", do="Take an instruct model")

    def close(self) -> None:
        """Free the memory."""
        self._model = None

    def generate(
        self, messages: Sequence[ChatMessage], schema: Mapping[str, Any] | None = None
    ) -> Generation:
        """Answer ``messages``; see `ChatModel`."""
        if any(each.pictures for each in messages):
            raise ModelError(f"{self.name} takes no pictures")
        begun = time.monotonic()
        try:
            inputs = self._tokenizer.apply_chat_template(
                [{"role": each.role, "content": each.text} for each in messages],
                add_generation_prompt=True,
                enable_thinking=self._options.thinking,
                return_dict=True,
                return_tensors="pt",
            ).to(self._model.device)
            with self._torch.inference_mode():
                written = self._model.generate(
                    **inputs,
                    do_sample=False,
                    temperature=None,
                    top_p=None,
                    top_k=None,
                    max_new_tokens=self._options.max_tokens,
                    max_time=self._options.timeout,
                    pad_token_id=self._tokenizer.pad_token_id or self._tokenizer.eos_token_id,
                )
        except (
            RuntimeError,
            ValueError,
            IndexError,
        ) as error:  # memory, context, a template that refuses a role
            seconds, why = time.monotonic() - begun, shorten(error)
            raise ModelError(
                f"{self.name} gave no answer: {why}", latency_seconds=seconds, failures=(why,)
            ) from None
        count = inputs["input_ids"].shape[1]
        new = written[0, count:].tolist()
        text = self._tokenizer.decode(new, skip_special_tokens=True)
        ends = self._model.generation_config.eos_token_id
        cut = not new or new[-1] not in (ends if isinstance(ends, list) else [ends])
        usage, seconds = Usage(count, len(new)), time.monotonic() - begun
        return Generation(text, read_json_or_none(text), usage, seconds, self._options.path.name, cut=cut)
