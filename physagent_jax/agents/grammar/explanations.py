"""Explanations behind a colon that give numbers: "wring it: its upper end turns by 40 degrees"."""

from __future__ import annotations

from physagent_jax.agents.grammar.clauses import Clause, get_verb
from physagent_jax.agents.grammar.mentions import Mention, MentionKind, empty
from physagent_jax.agents.rules.language.modifiers import Names, Place
from physagent_jax.agents.rules.language.verbs import Effect

_MEASURES = (MentionKind.QUANTITY, MentionKind.TIME)
_SIZES = (Effect.SCALE, Effect.SWELL)


def merge_explanations(clauses: list[Clause], mentions: list[Mention]) -> tuple[list[Clause], list[Mention]]:
    """Joins a clause before a colon with the one behind it that measures the same motion.

    The verb is the first one's; what both tell is the second one's.

    Returns:
        The clauses, and the mentions; colons that are understood, and verbs that say the same again, are emptied.
    """
    mentions = list(mentions)
    for index, colon in enumerate(mentions):
        if colon.words != ":" or colon.kind is not MentionKind.JOIN:
            continue
        before = [c for c in clauses if c.head is not None and c.head.first < colon.first]
        after = [c for c in clauses if c.head is not None and _find_first(c) > colon.first]
        if len(before) == 1 and after and _is_explaining(before[0], after[0]):
            merged = _merge(before[0], after[0])
            clauses = [merged if c is before[0] else c for c in clauses if c is not after[0]]
            mentions[index] = empty(colon, ":")
            again = None if after[0].verb is None or after[0].inherited else after[0].verb.first
            mentions = [empty(m, m.phrase) if m.first == again else m for m in mentions]
    return clauses, mentions


def _find_first(clause: Clause) -> int:
    """Index of the first token of what a clause says itself: an inherited verb stands elsewhere."""
    return min((m.first for m in clause.mentions), default=-1)


def _is_explaining(clause: Clause, other: Clause) -> bool:
    """Return whether the second tells the first's motion again, with a measure that the first does not have."""
    if clause.negated or other.negated or clause.verb is None:
        return False
    one, two = get_verb(clause.head), get_verb(other.head)
    alike = one.effect is two.effect or {one.effect, two.effect} <= set(_SIZES)
    alike = alike or other.inherited
    alike = alike or _is_parting(clause) and two.effect in _SIZES and two.sign > 0
    if not alike or clause.select(*_MEASURES) or not other.select(MentionKind.QUANTITY):
        return False
    ways, others = ({m.value for m in c.select(MentionKind.DIRECTION)} for c in (clause, other))
    return not (ways and others) or ways == others


def _is_parting(clause: Clause) -> bool:
    """Return whether ends are pulled apart, which makes it longer."""
    return bool(clause.select(MentionKind.SIDES)) and get_verb(clause.head).pulls


def _merge(clause: Clause, other: Clause) -> Clause:
    told = [m for m in other.modifiers if not (m.kind is MentionKind.PLACE and _is_against(clause, other))]
    kinds = {m.kind for m in told}
    clause.modifiers = [*(m for m in clause.modifiers if m.kind not in kinds), *told]
    clause.mentions = [*clause.mentions, *other.mentions]
    clause.stays = clause.stays or other.stays
    return clause


def _is_against(clause: Clause, other: Clause) -> bool:
    """Return whether one end is measured against the other: what is wrung turns at both."""
    ends: list[Names] = [m.value.names for m in other.select(MentionKind.PLACE) if isinstance(m.value, Place)]
    return get_verb(clause.head).wrings and len(ends) > 1
