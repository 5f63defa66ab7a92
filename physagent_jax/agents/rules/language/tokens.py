"""Cuts a sentence into tokens and undoes the inflection of verbs."""

from __future__ import annotations

import re
from dataclasses import dataclass

from physagent_jax.agents.lexicon import read_forms

# A word with its contraction, a number, or a mark of punctuation that can end a clause.
_TOKEN = re.compile(
    r"(?<!\w)(?:i\.e|e\.g)\.?(?!\w)|(?<!\w)[-\u2212](?=\d)|(?<=\s)-(?=\s)|\d{1,9}(?:\.\d{1,9})?|[^\W\d_]+(?:'[^\W\d_]+)?|[,;.!?:\n\u2014\u2013%\u00b0/]"
)
_SIGNS = {"%": "percent", "\u00b0": "degrees", "/": "per", "-": "minus", "\u2212": "minus"}
_ABBREVIATIONS = frozenset({"approx", "ca", "deg", "sec", "vs", "incl"})


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


FORMS = read_forms()


def is_participle(form: str) -> bool:
    """Return whether a form of a verb is its present participle: "swinging", but not "swing"."""
    return form.endswith("ing") and FORMS.get(form) != form
