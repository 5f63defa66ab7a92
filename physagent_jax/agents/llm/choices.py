"""Types of a form's fields: closed lists of words, and plain text."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Annotated, Any

from pydantic import AfterValidator, Field, GetCoreSchemaHandler
from pydantic_core import PydanticCustomError, core_schema


class OneOf:
    """Annotation of a string that is one of some words; they are listed when they are needed, not before."""

    def __init__(self, list_words: Callable[[], Iterable[str]]):
        self._list_words = list_words

    def _check(self, word: str) -> str:
        words = list(self._list_words())
        if word not in words:
            raise PydanticCustomError("enum", "Input should be one of {words}", {"words": ", ".join(words)})
        return word

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler):
        """Validation against the words."""
        return core_schema.no_info_after_validator_function(self._check, handler(source))

    def __get_pydantic_json_schema__(self, *_: Any) -> dict[str, Any]:
        """An enumeration of the words."""
        return {"type": "string", "enum": list(self._list_words())}


def _make_plain(text: str) -> str:
    """The text on one line; what is not printable, a terminal's escapes among it, becomes a space."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


Phrase = Annotated[str, Field(max_length=200), AfterValidator(_make_plain)]
Sentences = Annotated[str, Field(max_length=2000), AfterValidator(_make_plain)]
