"""The chat models that a run may choose by name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import ValidationError

from physagent_jax.chat.base import ChatModel
from physagent_jax.chat.replay import Recorder
from physagent_jax.core.errors import UserError
from physagent_jax.core.reading import format_validation_error
from physagent_jax.core.registry import Choice, Registry

_HERE = "physagent_jax.chat"
MODELS = Registry(
    "`--llm`",
    {
        "openai": f"{_HERE}.openai_client:OpenAIModel",
        "transformers": f"{_HERE}.transformers_client:TransformersModel",
        "llama": f"{_HERE}.llama_client:LlamaModel",
        "replay": f"{_HERE}.replay:ReplayModel",
    },
)


def locate_model(place: str) -> tuple[str, dict[str, Any]]:
    """The choice of the model at a place: a GGUF file, a cassette (.jsonl), or a server's URL#MODEL.

    Raises:
        UserError: The place is of none of these kinds.
    """
    if "://" in place:
        url, _, model = place.partition("#")
        if not model:
            raise UserError("a server's model has a name", got=place, do="Give URL#MODEL")
        return "openai", {"url": url, "model": model}
    if not place:
        raise UserError("no model is named", do="Give a GGUF file, a cassette (.jsonl) or URL#MODEL")
    return "replay" if place.endswith(".jsonl") else "llama", {"path": place}


def make_model(choice: Choice, *, record: str | Path | None = None) -> ChatModel:
    """The chat model that is chosen: a name of `MODELS` or a server's address, with the options of the model.

    With ``record``, its answers are kept in that cassette.

    Raises:
        UserError: There is no such model, its package is missing, or an option is wrong.
    """
    name, options = (choice, {}) if isinstance(choice, str) else choice
    if "://" in name:
        name, options = "openai", {"url": name, **options}
    try:
        model = MODELS.make((name, options))
    except ValidationError as error:
        do = "Change the options of the model"
        raise format_validation_error(error, f"`--llm` {name!r}", do=do) from None
    return model if record is None else Recorder(model, record)
