"""Parts that only tell where or which way something happens: nothing is done to them.

"Its arm comes off at the shoulder", "it leans toward its tail", "it melts from the ears down", "its knees give way".
"""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.grammar.mentions import LOOSE, Mention, MentionKind, empty, get_last_motion
from physagent_jax.agents.grammar.tables import get_set
from physagent_jax.agents.lexicon import Effect

_NOUNS = (MentionKind.PLACE, MentionKind.UNKNOWN)
_ADJECTIVES = 4  # before a noun, at most


def read_landmarks(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Makes a way of the part that something goes towards, and empties those that tell a joint or a beginning."""
    result = list(mentions)
    for at, mention in enumerate(mentions):
        if mention.kind not in _NOUNS:
            continue
        before = _find_preposition(mentions, at)
        if mention.kind is MentionKind.PLACE and _is_goal(mentions, before):
            result[at] = replace(mention, kind=MentionKind.DIRECTION, value=(mention.phrase,))
        elif any(tells(mentions, at, before) for tells in (_is_joint, _is_beginning, _is_giving_way)):
            result[at] = empty(mention)
    return result


def _find_preposition(mentions: list[Mention], at: int) -> int:
    """Index of what stands before a noun's phrase."""
    before = at - 1
    while before >= max(at - _ADJECTIVES, 0) and mentions[before].kind in LOOSE:
        before -= 1
    return before - (before >= 0 and mentions[before].form in get_set("determiners"))


def _is_goal(mentions: list[Mention], before: int) -> bool:
    """Return whether what stands before a part makes it the way: "toward its tail", "in the direction of its tail"."""
    words = [each.form for each in mentions[max(before - 1, 0) : before + 1]]
    return words[-1:] in (["toward"], ["towards"]) or words == ["direction", "of"]


def _is_joint(mentions: list[Mention], at: int, before: int) -> bool:
    """Return whether a noun tells where a part bends or comes off: "its arm bends at the elbow"."""
    if mentions[at].phrase not in get_set("joints") or before < 0:
        return False
    motion, preposition = get_last_motion(mentions[:at]), mentions[before]
    named = any(each.kind is MentionKind.PLACE for each in mentions[:before])
    if motion is None or not (named or motion.manner == "detach"):
        return False
    acts = motion.effect in (Effect.STRIKE, Effect.PUSH) and not (motion.manner or motion.generic)
    placed = preposition.form == "from" or preposition.form in ("at", "in") and not acts
    return placed or preposition.motion is motion and motion.manner == "detach"  # "breaks off its base"


def _is_beginning(mentions: list[Mention], at: int, before: int) -> bool:
    """Return whether a noun tells where what gives way begins to: "it melts from the ears down"."""
    starts = before > 0 and mentions[before - 1].form in ("starting", "beginning")
    placed = before >= 0 and mentions[before].form in (("from", "with", "at") if starts else ("from",))
    motion = get_last_motion(mentions[:at]) if placed else None
    return motion is not None and motion.gives


def _is_giving_way(mentions: list[Mention], at: int, _before: int) -> bool:
    """Return whether it is what all of it stands on that gives way: "its knees buckle"."""
    if mentions[at].words.lower().split()[-1] not in get_set("supports"):
        return False
    behind = next((each for each in mentions[at + 1 :] if each.kind is not MentionKind.FUNCTION), None)
    if behind is None or behind.kind is not MentionKind.VERB:
        return False
    return behind.phrase.startswith(("buckle", "give"))
