"""Phrases beside a push, a pull or a blow that say that the object ends elsewhere: "away", "aside", "off the table".

Without one, a push tells a direction only, and what is rooted bends: "push the plant to the left". A direction from
or to the viewer ("away from us") tells no more than that.
"""

from __future__ import annotations

from collections.abc import Sequence

from physagent_jax.agents.grammar.tables import get_set


def ends_elsewhere(words: Sequence[str]) -> bool:
    """Return whether a clause says that what it moves ends at another place.

    Args:
        words: The clause's words in lower case, in their order.
    """
    return any(_begins_displacement(words[at:], words[at - 1] if at else "") for at in range(len(words)))


def _begins_displacement(rest: Sequence[str], before: str) -> bool:
    """Return whether the words ``rest``, which follow ``before``, begin with a phrase for a change of place."""
    first, second = rest[0], rest[1] if len(rest) > 1 else ""
    if any(" ".join(rest[:length]) in get_set("elsewhere") for length in (1, 2, 3)):
        return True
    if first == "away":
        return second != "from" or _find_noun(rest[2:]) not in get_set("onlookers")
    if first == "off":  # "a hand from off screen" tells where the cause is
        return before != "from" and second not in get_set("states")
    if first == "out":
        return second == "of" and len(rest) > 2 and rest[2] in get_set("determiners")
    if first in get_set("leading") and second in get_set("determiners"):
        bounded = [word in get_set(name) for word, name in zip(rest[2:], ("other_sides", "bounds"))]
        # "To the door", "to the other side".
        return _find_noun(rest[1:]) in get_set("destinations") or bounded == [True, True]
    return False


def _find_noun(words: Sequence[str]) -> str:
    """The first word past determiners; empty if there is none."""
    return next((word for word in words if word not in get_set("determiners")), "")
