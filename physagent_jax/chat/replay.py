"""Recorded exchanges with chat models: a cassette is a JSONL file of requests with their answers.

A request is known by the sha256 of everything that is sent: messages, hashes of pictures, schema and model.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Literal

from pydantic import JsonValue

from physagent_jax.chat.base import ChatModel, Generation, Messages, ModelError, Schema, make_writable
from physagent_jax.core.errors import UserError
from physagent_jax.core.files import explain_write_error, make_folders
from physagent_jax.core.reading import decode_json, parse_model, read_bytes, shorten
from physagent_jax.core.strict import Strict

_MOST_BYTES = 2**28  # of a cassette
_SHOWN = 40  # characters of a difference


class SentMessage(Strict):
    """A message of a request, with the sha256 of its pictures."""

    role: Literal["system", "user", "assistant"]
    text: str
    pictures: tuple[str, ...] = ()


class Request(Strict):
    """Everything that a model is sent."""

    model: str
    has_eyes: bool = False
    schema_: dict[str, JsonValue] | None = None
    messages: tuple[SentMessage, ...]

    @property
    def key(self) -> str:
        """The sha256 of the request in canonical JSON."""
        text = json.dumps(self.model_dump(mode="json"), sort_keys=True, separators=(",", ":"))
        return _hash(text.encode())


class Entry(Strict):
    """One line of a cassette."""

    key: str
    request: Request
    answer: Generation


def read_cassette(path: Path) -> dict[str, Entry]:
    """The entries of a cassette by their keys.

    Raises:
        UserError: There is no such file, or a line is no entry or was changed.
    """
    entries = {}
    for number, line in enumerate(read_bytes(path, most=_MOST_BYTES, what="the cassette").splitlines(), 1):
        origin = f"{shorten(path)}, line {number}"
        entry = parse_model(decode_json(line, origin), Entry, origin)
        if entry.key != entry.request.key:
            raise UserError(f"{origin} was changed: its key is not that of its request", do="Record it again")
        entries[entry.key] = entry
    return entries


class ReplayModel:
    """A model that answers only what a cassette holds; ``model`` names one if it holds several."""

    def __init__(self, path: str | Path, model: str = ""):
        self._path, self._entries = Path(path), read_cassette(Path(path))
        recorded = {each.request.model: each.request.has_eyes for each in self._entries.values()}
        if (model and model not in recorded) or (not model and len(recorded) != 1):
            wrong = "does not hold this model" if model else "does not hold one model"
            known = f"It holds: {', '.join(recorded) or 'nothing'}"
            raise UserError(f"the cassette {shorten(path)} {wrong}", got=model or None, do=known)
        self._model = model or next(iter(recorded))
        self.name, self.has_eyes = f"replay:{self._model}", recorded[self._model]

    def close(self) -> None:
        """There is nothing to free."""

    def generate(self, messages: Messages, schema: Schema | None = None) -> Generation:
        """The recorded answer; see `ChatModel`."""
        request = _describe(self._model, self.has_eyes, messages, schema)
        if request.key not in self._entries:
            what = _find_difference(request, (each.request for each in self._entries.values()))
            do = "Record the exchange again, or ask what was asked then"
            raise ModelError(f"the cassette {shorten(self._path)} does not hold this request: {what}", do=do)
        return self._entries[request.key].answer


class Recorder:
    """A model whose answers are added to a cassette; what is in it already is not asked again."""

    def __init__(self, model: ChatModel, path: str | Path):
        self.name, self.has_eyes = model.name, model.has_eyes
        self._model, self._path, self.close = model, Path(path), model.close
        self._entries = read_cassette(self._path) if self._path.exists() else {}

    def generate(self, messages: Messages, schema: Schema | None = None) -> Generation:
        """The recorded answer, or a new one; see `ChatModel`."""
        request = _describe(self.name, self.has_eyes, messages, schema)
        if request.key not in self._entries:
            answer = self._model.generate(messages, schema)
            entry = Entry(key=request.key, request=request, answer=answer)
            try:
                make_folders(self._path.parent)
                with self._path.open("a", encoding="utf-8") as file:
                    file.write(entry.model_dump_json() + "\n")
            except OSError as error:
                raise explain_write_error(self._path, error) from None
            self._entries[entry.key] = entry
        return self._entries[request.key].answer


def _describe(model: str, has_eyes: bool, messages: Messages, schema: Schema | None) -> Request:
    sent = []
    for each in messages:
        pictures = tuple(map(_hash, each.pictures))
        sent.append(SentMessage(role=each.role, text=make_writable(each.text), pictures=pictures))
    asked = None if schema is None else dict(schema)
    return Request(model=model, has_eyes=has_eyes, schema_=asked, messages=tuple(sent))


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _find_difference(request: Request, recorded: Iterable[Request]) -> str:
    """The first thing in which a request differs from the recorded one that is most like it."""
    parts = _list_parts(request)
    found = [_compare(parts, _list_parts(other)) for other in recorded]
    return max(found, key=lambda each: each[0])[1]


def _list_parts(request: Request) -> dict[str, str]:
    """The parts of a request by their names, in the order in which they are compared."""
    parts = {"the model": request.model, "the schema": json.dumps(request.schema_, sort_keys=True)}
    for place, message in enumerate(request.messages, 1):
        parts[f"message {place}, {message.role}"] = message.text
        parts[f"the pictures of message {place}"] = " ".join(message.pictures)
    return parts | {"the model's sight": str(request.has_eyes)}


def _compare(asked: dict[str, str], recorded: dict[str, str]) -> tuple[int, str]:
    """The place of the first part that differs, and the difference in words."""
    parts = enumerate(asked | recorded)
    place, name = next((i, name) for i, name in parts if asked.get(name) != recorded.get(name))
    mine, theirs = asked.get(name), recorded.get(name)
    if mine is None or theirs is None:
        return place, f"{name} was {'recorded and is not' if mine is None else 'not recorded and is'} sent"
    at = len(os.path.commonprefix([mine, theirs]))
    excerpts = f"recorded {theirs[at : at + _SHOWN]!r}, asked {mine[at : at + _SHOWN]!r}"
    return place, f"{name} differs at character {at + 1}: {excerpts}"
