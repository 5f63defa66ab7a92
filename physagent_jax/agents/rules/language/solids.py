"""Walls and blocks that a sentence names, and where they are: "the wall on the right", "into the left wall"."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from physagent_jax.agents.rules.language.modifiers import OBSTACLES, Names
from physagent_jax.agents.rules.language.tokens import Token

_SIDES: dict[str, Names] = {
    "left": ("left",),
    "right": ("right",),
    "front": ("toward",),
    "back": ("away",),
    "rear": ("away",),
}
_PLACES: dict[str, Names] = {"behind": ("away",), "above": ("up",), "overhead": ("up",), "below": ("down",)}
_DETERMINERS = frozenset(
    {"a", "an", "the", "its", "his", "some", "two", "solid", "hard", "big", "brick", "stone"}
)
_WAYS = frozenset(
    {"against", "into", "onto", "on", "at", "off", "over", "hit", "hits", "hitting", "strike", "strikes"}
)
_PLATES = frozenset({"walls", "plates", "plate", "boards", "blocks", "wall"})


@dataclass(frozen=True)
class Solid:
    """A wall or block as the sentence has it.

    Attributes:
        kind: "wall" or "block"; "" for plates that squeeze, which are no surroundings.
        names: Where it is, in the viewer's words; empty = wherever the motion goes.
        opposite: Where the other of two is; empty = there is one.
    """

    kind: Literal["wall", "block", ""]
    names: Names = ()
    opposite: Names = ()


def match_solid(tokens: list[Token], at: int, object_words: frozenset[str]) -> tuple[Solid, int] | None:
    """The solid whose name, or whose side before it, stands at ``tokens[at]``, and the index behind it."""
    text = _get(tokens, at)
    names: Names = ()
    noun_at = at
    if text in _SIDES and _get(tokens, at + 1) in OBSTACLES:
        names, noun_at = _SIDES[text], at + 1
    noun_at += _get(tokens, noun_at) in OBSTACLES and _get(tokens, noun_at + 1) in OBSTACLES  # "brick wall"
    noun = _get(tokens, noun_at)
    before = _find_way(tokens, at)
    if before == "between" and noun in _PLATES:
        return Solid(""), noun_at + 1
    if noun == "walls" and (pair := _match_pair(tokens, noun_at + 1, object_words)):
        return pair
    if noun not in OBSTACLES or noun in object_words:
        return None
    needs_way = OBSTACLES[noun] == "block" or noun == "ceiling"
    if needs_way and before not in _WAYS:
        return None
    kind: Literal["wall", "block"] = "block" if OBSTACLES[noun] == "block" else "wall"
    if noun == "ceiling":
        names = ("up",)
    elif kind == "block" and before in ("onto", "on"):
        names = ("down",)
    told, behind = _match_where(tokens, noun_at + 1, object_words)
    return Solid(kind, told or names), behind


def _match_pair(tokens: list[Token], at: int, object_words: frozenset[str]) -> tuple[Solid, int] | None:
    """Reads "(walls) left and right of it", "on both sides", "on the left and on the right"."""
    words = [_get(tokens, at + i) for i in range(7) if _get(tokens, at + i) not in ("the", "its", "to")]
    for phrase in (
        ("left", "and", "right"),
        ("on", "left", "and", "right"),
        ("on", "both", "sides"),
        ("on", "either", "side"),
    ):
        if tuple(words[: len(phrase)]) == phrase:
            behind = at
            for _ in phrase:
                while _get(tokens, behind) in ("the", "its", "to"):
                    behind += 1
                behind += 1
            behind = (
                _skip_object(tokens, behind + 1, object_words) if _get(tokens, behind) == "of" else behind
            )
            return Solid("wall", ("left",), ("right",)), behind
    return None


def _find_way(tokens: list[Token], at: int) -> str:
    """The word before the name, past articles and adjectives."""
    before = at - 1
    while before >= 0 and tokens[before].text in _DETERMINERS:
        before -= 1
    return _get(tokens, before)


def _match_where(tokens: list[Token], at: int, object_words: frozenset[str]) -> tuple[Names, int]:
    """Reads "on the right side", "to the left of it", "behind it", "in front of the robot"."""
    first = _get(tokens, at)
    if first in _PLACES:
        return _PLACES[first], _skip_object(tokens, at + 1, object_words)
    if (first, _get(tokens, at + 1)) == ("in", "front"):
        return ("toward",), _skip_object(tokens, at + 2 + (_get(tokens, at + 2) == "of"), object_words)
    if first not in ("on", "at", "to"):
        return (), at
    side_at = at + 1 + (_get(tokens, at + 1) in ("the", "its", "his", "our"))
    side = _get(tokens, side_at)
    if side not in _SIDES:
        return (), at
    behind = side_at + 1 + (_get(tokens, side_at + 1) in ("side", "hand"))
    owned = _get(tokens, behind) == "of"
    if first == "to" and not owned:  # "against the wall to the left" tells the way
        return (), at
    return _SIDES[side], _skip_object(tokens, behind + 1, object_words) if owned else behind


def _skip_object(tokens: list[Token], at: int, object_words: frozenset[str]) -> int:
    """Past "it" or "the robot"."""
    if _get(tokens, at) in ("it", "him", "her"):
        return at + 1
    return at + 2 if _get(tokens, at) == "the" and _get(tokens, at + 1) in object_words else at


def _get(tokens: list[Token], at: int) -> str:
    return tokens[at].text if 0 <= at < len(tokens) else ""
