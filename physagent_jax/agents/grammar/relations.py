"""Relations between clauses: what repeats the verb before it, what comes of what, and the order in time."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from physagent_jax.agents.grammar.clauses import (
    DRIVING,
    TURNING,
    WHERE,
    Clause,
    get_verb,
    group_mentions,
    is_turn,
    tell_result,
)
from physagent_jax.agents.grammar.mentions import WAYS, Mention, MentionKind
from physagent_jax.agents.grammar.subjects import sticks_out
from physagent_jax.agents.grammar.tables import LEXICON, get_set
from physagent_jax.agents.grammar.tokens import is_participle
from physagent_jax.agents.intent import Quantity
from physagent_jax.agents.lexicon import Effect, Join, Motion, Repeat
from physagent_jax.agents.lexicon.types import is_end

_MOVING = (*WAYS, MentionKind.SENSE, MentionKind.QUANTITY, MentionKind.REPEAT)
_MOVING += (MentionKind.INTENSITY, MentionKind.COMPARATIVE)
_DENT = LEXICON.motions["dent"]
# What an object does by itself beside its motion; a push or a blow brings about what follows.
_FORMS = (Effect.TURN, Effect.SWAY, Effect.JUMP, Effect.ROLL, Effect.SCALE, Effect.SWELL, Effect.LEAN)
_ELSEWHERE = (*WAYS, MentionKind.PLACE, MentionKind.EXCLUDED, MentionKind.TIME)
_LENGTHS = ("metres", "lengths")
_LYING = (Effect.ROLL, Effect.PUSH, Effect.SWAY, Effect.TURN)  # what something does once it has fallen over
_SEPARATE = (Effect.FALL, Effect.TOPPLE, Effect.STILL, Effect.RELEASE, Effect.HOLD)


def read_clauses(mentions: list[Mention]) -> list[Clause]:
    """The clauses of a sentence in the order in which they happen."""
    clauses = group_mentions(mentions)
    for index, clause in enumerate(clauses):
        _inherit(clauses, index)
        blown = clause.head is not None and get_verb(clause.head).wind and clause.select(MentionKind.FROM)
        if blown:  # "a wind from the right blows it away": off, wherever that is
            clause.modifiers = [m for m in clause.modifiers if m.phrase != "away"]
    clauses = [each for clause in clauses for each in _part_places(clause)]
    untils = [m.first for m in mentions if m.kind is MentionKind.JOIN and m.phrase == "until"]
    whens = [m.first for m in mentions if m.kind is MentionKind.JOIN and m.phrase == "when"]
    thens = [m.first for m in mentions if m.value is Join.THEN and m.words[0].isalpha()]
    clauses = _withstand(clauses, thens)
    return _sort_clauses(_merge_results(_turn_whens(_turn_untils(clauses, untils), whens)))


def _part_places(clause: Clause) -> list[Clause]:
    """The same clause for each of several parts that are listed: "its ears and its tail wiggle"."""
    if not clause.select(MentionKind.LISTED):
        return [clause]
    places = clause.select(MentionKind.PLACE, MentionKind.LISTED)
    named = [replace(place, kind=MentionKind.PLACE) for place in places]
    rest = [each for each in clause.modifiers if each not in places]
    if clause.head is None or clause.has(Effect.STILL, Effect.HOLD) or get_verb(clause.head).wrings:
        return [replace(clause, modifiers=[*rest, *named])]
    return [
        replace(
            clause,
            join=Join.WHILE if number else clause.join,
            modifiers=[*rest, place],
            mentions=[m for m in clause.mentions if m not in places or m.first == place.first],
        )
        for number, place in enumerate(named)
    ]


def _withstand(clauses: list[Clause], thens: list[int]) -> list[Clause]:
    """Leaves rest alone where the whole stays where it is whatever acts on it: "it does not move though it is hit"."""
    told = [clause for clause in clauses if clause.head is not None]
    yields = any(clause.join is Join.BUT for clause in told)
    rests = [clause for clause in told if _is_unmoved(clause) or yields and _is_staying(clause)]
    passive = all(c.cause or c.has(Effect.STILL) or _is_act(c) for c in told if not _is_unmoved(c))
    sways = any(c.verb and c.has(Effect.SWAY) for c in told)  # "it sways, but it stays on its feet"
    if not rests or not passive or sways and not any(map(_is_unmoved, rests)):
        return clauses
    first = min(m.first for m in rests[0].mentions)
    if any(0 < then < first for then in thens):  # "push it, then it does not move"
        return clauses
    word = LEXICON.motions["stay still"]
    still = replace(rests[0].mentions[0], kind=MentionKind.VERB, value=word, phrase="stay still")
    return [Clause(rests[0].join, still, mentions=rests[0].mentions)]


def _is_unmoved(clause: Clause) -> bool:
    """Return whether a clause denies any motion of the whole: "does not move", "won't budge an inch"."""
    if clause.verb is None or not clause.negated or clause.select(*_ELSEWHERE):
        return False
    idiom = all(m.words.lower().startswith(("a", "one")) for m in clause.select(MentionKind.QUANTITY))
    return clause.verb.phrase.split()[0] in get_set("budging") and idiom


def _is_staying(clause: Clause) -> bool:
    """Return whether a clause says that the whole is at rest all along: "stands still", and not "stops"."""
    stays = clause.verb is not None and clause.verb.phrase.split()[0] in get_set("staying")
    return stays and clause.has(Effect.STILL) and not clause.negated and not clause.select(*_ELSEWHERE)


def _turn_untils(clauses: list[Clause], untils: list[int]) -> list[Clause]:
    """Puts what does not happen until something else does behind that: "it does not fall until it is pushed"."""
    turned = list(clauses)
    for at, (late, early) in enumerate(pairwise(clauses)):
        if late.verb is None or early.verb is None or not late.negated or get_verb(late.verb).generic:
            continue
        if any(late.verb.first < until < early.verb.first for until in untils):
            late.negated, late.join, early.join = False, Join.THEN, late.join
            turned[at : at + 2] = [early, late]
    return turned


def _turn_whens(clauses: list[Clause], whens: list[int]) -> list[Clause]:
    """Makes a result of what happens when something is done to it: "it tips over when it is hit from the left"."""
    turned = list(clauses)
    for at, (effect, act) in enumerate(pairwise(clauses)):
        if effect.verb is None or act.verb is None or effect.negated or act.negated:
            continue
        behind = any(effect.verb.first < when < act.verb.first for when in whens)
        dropped = act.verb.phrase.startswith("drop") and effect.has(Effect.SWAY, Effect.SCALE)
        if behind and (dropped or _is_act(act)) and (effect.has(Effect.SCALE) or not _is_act(effect)):
            act.join, effect.join = effect.join, Join.RESULT
            turned[at : at + 2] = [act, effect]
        elif at == 0 and any(when < effect.verb.first for when in whens) and act.join is Join.COMMA:
            act.join = Join.RESULT if _is_act(effect) else act.join  # "when it is hit, it tips over"
    return turned


def _is_act(clause: Clause) -> bool:
    """Return whether something else does it to the object."""
    verb = get_verb(clause.verb)
    pressed = verb.effect is Effect.SCALE and verb.sign < 0 and verb.manner != "crumple"
    return not verb.generic and (clause.has(*DRIVING) or pressed)


def _inherit(clauses: list[Clause], index: int) -> None:
    """Gives a clause without verb the verb before it: "push it to the left, then to the right"."""
    clause = clauses[index]
    held = clause.select(MentionKind.ANCHOR) and not clause.select(*_MOVING)  # "while its feet are stuck"
    if clause.head is not None or not clause.modifiers or held:
        return
    before = next((c for c in reversed(clauses[:index]) if c.head is not None), None)
    own = _find_own_motion(clause, before)
    if own is not None:
        clause.verb = replace(own[0], kind=MentionKind.VERB, value=own[1], phrase=own[2])
    elif before is not None and not before.has(Effect.STILL, Effect.RELEASE, Effect.HOLD):
        clause.verb, clause.cause, clause.inherited = before.verb, before.cause, True
        _take_over(clause, before)


def _find_own_motion(clause: Clause, before: Clause | None) -> tuple[Mention, Motion, str] | None:
    """The mention that tells by itself what is done, the motion and its phrase."""
    for mention in clause.select(MentionKind.QUANTITY):
        size = mention.value
        assert isinstance(size, Quantity)
        if size.relation == "is" and size.dimension != "far":  # "make it twice as tall"
            motion = "stretch" if size.value >= 1 else "squeeze"
            return mention, LEXICON.motions[motion], motion
        turn = is_turn(mention)
        idle = before is None or before.has(Effect.STILL, Effect.RELEASE, Effect.HOLD)
        if size.unit == "degrees" and idle or turn and not (before and before.has(*TURNING)):  # "a full turn"
            return mention, LEXICON.motions["turn"], "turn"
    for mention in clause.select(MentionKind.GRAVITY):
        if mention.value == "down" and not clause.select(MentionKind.FROM):  # "then let gravity act"
            return mention, LEXICON.motions["fall"], "fall"
    if before is not None and before.negated and before.verb is None:
        for mention in clause.select(MentionKind.DIRECTION):  # "no rotation, just up"
            return mention, LEXICON.motions["push"], "push"
    return None


def _take_over(clause: Clause, before: Clause) -> None:
    """Gives a clause with the verb before it also where that was done, if it tells nothing else."""
    ordinals = [m for m in clause.select(MentionKind.ORDINAL) if m.phrase != "one"]
    if ordinals:  # "twice, the second time harder": one stroke less before
        for index, mention in enumerate(before.modifiers):
            if isinstance(mention.value, Repeat) and (mention.value.count or 0) > 1:
                count = (mention.value.count or 2) - 1
                before.modifiers[index] = replace(mention, value=replace(mention.value, count=count))
    if not clause.select(*WHERE):  # "..., then harder": the same again
        again = [m for m in before.select(*WHERE) if not (ordinals and m.kind is MentionKind.REPEAT)]
        clause.modifiers = [*again, *clause.modifiers]
    elif clause.select(MentionKind.SENSE) and not clause.select(MentionKind.AXIS, MentionKind.VIEW):
        clause.modifiers += before.select(MentionKind.AXIS, MentionKind.VIEW)  # about the same axis
    if not clause.select(MentionKind.PLACE):  # "it tilts its head to the left, then to the right"
        clause.modifiers += [each for each in before.select(MentionKind.PLACE) if sticks_out(each)]


def _merge_results(clauses: list[Clause]) -> list[Clause]:
    """Makes one clause of cause and effect ("pushes it so that it bends"): the effect's verb, all modifiers."""
    merged: list[Clause] = []
    caused = (_is_carried_off, _is_moved_by_wind, _is_pushed_over)
    for index, clause in enumerate(clauses):
        brakes = bool(merged) and merged[-1].has(Effect.STILL) and get_verb(merged[-1].head).brief
        if brakes and clause.join in (Join.RESULT, Join.AND):
            first = merged.pop()  # "it drives forward and brakes, so that it rocks": along its way
            rocks = clause.join is Join.RESULT and clause.has(Effect.SWAY)
            stopped = clause.join if rocks else Join.THEN  # "drives, brakes and tips up"
            clause.join = stopped if merged else first.join
        before = merged[-1] if merged else None
        acts = before is not None and before.head is not None and clause.verb is not None
        if before is None or not acts or clause.negated or before.negated or before.has(Effect.HOLD):
            merged.append(clause)
            continue
        if clause.join is Join.COMMA:
            clause.join = _find_comma(merged, clause)
        aloft = before.has(Effect.STRIKE, Effect.JUMP) and get_verb(before.head).gravity
        if clause.join is Join.COMMA and aloft and clause.has(Effect.TURN) and get_verb(clause.verb).tumbles:
            clause.join = Join.AND  # "toss it up, let it do a somersault"
        if clause.verb and clause.join in (Join.AND, Join.COMMA) and _is_dented(before, clause):
            clause.join, clause.verb = Join.RESULT, replace(clause.verb, value=_DENT, phrase="dent")
            clause.modifiers = [m for m in clause.modifiers if m.kind is not MentionKind.PLACE]
        if clause.join in (Join.RESULT, Join.AND) and before.has(Effect.STILL):
            clause.join = Join.THEN  # "nothing happens until it is hit", "it stops and shakes"
        bows = LEXICON.motions["bow"] in (get_verb(before.head), get_verb(clause.verb))
        if clause.join is Join.AND and bows and not (clause.has(Effect.TOPPLE) or get_verb(before.head).wind):
            clause.join = Join.THEN  # "it twirls and takes a bow", "it bows and exits"
        repeated = any(each.inherited and each.verb is clause.verb for each in clauses[index + 1 : index + 2])
        if clause.join is Join.RESULT and repeated and get_verb(clause.verb).generic:
            clause.join = Join.THEN  # "it sways: its top goes left, then right, and back"
        if clause.stays and not clause.modifiers and before.has(get_verb(clause.verb).effect):
            before.stays = True  # "compress it and keep it compressed"
        elif _is_saying_size_again(before, clause):
            _absorb(before, clause)
        elif _is_falling_over(before, clause):
            _absorb(before, clause, clause.has(Effect.FALL))
        elif clause.join is Join.RESULT or any(tells(before, clause) for tells in caused):
            merged += _relate(before, clause)
        else:
            flies = clause.has(Effect.TURN) and get_verb(before.head).gravity
            if clause.join is Join.AND and before.has(Effect.STRIKE) and (flies or clause.has(Effect.TOPPLE)):
                # "A kick topples it to the right", "it is thrown spinning to the right".
                told = before.select(*WHERE)
                before.modifiers += [] if told else clause.select(*WAYS)
                clause.modifiers = [m for m in clause.modifiers if told or not flies or m.kind not in WAYS]
            if clause.join is Join.AND and before.has(Effect.STRIKE) and clause.has(Effect.PUSH):
                clause.join = Join.THEN  # "it is thrown to the left and slides down"
            if clause.join is Join.AND and before.has(Effect.SWAY) and get_verb(clause.verb).gravity:
                clause.join = Join.THEN  # "shakes it and throws it away"
            if clause.join is Join.AND and clause.has(Effect.PUSH) and _is_turning_about(before, clause):
                clause.join = Join.THEN  # "it turns around and drives away"
            merged.append(clause)
    return merged


def _is_turning_about(clause: Clause, later: Clause) -> bool:
    """Return whether it turns as a whole, by an angle or to a side, before it goes on its own way."""
    verb, places = get_verb(clause.head), clause.select(MentionKind.PLACE)
    degrees = [m for m in clause.select(MentionKind.QUANTITY) if getattr(m.value, "unit", "") == "degrees"]
    told = verb.angle or degrees or get_verb(later.verb).direction == "ahead" and clause.select(*WAYS)
    return verb.effect is Effect.TURN and verb.direction == "up" and bool(told) and not places


def _is_saying_size_again(before: Clause, clause: Clause) -> bool:
    """Return whether a second verb only measures the change of size: "it deflates and shrinks to half its size"."""
    first, second = get_verb(before.head), get_verb(clause.verb)
    alike = first.effect is second.effect in (Effect.SCALE, Effect.SWELL) and first.sign == second.sign
    other = before.verb is not clause.verb
    measured = bool(clause.select(MentionKind.QUANTITY)) and not before.modifiers and clause.join is Join.AND
    # "Somebody sits on it, it gets squashed".
    comes = first.sign < 0 and not clause.modifiers and clause.join in (Join.AND, Join.COMMA)
    return alike and other and (measured or comes)


def _is_dented(blow: Clause, clause: Clause) -> bool:
    """Return whether a blow leaves a dent: "it is struck on its left side and keeps the dent, or crumples there"."""
    verb, struck = get_verb(clause.verb), [m.phrase for m in blow.select(MentionKind.PLACE)]
    dents = verb.sign < 0 and (verb.quick or bool(struck) and verb.effect in (Effect.SCALE, Effect.SWELL))
    placed = all(m.phrase in struck for m in clause.select(*WHERE))
    return blow.has(Effect.STRIKE) and dents and placed and not get_verb(blow.head).gravity


def _find_comma(merged: list[Clause], clause: Clause) -> Join:
    """The meaning of a comma before a verb: another motion at the same time, what comes of it, or the next one."""
    before = merged[-1]
    verb, head = clause.verb, before.head
    assert verb is not None and head is not None
    participle, other = is_participle(verb.form), is_participle(head.form)
    if participle and not other:
        return Join.WHILE if _is_moving_beside(before, clause) else Join.RESULT
    leads = before.verb is not None and other and not participle and len(merged) == 1
    if leads and before.join is not Join.AFTER and not before.has(Effect.STILL, Effect.RELEASE):
        return Join.WHILE  # "spinning, it rises"
    alone = before.verb is None and clause.cause is None and not before.select(MentionKind.TIME)
    return Join.RESULT if alone else Join.COMMA  # "with great force, it is thrown"


def _is_moving_beside(before: Clause, clause: Clause) -> bool:
    """Return whether a participle tells a motion of its own: "it falls, spinning", "push it right, spinning it"."""
    if before.cause is not None:
        return False
    first, second = get_verb(before.head), get_verb(clause.verb)
    ways = before.select(*WAYS) or first.direction is not None
    if second.effect is Effect.PUSH:
        return first.effect is not Effect.STRIKE and (second.bound or bool(clause.select(*WAYS)))
    itself = first.effect in (Effect.FALL, *_FORMS) or first.effect is Effect.PUSH and bool(ways)
    return itself and second.effect in _FORMS and second.effect is not first.effect


def _relate(cause: Clause, effect: Clause) -> list[Clause]:
    """Merges an effect with its cause; returns it where it stays a clause of its own."""
    first, second = get_verb(cause.head), get_verb(effect.verb)
    falls = first.effect is Effect.FALL and not first.gives
    drops = falls and second.effect in (Effect.ROLL, Effect.PUSH, Effect.SWAY, Effect.LEAN)
    drops |= (falls or first.gravity) and second.effect is Effect.BURST  # "drop it so that it bursts"
    # "Knock it over so that it rolls away"; where it "goes", it falls.
    told = second.generic and second.effect is not Effect.TURN and bool(effect.select(*WAYS))
    drops |= first.effect is Effect.TOPPLE and not told and second.effect in _LYING
    if first.gravity and second.effect is Effect.ROLL and effect.verb is not None:  # what is in the air turns
        effect.verb = replace(effect.verb, value=(second := LEXICON.motions["tumble"]), phrase="tumble")
        if cause.verb is not None and (across := LEXICON.motions.get(f"{cause.verb.phrase} across")):
            cause.verb = replace(cause.verb, value=across)  # "throw it so that it tumbles across the floor"
    # "Toss it so that it flips", "drop it so that it rolls", "twist it until it tears".
    shapes = {first.effect, second.effect} <= {Effect.TURN, Effect.SCALE, Effect.SWAY}
    another = drops or second.effect is Effect.TURN and first.gravity
    fell = cause.has(Effect.FALL, Effect.TOPPLE)
    another |= fell and second.effect is Effect.STRIKE and not effect.modifiers
    severs = second.manner == "detach" and first.effect in _FORMS and not cause.select(MentionKind.PLACE)
    another |= shapes and second.effect is not first.effect
    lengths = [m for m in cause.select(MentionKind.QUANTITY) if getattr(m.value, "unit", "") in _LENGTHS]
    own = first.effect in (Effect.PUSH, Effect.ROLL) and second.effect is Effect.SWAY and bool(lengths)
    own |= first.effect is Effect.SWELL and first.sign > 0 and second.effect is Effect.PUSH
    if own:  # "it drives two metres so that it rocks", which is the way that it went; "inflate it until it floats up"
        effect.join = Join.THEN
        alone = effect.select(*WHERE) or first.effect is Effect.SWELL
        effect.modifiers += [] if alone else cause.select(*WAYS)
        return [effect]
    if first.pokes and second.jiggles:  # "a finger taps it so that it wobbles"
        effect.join = Join.AND
        return [effect]
    flung = second.generic and second.effect is Effect.PUSH and first.effect is Effect.TURN
    if flung and effect.select(MentionKind.PLACE):  # "spin it so fast that its leaves fly outwards"
        return []
    if first.wrings and second.effect is Effect.TURN:  # "wring it: its upper end turns against its lower end"
        effect.modifiers = [m for m in effect.modifiers if m.kind is not MentionKind.PLACE]
        _absorb(cause, effect)
        return []
    if first.effect is Effect.STRIKE and second.effect is Effect.PUSH:  # "hit it: it rises"
        led = any(way.phrase != "away" for way in effect.select(*WAYS))
        if led and cause.verb is not None and effect.verb is not None and effect.verb.phrase == "fly":
            thrown = replace(LEXICON.motions["throw"], strength=first.strength)
            cause.verb = replace(cause.verb, value=thrown)  # "hit it in the belly so that it flies backwards"
            cause.modifiers = [m for m in cause.modifiers if m.kind is not MentionKind.PLACE]
        if second.direction and (verb := effect.verb) and not effect.select(*WAYS):
            effect.modifiers.append(replace(verb, kind=MentionKind.DIRECTION, value=(second.direction,)))
        _absorb(cause, effect)
        return []
    # "Lift its front until it stands on its back end, or tips": but by a handle, it tilts about the other side.
    upwards = [m for m in cause.select(*WAYS) if m.value == ("up",)]
    raised = first.effect is Effect.PUSH and (first.bound or bool(upwards))
    if second.effect is Effect.LEAN and (second.angle or raised):
        places = cause.select(MentionKind.PLACE)
        grips = [] if second.angle else list(filter(sticks_out, places))
        kept = [m for m in cause.modifiers if m not in places or m in grips]
        told = [m for m in (*kept, *effect.modifiers) if m not in upwards]
        led = second.direction or any(m.kind in WAYS for m in told)
        names = [] if led else [getattr(m.value, "names", ()) for m in places if m not in grips]
        sides = [each for each in names if {*each} - {"up", "down"}]
        kept = kept if grips else [m for m in kept if m not in upwards]
        cause.modifiers = kept + [replace(places[0], kind=MentionKind.FROM, value=each) for each in sides[:1]]
    if second.effect is Effect.TOPPLE and cause.has(*DRIVING) and not cause.select(*WAYS):
        cause.modifiers += effect.select(*WAYS)  # "push it until it tips over to the right"
    # "Twist it until it snaps in two".
    if second.effect in _SEPARATE or another or severs or is_end(first, second):
        ends = second.effect in (Effect.STILL, Effect.RELEASE) or is_end(first, second) or severs
        effect.join = Join.THEN if ends or drops else Join.WHILE
        return [effect]
    if first.effect is Effect.STRIKE and second.effect is Effect.LEAN:  # "hit its belly so that it folds"
        cause.modifiers = [m for m in cause.modifiers if m.kind is not MentionKind.PLACE or sticks_out(m)]
    yields = second.effect in (Effect.SCALE, Effect.SWELL) and not effect.select(*WAYS)
    if falls and yields or first.effect is Effect.SCALE and first.sign < 0 and second.effect is Effect.SWELL:
        return []  # "press it until it bulges", "drop it, so it squashes": it does so by itself
    driven = first.effect in DRIVING and first.direction is None
    sized = driven and second.effect in (Effect.SCALE, Effect.SWELL)  # "pull it until it is longer"
    _absorb(cause, effect, second.generic and not sized and not second.angle)
    return []


def _absorb(cause: Clause, effect: Clause, generic: bool = True) -> None:
    """Adds what is told of the effect to the cause."""
    if not generic:
        cause.cause, cause.verb = cause.cause or cause.verb, effect.verb
    elif effect.verb is not None:
        cause.modifiers += tell_result(cause, effect.verb)
    told = [m for m in effect.modifiers if m.phrase != "away" or not cause.select(*WAYS)]
    falls = generic and cause.has(Effect.TOPPLE)
    cause.modifiers += [m for m in told if not (falls and m.value == ("down",))]
    cause.mentions += effect.mentions


def _is_carried_off(before: Clause, clause: Clause) -> bool:
    """Return whether a travel is the work of a blow or a push: "kicked from the left and flies away"."""
    verb, first = get_verb(clause.verb), get_verb(before.head)
    travels = verb.effect is Effect.PUSH and verb.generic
    rolls = verb.effect is Effect.ROLL and not (first.gravity or clause.select(MentionKind.PLACE))
    if clause.join not in (Join.AND, Join.COMMA) or not (travels or rolls):
        return False
    pushed = first.effect is Effect.PUSH and not first.generic and first.direction is None
    bare = all(way.phrase == "away" for way in clause.select(*WAYS))  # off, wherever that is
    driven = pushed and (bare or travels and not before.select(*WHERE))
    elsewhere = before.select(MentionKind.DIRECTION) and clause.select(MentionKind.DIRECTION) and not bare
    if before.select(MentionKind.SOLID) and clause.select(*WAYS):  # "thrown against a wall and slides down"
        elsewhere = elsewhere or all(way.value == ("down",) for way in clause.select(*WAYS))
    return before.has(Effect.STRIKE) and not elsewhere or driven


def _is_pushed_over(before: Clause, clause: Clause) -> bool:
    """Return whether a toppling is the work of a push: "it is shoved from behind, tips over and lies there"."""
    first = get_verb(before.head)
    pushed = before.has(Effect.PUSH) and not (first.generic or first.wind or first.direction)
    goes = before.select(MentionKind.QUANTITY, MentionKind.DIRECTION, MentionKind.TIME)
    return pushed and not goes and clause.has(Effect.TOPPLE) and clause.join in (Join.COMMA, Join.AND)


def _is_moved_by_wind(wind: Clause, clause: Clause) -> bool:
    """Return whether a swaying is the wind's work and goes its way: "wind blows from the left and the plant sways"."""
    if not get_verb(wind.head).wind or clause.join is Join.THEN:
        return False
    return clause.has(Effect.LEAN) or clause.has(Effect.SWAY) and not clause.select(*WAYS)


def _is_falling_over(topple: Clause, clause: Clause) -> bool:
    """Return whether a fall ends a toppling: "it tips over to the right and falls"."""
    ways = [m for m in clause.select(*WAYS) if m.value != ("down",)]
    told = bool(topple.select(*WHERE))
    # "Knock it over so that it falls on its side".
    onto = clause.join is Join.RESULT and clause.has(Effect.TOPPLE)
    return topple.has(Effect.TOPPLE) and (onto or clause.has(Effect.FALL)) and not (ways and told)


def _sort_clauses(clauses: list[Clause]) -> list[Clause]:
    """Puts "B after A" and "before B, A" in the order of time; a list is a sequence to its last "and"."""
    ordered: list[Clause] = []
    if len(clauses) > 1 and clauses[0].join is Join.BEFORE:
        clauses[0].join = Join.THEN
        clauses = [clauses[1], clauses[0], *clauses[2:]]
    for index, clause in enumerate(clauses):
        if index == 1 and clauses[0].join is Join.WHILE and clause.join is Join.COMMA:
            clause.join = Join.WHILE  # "while it falls, it rotates"
        if clause.join is Join.AFTER and ordered:
            ordered.insert(len(ordered) - 1, clause)
            clause.join, ordered[-1].join = ordered[-1].join, Join.THEN
        else:
            ordered.append(clause)
    for before, clause in pairwise(ordered):
        if clause.join is Join.AND and before.join is Join.COMMA and before is not ordered[0]:
            clause.join = Join.COMMA
    return ordered
