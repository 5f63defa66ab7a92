"""Parts that are named so that it is not clear which, or whose: "one end", "the bottom right", "off its feet"."""

from __future__ import annotations

from collections.abc import Callable

from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.naming import DETERMINERS, OWNERS
from physagent_jax.agents.rules.language.neighbours import get_phrase, has_motion
from physagent_jax.agents.rules.language.verbs import Effect, Verb

_NAMELESS_PARTS = frozenset({"end", "ends", "part", "parts", "side", "corner", "edge"})
_TOWARDS = frozenset({"to", "toward", "towards", "from", "into"})


def find_parts(mentions: list[Mention]) -> list[str]:
    """Plain sentences about parts that were not found."""
    return [doubt for index in range(len(mentions)) for rule in _RULES for doubt in rule(mentions, index)]


def _find_corner(mentions: list[Mention], index: int) -> list[str]:
    """Says "push the bottom right": a corner, or the bottom to the right?"""
    mention = mentions[index]
    corner = (
        mention.kind is MentionKind.DIRECTION and isinstance(mention.value, tuple) and len(mention.value) > 1
    )
    if (
        corner
        and get_phrase(mentions, index - 1) in ("the", *OWNERS)
        and get_phrase(mentions, index - 2) not in _TOWARDS
    ):
        return [
            f"Whether '{get_phrase(mentions, index - 1)} {mention.words}' is a place or a way is not understood."
        ]
    return []


def _find_unnamed(mentions: list[Mention], index: int) -> list[str]:
    """Says "something on its left": a thing that is there, and no part."""
    after = mentions[index + 1 : index + 4]
    place = next((m for m in after if m.kind is MentionKind.PLACE), None)
    some = mentions[index].form in ("something", "someone", "somebody", "anything")
    if some and place is not None and after[0].form in ("on", "at", "near", "behind"):
        return [f"What is '{place.words}' is not understood."]
    return []


def _find_struck_side(mentions: list[Mention], index: int) -> list[str]:
    """Says "a punch to the right side": where it is hit, or where it goes?"""
    mention, before = mentions[index], mentions[max(index - 3, 0) : index]
    sided = mention.kind is MentionKind.DIRECTION and mention.words.lower().endswith("side")
    hit = any(isinstance(m.value, Verb) and m.value.effect is Effect.STRIKE for m in before)
    if sided and hit:
        return [f"Whether '{mention.words}' is where it is hit or where it goes is not understood."]
    return []


def _find_off_part(mentions: list[Mention], index: int) -> list[str]:
    """Says "kick it off its feet": it is not its feet that are kicked."""
    parted = mentions[index].kind is MentionKind.PLACE and get_phrase(mentions, index - 1) in OWNERS
    if parted and get_phrase(mentions, index - 2) == "off":
        return [f"What 'off its {mentions[index].words}' means is not understood."]
    return []


def _find_nameless_part(mentions: list[Mention], index: int) -> list[str]:
    """Says "one end of it", "on its side"."""
    mention, before = mentions[index], get_phrase(mentions, index - 1)
    if mention.kind is MentionKind.FUNCTION and mention.form in _NAMELESS_PARTS:
        if before in DETERMINERS | {"one", "other", "no"}:
            return [f"Which part '{before} {mention.words}' is, is not understood."]
    return []


def _find_raised_limbs(mentions: list[Mention], index: int) -> list[str]:
    """Says "hands up": a part, where nothing is done to the whole."""
    mention, after = mentions[index], mentions[index + 1] if index + 1 < len(mentions) else None
    limb = mention.kind is MentionKind.FUNCTION and mention.form in ("hand", "hands", "finger", "fingers")
    told = after is not None and after.kind is MentionKind.DIRECTION
    if limb and told and not has_motion(mentions[:index]):
        return [f"Whose '{mention.words}' goes there is not understood."]
    return []


def _find_stage_side(mentions: list[Mention], index: int) -> list[str]:
    """Says "stage left": the actor's left, the viewer's right, or does the writer mean the viewer's?"""
    after = mentions[index + 1] if index + 1 < len(mentions) else None
    if mentions[index].form != "stage" or after is None or after.phrase not in ("left", "right"):
        return []
    return [f"Whose left or right 'stage {after.words}' is, is not understood."]


def _find_facing(mentions: list[Mention], index: int) -> list[str]:
    """Says "turn its back to us": all of it turns, so that its back is there."""
    mention = mentions[index]
    before = next((m for m in reversed(mentions[:index]) if m.phrase not in DETERMINERS), None)
    turns = before is not None and isinstance(before.value, Verb) and before.value.effect is Effect.TURN
    if turns and mention.kind is MentionKind.PLACE and mention.phrase in ("back", "front"):
        return [f"Where its {mention.words} is to be is not understood."]
    return []


_RULES: tuple[Callable[[list[Mention], int], list[str]], ...] = (
    _find_corner,
    _find_unnamed,
    _find_struck_side,
    _find_off_part,
    _find_nameless_part,
    _find_raised_limbs,
    _find_stage_side,
    _find_facing,
)
