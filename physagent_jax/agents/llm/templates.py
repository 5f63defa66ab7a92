"""Prompts as files: `prompts/NAME.md` with {{placeholders}}, a system part and a user part."""

from __future__ import annotations

import functools
import json
import re
from collections.abc import Mapping
from importlib import resources

from physagent_jax.agents.llm.base import ChatMessage

_USER = "\n=== user ===\n"
_PLACE = re.compile(r"\{\{(\w+)\}\}")


def write_messages(
    name: str, values: Mapping[str, object], pictures: tuple[bytes, ...] = ()
) -> list[ChatMessage]:
    """The messages of a prompt.

    A value is put in once and not looked into, so that braces in a user's sentence stay what they are.

    Args:
        name: The prompt's file without its suffix.
        values: A text for each placeholder.
        pictures: PNG files that go with the user's part.
    """
    system, user = (_PLACE.sub(lambda found: str(values[found[1]]), part) for part in _read(name))
    return [ChatMessage("system", system.strip()), ChatMessage("user", user.strip(), pictures)]


def quote(text: str) -> str:
    """A user's text as one quoted line: no quotation mark or line break in it ends the quotation."""
    return json.dumps(" ".join(text.split()), ensure_ascii=False)


def list_rows(rows: Mapping[str, str]) -> str:
    """Names with their meanings, a line each."""
    return "\n".join(f"- {name}: {meaning}" for name, meaning in rows.items())


@functools.cache
def _read(name: str) -> tuple[str, str]:
    text = resources.files("physagent_jax.agents.llm").joinpath("prompts", f"{name}.md").read_text("utf-8")
    system, user = text.split(_USER)
    return system, user
