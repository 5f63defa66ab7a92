"""Corrections of words just said: "to the left, no wait, to the right", "the tip, i.e. the top".

What stands behind replaces the last phrase of its kind before. Where it is more than such a phrase ("push it, no, pull
it left"), nothing is replaced, and `retractions` says that it is not understood.
"""

from __future__ import annotations

from physagent_jax.agents.grammar.mentions import Mention, MentionKind, empty
from physagent_jax.agents.rules.language.modifiers import WHOLE_WORDS
from physagent_jax.agents.grammar.mentions import has_motion

# Words that take back what stands before them, longest first.
_MARKS: tuple[tuple[str, ...], ...] = (
    ("no", ",", "wait"),
    ("wait", ",", "no"),
    ("no", "wait"),
    ("wait", "no"),
    ("or", "rather"),
    ("actually", "make", "that"),
    ("i", "mean"),
    ("that", "is", ","),
    ("make", "that"),
    ("scratch", "that"),
    ("sorry",),
    ("correction",),
    ("actually",),
    ("rather",),
    ("ie",),
    ("no",),
)
_WAYS = (MentionKind.DIRECTION, MentionKind.FROM)
_REPLACED = {kind: (kind,) for kind in (MentionKind.PLACE, MentionKind.SENSE, MentionKind.QUANTITY)} | {
    MentionKind.DIRECTION: _WAYS,
    MentionKind.FROM: _WAYS,
}
_LOOSE = (MentionKind.FUNCTION, MentionKind.JOIN)
_ENDS = (MentionKind.JOIN, MentionKind.VERB)


def read_corrections(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """The mentions with what is taken back emptied; ``names`` are words for the object."""
    result = list(mentions)
    for at in range(1, len(mentions)):
        size = match_correction(mentions, at)
        if not size or mentions[at - 1].kind is not MentionKind.JOIN and mentions[at].form != "or":
            continue
        behind = at + size
        while behind < len(mentions) and mentions[behind].kind is MentionKind.JOIN:
            behind += 1
        ends = (i for i in range(behind, len(mentions)) if mentions[i].kind in _ENDS)
        end = next(ends, len(mentions))
        replaced = _find_replaced(result[:at], mentions[behind:end], names)
        if replaced is None:
            continue
        first = at
        while has_motion(result[:at]) and result[first - 1].kind is MentionKind.JOIN:
            first -= 1
        if not any(m.kind in _REPLACED for m in mentions[behind:end]):
            behind = end  # "the whole man"
        for place in (*replaced, *range(first, behind)):
            result[place] = empty(result[place])
        if end < len(result) and result[end].words == "," and not has_motion(result[:at]):
            result[end] = empty(result[end])  # "his head, sorry, the whole man, slides"
    return result


def match_correction(mentions: list[Mention], at: int) -> int:
    """The number of mentions from ``at`` on that take back what stands before; 0 if they do not."""
    forms = [m.words.lower() if m.kind is MentionKind.JOIN else m.form for m in mentions[at : at + 3]]
    phrases = [m.words.lower() for m in mentions[at : at + 3]]
    for mark in _MARKS:
        if tuple(forms[: len(mark)]) == mark:
            return len(mark)
        if phrases and phrases[0] == " ".join(mark):
            return 1
    return 0


def _find_replaced(before: list[Mention], said: list[Mention], names: frozenset[str]) -> list[int] | None:
    """Places of what the phrases in ``said`` stand for instead; None if they are more than that."""
    told = [m for m in said if m.kind in _REPLACED]
    whole = not told and any(m.phrase in WHOLE_WORDS for m in said)
    loose = (*_LOOSE, MentionKind.UNKNOWN) if whole else _LOOSE
    if not said or any(m.kind not in (*_REPLACED, *loose) for m in said):
        return None
    verbs = [i for i, m in enumerate(before) if m.kind is MentionKind.VERB]
    ways = [m for m in before[verbs[-1] if verbs else 0 :] if m.kind in _WAYS]
    if len(ways) > 1 and any(m.kind in _WAYS for m in told):
        return None
    replaced = []
    for mention in told:
        there = [i for i, m in enumerate(before) if m.kind in _REPLACED[mention.kind] and i not in replaced]
        replaced += there[-1:]
    parts = [i for i, m in enumerate(before) if m.kind is MentionKind.PLACE]
    return replaced or (parts[-1:] if whole else []) or None
