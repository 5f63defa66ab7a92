"""Words for parts that tell how all of the object comes to lie or goes: "nose first", "ends up on its wheels".

Nothing is done to such a part, nor to one that a likeness names ("as if it wants to shake hands"), nor to somebody
else's ("a big hand lifts it"): it is neither looked for nor asked for. The words are the lexicon's
(`agents/lexicon/postures.yaml`).
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable, Sequence

from physagent_jax.agents.grammar.tables import LEXICON_PACKAGE
from physagent_jax.agents.lexicon import read_lexicon
from physagent_jax.core.reading import read_packaged_yaml


@functools.cache
def _make_patterns() -> tuple[re.Pattern[str], ...]:
    """Patterns with the group "part": what it comes to lie on, what goes first, is turned or acts; a likeness's."""
    words = {key: str(value) for key, value in read_packaged_yaml(LEXICON_PACKAGE, "postures.yaml").items()}
    told = {key: _join(value.split()) for key, value in words.items()}
    part = rf"(?:{told['adjectives']}\s+)*(?P<part>{told['parts']})\b"
    goes = rf"\b{told['verbs']}(?:s|es|ed|d|ing)?\b(?:\s+(?!an?\s|on\b|onto\b)\w+){{0,4}}?"
    first = _join([re.sub(r"\s+", r"\\s+", each) for each in words["first"].split(", ")])
    owned = "".join(rf"(?<!{each} )" for each in ("the", "its", "his", "her", "their", "s"))
    agents = _join([re.escape(each) for each in read_lexicon().agents])
    begin = r"(?:^|[,.;:!]|\b(?:and|as|by|if|then|until|when|while)\b)"
    return (
        re.compile(rf"{begin}\s*an?\s+(?:\w+\s+){{0,2}}?(?P<part>{agents})\b(?! of\b)"),
        re.compile(rf"{goes}\s+{told['prepositions']}\s+{told['owners']}\s+{part}"),
        re.compile(rf"{part}[\s-]+{first}\b"),
        re.compile(rf"(?<!\w){owned}{part}[\s-]+{told['turned']}\b"),
        re.compile(
            r"\b(?:as if|as though|like (?=an?\b|someone|it|he|she|they|when))(?P<part>.*?)(?:[,.;:!]|\bthen\b|$)"
        ),
    )


def _join(words: Sequence[str]) -> str:
    """A pattern of any of some words, longer ones first."""
    return f"(?:{'|'.join(sorted(words, key=len, reverse=True))})"


def strip_postures(sentence: str) -> str:
    """The sentence without the words for parts that tell a posture alone."""
    text = sentence.lower()
    for pattern in _make_patterns():
        for match in pattern.finditer(text):
            start, end = match.span("part")
            sentence = sentence[:start] + " " * (end - start) + sentence[end:]
    return sentence


def list_acted(words: Iterable[str], sentence: str) -> tuple[str, ...]:
    """Those of some words for parts whose noun stands in a sentence for more than a posture."""
    left = strip_postures(sentence).lower()
    nouns = {word: re.escape(word.lower().split()[-1]) for word in words}  # "one of its arms" is no quotation
    return tuple(word for word, noun in nouns.items() if re.search(rf"\b{noun}\b", left))
