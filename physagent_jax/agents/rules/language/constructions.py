"""Constructions that the grammar has no reading for, although it knows each of their words.

Taken word by word they would say something else: "over the wall", "around its neck", "faster and faster", "left or
right", "everything but rotate". A rule here holds for a construction, whatever the words in it.
"""

from __future__ import annotations

from collections.abc import Callable

from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import (
    FUNCTION_WORDS,
    NUMBERS,
    PAUSES,
    SCENE_NOUNS,
    UNITS,
    WHOLE_WORDS,
    Join,
    Place,
)
from physagent_jax.agents.rules.language.naming import DETERMINERS
from physagent_jax.agents.rules.language.quantities import Quantity
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
_SCALES = (Effect.SCALE, Effect.SWELL)
_BECOMING = frozenset({"get", "gets", "getting", "become", "becomes", "becoming", "got", "became"})
_KEEPING = frozenset({"keep", "keeps", "keeping", "kept"})
_SCENE = frozenset({"ground", "floor", "table", "ceiling", "wall", "walls", "sky"})
_GOALS_HERE = frozenset({"table", "hand", "hands", "person", "people", "ball", "plate", "rope"})
_SUPPORTS = frozenset({"plate", "plates"})
_SURFACES = frozenset({"ground", "floor", "table", "sky"})
_ACROSS = frozenset({"over", "across", "along", "about", "around", "through"})
_MEASURES = (MentionKind.QUANTITY, MentionKind.COMPARATIVE, MentionKind.INTENSITY, MentionKind.DEGREE)
_PARTICLES = frozenset({"in", "out", "around", "about", "through", "across", "along"})


def find_constructions(mentions: list[Mention]) -> list[str]:
    """Plain sentences about constructions that were not understood."""
    return [doubt for index in range(len(mentions)) for rule in _RULES for doubt in rule(mentions, index)]


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


def _find_unknown_goal(mentions: list[Mention], index: int) -> list[str]:
    """Says "towards the hand", "into a ball", "in the direction of the hill": a way that no direction tells."""
    mention, after = mentions[index], mentions[index + 1 : index + 4]
    noun = next((m.form for m in after if m.phrase not in DETERMINERS), "")
    goal = mention.form in ("toward", "towards", "into") or mention.form == "to" and noun in _GOALS_HERE
    goal = goal or mention.form == "direction" and _get_phrase(mentions, index + 1) == "of"
    if mention.kind is not MentionKind.FUNCTION or not goal:
        return []
    if any(m.kind in (*_WAYS, MentionKind.SOLID, MentionKind.PLACE, MentionKind.UNKNOWN) for m in after):
        return []
    told = next((m for m in reversed(mentions[:index]) if isinstance(m.value, Verb)), None)
    if told is not None and isinstance(told.value, Verb) and told.value.effect is Effect.STRIKE:
        return []  # "bumps into it"
    return [f"Where '{' '.join(m.words for m in (mention, *after[:2]))}' is, is not understood."]


def _find_means(mentions: list[Mention], index: int) -> list[str]:
    """Says "stretch it by pulling its head": one thing, told twice."""
    mention, before = mentions[index], _get_phrase(mentions, index - 1)
    means = mention.kind is MentionKind.VERB and mention.form.endswith("ing") and before == "by"
    if means and _has_motion(mentions[: index - 1]):
        return [f"How 'by {mention.words}' does it is not understood."]
    return []


def _find_camera(mentions: list[Mention], index: int) -> list[str]:
    """Says "the camera moves left": no sentence moves it, and the object is not meant."""
    mention = mentions[index]
    if mention.kind is MentionKind.FUNCTION and mention.form in ("camera", "cameras"):
        return ["What the camera does is not told by a sentence."]
    return []


def _find_growth(mentions: list[Mention], index: int) -> list[str]:
    """Says "jump higher", "throw it twice, the second time longer": more of it, and no growth."""
    mention = mentions[index]
    grows = isinstance(mention.value, Verb) and mention.value.generic and mention.value.effect in _SCALES
    if not grows or not mention.form.endswith("er"):
        return []
    for other in reversed(mentions[:index]):
        if other.form in _BECOMING | {"make", "makes", "made", "making", "is", "be"}:
            return []
        if isinstance(other.value, Verb):
            same = other.value.effect in (*_SCALES, Effect.STILL)
            return [] if same else [f"What is '{mention.words}' is not understood."]
    return []


def _find_state(mentions: list[Mention], index: int) -> list[str]:
    """Says "the fallen robot", "the robot is on the left": how it is at first."""
    mention = mentions[index]
    if mention.phrase == "state":
        return [f"That it is '{mention.words}' at first is not understood."]
    if mention.form not in ("is", "are", "was", "were") or mention.kind is not MentionKind.FUNCTION:
        return []
    first = index
    while first > 0 and mentions[first - 1].kind is not MentionKind.JOIN:
        first -= 1
    end = index + 1
    while end < len(mentions) and mentions[end].kind is not MentionKind.JOIN:
        end += 1
    kinds = {m.kind for m in mentions[first:end]}
    says = kinds & {
        *_MOTIONS,
        MentionKind.GRAVITY,
        MentionKind.ANCHOR,
        MentionKind.COMPARATIVE,
        MentionKind.NOT,
    }
    told = [m for m in mentions[index + 1 : end] if m.kind in (MentionKind.DIRECTION, MentionKind.QUANTITY)]
    placed = [m for m in told if not isinstance(m.value, Quantity) or m.value.unit == "metres"]
    if placed and not says:
        return [f"That it is '{placed[0].words}' at first is not understood."]
    return []


def _find_idle_denial(mentions: list[Mention], index: int) -> list[str]:
    """Says "but it can not", "or not": nothing follows that would not happen."""
    ends = index + 1 == len(mentions) or mentions[index + 1].kind is MentionKind.JOIN
    if mentions[index].kind is MentionKind.NOT and ends and _has_motion(mentions[:index]):
        return [f"What '{mentions[index].words}' denies is not understood."]
    return []


def _find_counted_pause(mentions: list[Mention], index: int) -> list[str]:
    """Says "three times with pauses of a second": how long the pauses are, and not what comes after all."""
    mention = mentions[index]
    rests = (
        isinstance(mention.value, Verb) and mention.value.effect is Effect.STILL and not mention.value.generic
    )
    counted = any(m.kind is MentionKind.REPEAT for m in mentions[:index])
    if (
        rests
        and counted
        and mention.form.endswith(("ing", "s"))
        and mentions[index - 1].kind is not MentionKind.NOT
    ):
        if mention.form.endswith("ing") or any(m.form == "with" for m in mentions[max(index - 4, 0) : index]):
            return [f"When '{mention.words}' is, is not understood."]
    return []


def _find_acted_scene(mentions: list[Mention], index: int) -> list[str]:
    """Says "tilt the plate", "push the wall": what is around the object; shaken, it shakes the object."""
    mention = mentions[index]
    solid = mention.kind is MentionKind.SOLID
    placed = index >= 2 and _get_phrase(mentions, index - 1) in DETERMINERS
    verb = mentions[index - 2].value if placed and mentions[index - 2].kind is MentionKind.VERB else None
    scene = mention.kind is MentionKind.FUNCTION and mention.form in _SCENE | _SUPPORTS
    acted = isinstance(verb, Verb) and verb.effect is not Effect.SWAY and not (solid and verb.generic)
    return [f"'{mention.words}' does not move here."] if acted and (solid or scene) else []


def _find_placed_thing(mentions: list[Mention], index: int) -> list[str]:
    """Says "there is a table", "it bounces between two walls": things that are not here."""
    mention = mentions[index]
    there = [m.form for m in mentions[max(index - 3, 0) : index]]
    if mention.kind is MentionKind.FUNCTION and mention.form in SCENE_NOUNS and there[:2] == ["there", "is"]:
        return [f"There is no {mention.words} here."]
    presses = any(isinstance(m.value, Verb) and m.value.effect in _SCALES for m in mentions)
    if mention.phrase == "plates" and not presses:
        return [f"Where '{mention.words}' is, is not understood."]
    return []


def _find_whereabouts(mentions: list[Mention], index: int) -> list[str]:
    """Says "the robot on the left", "push it on the left": where, and not where to."""
    mention = mentions[index]
    if mention.kind is not MentionKind.DIRECTION or mention.phrase not in ("left", "right"):
        return []
    if _get_phrase(mentions, index - 1) in DETERMINERS and _get_phrase(mentions, index - 2) in ("on", "at"):
        return [f"What is 'on the {mention.words}' is not understood."]
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


def _find_facing(mentions: list[Mention], index: int) -> list[str]:
    """Says "turn its back to us": all of it turns, so that its back is there."""
    mention = mentions[index]
    before = next((m for m in reversed(mentions[:index]) if m.phrase not in DETERMINERS), None)
    turns = before is not None and isinstance(before.value, Verb) and before.value.effect is Effect.TURN
    if turns and mention.kind is MentionKind.PLACE and mention.phrase in ("back", "front"):
        return [f"Where its {mention.words} is to be is not understood."]
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
    acts = any(m.phrase in ("it", "him", "her") for m in mentions[index:])
    scene = mention.form in _SCENE or mention.form in _SUPPORTS and not acts
    if not scene or _get_phrase(mentions, index - 1) not in DETERMINERS:
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


_RULES: tuple[Callable[[list[Mention], int], list[str]], ...] = (
    _find_comparison,
    _find_delay,
    _find_loose_number,
    _find_explanation,
    _find_choice,
    _find_passage,
    _find_scene_passage,
    _find_idle_denial,
    _find_unknown_goal,
    _find_means,
    _find_camera,
    _find_growth,
    _find_state,
    _find_placed_thing,
    _find_whereabouts,
    _find_idle_pause,
    _find_counted_pause,
    _find_acted_scene,
    _find_nameless_part,
    _find_posture,
    _find_facing,
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
