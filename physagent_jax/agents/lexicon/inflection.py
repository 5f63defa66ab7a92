"""Inflected forms of the lexicon's verbs."""

from __future__ import annotations

import functools

from physagent_jax.agents.lexicon.reading import read_lexicon

_VOWELS = "aeiou"


def inflect(verb: str) -> set[str]:
    """Regular and irregular forms of a one-word verb.

    Doubling of the last consonant depends on stress, which letters do not show where there are several syllables: both
    spellings are produced, and the wrong one is never met. With one vowel it is doubled ("taped" is of "tape").
    """
    irregular = read_lexicon().irregular.get(verb, "").split()
    forms = {verb, verb + "s", verb + "ed", verb + "ing", *irregular}
    if verb.endswith(("s", "x", "z", "ch", "sh", "o")):
        forms.add(verb + "es")
    if verb.endswith("e"):
        forms |= {verb + "d", verb[:-1] + "ing"}
    if verb.endswith("y") and verb[-2:-1] not in _VOWELS:
        forms |= {verb[:-1] + "ies", verb[:-1] + "ied"}
    if len(verb) > 2 and verb[-1] not in _VOWELS + "wxy" and verb[-2] in _VOWELS and verb[-3] not in _VOWELS:
        forms |= {verb + verb[-1] + "ed", verb + verb[-1] + "ing"}
        if sum(letter in _VOWELS + "y" for letter in verb) == 1:
            forms -= {verb + "ed", verb + "ing"}
    return forms


@functools.cache
def read_forms() -> dict[str, str]:
    """Every inflected form of every verb in the lexicon, to its lemma; "jumping" of "jumping jacks" is of "jump"."""
    lexicon = read_lexicon()
    verbs = (phrase for phrase, each in lexicon.motions.items() if not (each.generic and " " in phrase))
    lemmas = {phrase.split()[0] for phrase in verbs} | set(lexicon.irregular)  # "head over heels" is no verb
    forms: dict[str, str] = {}
    for lemma in sorted(lemmas):
        for form in inflect(lemma):
            forms.setdefault(form, lemma)
    return forms
