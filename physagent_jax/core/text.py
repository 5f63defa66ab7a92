"""Sentences of texts for people."""

from __future__ import annotations

import re


def split_reason(text: str) -> tuple[str, str]:
    """The first sentence of a text, which says why in plain words, and the rest."""
    first, *rest = re.split(r"(?<=[.!?])\s+(?=\S)", text.strip(), maxsplit=1)
    return first, "".join(rest)
