"""Words that are not understood: which of them matter, and which only decorate."""

from __future__ import annotations

from physagent_jax.agents.rules.language.decoration import is_decorating, is_describing_part, is_owned_aside
from physagent_jax.agents.rules.language.frames import is_mood
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import PARTS, UNPLACED_PARTS
from physagent_jax.agents.rules.language.naming import DETERMINERS, OWNERS, PREPOSITIONS, is_telling
from physagent_jax.agents.rules.language.neighbours import get_phrase
from physagent_jax.agents.schema import SceneBrief

_LEAST_WORDS, _MOST_UNKNOWN = 3, 0.5


def list_unknown(
    mentions: list[Mention], names: frozenset[str], brief: SceneBrief
) -> tuple[list[str], list[str]]:
    """Unknown content words, and notes; a noun is taken for the object if the sentence does not name it otherwise."""
    named = any(mention.phrase in names for mention in mentions)
    may_be_named = not is_telling(brief.object_name)
    unknown: list[str] = []
    taken: list[str] = []
    for index, mention in enumerate(mentions):
        word = mention.phrase
        if mention.kind is not MentionKind.UNKNOWN or word in unknown or word in names:
            continue
        if is_mood(word):
            continue
        before = get_phrase(mentions, index - 1)
        owned = (
            before in OWNERS and not is_owned_aside(mentions, index) or word.removesuffix("s") in PARTS
        )  # "its corners", "the arms"
        if is_describing_part(mentions, index) or word in UNPLACED_PARTS or owned:
            unknown.append(word)
        elif (
            word.isalpha()
            and may_be_named
            and (before in taken or not (named or taken) and _is_done_to(mentions, index))
        ):
            taken.append(word)  # "the castle", "the sand castle"
        elif word not in taken and not is_decorating(mentions, index, names):
            unknown.append(word)
    notes = [f"'{' '.join(taken)}' is taken to be the object ({brief.object_name})."] if taken else []
    return unknown, notes


def is_mostly_unknown(mentions: list[Mention], unknown: list[str]) -> bool:
    """Return whether so little was understood that what was is probably misunderstood: another language, say."""
    words = [
        mention for mention in mentions if mention.kind is not MentionKind.JOIN or mention.words.isalpha()
    ]
    return len(words) >= _LEAST_WORDS and len(unknown) >= _MOST_UNKNOWN * len(words)


def _is_done_to(mentions: list[Mention], index: int) -> bool:
    """Return whether a noun with its article is a subject or an object, not after a preposition: "in a circle"."""
    return get_phrase(mentions, index - 1) in DETERMINERS and (
        get_phrase(mentions, index - 2) not in PREPOSITIONS
    )
