"""Tokens of a sentence: words, numbers and punctuation, with the verb that each is a form of."""

from __future__ import annotations

import functools
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from physagent_jax.agents.grammar.tables import LEXICON, NUMBERS, get_set, read_sections
from physagent_jax.agents.lexicon import read_forms
from physagent_jax.core.names import count_slips

# A word with its contraction, a number, or a mark of punctuation that can end a clause.
_TOKEN = re.compile(
    r"(?<!\w)(?:i\.e|e\.g)\.?(?!\w)|(?<!\w)[-\u2212](?=\d)|(?<=\s)-(?=\s)|\d{1,9}(?:\.\d{1,9})?|[^\W\d_]+(?:'[^\W\d_]+)?|[,;.!?:\n\u2014\u2013%\u00b0/]"
)
_SIGNS = {"%": "percent", "\u00b0": "degrees", "/": "per", "-": "minus", "\u2212": "minus"}
_LEAST, _LEAST_NAME, _LONG_NAME = 3, 6, 8  # letters of words, and of names, in which slips are undone
_AROUND = re.compile(r" (?:the|its|his|her|their|a) ")  # "round the middle"
_RUN = re.compile(r"(.)\1{2,}")
_LEAST_VERB = 6  # letters of a verb in which one that is left out is found


@dataclass(frozen=True)
class Token:
    """One word, number or punctuation mark.

    Attributes:
        text: Lower case.
        lemma: The verb that it is a form of, else the text itself.
        start, end: Place in the sentence.
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


# A sentence is taken apart four times, and a refusal looks through all patterns.
@functools.lru_cache(maxsize=1024)
def tokenise(sentence: str) -> tuple[Token, ...]:
    """Tokens of ``sentence``; hyphens separate words, "doesn't" becomes "does", "not", "it's" becomes "it"."""
    # One character may have several in lower case; those are kept, so that places stay valid.
    text = "".join(c.lower() if len(c.lower()) == 1 else c for c in sentence)
    text = text.replace("\u2019", "'").replace("\u2018", "'")
    tokens: list[Token] = []
    for match in _TOKEN.finditer(text):
        if match.group() == "." and tokens and tokens[-1].text in get_set("abbreviations"):
            continue  # "approx. 20 %"
        word, _, suffix = match.group().partition("'")
        word = word.replace(".", "") if word[0].isalpha() else word  # "i.e."
        negated = suffix == "t" and word.endswith("n")
        word = word[:-1] if negated else word
        dash = word in ("-", "\u2013", "\u2014") and not text[match.end() : match.end() + 1].isdigit()
        word = {"ca": "can", "wo": "will"}.get(word, word) if negated else _SIGNS.get(word, word)
        word = "," if dash else word  # "push it left - gently"
        word = "around" if word == "round" and _is_around(tokens, text[match.end() :]) else word
        spelt: str = read_sections()["informal"].get(word, word)
        for each in spelt.split():
            tokens.append(Token(each, FORMS.get(each, each), match.start(), match.end(), suffix == "s"))
        if negated:
            tokens.append(Token("not", "not", match.start(), match.end()))
    return tuple(token for token in tokens if token.text)


def _is_around(before: Sequence[Token], behind: str) -> bool:
    """Return whether "round" tells where: "spins round", "squeeze it round the middle"."""
    turns = bool(before) and before[-1].lemma in FORMS.values() and not behind.startswith(" and round")
    return turns or bool(before) and before[-1].text != "and" and _AROUND.match(behind) is not None


FORMS = read_forms()


def is_participle(form: str) -> bool:
    """Return whether a form of a verb is its present participle: "swinging", but not "swing"."""
    return form.endswith("ing") and FORMS.get(form) != form


def _collect_known() -> frozenset[str]:
    """Every word of the lexicon and of the grammar's tables."""
    lexicon = (entry for table in vars(LEXICON).values() for entry in table)
    tables = (entry for table in read_sections().values() for entry in table)
    words = (word for phrases in (lexicon, tables) for phrase in phrases for word in str(phrase).split())
    return frozenset(words) | frozenset(FORMS) | frozenset(NUMBERS)


KNOWN = _collect_known()
_LONGEST, _SLIPS = (
    max(map(len, KNOWN)),
    2,
)  # letters, and slips in one word: nothing longer is near to a known word


def correct_spelling(tokens: Sequence[Token], names: frozenset[str]) -> list[Token]:
    """The tokens with slips of the keyboard undone: letters doubled or the wrong way round, a name nearly right.

    Only words that mean nothing as they stand are read as others; places in the sentence are kept. ``names`` are words
    for the object.
    """
    meant = {text: _find_meant(text, names) for text in {token.text for token in tokens}}
    behind = get_set("determiners") | get_set("objects") | names
    for at, token in enumerate(tokens[:-1]):
        begins = at == 0 or tokens[at - 1].text in (",", ".", "and", "then", "to", "please")
        if begins and meant[token.text] is None and tokens[at + 1].text in behind:
            meant[token.text] = _find_verb(token.text, names)
    return [
        token
        if (word := meant[token.text]) is None
        else replace(token, text=word, lemma=FORMS.get(word, word))
        for token in tokens
    ]


def describe_corrections(sentence: str, names: frozenset[str]) -> list[str]:
    """Corrected spellings, in plain sentences."""
    tokens = tokenise(sentence)
    pairs = zip(tokens, correct_spelling(tokens, names))
    return [f"'{said.text}' is read as '{meant.text}'." for said, meant in pairs if said.text != meant.text]


def _find_meant(text: str, names: frozenset[str]) -> str | None:
    """The word that is meant by one that means nothing; None if it stands, or if nothing is near."""
    stands = any(word in known for word in (text, text.removesuffix("s")) for known in (names, KNOWN))
    longest = max(map(len, names), default=0)
    if stands or not text.isalpha() or not _LEAST <= len(text) <= max(longest, _LONGEST) + _SLIPS:
        return None
    near = [text[:i] + text[i + 1] + text[i] + text[i + 2 :] for i in range(len(text) - 1)]
    near += [text[:i] + text[i + 1 :] for i in range(1, len(text)) if text[i] == text[i - 1]]
    near += [text[:i] + text[i] + text[i:] for i in range(1, len(text) - 1)]  # "midle"
    # "Sooo".
    near += [word for kept in (r"\1", r"\1\1") if (word := _RUN.sub(kept, text)) not in LEXICON.negations]
    near += [text + "g"] if text.endswith("in") else []  # "landin"
    found = {word for word in near if word != text and (word in KNOWN or word in names)}
    if len(found) == 1:
        return found.pop()
    meant = [w for w in names if len(w) >= _LEAST_NAME and count_slips(text, w) <= 1 + (len(w) >= _LONG_NAME)]
    return min(meant, key=lambda w: count_slips(text, w)) if meant and text[0] == meant[0][0] else None


def _find_verb(text: str, names: frozenset[str]) -> str | None:
    """The verb that a request begins with, a letter left out: "strech it"; None if it is a word, or none is near."""
    if text in names or text in KNOWN or len(text) < _LEAST_VERB:
        return None
    longer = (verb for verb in FORMS if verb[0] == text[0] and len(verb) == len(text) + 1)
    verbs = [verb for verb in longer if count_slips(text, verb) == 1]
    return verbs[0] if len(verbs) == 1 else None
