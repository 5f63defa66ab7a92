"""The grammar: marks -> clauses, each with at most one verb, its modifiers and its relation to the one before.

A connective opens a segment of the sentence. A segment with a verb starts a clause; one without
continues the clause before it ("to the left *and up*") or repeats its verb ("..., *then to the right*").
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from physagent_jax.agents.rules.language.marks import Kind, Mark
from physagent_jax.agents.rules.language.modifiers import Join, Place, Repeat
from physagent_jax.agents.rules.language.verbs import Doing, Verb

_WHERE = (Kind.DIRECTION, Kind.FROM, Kind.AXIS, Kind.PLANE, Kind.SIDES, Kind.SENSE, Kind.PLACE, Kind.REPEAT)
_NEGATABLE = (
    *_WHERE,
    Kind.VERB,
    Kind.CAUSE,
    Kind.INTENSITY,
    Kind.DEGREE,
    Kind.COMPARATIVE,
    Kind.GRAVITY,
    Kind.ANCHOR,
)
_SEPARATE_EFFECTS = (Doing.FALL, Doing.TOPPLE, Doing.STILL, Doing.RELEASE, Doing.HOLD)


@dataclass
class Clause:
    """One thing that the sentence says.

    Attributes:
        join: Relation to the clause before.
        verb: The word that says what is done; None while only modifiers were met.
        cause: A noun that names what does it ("wind").
        modifiers: Everything else.
        negated: It is said *not* to happen.
        inherited: The verb is that of the clause before.
        marks: All marks, for quoting.
    """

    join: Join
    verb: Mark | None = None
    cause: Mark | None = None
    modifiers: list[Mark] = field(default_factory=list)
    negated: bool = False
    inherited: bool = False
    marks: list[Mark] = field(default_factory=list)

    def of(self, *kinds: Kind) -> list[Mark]:
        """Its modifiers of these kinds."""
        return [mark for mark in self.modifiers if mark.kind in kinds]

    @property
    def acts(self) -> Mark | None:
        """The mark that decides what is done."""
        return self.verb or self.cause

    @property
    def words(self) -> str:
        """The words of the mark that decides what is done."""
        return self.acts.words if self.acts else ""


def verb_of(mark: Mark | None) -> Verb:
    """The value of a VERB or CAUSE mark."""
    assert mark is not None and isinstance(mark.value, Verb)
    return mark.value


def read_clauses(marks: list[Mark]) -> list[Clause]:
    """Groups marks into clauses, in the order in which they happen."""
    clauses: list[Clause] = []
    for join, segment in _segments(marks):
        _add_segment(clauses, join, _apply_negations(segment))
    clauses = [c for c in (_inherit(clauses, i) for i in range(len(clauses))) if c is not None]
    return _in_order(_merge_results(clauses))


def _segments(marks: list[Mark]) -> list[tuple[Join, list[Mark]]]:
    """Cuts at connectives; of several in a row (", and then") the most telling one counts."""
    rank = [Join.COMMA, Join.AND, Join.RESULT, Join.WHILE, Join.BUT, Join.THEN, Join.AFTER, Join.BEFORE]
    segments: list[tuple[Join, list[Mark]]] = [(Join.THEN, [])]
    for mark in marks:
        if mark.kind is Kind.JOIN:
            assert isinstance(mark.value, Join)
            if any(m.kind is not Kind.FUNCTION for m in segments[-1][1]):
                segments.append((mark.value, []))
            elif len(segments) > 1 or mark.value in (Join.BEFORE, Join.AFTER):
                segments[-1] = (max(segments[-1][0], mark.value, key=rank.index), segments[-1][1])
        else:
            segments[-1][1].append(mark)
    return [segment for segment in segments if segment[1]]


def _apply_negations(marks: list[Mark]) -> list[Mark]:
    """Resolves NOT on everything but verbs: what is negated vanishes or turns into its opposite."""
    result: list[Mark] = []
    pending: Mark | None = None
    for mark in marks:
        if mark.kind is Kind.NOT:
            pending = mark
        elif pending is None or mark.kind not in _NEGATABLE:
            result.append(mark)
        elif mark.kind is Kind.DEGREE:  # "not too hard": the intensity that follows is negated
            continue
        else:
            result += _opposite(pending, mark)
            pending = None
    return result


def _opposite(negation: Mark, mark: Mark) -> list[Mark]:
    """What "not X" says."""
    if mark.kind in (Kind.VERB, Kind.CAUSE):
        return [negation, mark]
    if mark.kind in (Kind.INTENSITY, Kind.COMPARATIVE):
        assert isinstance(mark.value, float)
        value = 0.8 if mark.value > 1 else 1.2
        return [replace(mark, kind=Kind.INTENSITY, value=value, words=f"{negation.words} {mark.words}")]
    if mark.kind is Kind.GRAVITY:
        return [replace(mark, value=not mark.value, words=f"{negation.words} {mark.words}")]
    if mark.kind is Kind.ANCHOR:
        return [
            replace(
                mark, value="none" if mark.value != "none" else "base", words=f"{negation.words} {mark.words}"
            )
        ]
    return []


def _add_segment(clauses: list[Clause], join: Join, marks: list[Mark]) -> None:
    """Continues the last clause or starts new ones, at each verb of the segment."""
    has_verb = any(mark.kind is Kind.VERB for mark in marks)
    has_cause = any(mark.kind is Kind.CAUSE for mark in marks)
    clause = _open_clause(clauses, join, has_verb, has_cause, marks)
    fresh = clause.verb is None
    negated = False
    for mark in marks:
        if mark.kind is Kind.NOT:
            negated = True
        elif mark.kind is Kind.VERB and (negated or not _absorbed(clause, mark, fresh)):
            if clause.verb is not None and (negated or not _replaceable(clause.verb)):
                clause = Clause(Join.AND)
                clauses.append(clause)
            clause.verb, clause.negated, negated = mark, negated, False
            clause.marks.append(mark)
        elif mark.kind is Kind.CAUSE:
            _add_cause(clause, mark, negated, has_verb)
            negated = False
        elif mark.kind not in (Kind.FUNCTION, Kind.UNKNOWN, Kind.VERB):
            clause.modifiers.append(mark)
            clause.marks.append(mark)


def _add_cause(clause: Clause, mark: Mark, negated: bool, has_verb: bool) -> None:
    if negated and has_verb:  # "moves without wind": the cause is merely absent
        return
    clause.cause = clause.cause or mark
    clause.negated = clause.negated or negated
    clause.marks.append(mark)


def _open_clause(
    clauses: list[Clause], join: Join, has_verb: bool, has_cause: bool, marks: list[Mark]
) -> Clause:
    """The clause that a segment belongs to; a new one is appended."""
    last = clauses[-1] if clauses else None
    if last is not None:
        waiting = last.acts is None and not (len(clauses) > 1 and last.of(*_WHERE))
        # "a breeze comes and moves it": the noun of the last segment does what this verb says
        carried = (
            last.verb is None and last.cause is not None and has_verb and join in (Join.AND, Join.RESULT)
        )
        continues = (
            not has_verb
            and join in (Join.AND, Join.COMMA, Join.RESULT)
            and not (has_cause and join is Join.COMMA)
        )
        corrects = (
            join is Join.BUT and not has_verb and not last.negated
        )  # "not to the left but to the right"
        if (
            (waiting and join is not Join.THEN)
            or carried
            or corrects
            or (continues and not _other_place(last, marks))
        ):
            return last
    clause = Clause(join)
    clauses.append(clause)
    return clause


def _other_place(last: Clause, marks: list[Mark]) -> bool:
    """Whether a segment sends another part elsewhere: "... the top to the left and the bottom to the right"."""
    kinds = {mark.kind for mark in marks}
    return (
        Kind.PLACE in kinds
        and bool(kinds & {Kind.DIRECTION, Kind.FROM, Kind.SENSE})
        and bool(last.of(Kind.PLACE))
    )


def _absorbed(clause: Clause, mark: Mark, fresh: bool) -> bool:
    """Whether a second verb adds nothing: "stops moving", "a kick sends it flying"."""
    if clause.verb is None or not fresh:
        return False
    first, second = verb_of(clause.verb), verb_of(mark)
    stops = first.doing is Doing.STILL and not first.generic
    return stops or (second.generic and first.doing is not Doing.STILL)


def _replaceable(mark: Mark) -> bool:
    """Whether a verb only announces the next one: "goes spinning", "stands swaying"."""
    return verb_of(mark).generic


def _inherit(clauses: list[Clause], index: int) -> Clause | None:
    """A clause without verb repeats the verb before it: "push it to the left, then to the right"."""
    clause = clauses[index]
    if clause.acts is not None or not clause.modifiers:
        return clause
    before = next((c for c in reversed(clauses[:index]) if c.acts is not None), None)
    if before is None or verb_of(before.acts).doing in (Doing.STILL, Doing.RELEASE, Doing.HOLD):
        return clause
    clause.verb, clause.cause, clause.inherited = before.verb, before.cause, True
    if not clause.of(*_WHERE):  # "..., then harder": the same again
        clause.modifiers = [*before.of(*_WHERE), *clause.modifiers]
    elif clause.of(Kind.SENSE) and not clause.of(Kind.AXIS, Kind.VIEW):  # about the same axis
        clause.modifiers += before.of(Kind.AXIS, Kind.VIEW)
    return clause


def _merge_results(clauses: list[Clause]) -> list[Clause]:
    """Makes one action of cause and effect ("pushes it so that it bends"): the effect's verb, all modifiers."""
    merged: list[Clause] = []
    for clause in clauses:
        if clause.join is Join.COMMA and clause.verb and merged and merged[-1].acts is not None:
            participle = clause.verb.form.endswith("ing") and not merged[-1].acts.form.endswith("ing")
            clause.join = Join.RESULT if participle else Join.COMMA
        related = clause.join is Join.RESULT
        if merged and _carried_off(merged[-1], clause):
            clause.modifiers = [mark for mark in clause.modifiers if mark.phrase != "away"]
            related = True
        related = related or (bool(merged) and _moved_by_wind(merged[-1], clause))
        mergeable = (
            related
            and merged
            and merged[-1].acts
            and clause.verb
            and not clause.negated
            and not merged[-1].negated
        )
        if not mergeable:
            merged.append(clause)
        elif verb_of(clause.verb).doing in _SEPARATE_EFFECTS:
            stops = verb_of(clause.verb).doing in (Doing.STILL, Doing.RELEASE)
            clause.join = Join.THEN if stops else Join.WHILE
            merged.append(clause)
        else:
            _merge(merged[-1], clause)
    return merged


def _moved_by_wind(wind: Clause, clause: Clause) -> bool:
    """Whether a swaying is the wind's work and goes its way: "wind blows from the left and the plant sways"."""
    if clause.verb is None or wind.acts is None or not verb_of(wind.acts).wind or clause.join is Join.THEN:
        return False
    doing = verb_of(clause.verb).doing
    return doing is Doing.LEAN or (doing is Doing.SWAY and not clause.of(Kind.DIRECTION, Kind.FROM))


def _carried_off(blow: Clause, clause: Clause) -> bool:
    """Whether a travel is a blow's work: "kicked from the left and flies away"."""
    if clause.verb is None or blow.acts is None or clause.join not in (Join.AND, Join.COMMA):
        return False
    verb = verb_of(clause.verb)
    return verb.generic and verb.doing is Doing.PUSH and verb_of(blow.acts).doing is Doing.STRIKE


def _merge(cause: Clause, effect: Clause) -> None:
    if not verb_of(effect.verb).generic:
        cause.cause, cause.verb = cause.cause or cause.verb, effect.verb
    cause.modifiers += effect.modifiers
    cause.marks += effect.marks


def _in_order(clauses: list[Clause]) -> list[Clause]:
    """Puts "B after A" and "before B, A" in the order of time; a list is a sequence to its last "and"."""
    ordered: list[Clause] = []
    held_back: Clause | None = None
    for index, clause in enumerate(clauses):
        if clause.join is Join.BEFORE and index == 0 and len(clauses) > 1:
            held_back = clause
            continue
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


def places(clause: Clause) -> list[Place]:
    """The parts of the object that a clause names."""
    return [mark.value for mark in clause.of(Kind.PLACE) if isinstance(mark.value, Place)]


def repeats(clause: Clause) -> list[Repeat]:
    """The counts that a clause names."""
    return [mark.value for mark in clause.of(Kind.REPEAT) if isinstance(mark.value, Repeat)]
