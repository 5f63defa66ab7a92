"""Places and directions that share words: "the left arm", "its upper half", "the top", "from the front"."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.rules.language import modifiers as m
from physagent_jax.agents.rules.language import verbs as v
from physagent_jax.agents.rules.language.lexicon import LEXICON
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import FUNCTION_WORDS
from physagent_jax.agents.rules.language.naming import OWNERS
from physagent_jax.agents.rules.language.phrases import match_words
from physagent_jax.agents.rules.language.reader import Reader
from physagent_jax.agents.rules.language.tokens import FORMS

_GOING_OVER = (v.Effect.LEAN, v.Effect.TOPPLE, v.Effect.FALL)
_SIDES = frozenset({"left", "right", "front", "back", "rear"})
_NO_PARTS = frozenset(
    (
        "moment time way order amount angle direction place spot position thing speed gear hand edge corner faces "
        "points looks shows"
    ).split()
)
_LYING: dict[str, m.Names] = {
    "back": ("away",),
    "front": ("toward",),
    "face": ("toward",),
    "belly": ("toward",),
}


def _comes_to_lie(reader: Reader, at: int) -> bool:
    """Return whether a side is what it falls or tips on ("falls on its back"): it goes over that way."""
    if reader.get_preposition(at) not in ("on", "onto") or not reader.mentions:
        return False
    index = len(reader.mentions) - 1
    while index > 0 and reader.mentions[index].kind in (MentionKind.FUNCTION, MentionKind.INTENSITY):
        index -= 1
    verb = reader.mentions[index].value
    if not isinstance(verb, v.Verb) or verb.effect not in _GOING_OVER:
        return False
    if verb.effect is not v.Effect.TOPPLE:
        reader.mentions[index] = replace(reader.mentions[index], value=v.VERBS["topple"], phrase="topple")
    return True


def read_place(reader: Reader, at: int) -> Mention | None:
    """Places and directions that share words: "the left arm", "its upper half", "the top", "from the front"."""
    if reader.tokens[at].text in _LYING and _comes_to_lie(reader, at):
        return reader.make_mention(
            MentionKind.DIRECTION, _LYING[reader.tokens[at].text], reader.tokens[at].text + " side", [at]
        )
    if _is_lying_on(reader, at):
        return reader.make_mention(MentionKind.FUNCTION, None, "posture", [at])
    for size in (2, 1):
        phrase = " ".join(t.text for t in reader.tokens[at : at + size])
        names, part = m.PART_ADJECTIVES.get(phrase), reader.get_text(at + size)
        plural = part not in ("sides", "faces") and FORMS.get(part) is None  # "from the left tips it over"
        part = part.removesuffix("s") if plural else part
        part = _find_like(reader, at) if part in ("one", "other") else part
        towards = reader.get_preposition(at) in ("to", "toward", "towards", "from", "into")
        towards = towards and not (_is_excepted(reader, at) or _is_applied_to(reader, at, size))
        if names and part in m.PARTS:
            used = list(range(at, at + size + 1))
            if part == "side" and _comes_to_lie(reader, at):
                return reader.make_mention(MentionKind.DIRECTION, names, phrase, used)
            if towards:
                return _make_direction(reader, names, phrase, used)
            return reader.make_mention(
                MentionKind.PLACE, m.Place(names, m.PARTS[part]), f"{phrase} {part}", used
            )
        if names and _is_part_with_name(reader, at, size):
            place = m.Place(names, 0.5 if names in (("up",), ("down",)) else 2 / 3)
            return reader.make_mention(
                MentionKind.PLACE, place, f"{phrase} part", list(range(at, at + size + 1))
            )
        struck = reader.get_preposition(at) in ("on", "at") and reader.is_after_determiner(at)
        if names and struck and phrase in ("left", "right") and reader.is_striking():
            return reader.make_mention(MentionKind.PLACE, m.Place(names, 2 / 3), f"{phrase} side", [at])
        if names is None or phrase not in m.ENDS or _is_longer_phrase(reader, at):
            continue
        if reader.get_text(at - 1) in ("a", "an") and part in v.VERBS:
            return reader.make_mention(MentionKind.DIRECTION, names, phrase, [at])  # "a front flip"
        if towards:
            return _make_direction(reader, names, phrase, [at])
        if phrase == "back" and (_is_told_where(reader, at) or _is_regaining(reader, at)):
            return reader.make_mention(MentionKind.FUNCTION, None, phrase, [at])  # "back to the left"
        owned = at > 0 and reader.tokens[at - 1].possessive
        if phrase != "back" or owned or reader.is_after_determiner(at):
            return reader.make_mention(MentionKind.PLACE, m.Place(names, 2 / 3), phrase, [at])
        return reader.make_mention(MentionKind.DIRECTION, names, phrase, [at])
    return None


def _is_part_with_name(reader: Reader, at: int, size: int) -> bool:
    """Return whether a side stands before a noun that the lexicon lacks: "the upper shelves", "its left sleeve"."""
    noun, owner = reader.get_text(at + size), reader.get_text(at - 1)
    owners = ("the", "its", "his", "her", "their") if reader.tokens[at].text not in _SIDES else OWNERS
    if owner not in owners or not noun.isalpha() or noun in reader.object_words or noun in _NO_PARTS:
        return False
    known = noun in LEXICON or reader.tokens[at + size].lemma in LEXICON or noun in FUNCTION_WORDS - {"body"}
    before = reader.get_preposition(at)
    return not known and before not in ("to", "toward", "towards", "from", "into", "on", "onto", "at", "in")


def _find_like(reader: Reader, at: int) -> str:
    """The part that "one" stands for: "its left arm goes up, the right one down"; empty if there is none."""
    if not reader.is_after_determiner(at):
        return ""
    said = next((e for e in reversed(reader.mentions) if e.kind is MentionKind.PLACE), None)
    part = "" if said is None else said.phrase.split()[-1]
    return part if part in m.PARTS else ""


def _is_lying_on(reader: Reader, at: int) -> bool:
    """Return whether it travels on that side: "slides on its belly" moves all of it."""
    owned = reader.get_text(at - 1) in ("its", "his", "her") and reader.get_text(at - 2) == "on"
    if not owned or reader.tokens[at].text not in _LYING:
        return False
    verb = next((e.value for e in reversed(reader.mentions) if isinstance(e.value, v.Verb)), None)
    return verb is not None and verb.effect is v.Effect.PUSH and verb.generic


def _is_excepted(reader: Reader, at: int) -> bool:
    """Return whether "apart from" or "aside from" stands before it: a part, and no way."""
    before = [reader.get_text(at - back) for back in (1, 2, 3)]
    return any(pair in (("from", "apart"), ("from", "aside")) for pair in zip(before, before[1:]))


def _is_applied_to(reader: Reader, at: int, size: int) -> bool:
    """Return whether a blow that a noun names is given "to the top of it": there, and not that way."""
    part = reader.get_text(at + size)
    owned = "of" in (part, reader.get_text(at + size + 1)) and reader.get_preposition(at) == "to"
    if not owned:
        return False
    head = next((e for e in reversed(reader.mentions) if isinstance(e.value, v.Verb)), None)
    return head is not None and head.kind is MentionKind.CAUSE


def _is_told_where(reader: Reader, at: int) -> bool:
    """Return whether "back" goes a way that is named ("back to the left"), not to where it came from."""
    if reader.get_text(at + 1) not in ("to", "toward", "towards"):
        return False
    if reader.get_text(at + 2) in ("us", "me", "you"):
        return not reader.is_after_determiner(at)  # "turn its back to us"
    return any(reader.get_text(at + reach) in (*m.DIRECTIONS, *m.ENDS, *m.PLACES) for reach in (2, 3))


def _is_regaining(reader: Reader, at: int) -> bool:
    """Return whether "back" only says that it was so before: "shrinks back", "jumps back up"."""
    verbs = [e.value for e in reader.mentions if isinstance(e.value, v.Verb)]
    shapes = bool(verbs) and verbs[-1].effect in (v.Effect.SCALE, v.Effect.SWELL)
    jumps = bool(verbs) and verbs[-1].effect is v.Effect.JUMP and reader.get_text(at + 1) == "up"
    return shapes and not reader.is_after_determiner(at) and reader.get_text(at - 1) != "the" or jumps


def _is_longer_phrase(reader: Reader, at: int) -> bool:
    """Return whether a fixed phrase begins here: "back and forth" is not the back."""
    return any(
        len(words) > 1 and match_words(reader, words, at)
        for words, _, _ in LEXICON.get(reader.tokens[at].text, ())
    )


def _make_direction(reader: Reader, names: m.Names, phrase: str, used: list[int]) -> Mention:
    kind = MentionKind.FROM if reader.get_preposition(used[0]) == "from" else MentionKind.DIRECTION
    return reader.make_mention(kind, names, phrase, used)
