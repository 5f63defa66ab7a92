"""Tables of words that only the grammar uses: measures, expressions, looks and scenery.

They are the lexicon's YAML files as well; here a section is a set of words, or a table from words to values.
"""

from __future__ import annotations

import functools

from physagent_jax.agents.lexicon import read_lexicon
from physagent_jax.agents.lexicon.reading import split_phrases
from physagent_jax.core.reading import read_packaged_yaml

LEXICON_PACKAGE = "physagent_jax.agents.lexicon"
FILES = ("measures", "expressions", "scenery")


@functools.cache
def read_sections(files: tuple[str, ...] = FILES) -> dict[str, dict]:
    """The sections of files; a set of words is a table whose values are None."""
    sections: dict[str, dict] = {}
    for name in files:
        for section, rows in read_packaged_yaml(LEXICON_PACKAGE, f"{name}.yaml").items():
            rows = rows if isinstance(rows, dict) else {None: rows}
            sections[section] = {
                word: value for value, words in rows.items() for word in split_phrases(str(words))
            }
    return sections


@functools.cache
def get_set(section: str) -> frozenset[str]:
    """A section as a set of words."""
    return frozenset(read_sections()[section])


LEXICON = read_lexicon()
NUMBERS: dict[str, float] = {
    **LEXICON.numbers,
    **{
        word: float(value)
        for part in ("tens", "teens", "multiples")
        for word, value in read_sections()[part].items()
    },
}
