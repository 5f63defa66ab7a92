"""Words for parts that a sentence tells by their colour: "the green box", "its red part"."""

from __future__ import annotations

import functools
import re
from collections.abc import Collection, Iterator

from physagent_jax.agents.grammar.coverage import is_look
from physagent_jax.agents.lexicon import read_lexicon
from physagent_jax.forces.part import get_singular
from physagent_jax.scene.parts import list_hues

_SEATS = (
    "against",
    "from",
    "in",
    "into",
    "onto",
    "over",
    "under",
    "with",
    "by",
    "near",
    "beside",
    "behind",
    "like",
)


@functools.cache
def _make_pattern() -> re.Pattern[str]:
    """A pattern of a colour and its noun, with the word before the article."""
    colours = "|".join(list_hues())
    article = r"\b(?:(?P<before>[a-z]+) )?(?:the|its|his|her|their)"
    return re.compile(rf"{article} (?:[a-z]+ ){{0,2}}?(?P<colour>{colours}) (?P<noun>[a-z]+)\b(?! of\b)")


def find_coloured_words(sentence: str, others: Collection[str]) -> Iterator[tuple[str, str]]:
    """The colour and the noun of each part that is told so; nothing where another thing may be meant.

    Args:
        sentence: The sentence.
        others: Nouns for the object and for parts of it that are known.
    """
    lexicon = read_lexicon()
    parts = {*lexicon.parts, *lexicon.part_nouns, *lexicon.unplaced, *lexicon.ends}
    for match in _make_pattern().finditer(sentence.lower()):
        noun, one = match["noun"], get_singular(match["noun"])
        strange = not {noun, one} & (lexicon.words | lexicon.agents | lexicon.scene_nouns) and not is_look(
            noun
        )
        if match["before"] not in _SEATS and not {noun, one} & {*others} and (strange or {noun, one} & parts):
            yield match["colour"], noun
