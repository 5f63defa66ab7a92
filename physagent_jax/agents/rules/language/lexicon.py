"""All phrases of `verbs` and `modifiers` by their first word."""

from __future__ import annotations

from physagent_jax.agents.rules.language import modifiers as m
from physagent_jax.agents.rules.language import verbs as v
from physagent_jax.agents.rules.language.mentions import MentionKind
from physagent_jax.agents.rules.language.modifiers import FUNCTION_PHRASES
from physagent_jax.agents.rules.language.timing import parse_moment

Entry = tuple[tuple[str, ...], MentionKind, object]


def _build_lexicon() -> dict[str, list[Entry]]:
    """All phrases by their first word, longest first; at equal length the earlier table wins."""
    tables: list[tuple[MentionKind, dict]] = [
        (MentionKind.REPEAT, m.REPEATS),
        (MentionKind.VERB, v.VERBS),
        (MentionKind.CAUSE, v.CAUSES),
        (MentionKind.GRAVITY, m.GRAVITY),
        (MentionKind.ANCHOR, m.ANCHORS),
        (MentionKind.SENSE, m.SENSES),
        (MentionKind.VIEW, m.VIEWS),
        (MentionKind.AXIS, m.AXES),
        (MentionKind.PLANE, m.PLANES),
        (MentionKind.SIDES, m.SIDES),
        (MentionKind.PLACE, m.PLACES),
        (MentionKind.DIRECTION, m.DIRECTIONS),
        (MentionKind.COMPARATIVE, m.COMPARATIVES),
        (MentionKind.INTENSITY, m.INTENSITIES),
        (MentionKind.DEGREE, m.DEGREES),
        (MentionKind.JOIN, m.JOINS),
        (MentionKind.REVERSAL, dict.fromkeys(m.REVERSALS)),
        (MentionKind.REVERSAL, dict.fromkeys(m.SAME_WAYS, "same")),
        (MentionKind.EVEN, dict.fromkeys(m.EVENLY)),
        (MentionKind.EXCEPT, dict.fromkeys(m.EXCEPTIONS)),
        (MentionKind.TIME, {phrase: parse_moment(phrase) for phrase in m.MOMENTS}),
        (MentionKind.NOT, dict.fromkeys(m.NEGATIONS)),
        (MentionKind.FUNCTION, dict.fromkeys(FUNCTION_PHRASES)),
    ]
    by_first: dict[str, list[Entry]] = {}
    for kind, table in tables:
        for phrase, value in table.items():
            words = tuple(phrase.split())
            by_first.setdefault(words[0], []).append((words, kind, value))
    for entries in by_first.values():
        entries.sort(key=lambda entry: -len(entry[0]))
    return by_first


LEXICON = _build_lexicon()
