"""Constructions that the grammar has no reading for, although it knows each of their words.

Taken word by word they would say something else: "over the wall", "around its neck", "faster and faster", "left or
right", "everything but rotate". A rule here holds for a construction, whatever the words in it.
"""

from __future__ import annotations

from collections.abc import Callable

from physagent_jax.agents.rules.language.clauses import Clause, get_verb
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import (
    FUNCTION_WORDS,
    NUMBERS,
    PAUSES,
    UNITS,
    WHOLE_WORDS,
    Join,
    Place,
)
from physagent_jax.agents.rules.language.naming import DETERMINERS
from physagent_jax.agents.rules.language.tokens import FORMS
from physagent_jax.agents.rules.language.verbs import Effect, Verb

_MOTIONS = (MentionKind.VERB, MentionKind.CAUSE)
_WAYS = (MentionKind.DIRECTION, MentionKind.FROM, MentionKind.AXIS, MentionKind.PLANE, MentionKind.SENSE)
_DIRECTED = (Effect.PUSH, Effect.LEAN, Effect.STRIKE, Effect.ROLL, Effect.TOPPLE)
_CHOOSABLE = (*_MOTIONS, *_WAYS, MentionKind.PLACE)
_DOERS = frozenset({"people", "persons", "hands", "fingers", "fists", "plates"})
# Before a part or a solid: where it goes along, not what is acted on or run into.
_PAST = frozenset(
    "around about over under above below along across through behind beside past near between beyond".split()
)
_GOALS = frozenset({"to", "toward", "towards", "into", "onto", "from"})
_NAMELESS_PARTS = frozenset({"end", "ends", "part", "parts", "side", "corner", "edge"})
_POSTURES = frozenset({"stand", "sit", "lay", "lie", "rest"})
_BECOMING = frozenset({"get", "gets", "getting", "become", "becomes", "becoming", "got", "became"})
_KEEPING = frozenset({"keep", "keeps", "keeping", "kept"})
_SCENE = frozenset({"ground", "floor", "table", "ceiling", "wall", "walls", "sky"})
_SURFACES = frozenset({"ground", "floor", "table", "sky"})
_ACROSS = frozenset({"over", "across", "along", "about", "around", "through"})
_OPPOSITE = {
    "left": "right",
    "right": "left",
    "up": "down",
    "down": "up",
    "toward": "away",
    "away": "toward",
}
_MEASURES = (MentionKind.QUANTITY, MentionKind.COMPARATIVE, MentionKind.INTENSITY, MentionKind.DEGREE)
_PARTICLES = frozenset({"in", "out", "around", "about", "through", "across", "along"})


def find_constructions(mentions: list[Mention], clauses: list[Clause]) -> list[str]:
    """Plain sentences about constructions that were not understood."""
    doubts = [doubt for index in range(len(mentions)) for rule in _RULES for doubt in rule(mentions, index)]
    return (
        doubts
        + _find_restated(clauses)
        + _find_denied_way(clauses)
        + _find_contrary_way(clauses)
        + _find_many_ways(clauses)
        + _find_side_alone(clauses)
        + _find_held_side(clauses)
    )


def _find_comparison(mentions: list[Mention], index: int) -> list[str]:
    """Says "harder than before", "faster and faster", "each time harder"."""
    mention = mentions[index]
    if mention.form == "than":
        return ["What is compared by 'than' is not understood."]
    pair = mentions[index + 1 : index + 3]
    doubled = len(pair) == 2 and pair[0].phrase == "and" and pair[1].words.lower() == mention.words.lower()
    if doubled and mention.kind is not MentionKind.JOIN:
        return [f"How it changes by '{mention.words} and {mention.words}' is not understood."]
    each = any(other.form in ("each", "every") for other in mentions[max(index - 3, 0) : index + 4])
    alike = mention.kind is MentionKind.INTENSITY and "as" in (mention.form, _get_phrase(mentions, index - 1))
    if alike and _get_phrase(mentions, index + 1) == "as":
        return [f"What is as '{mention.words}' as it is not understood."]
    becomes = mention.kind is MentionKind.COMPARATIVE and _get_phrase(mentions, index - 1) in _BECOMING
    if becomes:
        return [f"How it changes by '{mention.words}' is not understood."]
    if mention.kind is MentionKind.COMPARATIVE and each:
        return [f"How '{mention.words}' grows from time to time is not understood."]
    return []


def _find_delay(mentions: list[Mention], index: int) -> list[str]:
    """Says "a second later", "every second"."""
    mention, before = mentions[index], _get_phrase(mentions, index - 1)
    loose = mention.kind is MentionKind.FUNCTION and mention.form in UNITS
    if loose and before in (*NUMBERS, "another"):
        return [f"When '{before} {mention.words}' is, is not understood."]
    rate = mention.kind is MentionKind.TIME and before in ("every", "each")
    if rate or mention.form == "per" or loose and before in ("every", "each", "per"):
        return [f"How often '{before} {mention.words}' is, is not understood."]
    return []


def _find_loose_number(mentions: list[Mention], index: int) -> list[str]:
    """Says "in two"; how many do it ("two people") does not matter."""
    mention = mentions[index]
    counts = mention.kind is MentionKind.FUNCTION and NUMBERS.get(mention.form, 0) >= 2
    if counts and _get_phrase(mentions, index + 1) not in _DOERS:
        return [f"What '{mention.words}' counts is not understood."]
    return []


def _find_explanation(mentions: list[Mention], index: int) -> list[str]:
    """Says "it rises: it gets taller", "twice: first left, then right"."""
    if mentions[index].words == ":" and any(m.kind is MentionKind.REPEAT for m in mentions[:index]):
        return ["What is counted before ':' is not understood."]
    if mentions[index].words == ":" and _has_motion(mentions[:index]) and _has_motion(mentions[index:]):
        return ["Whether what stands behind ':' happens besides is not understood."]
    return []


def _find_choice(mentions: list[Mention], index: int) -> list[str]:
    """Says "left or right", "push or pull it"; "neither ... or" is a list."""
    before, after = _find_telling(mentions, index, -1), _find_telling(mentions, index, 1)
    if mentions[index].form != "or" or before is None or after is None:
        return []
    if before.kind not in _CHOOSABLE or after.kind not in _CHOOSABLE:
        return []
    if any(m.kind is MentionKind.NOT for m in mentions[:index]):
        return []
    return [f"Which of '{before.words}' or '{after.words}' is meant is not understood."]


def _find_passage(mentions: list[Mention], index: int) -> list[str]:
    """Says "over the wall", "around its neck"."""
    mention = mentions[index]
    before = index - 1
    while before >= 0 and mentions[before].phrase in DETERMINERS:
        before -= 1
    preposition = _get_phrase(mentions, before)
    along = mention.kind is MentionKind.SOLID and mentions[before].form in ("down", "up")
    along = along or mention.kind is MentionKind.PLACE and preposition in _GOALS
    if mention.kind in (MentionKind.PLACE, MentionKind.SOLID) and (preposition in _PAST or along):
        return [f"What '{preposition} {mention.words}' means is not understood."]
    return []


def _find_scene_passage(mentions: list[Mention], index: int) -> list[str]:
    """Says "under the table", "around the table"; "across the floor" is where it moves anyway."""
    mention, before = mentions[index], index - 1
    while before >= 0 and mentions[before].phrase in DETERMINERS:
        before -= 1
    preposition = _get_phrase(mentions, before)
    where = mention.kind is MentionKind.FUNCTION and mention.form in _SCENE
    if where and preposition in _PAST and not (preposition in _ACROSS and mention.form in _SURFACES):
        return [f"Where '{preposition} the {mention.words}' is, is not understood."]
    return []


def _find_idle_denial(mentions: list[Mention], index: int) -> list[str]:
    """Says "but it can not", "or not": nothing follows that would not happen."""
    ends = index + 1 == len(mentions) or mentions[index + 1].kind is MentionKind.JOIN
    if mentions[index].kind is MentionKind.NOT and ends and _has_motion(mentions[:index]):
        return [f"What '{mentions[index].words}' denies is not understood."]
    return []


def _find_idle_pause(mentions: list[Mention], index: int) -> list[str]:
    """Says "pausing in between" of what is not counted."""
    mention = mentions[index]
    if mention.phrase in PAUSES and not any(m.kind is MentionKind.REPEAT for m in mentions):
        return [f"What '{mention.words}' is between is not understood."]
    return []


def _find_nameless_part(mentions: list[Mention], index: int) -> list[str]:
    """Says "one end of it", "on its side"."""
    mention, before = mentions[index], _get_phrase(mentions, index - 1)
    if mention.kind is MentionKind.FUNCTION and mention.form in _NAMELESS_PARTS:
        if before in DETERMINERS | {"one", "other", "no"}:
            return [f"Which part '{before} {mention.words}' is, is not understood."]
    return []


def _find_posture(mentions: list[Mention], index: int) -> list[str]:
    """Says "lay it on its back", "it stands on its head": something is done, and not stillness."""
    mention = mentions[index]
    turns = isinstance(mention.value, Verb) and mention.value.effect is Effect.TURN
    if mention.kind is not MentionKind.VERB or not (turns or FORMS.get(mention.form) in _POSTURES):
        return []
    place = _find_telling(mentions, index, 1)
    if place is not None and isinstance(place.value, Place) and "down" not in place.value.names:
        if any(m.phrase in ("on", "onto", "upon") for m in mentions[index : index + 4]):
            return [f"How it comes to be on its {place.words} is not understood."]
    if turns or mention.form not in _POSTURES:
        return []
    behind = mentions[index + 1] if index + 1 < len(mentions) else None
    imperative = index == 0 or mentions[index - 1].kind is MentionKind.JOIN
    if imperative and behind is not None and behind.phrase in DETERMINERS | {"it", "him", "them"}:
        return [f"What '{mention.words}' does is not understood."]
    return []


def _find_thing(mentions: list[Mention], index: int) -> list[str]:
    """Says "on a swing": a thing, although the word is a verb elsewhere."""
    mention = mentions[index]
    placed = _get_phrase(mentions, index - 1) in DETERMINERS and _get_phrase(mentions, index - 2) in (
        "on",
        "under",
    )
    if mention.kind is MentionKind.VERB and placed:
        return [f"There is no {mention.words} here."]
    return []


def _find_particle(mentions: list[Mention], index: int) -> list[str]:
    """Says "in and out", "it is pushed around", "face it to the right"."""
    mention, before = mentions[index], _get_phrase(mentions, index - 1)
    after = mentions[index + 1] if index + 1 < len(mentions) else None
    ends = after is None or after.kind in (MentionKind.JOIN, MentionKind.TIME, MentionKind.REPEAT)
    told = _find_telling(mentions, index, -1)
    turns = any(isinstance(m.value, Verb) and m.value.effect is Effect.TURN for m in mentions[:index])
    loose = told is not None and told.kind is not MentionKind.JOIN and not turns
    if mention.kind is MentionKind.FUNCTION and mention.form in _PARTICLES and ends and loose:
        return [f"Which way '{mention.words}' is, is not understood."]
    if mention.kind is MentionKind.PLACE and mention.phrase in ("face", "head"):
        begins = index == 0 or mentions[index - 1].kind is MentionKind.JOIN or before in ("it", "to")
        if after is not None and begins and after.phrase in DETERMINERS | {"it", "to", "toward"}:
            return [f"What '{mention.words} {after.words}' does is not understood."]
    return []


def _find_keeping(mentions: list[Mention], index: int) -> list[str]:
    """Says "keep the feet on the ground", "keep its width"."""
    mention, kept = mentions[index], _find_telling(mentions, index, 1)
    keeps = mention.kind is MentionKind.FUNCTION and mention.form in _KEEPING
    if (
        keeps
        and kept is not None
        and kept.kind in (MentionKind.PLACE, MentionKind.AXIS, MentionKind.EXCLUDED)
    ):
        return [f"What is to be kept of '{kept.words}' is not understood."]
    return []


def _find_measured_gravity(mentions: list[Mention], index: int) -> list[str]:
    """Says "gravity is halved", "low gravity"."""
    mention = mentions[index]
    around = mentions[max(index - 1, 0) : index + 4]
    if mention.phrase != "gravity" or not any(m.kind in _MEASURES for m in around):
        return []
    return ["How strong gravity is cannot be told here, only whether it acts and which way."]


def _find_moved_scene(mentions: list[Mention], index: int) -> list[str]:
    """Says "the floor tilts", "a wall moves towards it"; a floor that shakes shakes what stands on it."""
    mention = mentions[index]
    if mention.form not in _SCENE or _get_phrase(mentions, index - 1) not in DETERMINERS:
        return []
    begins = index < 2 or mentions[index - 2].kind is MentionKind.JOIN
    behind = index + 1
    while behind < len(mentions) and mentions[behind].phrase in ("is", "are", "was", "comes", "starts", "to"):
        behind += 1
    does = mentions[behind].value if begins and behind < len(mentions) else None
    if isinstance(does, Verb) and does.effect not in (Effect.SWAY, Effect.STILL):
        return [f"'{mention.words}' does not move here."]
    return []


def _find_pair(mentions: list[Mention], index: int) -> list[str]:
    """Says "the dog and the cat"."""
    if mentions[index].form != "and" or not 0 < index < len(mentions) - 1:
        return []
    after = index + 1
    while after < len(mentions) - 1 and mentions[after].phrase in DETERMINERS:
        after += 1
    first, second = mentions[index - 1], mentions[after]
    nouns = all(_is_noun(mentions, at) for at in (index - 1, after)) and first.phrase != second.phrase
    return [f"'{first.words} and {second.words}' are more than one object."] if nouns else []


def _is_noun(mentions: list[Mention], index: int) -> bool:
    """Whether a word that does nothing by itself stands behind an article."""
    mention = mentions[index]
    return (
        mention.kind in (MentionKind.FUNCTION, MentionKind.UNKNOWN)
        and mention.form not in FUNCTION_WORDS
        and _get_phrase(mentions, index - 1) in DETERMINERS
    )


def _find_omission(mentions: list[Mention], index: int) -> list[str]:
    """Says "everything but rotate it", "anything but gently"."""
    mention, after = mentions[index], _find_telling(mentions, index, 1)
    leaves_out = mention.value is Join.BUT and _get_phrase(mentions, index - 1) in (*WHOLE_WORDS, "anything")
    if leaves_out and after is not None and not isinstance(after.value, Place):
        return [f"What is left when '{after.words}' is left out is not understood."]
    return []


def _find_denial(mentions: list[Mention], index: int) -> list[str]:
    """Says "not to the left" and no other way: the one that is assumed might be the same."""
    mention, denied = mentions[index], _find_telling(mentions, index, 1)
    if (
        mention.kind is not MentionKind.NOT
        or denied is None
        or denied.kind not in (*_WAYS, MentionKind.PLACE)
    ):
        return []
    if any(m.kind is denied.kind and m is not denied for m in mentions):
        return []
    return [f"What is to be in place of what '{mention.words} {denied.words}' rules out is not understood."]


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


def _find_contrary_way(clauses: list[Clause]) -> list[str]:
    """Says "lift it down": the verb has its way already."""
    doubts = []
    for clause in clauses:
        verb = get_verb(clause.verb) if clause.verb is not None and not clause.inherited else None
        opposite = (
            {"up": ("down",), "down": ("up",)}.get(verb.direction or "") if verb and verb.bound else None
        )
        if opposite in [m.value for m in clause.select(MentionKind.DIRECTION)]:
            doubts.append(f"Which way '{clause.words}' goes here is not understood.")
    return doubts


def _find_many_ways(clauses: list[Clause]) -> list[str]:
    """Says "hit it from the left, the right and above": three blows, and not one along their sum."""
    doubts = []
    for clause in clauses:
        ways = {m.value for m in clause.select(MentionKind.DIRECTION)}
        ways |= {
            _OPPOSITE.get(m.value[0], "") and (_OPPOSITE[m.value[0]],)
            for m in clause.select(MentionKind.FROM)
            if isinstance(m.value, tuple)
        }
        if len(ways) > 2 and any(
            _OPPOSITE.get(way[0]) == other[0] for way in ways for other in ways if way and other
        ):
            doubts.append(f"In which order '{clause.words}' goes its ways is not understood.")
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
            if isinstance(m.value, Place) and {"left", "right"} & set(m.value.names)
        ]
        told = clause.select(*_WAYS, MentionKind.SIDES, MentionKind.SOLID, MentionKind.REPEAT)
        if sided and not told and get_verb(clause.verb).direction is None:
            doubts.append(f"Which way '{sided[0].words}' is to go is not understood.")
    return doubts


def _find_held_side(clauses: list[Clause]) -> list[str]:
    """Says "hold the left side": only the base and the top can be held."""
    doubts = []
    for clause in clauses:
        if clause.verb is None or clause.negated or get_verb(clause.verb).effect is not Effect.HOLD:
            continue
        places = [m for m in clause.select(MentionKind.PLACE) if isinstance(m.value, Place)]
        if places and not any({"up", "down"} & set(m.value.names) for m in places):
            doubts.append(f"'{places[0].words}' cannot be held: only the base and the top can.")
    return doubts


_RULES: tuple[Callable[[list[Mention], int], list[str]], ...] = (
    _find_comparison,
    _find_delay,
    _find_loose_number,
    _find_explanation,
    _find_choice,
    _find_passage,
    _find_scene_passage,
    _find_idle_denial,
    _find_idle_pause,
    _find_nameless_part,
    _find_posture,
    _find_thing,
    _find_particle,
    _find_keeping,
    _find_measured_gravity,
    _find_moved_scene,
    _find_pair,
    _find_omission,
    _find_denial,
)


def _find_telling(mentions: list[Mention], index: int, step: int) -> Mention | None:
    """The next mention that is no article or the like; ``step`` is -1 for the one before."""
    at = index + step
    while 0 <= at < len(mentions):
        if mentions[at].kind is not MentionKind.FUNCTION:
            return mentions[at]
        at += step
    return None


def _has_motion(mentions: list[Mention]) -> bool:
    return any(mention.kind in _MOTIONS for mention in mentions)


def _get_phrase(mentions: list[Mention], index: int) -> str:
    return mentions[index].phrase if 0 <= index < len(mentions) else ""
