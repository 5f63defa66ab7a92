"""A chat model in process from a folder of weights, by the package `transformers`."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from physagent_jax.chat.base import Messages, ModelError, Schema
from physagent_jax.chat.in_process import FileModel, FileOptions
from physagent_jax.core.errors import UserError
from physagent_jax.core.packages import import_package
from physagent_jax.core.reading import shorten


class TransformersOptions(FileOptions):
    """Options of the adapter `transformers`, beside those of `FileOptions`.

    The path is that of a folder with configuration, tokenizer and weights as safetensors.

    Attributes:
        device: Device of torch; "auto" = a GPU if there is one.
        thinking: Whether the model may write its thoughts first, if its chat template asks that.
    """

    device: Annotated[str, Field(max_length=40)] = "auto"
    thinking: bool = False


class TransformersModel(FileModel):
    """A model of a local folder, with `TransformersOptions`, greedy.

    Nothing is downloaded and no code of the folder is run. The model is held to no schema: the prompt states it, and
    answers that break it are asked for again. An answer that takes too long is cut.
    """

    def __init__(self, **options: Any):
        self._options = chosen = TransformersOptions(**options)
        super().__init__("transformers", chosen.path.resolve().name, chosen.timeout)
        path, device, shown = chosen.path, chosen.device, shorten(chosen.path)
        if not (path / "config.json").is_file():
            raise UserError(f"there is no model in the folder {shown}", do="Name the one with config.json")
        what = "the chat model `transformers`"
        torch = self._torch = import_package("torch", what, "models")
        transformers = import_package("transformers", what, "models")
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
            raise ModelError(f"the model in {shown} cannot be loaded", got=shorten(error)) from None
        if not self._tokenizer.chat_template:
            raise UserError(f"the model in {shown} has no chat template", do="Take an instruct model")

    def close(self) -> None:
        """Free the memory."""
        self._model = None

    def _complete(self, messages: Messages, schema: Schema | None) -> dict[str, Any]:
        del schema
        if any(each.pictures for each in messages):
            raise ValueError("it takes no pictures")
        tokenizer = self._tokenizer
        inputs = tokenizer.apply_chat_template(
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
                pad_token_id=tokenizer.pad_token_id or tokenizer.eos_token_id,
            )
        count = inputs["input_ids"].shape[1]
        new = written[0, count:].tolist()
        ends = self._model.generation_config.eos_token_id
        cut = not new or new[-1] not in (ends if isinstance(ends, list) else [ends])
        message = {"content": tokenizer.decode(new, skip_special_tokens=True)}
        return {
            "choices": [{"message": message, "finish_reason": "length" if cut else "stop"}],
            "usage": {"prompt_tokens": count, "completion_tokens": len(new)},
        }
