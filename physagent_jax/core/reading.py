"""Reading what comes from outside: files of bounded size, JSON of bounded shape, and schemas filled from it.

Every reader of the package goes through `open_regular`, so that a device, a pipe, a folder, a name that the
system cannot take and a file that is far too large are each refused in one line, and never waited for.
"""

from __future__ import annotations

import contextlib
import io
import json
import math
import os
import re
import stat
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError

from physagent_jax.core.errors import UserError
from physagent_jax.core.names import suggest

Schema = TypeVar("Schema", bound=BaseModel)

MIB = 2**20
JSON_BYTES = 32 * MIB  # a record of 10,000 frames has 10 MiB
JSON_DEPTH = 64
YAML_BYTES = 2**16  # its reader is slow, and nobody writes more by hand
YAML_SUFFIXES = (".yaml", ".yml")
JSON_DIGITS = 400  # of one number; the largest float written out has 309
_MISSPELT = ("extra_forbidden", "enum", "literal_error", "union_tag_invalid")  # as pydantic calls them
_SHOWN = 80  # characters of a name or value in a message

_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)
_MARKS = {
    b"\xef\xbb\xbf": "a byte order mark",
    b"\xff\xfe": "UTF-16",
    b"\xfe\xff": "UTF-16",
}


# --- files ---------------------------------------------------------------------------------------------


def open_regular(path: str | Path, *, most: int, what: str = "the file") -> io.BufferedReader:
    """Open a regular file of at most ``most`` bytes for reading; links are followed.

    Args:
        path: The file.
        most: Largest size [bytes].
        what: What it is to the user, for messages ("the anchor mask").

    Raises:
        UserError: There is none, it cannot be read, is no regular file, or is larger.
    """
    shown = shorten(path)
    try:
        # Without O_NONBLOCK, opening a pipe waits for somebody to write into it.
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0))
    except FileNotFoundError:
        name = what.removeprefix("the ")
        raise UserError(f"cannot read: there is no {name} {shown}", do="Check the path") from None
    except OSError as error:
        raise UserError(
            f"cannot read {what} {shown}", got=error.strerror or error, do="Check the path"
        ) from None
    except ValueError as error:  # a NUL, or characters that the file system's encoding lacks
        reason = "a name that is not text" if isinstance(error, UnicodeError) else error
        raise UserError(f"cannot read {what} {shown}", got=reason, do="Check the path") from None
    status = os.fstat(handle)
    if stat.S_ISREG(status.st_mode) and status.st_size <= most:
        return io.BufferedReader(_RegularFile(handle, f"{what} {shown}"))
    os.close(handle)
    if stat.S_ISREG(status.st_mode):
        raise _make_size_error(what, shown, status.st_size, most)
    kind = next((name for holds, name in _KINDS if holds(status.st_mode)), "no regular file")
    raise UserError(f"cannot read {what} {shown}", got=kind, do="Give a regular file")


class _RegularFile(io.FileIO):
    """A file whose failures to be read are a `UserError`, whoever reads it and when."""

    def __init__(self, handle: int, shown: str):
        super().__init__(handle, "rb")
        self._shown = shown

    def readinto(self, buffer: Any) -> int | None:
        with self._explaining():
            return super().readinto(buffer)

    def readall(self) -> bytes | None:
        with self._explaining():
            return super().readall()

    @contextlib.contextmanager
    def _explaining(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            reason = error.strerror or error
            raise UserError(f"cannot read {self._shown}", got=reason, do="Check the disk") from None


def check_regular(path: str | Path, *, most: int, what: str = "the file") -> int:
    """Size of a file [bytes] that a library reads by its name; raises as `open_regular`."""
    with open_regular(path, most=most, what=what) as file:
        return os.fstat(file.fileno()).st_size


def read_bytes(path: str | Path, *, most: int, what: str = "the file") -> bytes:
    """A file's bytes; raises as `open_regular`."""
    with open_regular(path, most=most, what=what) as file:
        told = os.fstat(file.fileno()).st_size
        data = file.read(told + 1)  # not `most`: as much memory would be taken at once
        if len(data) > told:
            data += file.read(most + 1 - len(data))
    if len(data) > most:  # the system told another size, as for what it makes up while it is read
        raise _make_size_error(what, shorten(path), len(data), most)
    return data


def check_counts(place: str, what: str, count: int, each: float, available: int) -> None:
    """Refuse a file that announces more than it can hold, before memory is taken for it.

    Args:
        place: The file, and where in it.
        what: What is counted ("vertices").
        count: How many the file announces.
        each: Least size of one of them [bytes].
        available: What the file has for them [bytes].

    Raises:
        UserError: ``count`` is negative, or they do not fit.
    """
    if count < 0 or count * each > available:
        raise UserError(
            f"{place} is truncated or damaged: it announces more than it holds",
            got=f"{_format_count(count)} {what} of {each:g} bytes or more in {max(available, 0):,} bytes",
            do="Copy or export the file again",
        )


# --- JSON ----------------------------------------------------------------------------------------------


def read_json(path: str | Path, *, what: str = "the file") -> Any:
    """Decode a JSON file.

    Raises:
        UserError: As `open_regular` and `decode_json`.
    """
    return decode_json(read_bytes(path, most=JSON_BYTES, what=what), shorten(path))


def decode_json(data: bytes, origin: str) -> Any:
    """Decode JSON; ``origin`` names it in messages.

    Raises:
        UserError: It is not JSON in UTF-8, has more than `JSON_BYTES`, is nested more than `JSON_DEPTH` deep, or
            holds a number that is not finite, is an integer beyond 64 bits or has more than `JSON_DIGITS` digits.
    """
    if len(data) > JSON_BYTES:
        raise _make_size_error("the JSON of", origin, len(data), JSON_BYTES)
    for mark, name in _MARKS.items():
        if data.startswith(mark):
            raise UserError(
                f"{origin} is not valid JSON: it begins with {name}",
                do="Save it as UTF-8 without a byte order mark",
            )

    def refuse(constant: str):
        raise UserError(
            f"{origin} holds {constant}, which is not a number", do="Replace it with a finite number"
        )

    def number(literal: str, kind: type) -> Any:
        if len(literal) > JSON_DIGITS:
            raise UserError(f"{origin} holds a number of {len(literal)} digits", do="Round it")
        value = kind(literal)
        if not (math.isfinite(value) if kind is float else -(2**63) <= value < 2**64):
            raise UserError(
                f"{origin} holds a number that is too large", got=shorten(literal, 40), do="Mend it"
            )
        return value

    try:
        text = data.decode("utf-8")
        decoded = json.loads(
            text,
            parse_constant=refuse,
            parse_int=lambda literal: number(literal, int),
            parse_float=lambda literal: number(literal, float),
        )
    except UnicodeDecodeError as error:
        raise UserError(
            f"{origin} is not valid JSON: it is not UTF-8", got=error, do="Save it as UTF-8"
        ) from None
    except json.JSONDecodeError as error:
        raise UserError(
            f"{origin} is not valid JSON", got=error, do="Mend the file or make it anew"
        ) from None
    except RecursionError:
        raise _make_depth_error(origin) from None
    _check_depth(decoded, origin)
    if "\\ud" in text.lower():
        _check_text(decoded, origin)
    return decoded


def read_yaml(path: str | Path, *, what: str = "the file") -> Any:
    """Decode a YAML file of plain values; what JSON cannot hold (dates, binary, references) is refused.

    Raises:
        UserError: As `open_regular` and `decode_json`, or it is not YAML.
    """
    import yaml

    data, origin = read_bytes(path, most=YAML_BYTES, what=what), shorten(path)
    try:
        text = data.decode("utf-8")
        # A reference may stand for itself, or for a thousand others: a document of a few lines could fill the memory.
        references = any(isinstance(event, yaml.AliasEvent) for event in yaml.parse(text, yaml.SafeLoader))
        decoded = None if references else yaml.safe_load(text)
        plain = json.dumps(decoded)
    except RecursionError:
        raise _make_depth_error(origin) from None
    except (yaml.YAMLError, ValueError, TypeError, OverflowError) as error:
        raise UserError(f"{origin} is not YAML of plain values", got=shorten(error), do="Mend it") from None
    if references:
        raise UserError(f"{origin} holds references (*name)", do="Write out what they stand for")
    return decode_json(plain.encode(), origin)


def read_packaged_yaml(package: str, name: str) -> Any:
    """Decode a YAML file that comes with a package; it is trusted."""
    import yaml

    text = (resources.files(package) / name).read_text(encoding="utf-8")
    return yaml.load(text, getattr(yaml, "CSafeLoader", yaml.SafeLoader))


def _check_text(decoded: Any, origin: str) -> None:
    """Refuse halves of surrogate pairs, which JSON can spell and no file can be written with."""
    try:
        json.dumps(decoded, ensure_ascii=False).encode("utf-8")
    except UnicodeEncodeError as error:
        half = ascii(error.object[error.start])
        raise UserError(f"{origin} holds half a character", got=half, do="Mend the text") from None


def _check_depth(decoded: Any, origin: str) -> None:
    level, depth = [decoded], 0
    while level := [each for each in level if isinstance(each, dict | list)]:
        depth += 1
        if depth > JSON_DEPTH:
            raise _make_depth_error(origin)
        level = [inner for each in level for inner in (each.values() if isinstance(each, dict) else each)]


# --- schemas -------------------------------------------------------------------------------------------


def read_model(path: str | Path, schema: type[Schema], *, what: str = "the file") -> Schema:
    """Read a JSON file as ``schema``.

    Raises:
        UserError: As `read_json`, or it breaks the schema; the message names the field.
    """
    return parse_model(read_json(path, what=what), schema, shorten(path))


def parse_model(data: Any, schema: type[Schema], origin: str) -> Schema:
    """Validate decoded JSON as ``schema``; ``origin`` names it in messages.

    Raises:
        UserError: It breaks the schema; the message names the field.
    """
    try:
        return schema.model_validate(data)
    except ValidationError as error:
        raise format_validation_error(error, origin, schema) from None


def format_validation_error(
    error: ValidationError,
    origin: str,
    schema: type[BaseModel] | None = None,
    do: str = "`physagent schema` prints the schema",
) -> UserError:
    """The first of pydantic's complaints as one line that names the field, what was got, what to do.

    Args:
        error: What pydantic raised.
        origin: The file or command line that the values are from.
        schema: What was validated: tells which key an unknown one is near to.
        do: What to do.
    """
    complaints = error.errors(include_url=False)
    # A misspelt key often comes with a complaint that the right one is missing.
    first = next((each for each in complaints if each["type"] in _MISSPELT), complaints[0])
    field = shorten(".".join(str(part) for part in first["loc"]), _SHOWN) or "(top level)"
    message = first["msg"].removeprefix("Value error, ")
    more = error.error_count() - 1
    extra = f" ({more} more problem{'s' if more > 1 else ''})" if more else ""
    got = first["input"]
    shown = repr(got) if isinstance(got, str | int | float | list | tuple | None) else type(got).__name__
    hint = suggest(*_find_misspelt(first, schema))
    return UserError(
        f"{origin}: field `{field}`: {message}{extra}",
        got=shorten(shown, _SHOWN),
        do=f"{hint} {do}".strip(),
    )


def _find_misspelt(complaint: Any, schema: type[BaseModel] | None) -> tuple[str, list[str]]:
    """The word that was not understood, and those that would have been."""
    context = complaint.get("ctx", {})
    match complaint["type"]:
        case "extra_forbidden" if schema is not None:
            *place, word = complaint["loc"]
            return str(word), sorted(_list_keys(schema, place))
        case "enum" | "literal_error":
            return str(complaint["input"]), re.findall(r"'([^']*)'", str(context["expected"]))
        case "union_tag_invalid":
            return str(context["tag"]), re.findall(r"'([^']*)'", str(context["expected_tags"]))
    return "", []


def _list_keys(annotation: Any, place: list) -> set[str]:
    """Keys that the schema has at a place in the data; a member of a union goes by its tag."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        fields = annotation.model_fields
        if not place:
            return set(fields)
        if place[0] in fields:
            return _list_keys(fields[place[0]].annotation, place[1:])
        tags = {field.default for field in fields.values() if isinstance(field.default, str)}
        return _list_keys(annotation, place[1:]) if place[0] in tags else set()
    arguments = [each for each in get_args(annotation) if each is not Ellipsis]
    if get_origin(annotation) in (tuple, list, dict):
        place = place[1:]
    return set().union(*(_list_keys(each, place) for each in arguments))


# --- words ---------------------------------------------------------------------------------------------


def shorten(text: object, length: int = 200) -> str:
    """``text`` as a message can show it: not longer than ``length``, every character printable."""
    text = str(text)
    text = text if len(text) <= length else f"{text[: length - 3]}..."
    return text if text.isprintable() else "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def _format_count(count: int) -> str:
    return f"{count:,}" if abs(count) < 2**64 else "more than 2^64"


def _make_size_error(what: str, shown: str, size: int, most: int) -> UserError:
    return UserError(
        f"{what} {shown} is too large to be read",
        got=f"{size:,} bytes, at most {most:,} are read",
        do="Check that it is the right file",
    )


def _make_depth_error(origin: str) -> UserError:
    return UserError(f"{origin} is nested too deeply", do=f"Use at most {JSON_DEPTH} levels")
