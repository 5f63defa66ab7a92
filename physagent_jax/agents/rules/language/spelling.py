"""Slips of the keyboard: two letters the wrong way round, a letter doubled, the object's name nearly right.

Only words that mean nothing as they stand are read as others; "form" and the like are words of their own.
"""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.rules.language import modifiers as m
from physagent_jax.agents.rules.language.lexicon import LEXICON
from physagent_jax.agents.rules.language.modifiers import FUNCTION_WORDS, MOODS, UNPLACED_PARTS
from physagent_jax.agents.rules.language.quantities import (
    ADJECTIVES,
    ANGLES,
    DIMENSIONS,
    METRES,
    UNKNOWN_UNITS,
)
from physagent_jax.agents.rules.language.tokens import FORMS, Token, tokenise

_LEAST, _LEAST_NAME, _LONG_NAME = 3, 6, 8
_WORDS_OF_THEIR_OWN = frozenset(
    "form forms hoping hoped bellow latter angel angels trial trials spilt stare staring".split()
)
_KNOWN = (
    frozenset(word for entries in LEXICON.values() for words, _, _ in entries for word in words)
    | frozenset(FORMS)
    | FUNCTION_WORDS
    | MOODS
    | m.MANNERS
    | UNPLACED_PARTS
    | frozenset((*m.NUMBERS, *m.UNITS, *m.OBSTACLES, *m.PARTS, *m.PART_ADJECTIVES, *m.SCENE_NOUNS))
    | frozenset((*ADJECTIVES, *ANGLES, *DIMENSIONS, *METRES, *UNKNOWN_UNITS))
)


def correct_spelling(tokens: list[Token], object_words: frozenset[str]) -> list[Token]:
    """The tokens with slips undone; places in the prompt are kept."""
    known, corrected = _KNOWN | object_words, []
    meant = {text: _find_meant(text, known, object_words) for text in {token.text for token in tokens}}
    for token in tokens:
        word = meant[token.text]
        corrected.append(token if word is None else replace(token, text=word, lemma=FORMS.get(word, word)))
    return corrected


def describe_corrections(prompt: str, object_words: frozenset[str]) -> list[str]:
    """Describe corrected spellings, in plain sentences."""
    tokens = tokenise(prompt)
    pairs = zip(tokens, correct_spelling(tokens, object_words))
    return [f"'{said.text}' is read as '{meant.text}'." for said, meant in pairs if said.text != meant.text]


def _find_meant(text: str, known: frozenset[str], object_words: frozenset[str]) -> str | None:
    """The word that is meant by one that means nothing; None if it stands, or if nothing is near."""
    if not text.isalpha() or len(text) < _LEAST or text in known or text in _WORDS_OF_THEIR_OWN:
        return None
    if text.removesuffix("s") in known:
        return None
    near = [text[:i] + text[i + 1] + text[i] + text[i + 2 :] for i in range(len(text) - 1)]
    near += [text[:i] + text[i + 1 :] for i in range(1, len(text)) if text[i] == text[i - 1]]
    near += [text[:i] + text[i] + text[i:] for i in range(1, len(text) - 1)]  # "midle"
    found = {word for word in near if word != text and word in known}
    if len(found) == 1:
        return found.pop()
    names = [
        w
        for w in object_words
        if len(w) >= _LEAST_NAME and _count_slips(text, w) <= 1 + (len(w) >= _LONG_NAME)
    ]
    return min(names, key=lambda w: _count_slips(text, w)) if names and text[0] == names[0][0] else None


def _count_slips(first: str, second: str) -> int:
    """Letters to add, leave out or change to make one word of the other (Levenshtein)."""
    row = list(range(len(second) + 1))
    for i, a in enumerate(first, 1):
        above, row[0] = row[0], i
        for j, b in enumerate(second, 1):
            above, row[j] = row[j], min(row[j] + 1, row[j - 1] + 1, above + (a != b))
    return row[-1]
