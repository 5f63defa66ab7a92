"""Clauses that do not say which way, or say several ways at once: one would have to be guessed."""

from __future__ import annotations

from physagent_jax.agents.rules.language.clauses import Clause, get_verb
from physagent_jax.agents.rules.language.mentions import MentionKind
from physagent_jax.agents.rules.language.modifiers import Join, Place, Repeat
from physagent_jax.agents.rules.language.tokens import FORMS
from physagent_jax.agents.rules.language.verbs import Effect, Verb

_WAYS = (MentionKind.DIRECTION, MentionKind.FROM, MentionKind.AXIS, MentionKind.PLANE, MentionKind.SENSE)
_DIRECTED = (Effect.PUSH, Effect.LEAN, Effect.STRIKE, Effect.ROLL, Effect.TOPPLE)
_DONE = (Effect.PUSH, Effect.LEAN, Effect.STRIKE, Effect.ROLL, Effect.SCALE, Effect.TURN, Effect.SWAY)
_OPPOSITE = {
    "left": "right",
    "right": "left",
    "up": "down",
    "down": "up",
    "toward": "away",
    "away": "toward",
}


def find_contradictions(clauses: list[Clause]) -> list[str]:
    """Plain sentences about ways, sides and ends that the clauses leave open."""
    return [doubt for rule in _RULES for doubt in rule(clauses)]


def _find_restated(clauses: list[Clause]) -> list[str]:
    """Says "an earthquake! It trembles": a cause by itself, and then the like of it."""
    doubts = []
    for cause, clause in zip(clauses, clauses[1:]):
        alone = cause.verb is None and cause.cause is not None and not cause.negated
        done = clause.verb is not None and clause.cause is None and not clause.negated
        if alone and done and get_verb(cause.cause).effect is get_verb(clause.verb).effect:
            doubts.append(f"Whether '{cause.words}' and '{clause.words}' are one thing is not understood.")
    return doubts


def _find_denied_way(clauses: list[Clause]) -> list[str]:
    """Says "push it without toppling it to the right": the way of which of them?"""
    doubts = []
    for clause, denied in zip(clauses, clauses[1:]):
        ways = denied.select(MentionKind.DIRECTION, MentionKind.FROM) if denied.negated else []
        does = clause.verb is not None and not clause.negated and get_verb(clause.verb).direction is None
        if ways and does and get_verb(clause.verb).effect in _DIRECTED and not clause.select(*_WAYS):
            doubts.append(f"What goes '{ways[0].words}' is not understood.")
    return doubts


def _find_axes(clauses: list[Clause]) -> list[str]:
    """Says "stretch it horizontally and vertically": along two axes."""
    doubts = []
    for clause in clauses:
        lines = [m for m in clause.select(MentionKind.AXIS, MentionKind.PLANE)]
        if clause.head is not None and len({m.value for m in lines}) > 1:
            doubts.append(f"How it is '{' and '.join(m.words for m in lines)}' at once is not understood.")
    return doubts


def _find_denied_motion(clauses: list[Clause]) -> list[str]:
    """Says "it is pushed but does not move", "it does not move when pushed": what is to be seen of the push?"""
    doubts = []
    pairs = list(zip(clauses, clauses[1:]))
    pairs += [(clause, denied) for denied, clause in pairs if clause.join is Join.WHILE]
    for clause, denied in pairs:
        moves = clause.head is not None and not clause.negated
        verb = get_verb(denied.verb) if denied.verb is not None and denied.negated else None
        still = verb is not None and verb.effect is Effect.PUSH and (verb.generic or denied.words == "budge")
        if moves and still and not denied.modifiers and get_verb(clause.head).effect in _DIRECTED:
            doubts.append(f"What '{clause.words}' does if it does not '{denied.words}' is not understood.")
    return doubts


def _find_contrary_way(clauses: list[Clause]) -> list[str]:
    """Says "lift it down", "lift it from above", "jump down": the verb has its way already."""
    doubts = []
    for clause in clauses:
        verb = get_verb(clause.verb) if clause.verb is not None and not clause.inherited else None
        jumps = verb is not None and verb.effect is Effect.JUMP
        own = "up" if jumps else verb.direction if verb is not None and verb.bound else None
        opposite = {"up": ("down",), "down": ("up",)}.get(own or "")
        against = [m.value for m in clause.select(MentionKind.DIRECTION)]
        against += [
            (_OPPOSITE[m.value[0]],) for m in clause.select(MentionKind.FROM) if isinstance(m.value, tuple)
        ]
        if opposite in against:
            doubts.append(f"Which way '{clause.words}' goes here is not understood.")
    return doubts


def _find_going_nowhere(clauses: list[Clause]) -> list[str]:
    """Says "off it goes", "it goes wild": which way, or how, is not told."""
    doubts = []
    for clause in clauses:
        goes = (
            clause.verb is not None and clause.cause is None and not clause.inherited and not clause.negated
        )
        if not goes or clause.words.split()[0].lower() not in ("go", "goes", "going", "went", "gone"):
            continue
        told = clause.select(
            *_WAYS, MentionKind.SIDES, MentionKind.SOLID, MentionKind.REPEAT, MentionKind.REVERSAL
        )
        if not told:
            doubts.append(f"Where it '{clause.words}' is not understood.")
    return doubts


def _find_unfixed(clauses: list[Clause]) -> list[str]:
    """Says "fix the base, then release it and push it": it is held only at first."""
    doubts = []
    for held, clause in zip(clauses, clauses[1:]):
        verbs = [get_verb(c.verb).effect for c in (held, clause) if c.verb is not None and not c.negated]
        if verbs == [Effect.HOLD, Effect.RELEASE]:
            doubts.append(f"Until when '{held.words}' holds is not understood.")
    return doubts


def _find_kept(clauses: list[Clause]) -> list[str]:
    """Says "bend it and don't let go": it is held, but where?"""
    return [
        f"What '{clause.words}' denies is not understood."
        for clause in clauses
        if clause.verb is not None and clause.negated and get_verb(clause.verb).effect is Effect.RELEASE
    ]


def _find_fragments(clauses: list[Clause]) -> list[str]:
    """Says "Push it. To the left. Gently.": told of the push before, and no other one."""
    doubts = []
    for before, clause in zip(clauses, clauses[1:]):
        if not clause.inherited or clause.join is not Join.THEN or before.head is None or clause.negated:
            continue
        manner = {m.kind for m in clause.modifiers} <= {MentionKind.INTENSITY, MentionKind.DEGREE}
        manner = manner or {m.kind for m in clause.mentions} == {MentionKind.REPEAT}  # "Hit it. Three times."
        late = clause.select(*_WAYS) and not before.select(*_WAYS) and get_verb(before.head).direction is None
        told = {m.kind for m in clause.modifiers} <= {*_WAYS}
        if clause.modifiers and {m.kind for m in clause.modifiers} == {MentionKind.PLACE}:
            late = told = True  # "Direction: left. Part: top."
        if get_verb(before.head).effect in _DIRECTED and (manner and clause.modifiers or late and told):
            doubts.append(
                f"Whether '{clause.modifiers[0].words}' tells of '{before.words}' is not understood."
            )
    return doubts


def _find_hovering(clauses: list[Clause]) -> list[str]:
    """Says "it rises, hovers and comes down": it stays up there, and rises no further."""
    return [
        f"How high '{clause.words}' is, is not understood."
        for before, clause in zip(clauses, clauses[1:])
        if before.verb is not None and clause.verb is not None and not clause.inherited
        if get_verb(before.verb).direction == get_verb(clause.verb).direction == "up"
        if clause.verb.form in ("hover", "hovers", "hovering", "floats", "floating")
    ]


def _find_rolling_upright(clauses: list[Clause]) -> list[str]:
    """Says "roll it up": nothing rolls up or down where there is no slope."""
    return [
        f"How it is to '{clause.words}' up or down is not understood."
        for clause in clauses
        if clause.verb is not None and get_verb(clause.verb).effect is Effect.ROLL
        if any(m.value in (("up",), ("down",)) for m in clause.select(MentionKind.DIRECTION))
    ]


def _find_many_ways(clauses: list[Clause]) -> list[str]:
    """Says "hit it from the left, the right and above": three blows, and not one along their sum."""
    doubts = []
    for clause in clauses:
        to = {m.value[0] for m in clause.select(MentionKind.DIRECTION) if isinstance(m.value, tuple)}
        to |= {_OPPOSITE[m.value[0]] for m in clause.select(MentionKind.FROM) if isinstance(m.value, tuple)}
        if len(to) > 2 and any(_OPPOSITE[way] in to for way in to):
            doubts.append(f"In which order '{clause.words}' goes its ways is not understood.")
    return doubts


def _find_ends_one_way(clauses: list[Clause]) -> list[str]:
    """Says "both ends move up": neither from both sides nor all of it."""
    return [
        f"What '{clause.select(MentionKind.SIDES)[0].words}' means for '{clause.words}' is not understood."
        for clause in clauses
        if clause.head is not None and clause.select(MentionKind.SIDES)
        if get_verb(clause.head).effect in (Effect.PUSH, Effect.STRIKE)
        and (len(clause.select(MentionKind.DIRECTION)) == 1 or get_verb(clause.head).bound)
    ]


def _find_shape(clauses: list[Clause]) -> list[str]:
    """Says "longer and thinner": not along one axis, and which the other is, is not told."""
    doubts = []
    for before, clause in zip(clauses, clauses[1:]):
        if before.verb is None or clause.verb is None or clause.join is not Join.AND:
            continue
        first, second = get_verb(before.verb), get_verb(clause.verb)
        shapes = first.generic and second.generic and first.effect is second.effect is Effect.SCALE
        if shapes and first.sign != second.sign and first.direction == second.direction:
            doubts.append(f"Along which axis it gets '{clause.words}' is not understood.")
    return doubts


def _find_swings_apart(clauses: list[Clause]) -> list[str]:
    """Says "up and down and left and right": two swings, or one and then another."""
    doubts = []
    for clause in clauses:
        swings = [
            m for m in clause.select(MentionKind.REPEAT) if isinstance(m.value, Repeat) and m.value.names
        ]
        ways = {m.value for m in clause.select(MentionKind.DIRECTION)}
        ways |= {m.value.names for m in swings if isinstance(m.value, Repeat)}
        axes = {frozenset({way[0], _OPPOSITE[way[0]]}) for way in ways if isinstance(way, tuple)}
        if swings and len(axes) > 1:
            doubts.append(f"In which order '{clause.words}' goes its ways is not understood.")
    return doubts


def _find_driven(clauses: list[Clause]) -> list[str]:
    """Says "does it move when it is hit from the left": it goes where the blow drives it."""
    drivers = [
        clause
        for clause in clauses
        if clause.head is not None and not clause.negated
        if get_verb(clause.head).effect in (Effect.PUSH, Effect.STRIKE)
        if clause.select(MentionKind.DIRECTION, MentionKind.FROM)
    ]
    during = [clause for clause in drivers if clause.join is Join.WHILE]
    doubts = []
    for clause in clauses:
        if (
            clause.head is None
            or clause.negated
            or clause.select(*_WAYS, MentionKind.SIDES, MentionKind.SOLID)
        ):
            continue
        verb = get_verb(clause.head)
        driven = bool(drivers if clause.join is Join.WHILE else during)
        if driven and verb.effect in _DIRECTED and verb.direction is None:
            doubts.append(f"Which way '{clause.words}' goes is not understood.")
    return doubts


def _find_side_alone(clauses: list[Clause]) -> list[str]:
    """Says "pull its right arm", "go at the left side": which way is not told, and the one assumed may be wrong."""
    doubts = []
    for clause in clauses:
        if clause.verb is None or clause.negated or get_verb(clause.verb).effect is not Effect.PUSH:
            continue
        sided = [
            m
            for m in clause.select(MentionKind.PLACE)
            if isinstance(m.value, Place) and {"left", "right", "away"} & set(m.value.names)
        ]
        told = clause.select(*_WAYS, MentionKind.SIDES, MentionKind.SOLID, MentionKind.REPEAT)
        if sided and not told and get_verb(clause.verb).direction is None:
            doubts.append(f"Which way '{sided[0].words}' is to go is not understood.")
    return doubts


def _find_held_with(clauses: list[Clause]) -> list[str]:
    """Says "bend it and hold it there three times": what is held goes on, and takes no count or measure."""
    counted = (MentionKind.REPEAT, MentionKind.QUANTITY, MentionKind.SENSE)
    doubts = []
    for clause in clauses:
        holds = [m for m in clause.mentions if isinstance(m.value, Verb) and m.value.effect is Effect.HOLD]
        if not clause.stays or not holds:
            continue
        held = [m for m in clause.mentions if m.kind in counted and m.first > holds[0].first]
        doubts += [f"What '{m.words}' means for '{holds[0].words}' is not understood." for m in held]
    return doubts


def _find_held_side(clauses: list[Clause]) -> list[str]:
    """Says "hold the left side": only the base and the top can be held."""
    doubts = []
    for clause in clauses:
        if clause.verb is None or clause.negated or get_verb(clause.verb).effect is not Effect.HOLD:
            continue
        places = [m for m in clause.select(MentionKind.PLACE) if isinstance(m.value, Place)]
        places = clause.select(MentionKind.SIDES) or places
        if places and not any(
            isinstance(m.value, Place) and {"up", "down"} & set(m.value.names) for m in places
        ):
            doubts.append(f"'{places[0].words}' cannot be held: only the base and the top can.")
    return doubts


def _find_denied_pair(clauses: list[Clause]) -> list[str]:
    """Says "do not lift it and drop it": is the second forbidden as well?"""
    doubts = []
    for denied, clause in zip(clauses, clauses[1:]):
        verbs = [c.verb for c in (denied, clause) if c.verb is not None]
        orders = len(verbs) == 2 and all(FORMS.get(v.form) == v.form for v in verbs)
        alike = orders and denied.negated and not clause.negated and clause.join is Join.AND
        if alike and denied is clauses[0] and not clause.inherited and get_verb(denied.verb).effect in _DONE:
            doubts.append(f"Whether '{clause.words}' is denied as well is not understood.")
    return doubts


def _find_torn_out(clauses: list[Clause]) -> list[str]:
    """Says "the storm rips it out of the ground": it goes out, and does not tear."""
    return [
        f"Where '{clause.words} {out.words}' leads is not understood."
        for clause in clauses
        if clause.head is not None and get_verb(clause.head).effect is Effect.SCALE
        for out in clause.select(MentionKind.ANCHOR)
        if out.phrase.startswith(("out of", "loose", "free"))
    ]


def _find_struck_around(clauses: list[Clause]) -> list[str]:
    """Says "hit from the left, from the right": one blow after the other; "from the top to the left": pushed there."""
    doubts = []
    for clause in clauses:
        verb = get_verb(clause.head) if clause.head is not None and not clause.negated else None
        if verb is None or verb.wind or clause.cause is not None:
            continue
        origins = [m.value[0] for m in clause.select(MentionKind.FROM) if isinstance(m.value, tuple)]
        around = verb.effect is Effect.STRIKE and any(_OPPOSITE[way] in origins for way in origins)
        sided = any(m.value in (("left",), ("right",)) for m in clause.select(MentionKind.DIRECTION))
        upright = verb.effect is Effect.PUSH and {"up", "down"} & set(origins) and sided
        if around or upright:
            doubts.append(f"Where '{clause.words}' acts is not understood.")
    return doubts


def _find_counted_turns(clauses: list[Clause]) -> list[str]:
    """Says "turn it 90 degrees twice": all of it, or each time?"""
    doubts = []
    for clause in clauses:
        turns = clause.head is not None and get_verb(clause.head).effect is Effect.TURN
        counts = [(m, m.value) for m in clause.select(MentionKind.REPEAT)]
        counted = [m for m, count in counts if isinstance(count, Repeat) and (count.count or 1) > 1]
        if turns and counted and clause.select(MentionKind.QUANTITY):
            doubts.append(f"How far '{clause.words}' turns '{counted[0].words}' is not understood.")
    return doubts


def _find_measured_ways(clauses: list[Clause]) -> list[str]:
    """Says "up a bit, left a lot": more of one way than of the other."""
    doubts = []
    for clause in clauses:
        ways = {m.value for m in clause.select(MentionKind.DIRECTION)}
        measures = [m for m in clause.select(MentionKind.INTENSITY, MentionKind.QUANTITY)]
        kinds = {m.value < 1 if isinstance(m.value, float) else m.words for m in measures}
        if clause.head is not None and len(ways) > 1 and len(kinds) > 1:
            words = "' and '".join(m.words for m in measures)
            doubts.append(f"Which way '{words}' belong to is not understood.")
    return doubts


_RULES = (
    _find_denied_pair,
    _find_torn_out,
    _find_struck_around,
    _find_counted_turns,
    _find_measured_ways,
    _find_restated,
    _find_axes,
    _find_denied_motion,
    _find_denied_way,
    _find_contrary_way,
    _find_going_nowhere,
    _find_hovering,
    _find_fragments,
    _find_kept,
    _find_unfixed,
    _find_many_ways,
    _find_rolling_upright,
    _find_ends_one_way,
    _find_shape,
    _find_swings_apart,
    _find_driven,
    _find_side_alone,
    _find_held_side,
    _find_held_with,
)
