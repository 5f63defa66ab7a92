"""Retractions: "left, or rather right", "it was going to fall".

Word by word the motion would be there all the same, or both that and what replaces it.
"""

from __future__ import annotations

from collections.abc import Callable

from physagent_jax.agents.rules.language.corrections import match_correction
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import MANNERS, Join
from physagent_jax.agents.rules.language.neighbours import MOTIONS, WAYS, get_phrase, has_motion
from physagent_jax.agents.rules.language.verbs import Effect, Verb

_ABSENT = frozenset({"nobody", "none"})
_FAILING = frozenset(
    (
        "refuse refuses refused refusing decline declines declined fail fails failed failing forget forgets forgot "
        "hesitate hesitates dare dares"
    ).split()
)
_INTENDING = frozenset({"going", "about", "supposed", "meant", "ready"})
_SHAPES = (Effect.LEAN, Effect.SCALE, Effect.TURN, Effect.TOPPLE, Effect.SWELL)
_PAST = frozenset({"was", "were"})


def find_retractions(mentions: list[Mention]) -> list[str]:
    """Plain sentences about motions that are taken back or do not come about."""
    return [doubt for index in range(len(mentions)) for rule in _RULES for doubt in rule(mentions, index)]


def _find_absent(mentions: list[Mention], index: int) -> list[str]:
    """Says "nobody pushes it", "no one": it is not done."""
    mention = mentions[index]
    absent = (
        mention.form in _ABSENT
        or mention.form == "one"
        and any(m.form == "no" for m in mentions[max(index - 1, 0) : index])
    )
    after = next((m for m in mentions[index + 1 :] if m.kind is not MentionKind.FUNCTION), None)
    owned = get_phrase(mentions, index + 1) == "of"
    if absent and not owned and after is not None and after.kind in MOTIONS:
        return [f"What happens if '{mention.words}' does it is not understood."]
    return []


def _find_failing(mentions: list[Mention], index: int) -> list[str]:
    """Says "I refuse to push it", "it fails to rise", "it is about to fall", "it was going to jump"."""
    mention = mentions[index]
    leads = get_phrase(mentions, index + 1) == "to" and has_motion(mentions[index + 2 : index + 4])
    intends = mention.form in _INTENDING and (
        mention.form != "going" or any(m.form in _PAST for m in mentions[max(index - 2, 0) : index])
    )
    if leads and (mention.form in _FAILING or intends):
        return [f"Whether what '{mention.words} to' leads to happens is not understood."]
    return []


def _find_correction(mentions: list[Mention], index: int) -> list[str]:
    """Says "left, or rather backwards", "clockwise... actually make that ...", "up, no, left"."""
    mention, before, behind = mentions[index], mentions[:index], mentions[index + 1 :]
    told = any(m.kind in (*MOTIONS, *WAYS) for m in before)
    again = any(m.kind in (*MOTIONS, *WAYS) for m in behind)
    if not told or not again:
        return []
    apart = before[-1].kind is MentionKind.JOIN or before[-1].form == "or"
    rather = (
        mention.form == "rather" and before[-1].form in ("or", ",", "but", "no") and behind[0].form != "than"
    )
    actual = mention.form in ("actually", "better", "sorry", "correction") and apart
    actual = actual or match_correction(mentions, index) > 1 and apart
    denies = mention.kind is MentionKind.NOT and mention.form in ("no", "nope")
    denies = denies and apart and behind[0].kind is MentionKind.JOIN and behind[0].value is not Join.BUT
    if rather or actual or denies:
        return [f"What '{mention.words}' takes back is not understood."]
    return []


def _find_concession(mentions: list[Mention], index: int) -> list[str]:
    """Says "although it is pushed, it stays", "even if it is hit", "despite the wind": what does it come to?"""
    mention, after = mentions[index], get_phrase(mentions, index + 1)
    though = mention.form in ("although", "though", "despite", "spite")
    if though or mention.form == "even" and after in ("if", "though", "when"):
        if has_motion(mentions[index:]):
            return [f"What comes of it '{mention.words}' that is not understood."]
    return []


def _find_lasting(mentions: list[Mention], index: int) -> list[str]:
    """Says "it stays bent", "lift it and keep it up": how it is in the end, and how it comes to be so."""
    mention, after = mentions[index], mentions[index + 1] if index + 1 < len(mentions) else None
    stays = mention.form in (
        "stay",
        "stays",
        "stayed",
        "staying",
        "remain",
        "remains",
        "remained",
        "remaining",
    )
    shaped = after is not None and isinstance(after.value, Verb) and after.value.effect in _SHAPES
    keeps = mention.form in ("keep", "keeps", "kept", "keeping") and get_phrase(mentions, index + 1) == "it"
    up = get_phrase(mentions, index + 2) in ("up", "down") and has_motion(mentions[:index])
    if stays and shaped or keeps and up:
        return [f"Whether '{mention.words}' tells a motion is not understood."]
    return []


def _find_multiple(mentions: list[Mention], index: int) -> list[str]:
    """Says "with twice the force": how strongly, and not how often."""
    mention, behind = mentions[index], [m.form for m in mentions[index + 1 : index + 4]]
    if mention.kind is MentionKind.REPEAT and mention.form in ("twice", "thrice") and MANNERS & set(behind):
        return [f"What '{mention.words}' as much is, is not understood."]
    return []


def _find_freedom(mentions: list[Mention], index: int) -> list[str]:
    """Says "it is free to move": it may, and nothing is done."""
    mention = mentions[index]
    freed = mention.form == "free" and get_phrase(mentions, index + 1) == "to"
    return [f"Whether '{mention.words} to' tells a motion is not understood."] if freed else []


def _find_return_of_gravity(mentions: list[Mention], index: int) -> list[str]:
    """Says "gravity off, push it up, gravity on", "no gravity until it is hit": it changes while it goes."""
    mention = mentions[index]
    if mention.kind is not MentionKind.GRAVITY or mention.value == "down":
        return []
    behind = mentions[index + 1 :]
    back = any(m.kind is MentionKind.GRAVITY and m.value == "down" for m in behind)
    falls = any(isinstance(m.value, Verb) and m.value.effect is Effect.FALL for m in behind)
    until = bool(behind) and behind[0].form == "until"
    if until or back and not falls and has_motion(behind):
        return [f"Until when '{mention.words}' holds is not understood."]
    return []


def _find_yet(mentions: list[Mention], index: int) -> list[str]:
    """Says "it is still falling": it goes on, and is not still."""
    mention, after = mentions[index], mentions[index + 1] if index + 1 < len(mentions) else None
    still = mention.kind is MentionKind.VERB and mention.words.lower().endswith("still")
    if still and after is not None and after.kind is MentionKind.VERB:
        return [f"Whether it is '{mention.words}' is not understood."]
    return []


_RULES: tuple[Callable[[list[Mention], int], list[str]], ...] = (
    _find_absent,
    _find_failing,
    _find_correction,
    _find_concession,
    _find_yet,
    _find_freedom,
    _find_return_of_gravity,
    _find_lasting,
    _find_multiple,
)
