"""Clauses: mentions grouped at connectives, each group with at most one verb and what modifies it.

A connective opens a segment of the sentence. A segment with a verb starts a clause; one without continues the clause
before it ("to the left *and up*"), or repeats its verb ("..., *then to the right*": `relations`).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from physagent_jax.agents.grammar.displacement import ends_elsewhere
from physagent_jax.agents.grammar.mentions import MOTIONS, WAYS, Mention, MentionKind
from physagent_jax.agents.grammar.tables import LEXICON, get_set
from physagent_jax.agents.grammar.tokens import is_participle
from physagent_jax.agents.intent import Quantity
from physagent_jax.agents.lexicon import Effect, Join, Motion, Repeat
from physagent_jax.agents.lexicon.types import HOLDABLE, OPPOSITES

_LINES = (*WAYS, MentionKind.AXIS, MentionKind.PLANE, MentionKind.SIDES)
WHERE = (*_LINES, MentionKind.SENSE, MentionKind.PLACE, MentionKind.LISTED, MentionKind.EXCLUDED)
WHERE += (MentionKind.REPEAT, MentionKind.REVERSAL)
TURNING = (Effect.TURN, Effect.ROLL, Effect.LEAN, Effect.TOPPLE)
DRIVING = (Effect.PUSH, Effect.STRIKE)
OPPOSITE_GRAVITY = {"down": "none", "none": "down", "up": "down"}
# Of several connectives in a row (", and then") the one that stands last here counts.
_RANK = (Join.COMMA, Join.AND, Join.RESULT, Join.WHILE, Join.BUT, Join.THEN, Join.AFTER, Join.BEFORE)
_TIMED = (Join.WHILE, Join.AFTER, Join.BEFORE)
_STRENGTHS = (MentionKind.INTENSITY, MentionKind.COMPARATIVE)
_MEASURES = (*_STRENGTHS, MentionKind.QUANTITY, MentionKind.TIME)
_NEGATABLE = (*WHERE, *MOTIONS, *_STRENGTHS, MentionKind.DEGREE, MentionKind.GRAVITY, MentionKind.ANCHOR)
_EMPTY = (MentionKind.FUNCTION, MentionKind.UNKNOWN, MentionKind.IGNORED)
_REACH = 12  # words behind a verb that may tell how it is done
_NOT_HARD, _NOT_GENTLY = 0.8, 1.2


@dataclass
class Clause:
    """One thing that the sentence says.

    Attributes:
        join: Relation to the clause before.
        verb: The word that says what is done; None while only modifiers were met.
        cause: A noun that names what does it ("wind").
        modifiers: Everything else.
        negated: Whether it is said *not* to happen.
        inherited: Whether the verb is that of the clause before.
        stays: Whether what it brings about is to be held.
        elsewhere: Whether what is moved ends at another place (`grammar.displacement`).
        mentions: All mentions, for quoting.
    """

    join: Join
    verb: Mention | None = None
    cause: Mention | None = None
    modifiers: list[Mention] = field(default_factory=list)
    negated: bool = False
    inherited: bool = False
    stays: bool = False
    elsewhere: bool = False
    mentions: list[Mention] = field(default_factory=list)

    def select(self, *kinds: MentionKind) -> list[Mention]:
        """Its modifiers of these kinds."""
        return [mention for mention in self.modifiers if mention.kind in kinds]

    def has(self, *effects: Effect) -> bool:
        """Return whether what it does is one of these."""
        return self.head is not None and get_verb(self.head).effect in effects

    @property
    def head(self) -> Mention | None:
        """The mention that decides what is done."""
        return self.verb or self.cause

    @property
    def words(self) -> str:
        """The words of the mention that decides what is done."""
        return self.head.words if self.head else ""


def mark_displacements(clauses: list[Clause], words: list[str]) -> None:
    """Mark the clauses whose words, from their first mention to the next clause's, tell of another place.

    Args:
        clauses: The clauses.
        words: The sentence's tokens in lower case.
    """
    firsts = [min((m.first for m in clause.mentions), default=len(words)) for clause in clauses]
    for clause, first in zip(clauses, firsts):
        end = min((each for each in firsts if each > first), default=len(words))
        clause.elsewhere = ends_elsewhere(words[first:end])


def get_verb(mention: Mention | None) -> Motion:
    """The value of a VERB or CAUSE mention."""
    assert mention is not None and mention.motion is not None
    return mention.motion


def is_turn(mention: Mention) -> bool:
    """Return whether a quantity is a turn in so many words: "a quick half turn"."""
    words = mention.words.lower()
    degrees = isinstance(mention.value, Quantity) and mention.value.unit == "degrees"
    return degrees and any(noun in words for noun in ("turn", "rotation", "revolution"))


def find_repeats(clause: Clause) -> list[Repeat]:
    """The counts that a clause names; "in both directions, left and right" goes there once."""
    counts = [m.value for m in clause.select(MentionKind.REPEAT) if isinstance(m.value, Repeat)]
    return [each for each in counts if not (each.names and clause.select(MentionKind.SIDES))]


def group_mentions(mentions: list[Mention]) -> list[Clause]:
    """The clauses of a sentence in the order of its words; some have no verb yet."""
    clauses: list[Clause] = []
    for join, segment in _part_list(split_segments(mentions)):
        _add_segment(clauses, join, apply_negations(segment))
    return clauses


def split_segments(mentions: list[Mention]) -> list[tuple[Join, list[Mention]]]:
    """The segments between connectives, each with the connective before it."""
    segments: list[tuple[Join, list[Mention]]] = [(Join.THEN, [])]
    for index, mention in enumerate(mentions):
        join, inside = segments[-1]
        if mention.kind is not MentionKind.JOIN:
            if len(segments) == 1 and join in _TIMED and _begins_main_clause(mentions[index:], inside):
                segments.append((Join.COMMA, []))  # "as it falls it spins"
            segments[-1][1].append(mention)
        elif join in (Join.AND, Join.COMMA) and inside and _is_trailing(mentions, index):
            assert isinstance(mention.value, Join)
            segments[-1] = (mention.value, inside)  # "lift it and spin it afterwards"
        elif any(m.kind is not MentionKind.FUNCTION for m in inside):
            assert isinstance(mention.value, Join)
            segments.append((mention.value, []))
        else:
            segments[-1] = (_combine(join, mention, len(segments) == 1), inside)
    told = [(_find_earlier(join, segment), segment) for join, segment in segments if segment]
    return _join_subjects(told)


def _join_subjects(segments: list[tuple[Join, list[Mention]]]) -> list[tuple[Join, list[Mention]]]:
    """Put the parts of one subject into the segment of their verb: "..., while the buns *and* the lettuce stay put"."""
    joined: list[tuple[Join, list[Mention]]] = []
    for join, segment in segments:
        before = joined[-1][1] if len(joined) > 1 else []
        parts = {MentionKind.PLACE, MentionKind.FUNCTION}
        named = any(m.kind is MentionKind.PLACE for m in before) and {m.kind for m in before} <= parts
        if named and join is Join.AND and _begins_with_subject(segment):
            joined[-1] = (joined[-1][0], before + segment)
        else:
            joined.append((join, segment))
    return joined


def _begins_with_subject(segment: list[Mention]) -> bool:
    """Return whether a part, or all else, does what the first verb says."""
    verb = next((at for at, each in enumerate(segment) if each.kind in MOTIONS), 0)
    nouns = (MentionKind.PLACE, MentionKind.LISTED, MentionKind.UNKNOWN)
    return any(m.kind in nouns or m.form in LEXICON.whole for m in segment[:verb])


def _find_earlier(join: Join, segment: list[Mention]) -> Join:
    """The relation of a segment; "push it, but spin it first" spins it before."""
    first = join is Join.BUT and bool(segment) and segment[-1].phrase == "first"
    return Join.AFTER if first and any(m.kind is MentionKind.VERB for m in segment) else join


def _part_list(segments: list[tuple[Join, list[Mention]]]) -> list[tuple[Join, list[Mention]]]:
    """Makes steps of a list of three ways or more: "it goes left, up, right"; two go together: "left, up"."""
    parted = list(segments)
    bare = {MentionKind.DIRECTION, MentionKind.INTENSITY, MentionKind.FUNCTION}
    begin = 0
    for end in range(1, len(segments) + 1):
        kinds = {m.kind for m in segments[end][1]} if end < len(segments) else set()
        before, now = (_list_ways(segments[at : at + 1]) for at in (end - 1, end))
        if now and now != before and segments[end][0] in (Join.COMMA, Join.THEN) and kinds <= bare:
            continue  # "backwards, away from us" is one way
        led = any(m.kind is MentionKind.DIRECTION for m in segments[begin][1])
        if led and end - begin > 2:
            parted[begin + 1 : end] = [(Join.THEN, segment) for _, segment in segments[begin + 1 : end]]
        begin = end
    return parted


def _list_ways(segments: list[tuple[Join, list[Mention]]]) -> list[object]:
    return [m.value for _, segment in segments for m in segment if m.kind is MentionKind.DIRECTION]


def _is_trailing(mentions: list[Mention], index: int) -> bool:
    """Return whether a word for what comes later ends its segment, and so belongs to what stands before it."""
    ends = index + 1 == len(mentions) or mentions[index + 1].kind is MentionKind.JOIN
    return ends and mentions[index].phrase in get_set("later") | get_set("meanwhile")


def _begins_main_clause(mentions: list[Mention], before: list[Mention]) -> bool:
    """Return whether a subject with its verb stands behind the one that only told the time."""
    if mentions[0].form not in get_set("pronouns") or not any(m.kind in MOTIONS for m in before):
        return False
    follows = next((m for m in mentions[1:] if m.kind is not MentionKind.INTENSITY), None)
    finite = follows is not None and follows.kind is MentionKind.VERB and follows.form.endswith("s")
    return follows is not None and (finite or follows.form in get_set("auxiliaries"))


def _combine(join: Join, mention: Mention, first: bool) -> Join:
    """The relation of a segment behind several connectives, or of the first one of the sentence."""
    assert isinstance(mention.value, Join)
    if first:
        if mention.phrase in get_set("during"):
            return Join.WHILE
        if mention.value is Join.BUT:
            return Join.BUT  # "despite the wind it stands still"
        opens = mention.phrase == "until" or mention.value is Join.BEFORE  # "until it is hit, it stays still"
        return Join.BEFORE if opens else Join.AFTER if mention.value is Join.AFTER else join
    if mention.phrase in get_set("meanwhile"):
        return Join.WHILE  # "it rises; at the same time it spins"
    if mention.phrase.startswith("before "):
        return Join.AFTER  # "push it; before that, lift it"
    if mention.value is Join.AFTER and join in (Join.AND, Join.THEN):
        return Join.THEN  # "lift it, and after landing it spins"
    return max(join, mention.value, key=_RANK.index)


def apply_negations(mentions: list[Mention]) -> list[Mention]:
    """Resolves "not" on everything but verbs: what is negated vanishes or turns into its opposite."""
    result: list[Mention] = []
    pending: Mention | None = None
    for index, mention in enumerate(mentions):
        denied = pending is not None and pending.phrase in ("no", "without")
        ground = denied and mention.form in LEXICON.scene_nouns
        if mention.kind is MentionKind.NOT:
            pending = mention
        elif pending is not None and (mention.kind is MentionKind.SOLID or ground):
            pending = None  # "no wall, just push it", "without a floor it falls"
            result += [mention] if mention.kind is not MentionKind.SOLID else []
        elif pending is None or mention.kind not in _NEGATABLE:
            result.append(mention)
        elif mention.motion and not denied and _is_manner_denied(mention, mentions[index + 1 :][:_REACH]):
            result.append(mention)  # "do not push it too hard" pushes it
        elif mention.kind is not MentionKind.DEGREE:
            result += _negate(pending, mention)
            pending = None
    return result


def _is_manner_denied(verb: Mention, behind: list[Mention]) -> bool:
    """Return whether only how strongly it is done is denied: "do not push it too hard"; ``behind`` follows the verb."""
    hard = any(m.kind is MentionKind.INTENSITY and isinstance(m.value, float) and m.value > 1 for m in behind)
    return hard and [m for m in (verb, *behind) if m.kind is MentionKind.VERB] == [verb]


def _negate(negation: Mention, mention: Mention) -> list[Mention]:
    """The meaning of "not X"."""
    words = f"{negation.words} {mention.words}"
    if mention.kind in MOTIONS:
        return [negation, mention]
    if mention.kind in _STRENGTHS:
        assert isinstance(mention.value, float)
        value = _NOT_HARD if mention.value > 1 else _NOT_GENTLY
        return [replace(mention, kind=MentionKind.INTENSITY, value=value, words=words)]
    if mention.kind is MentionKind.GRAVITY:
        return [replace(mention, value=OPPOSITE_GRAVITY[str(mention.value)], words=words)]
    if mention.kind is MentionKind.ANCHOR:
        return [replace(mention, value="none" if mention.value != "none" else "base", words=words)]
    return []


def _add_segment(clauses: list[Clause], join: Join, mentions: list[Mention]) -> None:
    """Continues the last clause or starts new ones, at each verb of the segment."""
    has_verb = any(mention.kind is MentionKind.VERB for mention in mentions)
    clause = _open_clause(clauses, join, has_verb, mentions)
    fresh = clause.verb is None
    negated = kept = False
    for mention in mentions:
        kept = kept or mention.kind is MentionKind.FUNCTION and mention.form in get_set("keeps")
        if mention.kind is MentionKind.NOT:
            negated = True
        elif mention.kind is MentionKind.VERB:
            if fresh and not negated and _is_absorbed(clause, mention):
                clause.modifiers += tell_result(clause, mention)
                continue
            bare = fresh and clause.has(Effect.HOLD) and get_verb(clause.verb).holds == "base"
            holds = not is_participle(mention.form) and (kept or bare)  # "keep it bent", "hold it bent"
            gone = negated and clause.head is None and len(clauses) > 1 and bool(clause.select(*WAYS))
            first, second = get_verb(clause.verb) if clause.verb else None, get_verb(mention)
            # "Goes spinning", "stands swaying", "grows taller": the first only announces the second.
            anew = first and not (holds or not negated and (first.generic or _is_becoming(first, second)))
            if gone or anew:
                clause = Clause(Join.AND)
                clauses.append(clause)
            clause.stays = holds and get_verb(mention).effect in HOLDABLE
            clause.verb, clause.negated, negated = mention, negated, False
            clause.mentions.append(mention)
        elif mention.kind is MentionKind.CAUSE:
            if negated and clause.verb is not None:  # "moves without wind": the cause is merely absent
                negated = False
                continue
            clause.cause = clause.cause or mention
            clause.negated = clause.negated or negated and not has_verb  # "no breeze stirs it"
            clause.mentions.append(mention)
        elif mention.kind not in _EMPTY:
            clause.modifiers.append(mention)
            clause.mentions.append(mention)


def _open_clause(clauses: list[Clause], join: Join, has_verb: bool, mentions: list[Mention]) -> Clause:
    """The clause that a segment belongs to; a new one is appended."""
    last = clauses[-1] if clauses else None
    if last is not None and _is_continuing(clauses, join, has_verb, mentions):
        return last
    if last is not None and not has_verb:
        if join is Join.COMMA and last.head is not None and _is_other_place(last, mentions):
            join = Join.WHILE  # "the top is pushed left, the bottom right"
        elif _is_turning_back(clauses, join, mentions):
            join = Join.THEN  # "push it left, right, and left again"
    if any(mention.kind is MentionKind.ORDINAL for mention in mentions):
        join = Join.THEN
    clauses.append(Clause(join))
    return clauses[-1]


def _is_continuing(clauses: list[Clause], join: Join, has_verb: bool, mentions: list[Mention]) -> bool:
    """Return whether a segment goes on with the last clause."""
    last = clauses[-1]
    if any(mention.kind is MentionKind.ORDINAL for mention in mentions):
        return False
    # "..., does a half turn".
    turns = any(is_turn(mention) for mention in mentions) and not last.has(*TURNING)
    if not has_verb and (_is_turning_back(clauses, join, mentions) or turns and last.head is not None):
        return False
    if not has_verb and join is Join.RESULT and last.has(*DRIVING) and any(map(_is_size, mentions)):
        return False  # "pull it until it is twice as long"
    waiting = last.head is None and not (len(clauses) > 1 and last.select(*WHERE)) and join is not Join.THEN
    corrects = join is Join.BUT and not has_verb and not last.negated  # "not to the left but to the right"
    # "A breeze comes and moves it": the noun of the last segment does what this verb says.
    carried = last.verb is None and last.cause is not None and has_verb and join in (Join.AND, Join.RESULT)
    carried = carried and not any(m.motion and m.motion.effect is Effect.HOLD for m in mentions)
    has_cause = any(mention.kind is MentionKind.CAUSE for mention in mentions)
    goes_on = join in (Join.AND, Join.RESULT) or join is Join.COMMA and not has_cause
    # "No rotation, just up" does not.
    goes_on = goes_on and not has_verb and not (last.negated and last.verb is None)
    return waiting or corrects or carried or goes_on and not _is_other_place(last, mentions)


def _is_other_place(last: Clause, mentions: list[Mention]) -> bool:
    """Return whether a segment sends another part elsewhere: "the top to the left and the bottom to the right"."""
    kinds = {mention.kind for mention in mentions}
    sent = MentionKind.PLACE in kinds and bool(kinds & {*WAYS, MentionKind.SENSE})
    return sent and bool(last.select(MentionKind.PLACE))


def _is_turning_back(clauses: list[Clause], join: Join, mentions: list[Mention]) -> bool:
    """Return whether a list goes the other way now: "push it left, right, and left again"."""
    last = clauses[-1]
    measured = any(m.kind in _MEASURES for m in mentions)
    measured &= not last.has(Effect.SWAY, Effect.SCALE, Effect.SWELL)
    measured |= any(m.form in get_set("pronouns") for m in mentions)  # "up it went and down it came"
    listed = len(clauses) > 1 and last.head is None or measured  # "gently to the left and hard to the right"
    if join is not Join.COMMA and not (join is Join.AND and listed):
        return False
    if any(repeat.alternate for repeat in find_repeats(last)):
        return False
    before, now = ([m.value for m in group if m.kind in WAYS] for group in (last.modifiers, mentions))
    return bool(before and now) and any({before[-1], now[0]} == {(a,), (b,)} for a, b in OPPOSITES)


def _is_absorbed(clause: Clause, mention: Mention) -> bool:
    """Return whether a second verb adds nothing: "stops moving", "a kick sends it flying"."""
    if clause.verb is None:
        return False
    first, second = get_verb(clause.verb), get_verb(mention)
    # "Never stops spinning".
    stops = first.effect is Effect.STILL and not first.generic and not clause.negated
    return stops or second.generic and first.effect is not Effect.STILL and not _is_becoming(first, second)


def _is_becoming(first: Motion, second: Motion) -> bool:
    """Return whether an adjective tells how it grows, or what a blow makes of it: "hammer it flat"."""
    rises = second.direction == "up" and second.sign > 0  # "push it higher"
    driven = first.effect in DRIVING and not first.generic and not rises
    overturned = driven and second.angle > 0  # "knock it upside down"
    sized = (driven or first.effect is Effect.SWELL) and second.effect is Effect.SCALE
    return (overturned or sized) and second.generic


def _is_size(mention: Mention) -> bool:
    """Return whether a quantity tells how large it becomes: "twice as long"."""
    told = mention.value if mention.kind is MentionKind.QUANTITY else None
    return isinstance(told, Quantity) and told.relation == "is" and told.dimension not in ("", "far")


def tell_result(cause: Clause, result: Mention) -> list[Mention]:
    """The line that an adjective tells of a stretch or a squeeze without one: "stretch it until it is taller"."""
    first, second = get_verb(cause.head), get_verb(result)
    alike = first.effect is second.effect is Effect.SCALE and first.sign == second.sign
    pressed = second.sign < 0 and second.direction == "right"  # "press it until it is thin"
    if not alike or pressed or second.direction is None or cause.select(*_LINES):
        return []
    return [replace(result, kind=MentionKind.AXIS, value=(second.direction,))]
