"""How far "from" and "except" reach in a list."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.rules.language import modifiers as m
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.reader import OWNING

_ORIGINS = frozenset(
    {"left", "right", "top", "bottom", "front", "back", "above", "below", "behind", "beneath"}
)


def spread_from(mentions: list[Mention]) -> list[Mention]:
    """Makes what is listed behind "from" a place that it comes from: "from the left, the right and above"."""
    result: list[Mention] = []
    listing = False
    for mention in mentions:
        joins = mention.kind is MentionKind.JOIN and mention.value in (m.Join.AND, m.Join.COMMA)
        if listing and mention.phrase in _ORIGINS:
            if mention.kind is MentionKind.DIRECTION:
                mention = replace(mention, kind=MentionKind.FROM)
            elif isinstance(mention.value, m.Place):  # "from top and bottom"
                mention = replace(mention, kind=MentionKind.FROM, value=mention.value.names)
        listing = mention.kind is MentionKind.FROM or listing and (joins or mention.phrase in OWNING)
        result.append(mention)
    return result


def mark_exceptions(mentions: list[Mention]) -> list[Mention]:
    """Makes the place in "except the head", "but not the head", "everything but the head" an excluded one."""
    result: list[Mention] = []
    at = 0
    while at < len(mentions):
        mention = mentions[at]
        place = _find_exception(mentions, at)
        if place is None:
            result.append(mention)
            at += 1
            continue
        result.append(replace(mentions[place], kind=MentionKind.EXCLUDED))
        at = place + 1
    return result


def _find_exception(mentions: list[Mention], at: int) -> int | None:
    """Index of the excluded place if an exception begins at ``at``."""
    mention = mentions[at]
    contrasts = mention.kind is MentionKind.JOIN and mention.value is m.Join.BUT
    if mention.kind is not MentionKind.EXCEPT and not contrasts:
        return None
    behind = at + 1
    negated = False
    while behind < len(mentions) and mentions[behind].kind in (MentionKind.FUNCTION, MentionKind.NOT):
        negated = negated or mentions[behind].kind is MentionKind.NOT
        behind += 1
    if behind >= len(mentions) or mentions[behind].kind is not MentionKind.PLACE:
        return None
    if not contrasts:
        return behind
    segment = [e for e in mentions[:at] if e.kind in (MentionKind.FUNCTION, MentionKind.JOIN)]
    joins = [i for i, e in enumerate(segment) if e.kind is MentionKind.JOIN]
    whole = any(e.phrase in m.WHOLE_WORDS for e in segment[joins[-1] + 1 if joins else 0 :])
    after = mentions[behind + 1] if behind + 1 < len(mentions) else None
    if whole and not negated:
        said = any(e.kind is MentionKind.VERB for e in mentions[:at])
        does = after is not None and after.kind is MentionKind.VERB
        return None if said and does else behind  # "all of it is still, but the top sways"
    return behind if negated and (after is None or after.kind is MentionKind.JOIN) else None
