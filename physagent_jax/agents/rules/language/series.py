"""Lists and counts whose items the grammar would join: "left, left, right", "two pushes, the first left"."""

from __future__ import annotations

from collections.abc import Callable

from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import Join, Repeat
from physagent_jax.agents.rules.language.naming import DETERMINERS
from physagent_jax.agents.rules.language.neighbours import get_phrase, has_motion

_ITEMS = frozenset({"first", "one", "once", "second"})
_WAYS = (MentionKind.DIRECTION, MentionKind.FROM, MentionKind.SENSE)
_LISTING = (Join.COMMA, Join.AND)
_SUBJECTS = DETERMINERS | {"it", "he", "she", "they", "you", "we", "i"}


def find_series(mentions: list[Mention]) -> list[str]:
    """Plain sentences about lists and counts that were not understood."""
    return [doubt for index in range(len(mentions)) for rule in _RULES for doubt in rule(mentions, index)]


def _find_shared_count(mentions: list[Mention], index: int) -> list[str]:
    """Says "two pushes, the first left, the second right": the count is of all of them."""
    count = mentions[index].value
    if not isinstance(count, Repeat) or (count.count or 1) < 2:
        return []
    comma = next((i for i in range(index, len(mentions)) if mentions[i].kind is MentionKind.JOIN), None)
    if comma is None or any(m.kind in _WAYS for m in mentions[index:comma]):
        return []
    behind = mentions[comma + 1 : comma + 6]
    ends = next(
        (i for i, m in enumerate(behind) if m.kind in (MentionKind.JOIN, MentionKind.VERB)), len(behind)
    )
    item = any(m.form in _ITEMS for m in behind[:ends])
    if item and any(m.kind in _WAYS for m in behind[:ends]):
        return [f"What is counted by '{mentions[index].words}' is not understood."]
    return []


def _find_shared_by_verbs(mentions: list[Mention], index: int) -> list[str]:
    """Says "raise and lower it three times": both, again and again."""
    count = mentions[index].value
    if not isinstance(count, Repeat) or (count.count or 1) < 2:
        return []
    first = max((i for i in range(index) if mentions[i].kind is MentionKind.VERB), default=0)
    before = mentions[first - 2 : first] if first > 1 else []
    joined = len(before) == 2 and before[1].phrase == "and" and before[0].kind is MentionKind.VERB
    if joined and mentions[first].kind is MentionKind.VERB:
        return [f"How often '{before[0].words}' is done is not understood."]
    return []


def _find_again(mentions: list[Mention], index: int) -> list[str]:
    """Says "push it left and then again": once more, by itself."""
    ends = index + 1 == len(mentions) or mentions[index + 1].kind is MentionKind.JOIN
    begins = (
        index > 0 and mentions[index - 1].kind is MentionKind.JOIN and mentions[index - 1].words[0].isalpha()
    )
    if mentions[index].form == "again" and mentions[index].phrase == "again" and begins and ends:
        return [f"What happens '{mentions[index].words}' is not understood."]
    return []


def _find_said_again(mentions: list[Mention], index: int) -> list[str]:
    """Says "left, left, right": once more the same way."""
    mention = mentions[index]
    if mention.kind is not MentionKind.DIRECTION:
        return []
    at = index + 1
    while at < len(mentions) and mentions[at].value in _LISTING and mentions[at].kind is MentionKind.JOIN:
        at += 1
    if get_phrase(mentions, at + 2) == "away":
        return []  # "up, up and away"
    again = at < len(mentions) and mentions[at].kind is mention.kind and mentions[at].phrase == mention.phrase
    return [f"How often it goes '{mention.words}' is not understood."] if again else []


def _find_every_time(mentions: list[Mention], index: int) -> list[str]:
    """Says "push it every time it comes to rest": as often as that happens."""
    mention, before = mentions[index], get_phrase(mentions, index - 1)
    each = mention.form == "time" and before in ("each", "every") or mention.form == "whenever"
    clause = get_phrase(mentions, index + 1) in _SUBJECTS
    if each and clause and has_motion(mentions[:index]) and has_motion(mentions[index:]):
        return [f"How often '{before} {mention.words}' is, is not understood."]
    return []


_RULES: tuple[Callable[[list[Mention], int], list[str]], ...] = (
    _find_shared_count,
    _find_shared_by_verbs,
    _find_again,
    _find_said_again,
    _find_every_time,
)
