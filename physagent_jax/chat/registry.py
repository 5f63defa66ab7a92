"""The chat models that a run may choose by name."""

from __future__ import annotations

from pathlib import Path

from pydantic import ValidationError

from physagent_jax.chat.base import ChatModel
from physagent_jax.chat.replay import Recorder
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
