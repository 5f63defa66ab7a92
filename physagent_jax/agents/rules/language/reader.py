"""A sentence while its phrases are looked for: what stands where, and what was found so far."""

from __future__ import annotations

from physagent_jax.agents.rules.language import verbs as v
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.spelling import correct_spelling
from physagent_jax.agents.rules.language.tokens import tokenise

OWNING = frozenset({"the", "its", "his", "her", "their", "a", "an", "this", "that", "your", "my", "some"})
FINITE = frozenset({"is", "are", "was", "were", "has", "have", "will", "would", "can", "should"})


class Reader:
    """One sentence and its tokens.

    Attributes:
        prompt: The sentence.
        tokens: Its tokens.
        object_words: Names of the object.
        used: Indices of the tokens that belong to a mention.
        mentions: What was found, in order of the first words.
    """

    def __init__(self, prompt: str, object_words: frozenset[str]):
        self.prompt, self.tokens = prompt, correct_spelling(tokenise(prompt), object_words)
        self.object_words = object_words
        self.used: set[int] = set()
        self.mentions: list[Mention] = []

    def is_striking(self) -> bool:
        """Return whether the last verb is a blow."""
        verbs = [e.value for e in self.mentions if isinstance(e.value, v.Verb)]
        return bool(verbs) and verbs[-1].effect is v.Effect.STRIKE

    def make_mention(self, kind: MentionKind, value: object, phrase: str, used: list[int]) -> Mention:
        """The mention of the tokens ``used``, which belong to it from now on."""
        self.used.update(used)
        words = self.prompt[self.tokens[used[0]].start : self.tokens[used[-1]].end]
        return Mention(kind, value, words, phrase, used[0], self.tokens[used[0]].text)

    def get_text(self, at: int) -> str:
        """The text of a token; empty past the ends."""
        return self.tokens[at].text if 0 <= at < len(self.tokens) else ""

    def is_after_determiner(self, at: int) -> bool:
        """Return whether an article or the like stands before it."""
        return self.get_text(at - 1) in OWNING

    def get_preposition(self, at: int) -> str:
        """The word before, past a determiner."""
        before = at - 2 if self.is_after_determiner(at) else at - 1
        return self.get_text(before)
