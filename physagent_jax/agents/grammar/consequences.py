"""Cause and effect in two clauses: one action, or two at the same time."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.grammar.clauses import WHERE, Clause, get_verb
from physagent_jax.agents.grammar.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import Join
from physagent_jax.agents.grammar.tokens import is_participle
from physagent_jax.agents.rules.language.verbs import VERBS, Effect, Verb

_DOWN = ("down",)
_PARTED = (MentionKind.PLACE, MentionKind.EXCLUDED)
_LEAVING = ("exit",)
_SHAPING = (Effect.TURN, Effect.SCALE, Effect.SWAY)
_FORMS = (Effect.SCALE, Effect.SWELL, Effect.LEAN)
# What an object does by itself; a push or a blow brings about what follows.
_ITSELF = (Effect.FALL, Effect.JUMP, Effect.TURN, Effect.SWAY, Effect.ROLL, *_FORMS)
_SEPARATE_EFFECTS = (Effect.FALL, Effect.TOPPLE, Effect.STILL, Effect.RELEASE, Effect.HOLD)


def split_turning_winds(clauses: list[Clause]) -> list[Clause]:
    """Makes two winds of one that turns: it blows to the first side, then to the second."""
    result: list[Clause] = []
    for clause in clauses:
        verb = clause.verb
        turns = verb is not None and get_verb(verb).effect is Effect.TURN and not clause.negated
        veers = turns and verb is not None and verb.phrase.startswith("turn") and not _is_turned(verb)
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


def _is_turned(verb: Mention) -> bool:
    """Return whether the wind turns something: "makes the vane turn", "turns it around"."""
    return verb.form == "turn" or " it " in verb.words


def give_exceptions(clauses: list[Clause]) -> list[Clause]:
    """Makes one motion of a part of "all is still except the top, which shakes": the rest's stillness follows."""
    result: list[Clause] = []
    for before, clause in zip((None, *clauses), clauses):
        excluded = before.select(MentionKind.EXCLUDED) if before is not None and _is_resting(before) else []
        moves = clause.verb is not None and not clause.negated
        if excluded and moves and clause.join is not Join.THEN and not clause.select(*_PARTED):
            clause.modifiers += [replace(mention, kind=MentionKind.PLACE) for mention in excluded]
            clause.join = before.join if before is not None else clause.join
            result.pop()
        result.append(clause)
    return result


def merge_results(clauses: list[Clause]) -> list[Clause]:
    """Makes one action of cause and effect ("pushes it so that it bends"): the effect's verb, all modifiers."""
    merged: list[Clause] = []
    for before, clause in zip(clauses, clauses[1:]):
        _share_direction(before, clause)
    for clause in clauses:
        if clause.join is Join.COMMA and clause.verb and merged and merged[-1].head is not None:
            participle = is_participle(clause.verb.form) and not is_participle(merged[-1].head.form)
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
        related = related or (bool(merged) and _is_driven(merged[-1], clause))
        related = related and not _is_holding(merged[-1] if merged else None)
        if merged and _is_accompanied(merged[-1], clause):
            merged.pop()
        if merged:
            _set_apart(merged[-1], clause)
        if merged and (_is_restating(merged[-1], clause) or _is_reshaping(merged[-1], clause)):
            merged[-1].modifiers += clause.modifiers
            merged[-1].mentions += clause.mentions
            continue
        if merged and _is_falling_over(merged[-1], clause):
            merged[-1].modifiers += [m for m in clause.modifiers if m.value != _DOWN]
            merged[-1].mentions += clause.mentions
            continue
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
    """Return whether what comes of it is another motion than what is done: "twist it until it tears"."""
    first, second = get_verb(cause.head), get_verb(clause.verb)
    if first.gravity and second.effect is Effect.TURN:
        return True  # "toss it so that it flips"
    travels = second.effect is Effect.PUSH and second.generic and bool(clause.select(MentionKind.DIRECTION))
    if travels and first.effect in (Effect.SWAY, Effect.TURN):
        return True  # "it shakes so hard that it moves to the left"
    return first.effect in _SHAPING and second.effect in _SHAPING and second.effect is not first.effect


def _is_at_rest(clause: Clause) -> bool:
    """Return whether a clause says that nothing moves."""
    verb = None if clause.verb is None or clause.negated else get_verb(clause.verb)
    return verb is not None and verb.effect is Effect.STILL and not verb.generic


def _is_resting(clause: Clause) -> bool:
    """Return whether a clause says that something rests: "all of it rests", too."""
    verb = None if clause.verb is None or clause.negated else get_verb(clause.verb)
    return verb is not None and verb.effect is Effect.STILL


def _share_direction(blow: Clause, clause: Clause) -> None:
    """A blow goes where what it fells goes: "a kick topples it to the right"."""
    told = clause.select(MentionKind.DIRECTION)
    if blow.head is None or clause.verb is None or blow.select(*WHERE) or clause.join is Join.THEN:
        return
    first, second = get_verb(blow.head), get_verb(clause.verb)
    pushes = first.effect is Effect.PUSH and not first.generic and first.direction is None
    if first.effect is Effect.STRIKE and second.effect is Effect.TOPPLE:
        blow.modifiers += told
    elif pushes and not (blow.negated or clause.negated) and second.effect in (Effect.ROLL, Effect.TOPPLE):
        blow.modifiers += told


def _is_moved_by_wind(wind: Clause, clause: Clause) -> bool:
    """Return whether a swaying is the wind's work and goes its way: "wind blows from the left and the plant sways"."""
    if clause.verb is None or wind.head is None or not get_verb(wind.head).wind or clause.join is Join.THEN:
        return False
    effect = get_verb(clause.verb).effect
    return effect is Effect.LEAN or (
        effect is Effect.SWAY and not clause.select(MentionKind.DIRECTION, MentionKind.FROM)
    )


def _is_moving_beside(cause: Clause, clause: Clause) -> bool:
    """Return whether a participle tells another motion at the same time: "push it right, spinning it"."""
    first, second = get_verb(cause.head), get_verb(clause.verb)
    pushed = first.effect is Effect.PUSH and not first.wind and (not first.generic or cause.verb is not None)
    beside = second.effect in (Effect.TURN, Effect.SWAY)
    goes = bool(cause.select(*WHERE)) or first.direction is not None
    own = cause.cause is None and not cause.negated and _is_own(first, second, clause)
    ways = [{m.value for m in c.select(MentionKind.DIRECTION)} for c in (cause, clause)]
    apart = (
        all(ways) and not ways[0] & ways[1] or first.bound and bool(ways[1])
    )  # "drag it left, tilting it right"
    own = own or apart and first.effect is Effect.PUSH and second.effect in (Effect.PUSH, Effect.LEAN)
    return own or pushed and cause.cause is None and beside and goes


def _is_own(first: Verb, second: Verb, clause: Clause) -> bool:
    """Return whether a participle tells one more motion of its own: "it falls, spinning", "it spins, moving left"."""
    if second.effect is Effect.PUSH and second.generic:
        ways = clause.select(MentionKind.DIRECTION, MentionKind.FROM)
        return first.effect in (Effect.TURN, Effect.JUMP, Effect.FALL) and bool(ways)
    goes = second.effect is Effect.PUSH and second.bound
    shapes = second.effect in (Effect.TURN, Effect.SWAY, Effect.JUMP, Effect.ROLL, *_FORMS)
    if first.effect is Effect.TOPPLE:
        return shapes and second.effect not in (Effect.TURN, Effect.ROLL, Effect.LEAN)
    differs = second.effect is not first.effect and not {first.effect, second.effect} <= {
        Effect.TURN,
        Effect.ROLL,
    }
    return first.effect in _ITSELF and differs and (goes or shapes)


def _is_meanwhile(first: Clause, clause: Clause) -> bool:
    """Return whether a participle stands before what happens at the same time: "spinning, it rises"."""
    if first.verb is None or clause.verb is None or first.join is Join.AFTER or first.negated:
        return False
    still = get_verb(first.verb).effect in (Effect.STILL, Effect.RELEASE, Effect.HOLD)
    return is_participle(first.verb.form) and not is_participle(clause.verb.form) and not still


def _is_introducing(cause: Clause, clause: Clause) -> bool:
    """Return whether a cause stands before a comma and what it does behind: "with great force, it is thrown"."""
    if cause.verb is not None or cause.cause is None or clause.verb is None or clause.join is not Join.COMMA:
        return False
    return clause.cause is None and not cause.select(MentionKind.TIME)


def _is_driven(push: Clause, clause: Clause) -> bool:
    """Return whether a travel is a push's work: "they pushed, and the cart moved a little to the right"."""
    if clause.verb is None or push.verb is None or push.select(*WHERE) or clause.join is Join.THEN:
        return False
    first, second = get_verb(push.verb), get_verb(clause.verb)
    pushed = first.effect is Effect.PUSH and not first.generic and first.direction is None
    travels = second.effect is Effect.PUSH and second.generic
    return pushed and travels and bool(clause.select(MentionKind.DIRECTION, MentionKind.FROM))


def _is_restating(first: Clause, clause: Clause) -> bool:
    """Return whether two nouns name one thing in a list of what is done: "tensile loading, elongation to 1.5 times"."""
    if first.verb is not None or clause.verb is not None or first.cause is None or clause.cause is None:
        return False
    one, other = get_verb(first.cause), get_verb(clause.cause)
    alike = one.effect is other.effect and one.sign == other.sign
    return alike and one.effect in _SHAPING and clause.join is Join.COMMA and not clause.select(*WHERE)


def _is_reshaping(first: Clause, clause: Clause) -> bool:
    """Return whether two verbs tell one change of size: "it loses air and shrinks to a third"."""
    if first.verb is None or clause.verb is None or first.negated or clause.negated:
        return False
    one, other = get_verb(first.verb), get_verb(clause.verb)
    alike = one.effect is other.effect is Effect.SWELL and one.sign == other.sign
    return alike and clause.join in (Join.AND, Join.COMMA) and not first.modifiers


def _is_falling_over(topple: Clause, clause: Clause) -> bool:
    """Return whether a fall ends a toppling: "it tips over to the right and falls", "knock it over, so it falls"."""
    if topple.verb is None or clause.verb is None or topple.negated or clause.negated:
        return False
    if get_verb(topple.verb).effect is not Effect.TOPPLE or get_verb(clause.verb).effect is not Effect.FALL:
        return False
    ways = [m for m in clause.modifiers if m.value != _DOWN]
    told = topple.select(*WHERE)
    return not ways or (not told and all(m.kind is MentionKind.DIRECTION for m in ways))


def _is_holding(clause: Clause | None) -> bool:
    """Return whether a clause tells what holds the object: "it hangs from a rope, spinning" spins, and hangs."""
    return clause is not None and clause.verb is not None and get_verb(clause.verb).effect is Effect.HOLD


def _is_accompanied(noise: Clause, clause: Clause) -> bool:
    """Return whether a blow is what is heard of a fall: "with a bump, it lands"."""
    alone = noise.verb is None and noise.cause is not None and not noise.modifiers
    falls = clause.verb is not None and get_verb(clause.verb).effect is Effect.FALL and not clause.negated
    return alone and falls and get_verb(noise.cause).effect is Effect.STRIKE and clause.join is Join.COMMA


def _set_apart(before: Clause, clause: Clause) -> None:
    """Puts what can only come later behind what stands before it."""
    verb = clause.verb if clause.verb is not None and not clause.negated else None
    if verb is None:
        return
    if clause.join is Join.AND and (verb.phrase in _LEAVING or _is_bouncing(before, clause)):
        clause.join = Join.THEN  # "it bows and exits"
    if _is_coming_down(before, verb):
        clause.verb, clause.join = replace(verb, value=VERBS["fall"], phrase="fall"), Join.THEN


def _is_bouncing(fall: Clause, clause: Clause) -> bool:
    """Return whether it bounces after it fell: "it hits the floor and bounces twice"."""
    falls = fall.verb is not None and not fall.negated and get_verb(fall.verb).effect is Effect.FALL
    return falls and clause.verb is not None and clause.verb.phrase == "bounce"


def _is_coming_down(throw: Clause, verb: Mention) -> bool:
    """Return whether what is thrown comes down again by itself: "toss it up and let it come back down"."""
    if throw.head is None or throw.negated:
        return False
    thrown = get_verb(throw.head)
    comes = verb.phrase.endswith("back down") and verb.form in ("come", "comes", "go", "goes")
    return comes and thrown.effect in (Effect.STRIKE, Effect.JUMP) and thrown.gravity


def _is_carried_off(cause: Clause, clause: Clause) -> bool:
    """Return whether a travel is a blow's work: "kicked from the left and flies away"."""
    if clause.verb is None or cause.head is None or clause.join not in (Join.AND, Join.COMMA):
        return False
    verb = get_verb(clause.verb)
    down = [("down",)]  # "thrown to the left and slides down"
    later = down == [m.value for m in clause.select(MentionKind.DIRECTION)] and cause.select(*WHERE)
    if verb.generic and later and clause.join is Join.AND:
        clause.join = Join.THEN
        return False
    return verb.generic and verb.effect is Effect.PUSH and get_verb(cause.head).effect is Effect.STRIKE


def _merge(cause: Clause, effect: Clause) -> None:
    if not get_verb(effect.verb).generic:
        cause.cause, cause.verb = cause.cause or cause.verb, effect.verb
    cause.modifiers += effect.modifiers
    cause.mentions += effect.mentions
