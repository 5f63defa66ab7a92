"""The account of verbs and ways: whether the grammar has used all that were found in the sentence.

A verb that heads no clause, and a way that no clause with a verb has taken up, got lost between two rules: "push it,
and after a short pause shake its head".
"""

from __future__ import annotations

import bisect
import itertools
from collections.abc import Sequence

from physagent_jax.agents.rules.language.clauses import Clause
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.verbs import Effect, Verb

_PARTING = (MentionKind.VERB, MentionKind.CAUSE, MentionKind.QUANTITY)  # "up half its height and down again"
_TELLING = (MentionKind.DIRECTION, MentionKind.INTENSITY, MentionKind.REPEAT)
_WEAK, _STRONG = 0.7, 1.2  # strengths up to and from which one word speaks against another
# What a hold or a rest adds to what is done needs no clause of its own: "bend it and hold it there".
_ADDING = (Effect.HOLD, Effect.STILL, Effect.RELEASE)

_SHAPING = (Effect.SCALE, Effect.SWELL)
_DENIALS = frozenset({"not", "don't", "do", "no", "never", "without", "doesn't", "instead", "rather"})


def find_unused(mentions: Sequence[Mention], clauses: Sequence[Clause]) -> list[str]:
    """Plain sentences about verbs and ways that no clause has taken up, and ways of two verbs that one has."""
    parting = [m.first for m in mentions if m.kind in _PARTING]
    doubts = [f"What '{m.words}' does here is not understood." for m in _list_lost_verbs(mentions, clauses)]
    doubts += [f"What '{m.words}' is said of is not understood." for m in _list_lost_ways(mentions, clauses)]
    doubts += [
        f"Whether '{one.words}' and '{other.words}' are of one motion is not understood."
        for clause in clauses
        for one, other in _list_mixed(clause, parting)
    ]
    for clause in clauses:
        doubts += [
            f"Which of {' and '.join(words)} is meant is not understood." for words in _list_rivals(clause)
        ]
    doubts += [
        f"What '{one.words}' denies is not understood."
        for one, other in zip(mentions, [*mentions[1:], None])
        if one.kind is MentionKind.NOT and (other is None or other.words in (".", ";", "!"))
    ]
    denied = _find_denied_manner(clauses)
    if denied is not None and not any(m.kind is MentionKind.DEGREE for m in mentions):
        doubts.append(f"Whether '{denied.words}' is of all that is denied is not understood.")
    return list(dict.fromkeys(doubts))


def _find_denied_manner(clauses: Sequence[Clause]) -> Mention | None:
    """Find a denied manner beside a motion that happens: "don't push it hard to the right, rock it"."""
    if len({c.head.first for c in clauses if c.head is not None and not c.negated and not c.inherited}) < 2:
        return None
    strengths = [m for c in clauses if not c.negated for m in c.select(MentionKind.INTENSITY)]
    return next((m for m in strengths if m.words.split()[0].lower() in _DENIALS), None)


def _list_lost_verbs(mentions: Sequence[Mention], clauses: Sequence[Clause]) -> list[Mention]:
    """Verbs that head no clause, unless the same word does elsewhere ("compress it and keep it compressed")."""
    heads = [head for clause in clauses for head in (clause.verb, clause.cause) if head is not None]
    used = {head.first for head in heads}
    phrases = {head.phrase for head in heads}
    effects = {head.value.effect for head in heads if isinstance(head.value, Verb)}
    return [
        m
        for before, m in zip([None, *mentions], mentions)
        if m.kind is MentionKind.VERB and isinstance(m.value, Verb) and m.first not in used
        if not m.value.generic and m.value.effect not in _ADDING and m.phrase not in phrases
        if m.value.effect not in _SHAPING or not effects.intersection(_SHAPING)  # "it grows taller"
        if m.value.effect is not Effect.FALL or Effect.TOPPLE not in effects  # "it tips over and falls"
        if before is None or before.kind is not MentionKind.CAUSE  # "the wind turns"
    ]


def _list_lost_ways(mentions: Sequence[Mention], clauses: Sequence[Clause]) -> list[Mention]:
    """Ways, strengths and counts that stand in a clause without a verb."""
    if not any(clause.head is not None for clause in clauses):
        return []
    headed = {
        m.first for clause in clauses if clause.head is not None for m in (*clause.modifiers, clause.head)
    }
    said = {m.value for m in mentions if m.kind in _TELLING and m.first in headed}
    loose = [m for clause in clauses if clause.head is None for m in clause.select(*_TELLING)]
    return [m for m in loose if m.first not in headed and m.value not in said]


def _list_rivals(clause: Clause) -> list[list[str]]:
    """Words that give one clause two strengths or two senses of rotation: "first gently, then hard"."""
    strengths = [
        (m, m.value) for m in clause.select(MentionKind.INTENSITY) if isinstance(m.value, float | int)
    ]
    weak = [m for m, value in strengths if value <= _WEAK]
    strong = [m for m, value in strengths if value >= _STRONG]
    senses = clause.select(MentionKind.SENSE)
    rivals = [[weak[0], strong[0]]] if weak and strong else []
    rivals += [senses[:2]] if len({m.value for m in senses}) > 1 else []
    return [[f"'{m.words}'" for m in pair] for pair in rivals]


def _list_mixed(clause: Clause, parting: Sequence[int]) -> list[tuple[Mention, Mention]]:
    """Different ways of one clause between which a verb or a quantity stands: each way may have its own."""
    ways = sorted(clause.select(MentionKind.DIRECTION, MentionKind.FROM), key=lambda m: m.first)
    found = []
    for one, other in itertools.pairwise(ways):
        same = one.value == other.value  # from the left and to the left are different ways
        mixed = same if one.kind is not other.kind else not same and one.kind is MentionKind.DIRECTION
        if mixed and bisect.bisect(parting, one.first) < bisect.bisect_left(parting, other.first):
            found.append((one, other))
    return found
