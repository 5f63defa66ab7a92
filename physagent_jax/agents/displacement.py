"""Phrases beside a push, a pull or a blow that say that the object ends elsewhere: "away", "aside", "off the table".

Without one, a push tells a direction only, and what is rooted bends: "push the plant to the left". A direction from
or to the viewer ("away from us") tells no more than that.
"""

from __future__ import annotations

from collections.abc import Sequence

HAULING_VERBS = frozenset({"drag", "haul", "tow"})
"""Verbs of pulling over the ground: what they take a told way leaves its place, as what slides or is carried does."""

_DETERMINERS = frozenset(
    {"the", "its", "his", "her", "their", "our", "your", "my", "this", "that", "a", "an"}
)
_VIEWERS = frozenset({"us", "me", "you", "viewer", "camera", "lens", "observer", "audience"})
# Each stands for a change of place, whatever follows it.
_ELSEWHERE: tuple[tuple[str, ...], ...] = (
    ("aside",),
    ("across",),
    ("elsewhere",),
    ("somewhere", "else"),
    ("closer",),
    ("nearer",),
    ("over", "there"),
    ("over", "here"),
    ("over", "to"),
    ("out", "of", "sight"),
    ("out", "of", "view"),
    ("out", "of", "reach"),
    ("out", "of", "frame"),
    ("out", "of", "shot"),
    ("out", "of", "range"),
)
_STATES = frozenset("balance centre center axis kilter line vertical plumb guard".split())  # "off balance"
_SIDES = frozenset({"other", "opposite", "far", "next"})  # "to the other side"
_BOUNDED = frozenset({"side", "end", "edge", "corner", "room", "spot", "place"})
_DESTINATIONS = frozenset(
    "corner room kitchen bedroom bathroom hall hallway corridor garden yard garage house shop box crate bin hole "
    "distance background foreground middle centre center edge window door doorway wall shelf table".split()
)
_LEADING = frozenset({"to", "into", "onto", "under", "behind", "through"})


def ends_elsewhere(words: Sequence[str]) -> bool:
    """Return whether a clause about a push, a pull, a drag or a blow says that the object ends at another place.

    Args:
        words: The clause's words in lower case, in their order.
    """
    listed = list(words)
    return any(_begins_displacement(listed[at:], listed[at - 1] if at else "") for at in range(len(listed)))


def _begins_displacement(rest: list[str], before: str) -> bool:
    """Return whether the words ``rest``, which follow ``before``, begin with a phrase for a change of place."""
    first, second = rest[0], rest[1] if len(rest) > 1 else ""
    if any(tuple(rest[: len(phrase)]) == phrase for phrase in _ELSEWHERE):
        return True
    if first == "away":
        return second != "from" or _find_noun(rest[2:]) not in _VIEWERS
    if first == "off":  # "a hand from off screen" tells where the cause is
        return before != "from" and second not in _STATES
    if first == "out":
        return second == "of" and len(rest) > 2 and rest[2] in _DETERMINERS
    if first in _LEADING and second in _DETERMINERS:
        return _find_noun(rest[1:]) in _DESTINATIONS or _is_bounded(rest[2:])
    return False


def _find_noun(words: list[str]) -> str:
    """The first word past determiners; empty if there is none."""
    return next((word for word in words if word not in _DETERMINERS), "")


def _is_bounded(words: list[str]) -> bool:
    """Return whether the words name another place by its relation: "other side", "next room"."""
    return len(words) > 1 and words[0] in _SIDES and words[1] in _BOUNDED
