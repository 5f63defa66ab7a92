"""A sentence cut at its connectives."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.grammar.clauses import HEADS, OPPOSITES
from physagent_jax.agents.grammar.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import Join
from physagent_jax.agents.rules.language.verbs import Effect, Verb

_TIMED = frozenset({Join.WHILE, Join.AFTER, Join.BEFORE})
_GOING_ON = frozenset({Join.AND, Join.THEN})
_MEANWHILE = frozenset({"at the same time", "and at the same time", "simultaneously", "meanwhile"})
_LATER = frozenset(
    {"afterwards", "afterward", "later", "after that", "subsequently", "in the end", "at last"}
)
_DURING = frozenset({"while", "whilst", "as"})


def split_segments(mentions: list[Mention]) -> list[tuple[Join, list[Mention]]]:
    """Cuts at connectives; of several in a row (", and then") the most telling one counts."""
    rank = [Join.COMMA, Join.AND, Join.RESULT, Join.WHILE, Join.BUT, Join.THEN, Join.AFTER, Join.BEFORE]
    segments: list[tuple[Join, list[Mention]]] = [(Join.THEN, [])]
    mentions = _part_list(mentions)
    for index, mention in enumerate(mentions):
        if mention.kind is MentionKind.JOIN:
            assert isinstance(mention.value, Join)
            if _is_trailing(mentions, index) and segments[-1][0] in (Join.AND, Join.COMMA):
                segments[-1] = (mention.value, segments[-1][1])  # "lift it first and spin it afterwards"
            elif any(m.kind is not MentionKind.FUNCTION for m in segments[-1][1]):
                segments.append((mention.value, []))
            elif len(segments) == 1 and mention.phrase == "until":
                segments[-1] = (Join.BEFORE, segments[-1][1])  # "until it is hit, it stays still"
            elif len(segments) == 1 and mention.phrase in _DURING:
                segments[-1] = (Join.WHILE, segments[-1][1])
            elif len(segments) > 1 and mention.phrase in _MEANWHILE:
                segments[-1] = (Join.WHILE, segments[-1][1])  # "it rises; at the same time it spins"
            elif mention.value is Join.AFTER and len(segments) > 1 and segments[-1][1]:
                segments.append((Join.AFTER, []))  # "stop it with a hand after it has rolled"
            elif mention.phrase.startswith("before ") and len(segments) > 1:
                segments[-1] = (Join.AFTER, segments[-1][1])  # "push it; before that, lift it"
            elif mention.value is Join.AFTER and len(segments) > 1 and segments[-1][0] in _GOING_ON:
                segments[-1] = (Join.THEN, segments[-1][1])  # "lift it, and after landing it spins"
            elif len(segments) > 1 or mention.value in (Join.BEFORE, Join.AFTER):
                segments[-1] = (max(segments[-1][0], mention.value, key=rank.index), segments[-1][1])
        else:
            if (
                len(segments) == 1
                and segments[0][0] in _TIMED
                and _begins_main_clause(mentions[index:], segments[0][1])
            ):
                segments.append((Join.COMMA, []))  # "as it falls it spins"
            segments[-1][1].append(mention)
    return [segment for segment in segments if segment[1]]


def _is_trailing(mentions: list[Mention], index: int) -> bool:
    """Return whether a word for what comes later ends its segment, and so belongs to what stands before it."""
    ends = index + 1 == len(mentions) or mentions[index + 1].kind is MentionKind.JOIN
    return ends and mentions[index].phrase in _LATER | _MEANWHILE


def _begins_main_clause(mentions: list[Mention], before: list[Mention]) -> bool:
    """Return whether a subject with its verb stands behind the one that only told the time."""
    subject, *rest = mentions
    if subject.form not in ("it", "he", "she") or not any(m.kind in HEADS for m in before):
        return False
    follows = next((m for m in rest if m.kind is not MentionKind.INTENSITY), None)
    if follows is None:
        return False
    finite = follows.kind is MentionKind.VERB and follows.form.endswith("s")
    return finite or follows.form in ("is", "gets", "will")


def _part_list(mentions: list[Mention]) -> list[Mention]:
    """Makes steps of the ways in a list that goes on with "then": "left, up, then right"."""
    joins = [i for i, m in enumerate(mentions) if m.kind is MentionKind.JOIN]
    result = list(mentions)
    thens = (i for i in reversed(joins) if mentions[i].value is Join.THEN and mentions[i].words.isalpha())
    last = next(thens, -1)
    for begin, at, end in zip([-1, *joins], joins, joins[1:]):
        if not any(m.kind is MentionKind.DIRECTION for m in mentions[begin + 1 : at]):
            continue
        listed = mentions[at].value is Join.COMMA and mentions[end].value in (Join.COMMA, Join.THEN)
        kinds = {m.kind for m in mentions[at + 1 : end]} - {MentionKind.FUNCTION}
        if (
            listed
            and end <= last
            and kinds <= {MentionKind.DIRECTION, MentionKind.INTENSITY}
            and MentionKind.DIRECTION in kinds
        ):
            result[at] = replace(mentions[at], value=Join.THEN)
    return _part_contrary(result)


def _part_contrary(mentions: list[Mention]) -> list[Mention]:
    """Makes steps of a list of three ways and more that cancel: "it goes up, left, down"."""
    joins = [i for i, m in enumerate(mentions) if m.kind is MentionKind.JOIN]
    result = list(mentions)
    run: list[int] = []
    ways: list[object] = []
    for begin, end in zip([-1, *joins], [*joins, len(mentions)]):
        inside = mentions[begin + 1 : end]
        told = [m.value for m in inside if m.kind is MentionKind.DIRECTION]
        bare = {m.kind for m in inside} <= {
            MentionKind.DIRECTION,
            MentionKind.INTENSITY,
            MentionKind.FUNCTION,
        }
        follows = begin >= 0 and mentions[begin].value in (Join.COMMA, Join.AND)
        if len(told) == 1 and bare and follows and ways:
            run, ways = [*run, begin], [*ways, *told]
        else:
            moves = [m.value for m in inside if isinstance(m.value, Verb) and m.kind is MentionKind.VERB]
            moves = [verb for verb in moves if verb.effect in (Effect.PUSH, Effect.STRIKE, Effect.LEAN)]
            run, ways = [], told if len(told) == 1 and moves else []
        if len(ways) > 2 and any({*pair} <= {*ways} for pair in OPPOSITES):
            for at in run:
                result[at] = replace(mentions[at], value=Join.THEN)
    return result
