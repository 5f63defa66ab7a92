"""Held things: a hold keeps what was just done, or it anchors the object."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.grammar.clauses import HOLDABLE, Clause, find_places, get_verb
from physagent_jax.agents.grammar.mentions import MentionKind
from physagent_jax.agents.rules.language.modifiers import Join
from physagent_jax.agents.rules.language.verbs import VERBS, Effect

_LETTING_GO = ("release", "let go", "let ~ go", "let loose", "set free", "relax", "let ~ relax")


def apply_holding(clauses: list[Clause]) -> list[Clause]:
    """Holding what was just moved keeps it there; holding what is then let go is no anchor."""
    result: list[Clause] = []
    for index, clause in enumerate(clauses):
        last = next((c for c in reversed(result) if c.head is not None), None)
        follows = next((c for c in clauses[index + 1 :] if c.head is not None and not c.negated), None)
        if clause.stays and last is not None and last.verb is not None and clause.verb is not None:
            if get_verb(last.verb).effect is get_verb(clause.verb).effect and not clause.modifiers:
                last.stays = True  # "compress it and keep it compressed"
                continue
        if clause.verb is not None and _is_hanging_in_the_air(clause, last):
            if follows is not None and get_verb(follows.head).effect is Effect.FALL:
                continue  # "thrown up, it hangs there and falls": so does all that turns back
            clause.verb = replace(clause.verb, value=VERBS["wait"], phrase="wait")
        if clause.negated or not is_bare_hold(clause) or clause.select(MentionKind.ANCHOR):
            result.append(clause)
            continue
        moved = last is not None and not last.negated and get_verb(last.head).effect in HOLDABLE
        if moved and last is not None and _is_let_go(follows) and not last.select(MentionKind.TIME):
            last.modifiers += clause.select(MentionKind.TIME)  # "hold it for a second, then release it"
            last.mentions += clause.mentions
            continue
        if follows is not None and clause.select(MentionKind.TIME) and clause.verb is not None:
            clause.verb = replace(
                clause.verb, value=VERBS["wait"], phrase="wait"
            )  # "hold it for a second, then"
            result.append(clause)
            continue
        if moved and clause.join is not Join.WHILE:
            assert last is not None
            last.stays = follows is None
            last.mentions += clause.mentions
        elif follows is None or get_verb(follows.head).effect not in (Effect.FALL, Effect.RELEASE):
            if clause.verb is not None and clause.verb.phrase.startswith(("stay", "remain")):
                clause.verb = replace(clause.verb, value=VERBS["stay put"], phrase="stay put")
            result.append(clause)
    return result


def _is_let_go(clause: Clause | None) -> bool:
    """Return whether what was held is let go of, and no more is told of that."""
    if clause is None or clause.verb is None or clause.negated or clause.modifiers:
        return False
    return get_verb(clause.verb).effect is Effect.RELEASE and clause.verb.phrase in _LETTING_GO


def _is_hanging_in_the_air(clause: Clause, last: Clause | None) -> bool:
    """Return whether what hangs has just been moved, and nothing is told that it hangs from."""
    if clause.verb is None or clause.verb.phrase != "hang" or clause.negated or clause.join is Join.WHILE:
        return False
    if last is None or last.negated or clause.select(MentionKind.ANCHOR, MentionKind.FROM, MentionKind.PLACE):
        return False
    return get_verb(last.head).effect in (Effect.PUSH, Effect.STRIKE, Effect.JUMP)


def is_bare_hold(clause: Clause) -> bool:
    """Return whether a clause only holds the object so far."""
    verb = None if clause.verb is None else get_verb(clause.verb)
    return (
        verb is not None and verb.effect is Effect.HOLD and verb.holds == "base" and not find_places(clause)
    )
