"""Clauses without a verb: the one before does it again, or a quantity says what is done."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.grammar.clauses import TURNING, WHERE, Clause, get_verb
from physagent_jax.agents.grammar.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import Repeat
from physagent_jax.agents.grammar.measures import Quantity
from physagent_jax.agents.rules.language.verbs import VERBS, Effect, Verb

_MOVING = (
    MentionKind.DIRECTION,
    MentionKind.FROM,
    MentionKind.SENSE,
    MentionKind.QUANTITY,
    MentionKind.REPEAT,
    MentionKind.INTENSITY,
    MentionKind.COMPARATIVE,
)


def inherit(clauses: list[Clause], index: int) -> None:
    """A clause without verb repeats the verb before it: "push it to the left, then to the right"."""
    clause = clauses[index]
    if clause.head is not None or not clause.modifiers:
        return
    if clause.select(MentionKind.ANCHOR) and not clause.select(*_MOVING):
        return  # "while its feet are stuck to the ground"
    for mention in clause.select(MentionKind.QUANTITY):
        size = mention.value
        if isinstance(size, Quantity) and size.acts and size.dimension != "far":  # "make it twice as tall"
            value = Verb(Effect.SCALE, sign=1 if size.value >= 1 else -1, direction="right")
            clause.verb = replace(mention, kind=MentionKind.VERB, value=value, phrase="scale")
            return
    pulls = clause.select(MentionKind.GRAVITY)
    if pulls and pulls[0].value == "down" and not clause.select(MentionKind.FROM):  # "then let gravity act"
        clause.verb = replace(pulls[0], kind=MentionKind.VERB, value=VERBS["fall"], phrase="fall")
        return
    before = next((c for c in reversed(clauses[:index]) if c.head is not None), None)
    if before is None or get_verb(before.head).effect in (Effect.STILL, Effect.RELEASE, Effect.HOLD):
        angles = [m for m in clause.select(MentionKind.QUANTITY) if getattr(m.value, "unit", "") == "degrees"]
        if angles:  # "a full turn"
            clause.verb = replace(angles[0], kind=MentionKind.VERB, value=VERBS["turn"], phrase="turn")
        return
    if (
        before.negated and before.verb is None and clause.select(MentionKind.DIRECTION)
    ):  # "no rotation, just up"
        way = clause.select(MentionKind.DIRECTION)[0]
        clause.verb = replace(way, kind=MentionKind.VERB, value=VERBS["push"], phrase="push")
        return
    angles = [m for m in clause.select(MentionKind.QUANTITY) if _is_turn(m)]
    if angles and get_verb(before.head).effect not in TURNING:
        clause.verb = replace(angles[0], kind=MentionKind.VERB, value=VERBS["turn"], phrase="turn")
        return
    clause.verb, clause.cause, clause.inherited = before.verb, before.cause, True
    ordinals = clause.select(MentionKind.ORDINAL)
    if ordinals:
        _take_stroke(before)
    if not clause.select(*WHERE):  # "..., then harder": the same again
        again = [m for m in before.select(*WHERE) if not (ordinals and m.kind is MentionKind.REPEAT)]
        clause.modifiers = [*again, *clause.modifiers]
    elif clause.select(MentionKind.SENSE) and not clause.select(
        MentionKind.AXIS, MentionKind.VIEW
    ):  # about the same axis
        clause.modifiers += before.select(MentionKind.AXIS, MentionKind.VIEW)


def _is_turn(mention: Mention) -> bool:
    """Return whether a quantity is a turn in so many words: "a quick half turn"."""
    degrees = isinstance(mention.value, Quantity) and mention.value.unit == "degrees"
    return degrees and any(noun in mention.words.lower() for noun in ("turn", "rotation", "revolution"))


def _take_stroke(clause: Clause) -> None:
    """One stroke less: it is told by itself ("twice, the second time harder")."""
    for index, mention in enumerate(clause.modifiers):
        if isinstance(mention.value, Repeat) and (mention.value.count or 0) > 1:
            repeat = replace(mention.value, count=(mention.value.count or 2) - 1)
            clause.modifiers[index] = replace(mention, value=repeat)
