"""The neighbours of a mention in the sentence."""

from __future__ import annotations

from physagent_jax.agents.rules.language.mentions import Mention, MentionKind

MOTIONS = (MentionKind.VERB, MentionKind.CAUSE)
WAYS = (MentionKind.DIRECTION, MentionKind.FROM, MentionKind.AXIS, MentionKind.PLANE, MentionKind.SENSE)


def find_telling(mentions: list[Mention], index: int, step: int) -> Mention | None:
    """The next mention that is no article or the like; ``step`` is -1 for the one before."""
    at = index + step
    while 0 <= at < len(mentions):
        if mentions[at].kind is not MentionKind.FUNCTION:
            return mentions[at]
        at += step
    return None


def has_motion(mentions: list[Mention]) -> bool:
    """Return whether something is done in them."""
    return any(mention.kind in MOTIONS for mention in mentions)


def get_phrase(mentions: list[Mention], index: int) -> str:
    """The phrase of a mention; empty past the ends."""
    return mentions[index].phrase if 0 <= index < len(mentions) else ""
