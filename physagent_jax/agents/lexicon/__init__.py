"""The lexicon: what words mean, as data (`*.yaml`), and the types of their meanings."""

from physagent_jax.agents.lexicon.inflection import inflect, read_forms
from physagent_jax.agents.lexicon.reading import LexiconError, make_lexicon, read_lexicon
from physagent_jax.agents.lexicon.types import (
    NAMED,
    Effect,
    Join,
    Lexicon,
    Moment,
    Motion,
    Names,
    Place,
    Repeat,
)

__all__ = [
    "NAMED", "Effect", "Join", "Lexicon", "LexiconError", "Moment", "Motion", "Names", "Place", "Repeat",
    "inflect", "make_lexicon", "read_forms", "read_lexicon"
]  # fmt: skip
