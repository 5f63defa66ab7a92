"""The grammar: mentions -> clauses, each with at most one verb, its modifiers and its relation to the one before.

A connective opens a segment of the sentence. A segment with a verb starts a clause; one without
continues the clause before it ("to the left *and up*") or repeats its verb ("..., *then to the right*").
"""

from __future__ import annotations

from physagent_jax.agents.grammar.clauses import Clause
from physagent_jax.agents.grammar.consequences import (
    give_exceptions,
    merge_results,
    split_turning_winds,
)
from physagent_jax.agents.grammar.grouping import add_segment
from physagent_jax.agents.grammar.holding import apply_holding
from physagent_jax.agents.grammar.inheritance import inherit
from physagent_jax.agents.grammar.mentions import Mention
from physagent_jax.agents.rules.language.modifiers import Join
from physagent_jax.agents.grammar.negation import apply_negations
from physagent_jax.agents.grammar.segments import split_segments


def read_clauses(mentions: list[Mention]) -> list[Clause]:
    """Groups mentions into clauses, in the order in which they happen."""
    clauses: list[Clause] = []
    for join, segment in split_segments(mentions):
        add_segment(clauses, join, apply_negations(segment))
    clauses = give_exceptions(split_turning_winds(clauses))
    for index in range(len(clauses)):
        inherit(clauses, index)
    return apply_holding(_sort_clauses(merge_results(clauses)))


def _sort_clauses(clauses: list[Clause]) -> list[Clause]:
    """Puts "B after A" and "before B, A" in the order of time; a list is a sequence to its last "and"."""
    ordered: list[Clause] = []
    held_back: Clause | None = None
    for index, clause in enumerate(clauses):
        if clause.join is Join.BEFORE and index == 0 and len(clauses) > 1:
            held_back = clause
            continue
        if index == 1 and clauses[0].join is Join.WHILE and clause.join is Join.COMMA:
            clause.join = Join.WHILE  # "while it falls, it rotates"
        if clause.join is Join.AFTER and ordered:
            ordered.insert(len(ordered) - 1, clause)
            clause.join, ordered[-1].join = ordered[-1].join, Join.THEN
        else:
            ordered.append(clause)
        if held_back is not None:
            held_back.join = Join.THEN
            ordered.append(held_back)
            held_back = None
    for before, clause in zip(ordered, ordered[1:]):
        if clause.join is Join.AND and before.join is Join.COMMA and before is not ordered[0]:
            clause.join = Join.COMMA
    return ordered
