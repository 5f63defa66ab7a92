"""Names that are looked up in a closed list."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

from physagent_jax.core.errors import UserError

_LISTED = 12  # names at most that a message lists in full


def find_nearest(name: str, known: Iterable[str], count: int = 3) -> list[str]:
    """Up to ``count`` of the ``known`` names that ``name`` may be a misspelling of, the nearest first."""
    by_key = {_normalise(each): each for each in known}
    close = difflib.get_close_matches(_normalise(name[:80]), by_key, n=count, cutoff=0.6)
    return [by_key[each] for each in close]


def suggest(name: str, known: Iterable[str]) -> str:
    """A sentence that names the nearest; a short list is given whole; "" if nothing is near."""
    known = list(known)
    near = find_nearest(name, known)
    if near:
        return f"Did you mean {' or '.join(f'`{each}`' for each in near)}?"
    return f"Known: {', '.join(known)}." if 0 < len(known) <= _LISTED else ""


def explain_unknown_name(what: str, name: object, known: Iterable[str], do: str = "") -> UserError:
    """The error for a ``name`` that is not one of the ``known``.

    Args:
        what: What is named, as the user would say ("`--kind`").
        name: What was got.
        known: What there is.
        do: What else to do.
    """
    hint = suggest(name, known) if isinstance(name, str) else ""
    return UserError(f"{what} is not known", got=repr(name)[:80], do=f"{hint} {do}".strip())


def _normalise(name: str) -> str:
    return name.strip().lower().replace("-", "_").replace(" ", "_")


def count_slips(first: str, second: str) -> int:
    """Letters to add, leave out or change to make one word of the other (Levenshtein)."""
    row = list(range(len(second) + 1))
    for i, a in enumerate(first, 1):
        above, row[0] = row[0], i
        for j, b in enumerate(second, 1):
            above, row[j] = row[j], min(row[j] + 1, row[j - 1] + 1, above + (a != b))
    return row[-1]
