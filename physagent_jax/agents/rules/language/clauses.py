"""The grammar: mentions -> clauses, each with at most one verb, its modifiers and its relation to the one before.

A connective opens a segment of the sentence. A segment with a verb starts a clause; one without
continues the clause before it ("to the left *and up*") or repeats its verb ("..., *then to the right*").
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import (
    OPPOSITE_GRAVITY,
    SCENE_NOUNS,
    Join,
    Names,
    Place,
    Repeat,
)
from physagent_jax.agents.rules.language.quantities import Quantity
from physagent_jax.agents.rules.language.verbs import VERBS, Effect, Verb

_WHERE = (
    MentionKind.DIRECTION,
    MentionKind.FROM,
    MentionKind.AXIS,
    MentionKind.PLANE,
    MentionKind.SIDES,
    MentionKind.SENSE,
    MentionKind.PLACE,
    MentionKind.EXCLUDED,
    MentionKind.REPEAT,
    MentionKind.REVERSAL,
)
_NEGATABLE = (
    *_WHERE,
    MentionKind.VERB,
    MentionKind.CAUSE,
    MentionKind.INTENSITY,
    MentionKind.DEGREE,
    MentionKind.COMPARATIVE,
    MentionKind.GRAVITY,
    MentionKind.ANCHOR,
)
_HOLDABLE = (Effect.PUSH, Effect.LEAN, Effect.SCALE, Effect.SWELL, Effect.TURN)
_KEEPS = frozenset({"keep", "keeps", "kept", "keeping"})
_OPPOSITES: tuple[tuple[Names, Names], ...] = (
    (("left",), ("right",)),
    (("up",), ("down",)),
    (("toward",), ("away",)),
)
_TIMED = frozenset({Join.WHILE, Join.AFTER, Join.BEFORE})
_HEADS = (MentionKind.VERB, MentionKind.CAUSE)
_MEASURED = {MentionKind.INTENSITY, MentionKind.COMPARATIVE, MentionKind.QUANTITY, MentionKind.TIME}
_SHAPING = (Effect.TURN, Effect.SCALE, Effect.SWAY)
_GOING_ON = frozenset({Join.AND, Join.THEN})
_MEANWHILE = frozenset({"at the same time", "and at the same time", "simultaneously", "meanwhile"})
_DURING = frozenset({"while", "whilst", "as"})
_SEPARATE_EFFECTS = (Effect.FALL, Effect.TOPPLE, Effect.STILL, Effect.RELEASE, Effect.HOLD)


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
        stays: What it brings about is to be held.
        mentions: All mentions, for quoting.
    """

    join: Join
    verb: Mention | None = None
    cause: Mention | None = None
    modifiers: list[Mention] = field(default_factory=list)
    negated: bool = False
    inherited: bool = False
    stays: bool = False
    mentions: list[Mention] = field(default_factory=list)

    def select(self, *kinds: MentionKind) -> list[Mention]:
        """Its modifiers of these kinds."""
        return [mention for mention in self.modifiers if mention.kind in kinds]

    @property
    def head(self) -> Mention | None:
        """The mention that decides what is done."""
        return self.verb or self.cause

    @property
    def words(self) -> str:
        """The words of the mention that decides what is done."""
        return self.head.words if self.head else ""


def get_verb(mention: Mention | None) -> Verb:
    """The value of a VERB or CAUSE mention."""
    assert mention is not None and isinstance(mention.value, Verb)
    return mention.value


def read_clauses(mentions: list[Mention]) -> list[Clause]:
    """Groups mentions into clauses, in the order in which they happen."""
    clauses: list[Clause] = []
    for join, segment in _split_segments(mentions):
        _add_segment(clauses, join, _apply_negations(segment))
    clauses = _split_turning_winds(clauses)
    for index in range(len(clauses)):
        _inherit(clauses, index)
    return _apply_holding(_sort_clauses(_merge_results(clauses)))


def _split_segments(mentions: list[Mention]) -> list[tuple[Join, list[Mention]]]:
    """Cuts at connectives; of several in a row (", and then") the most telling one counts."""
    rank = [Join.COMMA, Join.AND, Join.RESULT, Join.WHILE, Join.BUT, Join.THEN, Join.AFTER, Join.BEFORE]
    segments: list[tuple[Join, list[Mention]]] = [(Join.THEN, [])]
    mentions = _part_list(mentions)
    for index, mention in enumerate(mentions):
        if mention.kind is MentionKind.JOIN:
            assert isinstance(mention.value, Join)
            if any(m.kind is not MentionKind.FUNCTION for m in segments[-1][1]):
                segments.append((mention.value, []))
            elif len(segments) == 1 and mention.phrase in _DURING:
                segments[-1] = (Join.WHILE, segments[-1][1])
            elif len(segments) > 1 and mention.phrase in _MEANWHILE:
                segments[-1] = (Join.WHILE, segments[-1][1])  # "it rises; at the same time it spins"
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


def _begins_main_clause(mentions: list[Mention], before: list[Mention]) -> bool:
    """Whether a subject with its verb stands behind the one that only told the time."""
    subject, *rest = mentions
    if subject.form not in ("it", "he", "she") or not any(m.kind in _HEADS for m in before):
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
    return result


def _apply_negations(mentions: list[Mention]) -> list[Mention]:
    """Resolves NOT on everything but verbs: what is negated vanishes or turns into its opposite."""
    result: list[Mention] = []
    pending: Mention | None = None
    manner = False
    for mention in mentions:
        denies_manner = pending is not None and mention.kind is MentionKind.VERB
        manner = pending is not None and (
            manner or denies_manner and _is_manner_denied(mentions, mention)
        )  # "do not push it too hard" pushes it
        if mention.kind is MentionKind.NOT:
            pending = mention
        elif pending is not None and pending.phrase in ("no", "without") and mention.form in SCENE_NOUNS:
            pending = None  # "without a floor it falls"
            result.append(mention)
        elif pending is None or mention.kind not in _NEGATABLE:
            result.append(mention)
        elif mention.kind is MentionKind.DEGREE:  # "not too hard": the intensity that follows is negated
            continue
        elif manner and mention.kind is not MentionKind.INTENSITY:
            result.append(mention)
        else:
            result += _negate(pending, mention)
            pending = None
    return result


def _is_manner_denied(mentions: list[Mention], verb: Mention) -> bool:
    """Whether only how strongly it is done is denied: "do not push it too hard"."""
    behind = [m.kind for m in mentions if m.first > verb.first and m.kind is not MentionKind.FUNCTION]
    return (
        any(pair == (MentionKind.DEGREE, MentionKind.INTENSITY) for pair in zip(behind, behind[1:]))
        and MentionKind.VERB not in behind
    )


def _negate(negation: Mention, mention: Mention) -> list[Mention]:
    """What "not X" says."""
    if mention.kind in (MentionKind.VERB, MentionKind.CAUSE):
        return [negation, mention]
    if mention.kind in (MentionKind.INTENSITY, MentionKind.COMPARATIVE):
        assert isinstance(mention.value, float)
        value = 0.8 if mention.value > 1 else 1.2
        return [
            replace(
                mention, kind=MentionKind.INTENSITY, value=value, words=f"{negation.words} {mention.words}"
            )
        ]
    if mention.kind is MentionKind.GRAVITY:
        value = OPPOSITE_GRAVITY[str(mention.value)]
        return [replace(mention, value=value, words=f"{negation.words} {mention.words}")]
    if mention.kind is MentionKind.ANCHOR:
        return [
            replace(
                mention,
                value="none" if mention.value != "none" else "base",
                words=f"{negation.words} {mention.words}",
            )
        ]
    return []


def _add_segment(clauses: list[Clause], join: Join, mentions: list[Mention]) -> None:
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
        elif mention.kind is MentionKind.VERB and (negated or not _is_absorbed(clause, mention, fresh)):
            participle = not mention.form.endswith("ing")
            is_hold = participle and (
                kept or fresh and _is_bare_hold(clause)
            )  # "hold it bent", "keep it bent"
            replaceable = clause.verb is not None and (
                _is_replaceable(clause.verb) or _is_becoming(clause.verb, mention)
            )
            if clause.verb is not None and not is_hold and (negated or not replaceable):
                clause = Clause(Join.AND)
                clauses.append(clause)
            clause.stays = is_hold and get_verb(mention).effect in _HOLDABLE
            clause.verb, clause.negated, negated = mention, negated, False
            clause.mentions.append(mention)
        elif mention.kind is MentionKind.CAUSE:
            _add_cause(clause, mention, negated, has_verb)
            negated = False
        elif mention.kind not in (MentionKind.FUNCTION, MentionKind.UNKNOWN, MentionKind.VERB):
            clause.modifiers.append(mention)
            clause.mentions.append(mention)


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
        waiting = last.head is None and not (len(clauses) > 1 and last.select(*_WHERE))
        # "a breeze comes and moves it": the noun of the last segment does what this verb says
        carried = (
            last.verb is None and last.cause is not None and has_verb and join in (Join.AND, Join.RESULT)
        )
        continues = (
            not has_verb
            and join in (Join.AND, Join.COMMA, Join.RESULT)
            and not (has_cause and join is Join.COMMA)
            and not (join is Join.COMMA and _is_subordinate(clauses))
        )
        turns_back = not has_verb and _is_turning_back(clauses, join, mentions)
        strokes = any(mention.kind is MentionKind.ORDINAL for mention in mentions)
        beside = not has_verb and (_is_another(mentions) or _is_other_measure(last, join, mentions))
        if turns_back or strokes or beside:
            clause = Clause(Join.THEN)
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


def _is_subordinate(clauses: list[Clause]) -> bool:
    """Whether only the time was told so far: "once it has landed, ..."."""
    return len(clauses) == 1 and clauses[0].join is Join.AFTER and clauses[0].verb is not None


def _is_another(mentions: list[Mention]) -> bool:
    """Whether a segment tells of one more of them: "two kicks from the left and one from above"."""
    for mention, after in zip(mentions, mentions[1:]):
        counts = mention.kind is MentionKind.FUNCTION and mention.form in ("one", "another", "other")
        if counts and (
            after.kind in (MentionKind.DIRECTION, MentionKind.FROM)
            or after.phrase in ("to", "from", "toward", "towards")
        ):
            return any(m.kind in (MentionKind.DIRECTION, MentionKind.FROM) for m in mentions)
    return False


def _is_other_measure(last: Clause, join: Join, mentions: list[Mention]) -> bool:
    """Whether a segment goes the other way by its own measure: "hard to the left and softly to the right"."""
    if join is not Join.AND or last.head is None or get_verb(last.head).effect is Effect.SWAY:
        return False
    kinds = {mention.kind for mention in mentions}
    before = [m.value for m in last.select(MentionKind.DIRECTION, MentionKind.FROM)]
    now = [m.value for m in mentions if m.kind in (MentionKind.DIRECTION, MentionKind.FROM)]
    opposite = bool(before and now) and any({before[-1], now[0]} == set(pair) for pair in _OPPOSITES)
    both_counted = MentionKind.REPEAT in kinds and bool(last.select(MentionKind.REPEAT))
    return opposite and (both_counted or bool(kinds & _MEASURED))


def _is_other_place(last: Clause, mentions: list[Mention]) -> bool:
    """Whether a segment sends another part elsewhere: "... the top to the left and the bottom to the right"."""
    kinds = {mention.kind for mention in mentions}
    return (
        MentionKind.PLACE in kinds
        and bool(kinds & {MentionKind.DIRECTION, MentionKind.FROM, MentionKind.SENSE})
        and bool(last.select(MentionKind.PLACE))
    )


def _is_turning_back(clauses: list[Clause], join: Join, mentions: list[Mention]) -> bool:
    """Whether a list goes the other way now: "push it left, right, and left again"."""
    last = clauses[-1]
    listed = len(clauses) > 1 and last.verb is None and last.cause is None
    if join is not Join.COMMA and not (join is Join.AND and listed):
        return False
    if any(repeat.alternate for repeat in find_repeats(last)):
        return False
    before, now = (
        [m.value for m in group if m.kind is MentionKind.DIRECTION] for group in (last.modifiers, mentions)
    )
    return bool(before and now) and any({before[-1], now[0]} == set(pair) for pair in _OPPOSITES)


def _is_bare_hold(clause: Clause) -> bool:
    """Whether a clause only holds the object so far."""
    verb = None if clause.verb is None else get_verb(clause.verb)
    return (
        verb is not None and verb.effect is Effect.HOLD and verb.holds == "base" and not find_places(clause)
    )


def _is_absorbed(clause: Clause, mention: Mention, fresh: bool) -> bool:
    """Whether a second verb adds nothing: "stops moving", "a kick sends it flying"."""
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
    """Whether a verb only announces the next one: "goes spinning", "stands swaying"."""
    return get_verb(mention).generic


def _is_becoming(first: Mention, second: Mention) -> bool:
    """Whether an adjective tells how it grows: "grows taller"."""
    result = get_verb(second)
    return get_verb(first).effect is Effect.SWELL and result.effect is Effect.SCALE and result.generic


def _split_turning_winds(clauses: list[Clause]) -> list[Clause]:
    """Makes two winds of one that turns: it blows to the first side, then to the second."""
    result: list[Clause] = []
    for clause in clauses:
        turns = clause.verb is not None and get_verb(clause.verb).effect is Effect.TURN and not clause.negated
        veers = turns and clause.verb is not None and clause.verb.phrase.startswith("turn")
        if not veers or clause.cause is None or not get_verb(clause.cause).wind:
            result.append(clause)
            continue
        clause.verb = None
        result.append(clause)
        ways = clause.select(MentionKind.FROM, MentionKind.DIRECTION)
        if [way.kind for way in ways] == [MentionKind.FROM, MentionKind.DIRECTION]:
            rest = [mention for mention in clause.modifiers if mention not in ways]
            clause.modifiers = [*rest, replace(ways[0], kind=MentionKind.DIRECTION)]
            result.append(Clause(Join.THEN, None, clause.cause, [*rest, ways[1]], mentions=clause.mentions))
    return result


def _inherit(clauses: list[Clause], index: int) -> None:
    """A clause without verb repeats the verb before it: "push it to the left, then to the right"."""
    clause = clauses[index]
    if clause.head is not None or not clause.modifiers:
        return
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
    clause.verb, clause.cause, clause.inherited = before.verb, before.cause, True
    ordinals = clause.select(MentionKind.ORDINAL)
    if ordinals:
        _take_stroke(before)
    if not clause.select(*_WHERE):  # "..., then harder": the same again
        again = [m for m in before.select(*_WHERE) if not (ordinals and m.kind is MentionKind.REPEAT)]
        clause.modifiers = [*again, *clause.modifiers]
    elif clause.select(MentionKind.SENSE) and not clause.select(
        MentionKind.AXIS, MentionKind.VIEW
    ):  # about the same axis
        clause.modifiers += before.select(MentionKind.AXIS, MentionKind.VIEW)


def _take_stroke(clause: Clause) -> None:
    """One stroke less: it is told by itself ("twice, the second time harder")."""
    for index, mention in enumerate(clause.modifiers):
        if isinstance(mention.value, Repeat) and (mention.value.count or 0) > 1:
            repeat = replace(mention.value, count=(mention.value.count or 2) - 1)
            clause.modifiers[index] = replace(mention, value=repeat)


def _apply_holding(clauses: list[Clause]) -> list[Clause]:
    """Holding what was just moved keeps it there; holding what is then let go is no anchor."""
    result: list[Clause] = []
    for index, clause in enumerate(clauses):
        last = next((c for c in reversed(result) if c.head is not None), None)
        follows = next((c for c in clauses[index + 1 :] if c.head is not None), None)
        if clause.stays and last is not None and last.verb is not None and clause.verb is not None:
            if get_verb(last.verb).effect is get_verb(clause.verb).effect and not clause.modifiers:
                last.stays = True  # "compress it and keep it compressed"
                continue
        if clause.negated or not _is_bare_hold(clause) or clause.select(MentionKind.ANCHOR):
            result.append(clause)
            continue
        if follows is not None and clause.select(MentionKind.TIME) and clause.verb is not None:
            clause.verb = replace(
                clause.verb, value=VERBS["wait"], phrase="wait"
            )  # "hold it for a second, then"
            result.append(clause)
            continue
        moved = last is not None and not last.negated and get_verb(last.head).effect in _HOLDABLE
        if moved and clause.join is not Join.WHILE:
            assert last is not None
            last.stays = follows is None
            last.mentions += clause.mentions
        elif follows is None or get_verb(follows.head).effect not in (Effect.FALL, Effect.RELEASE):
            if clause.verb is not None and clause.verb.phrase.startswith(("stay", "remain")):
                clause.verb = replace(clause.verb, value=VERBS["stay put"], phrase="stay put")
            result.append(clause)
    return result


def _merge_results(clauses: list[Clause]) -> list[Clause]:
    """Makes one action of cause and effect ("pushes it so that it bends"): the effect's verb, all modifiers."""
    merged: list[Clause] = []
    for before, clause in zip(clauses, clauses[1:]):
        _share_direction(before, clause)
    for clause in clauses:
        if clause.join is Join.COMMA and clause.verb and merged and merged[-1].head is not None:
            participle = clause.verb.form.endswith("ing") and not merged[-1].head.form.endswith("ing")
            beside = participle and _is_moving_beside(merged[-1], clause)
            beside = beside or merged == clauses[:1] and _is_meanwhile(merged[-1], clause)
            clause.join = Join.WHILE if beside else Join.RESULT if participle else Join.COMMA
        if clause.join is Join.RESULT and merged and _is_at_rest(merged[-1]):
            clause.join = Join.THEN  # "nothing happens until it is hit"
        related = clause.join is Join.RESULT
        if merged and _is_carried_off(merged[-1], clause):
            clause.modifiers = [mention for mention in clause.modifiers if mention.phrase != "away"]
            related = True
        related = related or (bool(merged) and _is_moved_by_wind(merged[-1], clause))
        related = related or (bool(merged) and _is_introducing(merged[-1], clause))
        mergeable = (
            related
            and merged
            and merged[-1].head
            and clause.verb
            and not clause.negated
            and not merged[-1].negated
        )
        if not mergeable:
            merged.append(clause)
        elif _is_besides(merged[-1], clause):
            clause.join = Join.WHILE
            merged.append(clause)
        elif get_verb(clause.verb).effect in _SEPARATE_EFFECTS:
            stops = get_verb(clause.verb).effect in (Effect.STILL, Effect.RELEASE)
            clause.join = Join.THEN if stops else Join.WHILE
            merged.append(clause)
        else:
            _merge(merged[-1], clause)
    return merged


def _is_besides(cause: Clause, clause: Clause) -> bool:
    """Whether what comes of it is another motion than what is done: "twist it until it tears"."""
    first, second = get_verb(cause.head), get_verb(clause.verb)
    return first.effect in _SHAPING and second.effect in _SHAPING and second.effect is not first.effect


def _is_at_rest(clause: Clause) -> bool:
    """Whether a clause says that nothing moves."""
    verb = None if clause.verb is None or clause.negated else get_verb(clause.verb)
    return verb is not None and verb.effect is Effect.STILL and not verb.generic


def _share_direction(blow: Clause, clause: Clause) -> None:
    """A blow goes where what it fells goes: "a kick topples it to the right"."""
    told = clause.select(MentionKind.DIRECTION)
    if blow.head is None or clause.verb is None or blow.select(*_WHERE) or clause.join is Join.THEN:
        return
    if get_verb(blow.head).effect is Effect.STRIKE and get_verb(clause.verb).effect is Effect.TOPPLE:
        blow.modifiers += told


def _is_moved_by_wind(wind: Clause, clause: Clause) -> bool:
    """Whether a swaying is the wind's work and goes its way: "wind blows from the left and the plant sways"."""
    if clause.verb is None or wind.head is None or not get_verb(wind.head).wind or clause.join is Join.THEN:
        return False
    effect = get_verb(clause.verb).effect
    return effect is Effect.LEAN or (
        effect is Effect.SWAY and not clause.select(MentionKind.DIRECTION, MentionKind.FROM)
    )


def _is_moving_beside(cause: Clause, clause: Clause) -> bool:
    """Whether a participle tells another motion at the same time: "push it right, spinning it"."""
    first, second = get_verb(cause.head), get_verb(clause.verb)
    pushed = first.effect is Effect.PUSH and not first.wind and (not first.generic or cause.verb is not None)
    beside = second.effect in (Effect.TURN, Effect.SWAY)
    return pushed and cause.cause is None and beside and bool(cause.select(*_WHERE))


def _is_meanwhile(first: Clause, clause: Clause) -> bool:
    """Whether a participle stands before what happens at the same time: "spinning, it rises"."""
    if first.verb is None or clause.verb is None or first.join is Join.AFTER or first.negated:
        return False
    still = get_verb(first.verb).effect in (Effect.STILL, Effect.RELEASE, Effect.HOLD)
    return first.verb.form.endswith("ing") and not clause.verb.form.endswith("ing") and not still


def _is_introducing(cause: Clause, clause: Clause) -> bool:
    """Whether a cause stands before a comma and what it does behind: "with great force, it is thrown"."""
    if cause.verb is not None or cause.cause is None or clause.verb is None or clause.join is not Join.COMMA:
        return False
    return clause.cause is None and not cause.select(MentionKind.TIME)


def _is_carried_off(cause: Clause, clause: Clause) -> bool:
    """Whether a travel is a blow's work: "kicked from the left and flies away"."""
    if clause.verb is None or cause.head is None or clause.join not in (Join.AND, Join.COMMA):
        return False
    verb = get_verb(clause.verb)
    return verb.generic and verb.effect is Effect.PUSH and get_verb(cause.head).effect is Effect.STRIKE


def _merge(cause: Clause, effect: Clause) -> None:
    if not get_verb(effect.verb).generic:
        cause.cause, cause.verb = cause.cause or cause.verb, effect.verb
    cause.modifiers += effect.modifiers
    cause.mentions += effect.mentions


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


def find_places(clause: Clause) -> list[Place]:
    """The parts of the object that a clause names."""
    return [mention.value for mention in clause.select(MentionKind.PLACE) if isinstance(mention.value, Place)]


def find_excluded(clause: Clause) -> list[Place]:
    """The parts that a clause excepts."""
    return [
        mention.value for mention in clause.select(MentionKind.EXCLUDED) if isinstance(mention.value, Place)
    ]


def find_repeats(clause: Clause) -> list[Repeat]:
    """The counts that a clause names."""
    return [
        mention.value for mention in clause.select(MentionKind.REPEAT) if isinstance(mention.value, Repeat)
    ]
