"""Reading, checking and writing scene files."""

from __future__ import annotations

import json
from pathlib import Path

from pydantic import ValidationError

from physagent_jax.core.errors import UserError
from physagent_jax.scene.config.scene import SceneConfig


def load_scene(path: str | Path) -> SceneConfig:
    """Reads and validates a scene file.

    Raises:
        UserError: The file is missing, not JSON, or breaks the schema (the message names the field).
    """
    return parse_scene(load_json(path), origin=str(path))


def load_json(path: str | Path) -> object:
    """Decodes a JSON file.

    Raises:
        UserError: The file is missing or not JSON (NaN and Infinity are not).
    """
    path = Path(path)

    def refuse(constant: str):
        raise UserError(
            f"{path} holds {constant}, which is not a number", do="Replace it with a finite number"
        )

    try:
        return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)
    except OSError as error:
        raise UserError(f"cannot read {path}", got=error.strerror, do="Check the path") from None
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise UserError(f"{path} is not valid JSON", got=error, do="Mend the file or make it anew") from None


def parse_scene(data: object, *, origin: str = "scene") -> SceneConfig:
    """Validates decoded JSON as a scene; ``origin`` names it in messages."""
    try:
        return SceneConfig.model_validate(data)
    except ValidationError as error:
        raise validation_message(error, origin) from None


def validation_message(error: ValidationError, origin: str) -> UserError:
    """The first of pydantic's complaints as one line that names the field, what was got, what to do."""
    first = error.errors()[0]
    field = ".".join(str(part) for part in first["loc"]) or "(top level)"
    message = first["msg"].removeprefix("Value error, ")
    more = error.error_count() - 1
    extra = f" ({more} more problem{'s' if more > 1 else ''} in the file)" if more else ""
    got = first["input"]
    shown = (
        repr(got) if isinstance(got, (str, int, float, bool, type(None), list, tuple)) else type(got).__name__
    )
    return UserError(
        f"{origin}: field `{field}`: {message}{extra}",
        got=shown if len(shown) < 80 else shown[:77] + "...",
        do="`physagent schema` prints the schema",
    )


def dump_scene(config: SceneConfig) -> str:
    """Canonical JSON text: the same config gives the same bytes."""
    return json.dumps(config.model_dump(mode="json"), indent=2, ensure_ascii=False) + "\n"
