"""Types of a form's fields: closed lists of words, and plain text."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Annotated

from pydantic import AfterValidator, Field, GetPydanticSchema
from pydantic_core import PydanticCustomError, core_schema


def one_of(list_words: Callable[[], Iterable[str]]) -> GetPydanticSchema:
    """Annotation of a string that is one of some words; they are listed when they are needed, not before."""

    def check(word: str) -> str:
        words = list(list_words())
        if word not in words:
            raise PydanticCustomError("enum", "Input should be one of {words}", {"words": ", ".join(words)})
        return word

    return GetPydanticSchema(
        lambda source, handler: core_schema.no_info_after_validator_function(check, handler(source)),
        lambda _schema, _handler: {"type": "string", "enum": list(list_words())},
    )


def _make_plain(text: str) -> str:
    """The text on one line; what is not printable, a terminal's escapes among it, becomes a space."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


Phrase = Annotated[str, Field(max_length=200), AfterValidator(_make_plain)]
Sentences = Annotated[str, Field(max_length=2000), AfterValidator(_make_plain)]
