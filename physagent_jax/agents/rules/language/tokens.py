"""Cuts a sentence into tokens and undoes the inflection of verbs."""

from __future__ import annotations

import re
from dataclasses import dataclass

from physagent_jax.agents.rules.language.verbs import IRREGULAR_FORMS, VERBS

# A word with its contraction, a number, or a mark of punctuation that can end a clause.
_TOKEN = re.compile(
    r"(?<!\w)(?:i\.e|e\.g)\.?(?!\w)|(?<!\w)[-\u2212](?=\d)|(?<=\s)-(?=\s)|\d{1,9}(?:\.\d{1,9})?|[^\W\d_]+(?:'[^\W\d_]+)?|[,;.!?:\n\u2014\u2013%\u00b0/]"
)
_SIGNS = {"%": "percent", "\u00b0": "degrees", "/": "per", "-": "minus", "\u2212": "minus"}
_ABBREVIATIONS = frozenset({"approx", "ca", "deg", "sec", "vs", "incl"})
_VOWELS = "aeiou"


@dataclass(frozen=True)
class Token:
    """One word, number or punctuation mark.

    Attributes:
        text: Lower case.
        lemma: The verb that it is a form of, else the text itself.
        start, end: Place in the prompt.
        possessive: Whether it ends in "'s": what follows belongs to it.
    """

    text: str
    lemma: str
    start: int
    end: int
    possessive: bool = False

    @property
    def is_word(self) -> bool:
        """Return whether it is a word or number rather than punctuation."""
        return self.text[0].isalnum()


def tokenise(prompt: str) -> list[Token]:
    """Tokens of ``prompt``; hyphens separate words, "doesn't" becomes "does", "not", "it's" becomes "it"."""
    # One character may have several in lower case; those are kept, so that places stay valid.
    text = "".join(c.lower() if len(c.lower()) == 1 else c for c in prompt)
    text = text.replace("\u2019", "'").replace("\u2018", "'")
    tokens = []
    for match in _TOKEN.finditer(text):
        if match.group() == "." and tokens and tokens[-1].text in _ABBREVIATIONS:
            continue  # "approx. 20 %"
        word, _, suffix = match.group().partition("'")
        word = word.replace(".", "") if word[0].isalpha() else word  # "i.e."
        negated = suffix == "t" and word.endswith("n")
        word = word[:-1] if negated else word
        dash = word in ("-", "\u2013", "\u2014") and not text[match.end() : match.end() + 1].isdigit()
        word = {"ca": "can", "wo": "will"}.get(word, word) if negated else _SIGNS.get(word, word)
        word = "," if dash else word  # "push it left - gently"
        tokens.append(Token(word, FORMS.get(word, word), match.start(), match.end(), suffix == "s"))
        if negated:
            tokens.append(Token("not", "not", match.start(), match.end()))
    return [t for t in tokens if t.text]


def inflect(verb: str) -> set[str]:
    """Regular and irregular forms of a one-word verb.

    Doubling of the last consonant depends on stress, which letters do not show where there are several syllables: both
    spellings are produced, and the wrong one is never met. With one vowel it is doubled ("taped" is of "tape").
    """
    forms = {verb, verb + "s", verb + "ed", verb + "ing"} | set(IRREGULAR_FORMS.get(verb, "").split())
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


def _collect_forms() -> dict[str, str]:
    """Every inflected form of every verb in the lexicon, to its lemma; lemmas themselves win."""
    lemmas = {phrase.split()[0] for phrase in VERBS} | set(IRREGULAR_FORMS)
    forms: dict[str, str] = {}
    for lemma in sorted(lemmas):
        for form in inflect(lemma):
            forms.setdefault(form, lemma)
    return forms | {lemma: lemma for lemma in lemmas}


FORMS = _collect_forms()


def is_participle(form: str) -> bool:
    """Return whether a form of a verb is its present participle: "swinging", but not "swing"."""
    return form.endswith("ing") and FORMS.get(form) != form
