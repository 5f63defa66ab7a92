"""Models that benchmarks ask: opened when they are first needed, and where their answers are kept."""

from __future__ import annotations

import dataclasses
import functools
from pathlib import Path

from physagent_jax.chat.base import ChatModel
from physagent_jax.chat.registry import locate_model, make_model
from physagent_jax.core.errors import UserError
from physagent_jax.run.spec import Implementation


@dataclasses.dataclass(frozen=True)
class Asked:
    """A model of the command line.

    Attributes:
        text: "NAME=PLACE": a name for the tables, and a GGUF file, a cassette (.jsonl), or a server's address and the
            model's name as URL#MODEL.
        cassettes: Folder where answers are kept; a run that is stopped asks nothing twice.
    """

    text: str
    cassettes: Path

    @property
    def name(self) -> str:
        """The name in the tables."""
        return self.text.partition("=")[0]

    @property
    def place(self) -> str:
        """The place of the model, as `locate_model` has it.

        Raises:
            UserError: The text names none.
        """
        name, sign, place = self.text.partition("=")
        if not (name and sign and place):
            raise UserError("a model is NAME=PLACE", got=self.text, do="Pass small=models/small.gguf, say")
        return f"{place}#{name}" if "://" in place and "#" not in place else place

    @property
    def choice(self) -> Implementation:
        """The model as a run's spec would name it.

        Raises:
            UserError: The text names none.
        """
        kind, options = locate_model(self.place)
        return Implementation(name=kind, options=options)

    @property
    def record(self) -> str:
        """The cassette of its answers; "" = it is one itself."""
        return "" if self.choice.name == "replay" else str(self.cassettes / f"{self.name}.jsonl")

    def open(self) -> ChatModel:
        """The model; the same object whenever it is asked for."""
        return _open(self)


@functools.cache
def _open(asked: Asked) -> ChatModel:
    choice = asked.choice
    return make_model((choice.name, choice.options), record=asked.record or None)


def close_all(models: tuple[Asked, ...]) -> None:
    """Close the models that have been opened."""
    if _open.cache_info().currsize:
        for each in models:
            each.open().close()
    _open.cache_clear()
