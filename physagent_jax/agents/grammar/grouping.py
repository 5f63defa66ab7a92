"""Segments as clauses: whether a segment goes on with the clause before it or begins one."""

from __future__ import annotations

from physagent_jax.agents.grammar.clauses import (
    HOLDABLE,
    OPPOSITES,
    TURNING,
    WHERE,
    Clause,
    find_repeats,
    get_verb,
)
from physagent_jax.agents.grammar.holding import is_bare_hold
from physagent_jax.agents.grammar.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import Join
from physagent_jax.agents.grammar.measures import Quantity
from physagent_jax.agents.grammar.tokens import is_participle
from physagent_jax.agents.rules.language.verbs import Effect

_WAYS = (MentionKind.DIRECTION, MentionKind.FROM)
_BOTH_WAYS = (Effect.SWAY, Effect.SCALE, Effect.SWELL)
_KEEPS = frozenset({"keep", "keeps", "kept", "keeping"})
_MEASURED = {MentionKind.INTENSITY, MentionKind.COMPARATIVE, MentionKind.QUANTITY, MentionKind.TIME}


def add_segment(clauses: list[Clause], join: Join, mentions: list[Mention]) -> None:
    """Continues the last clause or starts new ones, at each verb of the segment."""
    has_verb = any(mention.kind is MentionKind.VERB for mention in mentions)
    has_cause = any(mention.kind is MentionKind.CAUSE for mention in mentions)
    clause = _open_clause(clauses, join, has_verb, has_cause, mentions)
    fresh = clause.verb is None
    negated = kept = False
    for mention in mentions:
        kept = kept or mention.kind is MentionKind.FUNCTION and mention.form in _KEEPS
        if mention.kind is MentionKind.NOT:
            negated = True
        elif mention.kind is MentionKind.VERB and (
            negated
            or _is_going_besides(clause, mentions, mention)
            or not _is_absorbed(clause, mention, fresh)
        ):
            participle = not is_participle(mention.form)
            is_hold = participle and (
                kept or fresh and is_bare_hold(clause)
            )  # "hold it bent", "keep it bent"
            replaceable = clause.verb is not None and (
                _is_replaceable(clause.verb) or _is_becoming(clause.verb, mention)
            )
            gone = negated and clause.head is None and len(clauses) > 1 and bool(clause.select(*_WAYS))
            if gone or clause.verb is not None and not is_hold and (negated or not replaceable):
                clause = Clause(Join.AND)
                clauses.append(clause)
            clause.stays = is_hold and get_verb(mention).effect in HOLDABLE
            clause.verb, clause.negated, negated = mention, negated, False
            clause.mentions.append(mention)
        elif mention.kind is MentionKind.CAUSE:
            _add_cause(clause, mention, negated, has_verb)
            negated = negated and clause.verb is None and _is_subject(mentions, mention)
        elif mention.kind not in (MentionKind.FUNCTION, MentionKind.UNKNOWN, MentionKind.VERB):
            clause.modifiers.append(mention)
            clause.mentions.append(mention)


def _is_subject(mentions: list[Mention], cause: Mention) -> bool:
    """Return whether "no" stands before a cause and its verb behind: "no breeze moves it"."""
    denied = any(m.phrase == "no" and m.first == cause.first - 1 for m in mentions)
    behind = next(
        (m for m in mentions if m.first > cause.first and m.kind is not MentionKind.INTENSITY), None
    )
    return denied and behind is not None and behind.kind is MentionKind.VERB


def _add_cause(clause: Clause, mention: Mention, negated: bool, has_verb: bool) -> None:
    if negated and has_verb:  # "moves without wind": the cause is merely absent
        return
    clause.cause = clause.cause or mention
    clause.negated = clause.negated or negated
    clause.mentions.append(mention)


def _open_clause(
    clauses: list[Clause], join: Join, has_verb: bool, has_cause: bool, mentions: list[Mention]
) -> Clause:
    """The clause that a segment belongs to; a new one is appended."""
    last = clauses[-1] if clauses else None
    if last is not None:
        waiting = last.head is None and not (len(clauses) > 1 and last.select(*WHERE))
        waiting = waiting and not any(_is_turn(m) for m in last.modifiers)
        # "a breeze comes and moves it": the noun of the last segment does what this verb says
        carried = (
            last.verb is None
            and last.cause is not None
            and has_verb
            and join in (Join.AND, Join.RESULT)
            and not any(m.kind is MentionKind.VERB and get_verb(m).effect is Effect.HOLD for m in mentions)
        )
        continues = (
            not has_verb
            and join in (Join.AND, Join.COMMA, Join.RESULT)
            and not (has_cause and join is Join.COMMA)
            and not (join is Join.COMMA and _is_subordinate(clauses))
            and not (last.negated and last.verb is None)  # "no rotation, just up"
        )
        if not has_verb and join is Join.COMMA and last.head is not None and _is_other_place(last, mentions):
            clause = Clause(Join.WHILE)  # "the top is pushed left, the bottom right"
            clauses.append(clause)
            return clause
        turns_back = not has_verb and _is_turning_back(clauses, join, mentions)
        strokes = any(mention.kind is MentionKind.ORDINAL for mention in mentions)
        beside = not has_verb and (_is_another(mentions) or _is_other_measure(last, join, mentions))
        turns = not has_verb and last.head is not None and _is_own_turn(last, mentions)
        if turns_back or strokes or beside or turns:
            clause = Clause(join if turns and join in (Join.BEFORE, Join.AFTER, Join.WHILE) else Join.THEN)
            clauses.append(clause)
            return clause
        corrects = (
            join is Join.BUT and not has_verb and not last.negated
        )  # "not to the left but to the right"
        if (
            (waiting and join is not Join.THEN)
            or carried
            or corrects
            or (continues and not _is_other_place(last, mentions))
        ):
            return last
    clause = Clause(join)
    clauses.append(clause)
    return clause


def _is_own_turn(last: Clause, mentions: list[Mention]) -> bool:
    """Return whether a segment names a turn that the verb before it does not make: "it slides in, does a half turn"."""
    return any(map(_is_turn, mentions)) and get_verb(last.head).effect not in TURNING


def _is_turn(mention: Mention) -> bool:
    degrees = isinstance(mention.value, Quantity) and mention.value.unit == "degrees"
    return degrees and "turn" in mention.words.lower()


def _is_subordinate(clauses: list[Clause]) -> bool:
    """Return whether only the time was told so far: "once it has landed, ..."."""
    return len(clauses) == 1 and clauses[0].join is Join.AFTER and clauses[0].verb is not None


def _is_another(mentions: list[Mention]) -> bool:
    """Return whether a segment tells of one more of them: "two kicks from the left and one from above"."""
    for mention, after in zip(mentions, mentions[1:]):
        counts = mention.kind is MentionKind.FUNCTION and mention.form in ("one", "another", "other")
        if counts and (
            after.kind in (MentionKind.DIRECTION, MentionKind.FROM)
            or after.phrase in ("to", "from", "toward", "towards")
        ):
            return any(m.kind in (MentionKind.DIRECTION, MentionKind.FROM) for m in mentions)
    return False


def _is_other_measure(last: Clause, join: Join, mentions: list[Mention]) -> bool:
    """Return whether a segment goes the other way by its own measure: "hard to the left and softly to the right"."""
    if join is not Join.AND or last.head is None or get_verb(last.head).effect in _BOTH_WAYS:
        return False
    kinds = {mention.kind for mention in mentions}
    before = [m.value for m in last.select(MentionKind.DIRECTION, MentionKind.FROM)]
    now = [m.value for m in mentions if m.kind in (MentionKind.DIRECTION, MentionKind.FROM)]
    opposite = bool(before and now) and any({before[-1], now[0]} == set(pair) for pair in OPPOSITES)
    both_counted = MentionKind.REPEAT in kinds and bool(last.select(MentionKind.REPEAT))
    return opposite and (both_counted or bool(kinds & _MEASURED))


def _is_other_place(last: Clause, mentions: list[Mention]) -> bool:
    """Return whether a segment sends another part elsewhere: "... the top to the left and the bottom to the right"."""
    kinds = {mention.kind for mention in mentions}
    return (
        MentionKind.PLACE in kinds
        and bool(kinds & {MentionKind.DIRECTION, MentionKind.FROM, MentionKind.SENSE})
        and bool(last.select(MentionKind.PLACE))
    )


def _is_turning_back(clauses: list[Clause], join: Join, mentions: list[Mention]) -> bool:
    """Return whether a list goes the other way now: "push it left, right, and left again"."""
    last = clauses[-1]
    listed = len(clauses) > 1 and last.verb is None and last.cause is None
    listed = listed or any(m.form in ("it", "he", "she", "they") for m in mentions)  # "and down it came"
    if join is not Join.COMMA and not (join is Join.AND and listed):
        return False
    if any(repeat.alternate for repeat in find_repeats(last)):
        return False
    before, now = (
        [m.value for m in group if m.kind is MentionKind.DIRECTION] for group in (last.modifiers, mentions)
    )
    return bool(before and now) and any({before[-1], now[0]} == set(pair) for pair in OPPOSITES)


def _is_going_besides(clause: Clause, mentions: list[Mention], verb: Mention) -> bool:
    """Return whether it goes somewhere besides its motion on the spot: "it shakes so hard that it moves left"."""
    at = mentions.index(verb)
    subject = at > 0 and mentions[at - 1].phrase == "it" and verb.form.endswith("s")
    told = any(m.kind is MentionKind.DIRECTION for m in mentions[at:])
    spot = clause.verb is not None and get_verb(clause.verb).effect in (Effect.SWAY, Effect.TURN)
    return subject and told and spot and get_verb(verb).effect is Effect.PUSH


def _is_absorbed(clause: Clause, mention: Mention, fresh: bool) -> bool:
    """Return whether a second verb adds nothing: "stops moving", "a kick sends it flying"."""
    if clause.verb is None or not fresh:
        return False
    first, second = get_verb(clause.verb), get_verb(mention)
    stops = (
        first.effect is Effect.STILL and not first.generic and not clause.negated
    )  # "never stops spinning"
    return stops or (
        second.generic and first.effect is not Effect.STILL and not _is_becoming(clause.verb, mention)
    )


def _is_replaceable(mention: Mention) -> bool:
    """Return whether a verb only announces the next one: "goes spinning", "stands swaying"."""
    return get_verb(mention).generic


def _is_becoming(first: Mention, second: Mention) -> bool:
    """Return whether an adjective tells how it grows: "grows taller"."""
    result = get_verb(second)
    return get_verb(first).effect is Effect.SWELL and result.effect is Effect.SCALE and result.generic
