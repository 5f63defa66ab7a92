"""Verbs and causes of the lexicon under the names of this folder."""

from __future__ import annotations

from physagent_jax.agents.lexicon import Effect, read_lexicon
from physagent_jax.agents.lexicon import Motion as Verb

__all__ = ["Effect", "Verb"]
_WORDS = read_lexicon()
VERBS, CAUSES = _WORDS.motions, _WORDS.causes
IRREGULAR_FORMS, NOUNS_AFTER_THE = _WORDS.irregular, _WORDS.nouns
