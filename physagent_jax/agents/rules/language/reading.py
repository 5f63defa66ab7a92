"""A sentence as a list of mentions in the order of the words."""

from __future__ import annotations

from physagent_jax.agents.rules.language import modifiers as m
from physagent_jax.agents.rules.language import verbs as v
from physagent_jax.agents.rules.language.corrections import read_corrections
from physagent_jax.agents.rules.language.counts import read_ordinal, read_quantity, read_time_or_count
from physagent_jax.agents.rules.language.frames import drop_frames
from physagent_jax.agents.rules.language.idioms import (
    read_apart,
    read_coming,
    read_condition,
    read_farther,
    read_floating,
    read_frontal,
    read_manner,
    read_nothing,
    read_once,
    read_prevention,
    read_reach,
    read_so,
    read_solid,
    read_state,
    read_target,
    read_thanks,
)
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.phrases import read_phrase, read_word
from physagent_jax.agents.rules.language.places import read_place
from physagent_jax.agents.rules.language.reader import Reader
from physagent_jax.agents.rules.language.repetition import merge_repetitions
from physagent_jax.agents.rules.language.scopes import (
    drop_asides,
    mark_exceptions,
    part_substitutes,
    read_delays,
    read_returns,
    spread_from,
)
from physagent_jax.agents.rules.language.similes import read_similes


def find_mentions(prompt: str, object_words: frozenset[str]) -> list[Mention]:
    """The mentions of ``prompt``; ``object_words`` are names of the object and never verbs after "the"."""
    reader = Reader(prompt, object_words)
    for at in range(len(reader.tokens)):
        if at not in reader.used:
            reader.mentions.append(_read_at(reader, at))
    mentions = part_substitutes(read_corrections(reader.mentions, object_words), object_words)
    mentions = drop_asides(read_delays(read_returns(mentions)))
    mentions = merge_repetitions(read_similes(mark_exceptions(spread_from(mentions))), object_words)
    return drop_frames(mentions, object_words)


def _read_at(reader: Reader, at: int) -> Mention:
    token = reader.tokens[at]
    if not token.is_word:
        join = m.Join.COMMA if token.text in (",", ":") else m.Join.THEN
        return reader.make_mention(MentionKind.JOIN, join, token.text, [at])
    if token.text in reader.object_words and (token.lemma not in v.VERBS or reader.is_after_determiner(at)):
        return reader.make_mention(MentionKind.FUNCTION, None, token.text, [at])
    return (
        read_solid(reader, at)
        or read_thanks(reader, at)
        or read_once(reader, at)
        or read_condition(reader, at)
        or read_prevention(reader, at)
        or read_so(reader, at)
        or read_reach(reader, at)
        or read_state(reader, at)
        or read_target(reader, at)
        or read_floating(reader, at)
        or read_apart(reader, at)
        or read_farther(reader, at)
        or read_manner(reader, at)
        or read_frontal(reader, at)
        or read_coming(reader, at)
        or read_nothing(reader, at)
        or read_quantity(reader, at)
        or read_ordinal(reader, at)
        or read_place(reader, at)
        or read_time_or_count(reader, at)
        or read_phrase(reader, at)
        or read_word(reader, at)
    )
