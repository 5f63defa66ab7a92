"""Names of the object in a sentence: its own name, or a noun for things of its kind."""

from __future__ import annotations

import re

from physagent_jax.agents.rules.language.modifiers import FUNCTION_WORDS, PLACES
from physagent_jax.agents.rules.language.tokens import FORMS, Token, tokenise
from physagent_jax.agents.schema import SceneBrief

DETERMINERS = frozenset({"the", "a", "an", "this", "that", "my", "your", "its", "his", "her", "their"})
OWNERS = ("its", "his", "her", "their")
PREPOSITIONS = frozenset(
    (
        "in on to into onto at by for from with within under over against through across along about around off near "
        "upon like until towards toward"
    ).split()
)
# Names of files that do not say what is in them; nor do digits, or words of one or two letters.
_SAYING_NOTHING = frozenset(
    (
        "asset assets capture cloud data export final gaussian gaussians image img input mesh model object output "
        "photo picture point pointcloud points recording result sample scan scene splat splats test thing untitled"
    ).split()
)


_WHEELED = frozenset(
    (
        "car truck lorry bus van tram train locomotive wagon cart trolley tractor bulldozer bike bicycle motorbike "
        "motorcycle scooter skateboard wheelchair pram stroller pushchair suitcase tricycle taxi jeep"
    ).split()
)


def collect_object_words(prompt: str, brief: SceneBrief) -> frozenset[str]:
    """The words of ``prompt`` that name the object: its name and kind, or a noun for its kind, singular and plural.

    A noun that the lexicon has another meaning for is none, nor is one beside the object's own name, unless both are
    one name ("the teddy bear", "the loaf of bread"): then it is a part, or another thing.
    """
    own = set(_add_plurals(_split(f"{brief.object_name} {brief.object_kind}")))
    nouns = {w for w in _add_plurals(brief.object_nouns) if not _has_other_meaning(w)}
    tokens = tokenise(prompt)
    texts = [token.text for token in tokens]
    places = [at for at, text in enumerate(texts) if text in own]
    if not places:
        said = {text for at, text in enumerate(texts) if text in nouns and not _is_placing(tokens, at)}
        return frozenset(own | said)
    beside = set()
    for at in places:
        beside.update(texts[max(at - 1, 0) : at])
        if texts[at - 1 : at] == ["of"]:
            beside.update(texts[max(at - 2, 0) : at - 1])
        if not tokens[at].possessive:
            beside.update(texts[at + 1 : at + 2])
        if texts[at + 1 : at + 2] == ["of"]:
            beside.update(texts[at + 2 : at + 3])
    return frozenset(own | (beside & nouns))


def _is_placing(tokens: list[Token], at: int) -> bool:
    """Return whether a noun tells where or with what ("in the water", "with snow"); "on the cake" is done to it."""
    before = at - 1
    while before > 0 and tokens[before].text in DETERMINERS:
        before -= 1
    if before < 0 or tokens[before].text not in PREPOSITIONS:
        return False
    return tokens[before].text not in ("on", "at") or tokens[before - 1].text not in FORMS


def is_telling(name: str) -> bool:
    """Return whether a name says what the object is; a noun that is not its own is then hardly the object."""
    return any(len(word) > 2 and word.isalpha() and word not in _SAYING_NOTHING for word in _split(name))


def has_wheels(brief: SceneBrief) -> bool:
    """Return whether it rolls on wheels, and so stays upright when it is rolled."""
    return bool(_WHEELED & set(_split(brief.object_name))) or "office" in _split(brief.object_name)


def _split(name: str) -> list[str]:
    return re.findall(r"[^\W\d_]+", name.lower())


def _add_plurals(words) -> list[str]:
    return [form for word in words for form in (word, word + "s", word + "es")]


def _has_other_meaning(word: str) -> bool:
    return word in FUNCTION_WORDS or word in PLACES or word in FORMS
