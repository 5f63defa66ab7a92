"""Surroundings that are not in the scene: tables, cameras, moving floors, goals."""

from __future__ import annotations

from collections.abc import Callable

from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import SCENE_NOUNS
from physagent_jax.agents.rules.language.naming import DETERMINERS
from physagent_jax.agents.rules.language.neighbours import MOTIONS, WAYS, get_phrase
from physagent_jax.agents.rules.language.quantities import Quantity
from physagent_jax.agents.rules.language.verbs import Effect, Verb

# Before a part or a solid: where it goes along, not what is acted on or run into.
_PAST = frozenset(
    "around about over under above below along across through behind beside past near between beyond".split()
)
_GOALS = frozenset({"to", "toward", "towards", "into", "onto", "from"})
_SCALES = (Effect.SCALE, Effect.SWELL)
_SCENE = frozenset({"ground", "floor", "table", "ceiling", "wall", "walls", "sky"})
_GOALS_HERE = frozenset({"table", "hand", "hands", "person", "people", "ball", "plate", "rope"})
_SUPPORTS = frozenset({"plate", "plates"})
_SURFACES = frozenset({"ground", "floor", "table", "sky"})
_TAKING = frozenset({"take", "takes", "taking", "pull", "pulls", "pulling"})
_ADJECTIVES = (MentionKind.UNKNOWN, MentionKind.INTENSITY)
_ACROSS = frozenset({"over", "across", "along", "about", "around"})
_MEASURES = (MentionKind.QUANTITY, MentionKind.COMPARATIVE, MentionKind.INTENSITY, MentionKind.DEGREE)


def find_surroundings(mentions: list[Mention]) -> list[str]:
    """Plain sentences about things and places that the scene does not have."""
    return [doubt for index in range(len(mentions)) for rule in _RULES for doubt in rule(mentions, index)]


def _find_passage(mentions: list[Mention], index: int) -> list[str]:
    """Says "over the wall", "around its neck"."""
    mention = mentions[index]
    if mention.kind not in (MentionKind.PLACE, MentionKind.SOLID):
        return []
    before = index - 1
    while before >= 0 and mentions[before].phrase in DETERMINERS:
        before -= 1
    preposition = get_phrase(mentions, before)
    along = mention.kind is MentionKind.SOLID and mentions[before].phrase in ("down", "up")
    heads = [m for m in mentions[:index] if m.kind in MOTIONS]
    applied = (
        bool(heads) and heads[-1].kind is MentionKind.CAUSE and preposition == "to"
    )  # "an impulse to the top"
    along = along or mention.kind is MentionKind.PLACE and preposition in _GOALS and not applied
    if preposition in _PAST or along:
        return [f"What '{preposition} {mention.words}' means is not understood."]
    return []


def _find_scene_passage(mentions: list[Mention], index: int) -> list[str]:
    """Says "under the table", "around the table"; "across the floor" is where it moves anyway."""
    mention, before = mentions[index], index - 1
    while before >= 0 and mentions[before].phrase in DETERMINERS:
        before -= 1
    preposition = get_phrase(mentions, before)
    where = mention.kind is MentionKind.FUNCTION and mention.form in _SCENE
    if where and preposition in _PAST and not (preposition in _ACROSS and mention.form in _SURFACES):
        return [f"Where '{preposition} the {mention.words}' is, is not understood."]
    return []


def _find_front(mentions: list[Mention], index: int) -> list[str]:
    """Says "move it in front of us": a place, where no way is told."""
    told = any(m.kind in (*WAYS, MentionKind.SOLID) for m in mentions)
    if (
        mentions[index].phrase != "in front of"
        or told
        or not any(m.kind in MOTIONS for m in mentions[:index])
    ):
        return []
    return ["Where 'in front of' is, is not understood."]


def _find_unknown_goal(mentions: list[Mention], index: int) -> list[str]:
    """Says "towards the hand", "into a ball", "in the direction of the hill": a way that no direction tells."""
    mention, after = mentions[index], mentions[index + 1 : index + 4]
    noun = next((m.form for m in after if m.phrase not in DETERMINERS), "")
    goal = mention.form in ("toward", "towards", "into") or mention.form == "to" and noun in _GOALS_HERE
    goal = goal or mention.form == "direction" and get_phrase(mentions, index + 1) == "of"
    if mention.kind is not MentionKind.FUNCTION or not goal:
        return []
    if any(m.kind in (*WAYS, MentionKind.SOLID, MentionKind.PLACE, MentionKind.UNKNOWN) for m in after):
        return []
    told = next((m for m in reversed(mentions[:index]) if isinstance(m.value, Verb)), None)
    if (
        told is not None
        and isinstance(told.value, Verb)
        and told.value.effect in (Effect.STRIKE, Effect.HOLD)
    ):
        return []  # "bumps into it", "glued to the table"
    return [f"Where '{' '.join(m.words for m in (mention, *after[:2]))}' is, is not understood."]


def _find_retreat(mentions: list[Mention], index: int) -> list[str]:
    """Says "away from the wall": the way is the wall's other side."""
    behind = mentions[index + 1 : index + 4]
    leaves = mentions[index].phrase == "away" and any(m.form == "from" for m in behind)
    solid = next((m for m in behind if m.kind is MentionKind.SOLID or m.form in SCENE_NOUNS), None)
    return [f"Where 'away from {solid.words}' is, is not understood."] if leaves and solid is not None else []


def _find_camera(mentions: list[Mention], index: int) -> list[str]:
    """Says "the camera moves left": no sentence moves it, and the object is not meant."""
    mention = mentions[index]
    begins = index == 0 or mentions[index - 1].kind is MentionKind.JOIN
    pans = begins and mention.form in ("pan", "pans", "panning", "zoom", "zooms")
    if pans or mention.kind is MentionKind.FUNCTION and mention.form in ("camera", "cameras"):
        return ["What the camera does is not told by a sentence."]
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
        *MOTIONS,
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


def _find_acted_scene(mentions: list[Mention], index: int) -> list[str]:
    """Says "tilt the plate", "push the wall": what is around the object; shaken, it shakes the object."""
    mention = mentions[index]
    solid = mention.kind is MentionKind.SOLID
    article = index - 1
    while article > 0 and (mentions[article].kind in _ADJECTIVES or mentions[article].form == "invisible"):
        article -= 1
    placed = article >= 1 and get_phrase(mentions, article) in DETERMINERS
    verb = mentions[article - 1].value if placed and mentions[article - 1].kind is MentionKind.VERB else None
    scene = mention.kind is MentionKind.FUNCTION and mention.form in _SCENE | _SUPPORTS
    taken = [m.form for m in mentions[max(article - 2, 0) : article]]
    if scene and placed and taken[-1:] == ["away"] and _TAKING & set(taken):
        return [f"What comes of it that '{mention.words}' is taken away is not understood."]
    acted = (
        isinstance(verb, Verb)
        and verb.effect not in (Effect.SWAY, Effect.HOLD)
        and not (solid and verb.generic)
    )
    return [f"'{mention.words}' does not move here."] if acted and (solid or scene) else []


def _find_placed_thing(mentions: list[Mention], index: int) -> list[str]:
    """Says "there is a table", "it bounces between two walls": things that are not here."""
    mention = mentions[index]
    there = [m.form for m in mentions[max(index - 3, 0) : index]]
    if mention.kind is MentionKind.FUNCTION and mention.form in SCENE_NOUNS and there[:2] == ["there", "is"]:
        return [f"There is no {mention.words} here."]
    if mention.phrase != "plates":
        return []
    presses = any(isinstance(m.value, Verb) and m.value.effect in _SCALES for m in mentions)
    return [] if presses else [f"Where '{mention.words}' is, is not understood."]


def _find_whereabouts(mentions: list[Mention], index: int) -> list[str]:
    """Says "the robot on the left", "push it on the left": where, and not where to."""
    mention = mentions[index]
    if mention.kind is MentionKind.PLACE and mention.words.lower() in ("left side", "right side"):
        owned = index > 0 and mentions[index - 1].words.endswith(("'s", "\u2019s"))
        if get_phrase(mentions, index - 1) not in DETERMINERS and not owned:
            return [f"Whether '{mention.words}' is where or where to is not understood."]
    if mention.kind is not MentionKind.DIRECTION or mention.phrase not in ("left", "right"):
        return []
    if get_phrase(mentions, index - 1) in DETERMINERS and get_phrase(mentions, index - 2) in ("on", "at"):
        return [f"What is 'on the {mention.words}' is not understood."]
    return []


def _find_thing(mentions: list[Mention], index: int) -> list[str]:
    """Says "on a swing": a thing, although the word is a verb elsewhere."""
    mention = mentions[index]
    placed = get_phrase(mentions, index - 1) in DETERMINERS and get_phrase(mentions, index - 2) in (
        "on",
        "under",
    )
    if mention.kind is MentionKind.VERB and placed:
        return [f"There is no {mention.words} here."]
    return []


def _find_moved_scene(mentions: list[Mention], index: int) -> list[str]:
    """Says "the floor tilts", "a wall moves towards it"; a floor that shakes shakes what stands on it."""
    mention = mentions[index]
    if mention.form not in _SCENE | _SUPPORTS or get_phrase(mentions, index - 1) not in DETERMINERS:
        return []
    if mention.form in _SUPPORTS and any(m.phrase in ("it", "him", "her") for m in mentions[index:]):
        return []
    begins = index < 2 or mentions[index - 2].kind is MentionKind.JOIN
    behind = index + 1
    while behind < len(mentions) and mentions[behind].phrase in ("is", "are", "was", "comes", "starts", "to"):
        behind += 1
    does = mentions[behind].value if begins and behind < len(mentions) else None
    if isinstance(does, Verb) and does.effect not in (Effect.SWAY, Effect.STILL):
        return [f"'{mention.words}' does not move here."]
    return []


def _find_measured_gravity(mentions: list[Mention], index: int) -> list[str]:
    """Says "gravity is halved", "low gravity"."""
    mention = mentions[index]
    around = mentions[max(index - 1, 0) : index + 4]
    if mention.phrase != "gravity" or not any(m.kind in _MEASURES for m in around):
        return []
    return ["How strong gravity is cannot be told here, only whether it acts and which way."]


_RULES: tuple[Callable[[list[Mention], int], list[str]], ...] = (
    _find_passage,
    _find_scene_passage,
    _find_front,
    _find_unknown_goal,
    _find_retreat,
    _find_camera,
    _find_state,
    _find_acted_scene,
    _find_placed_thing,
    _find_whereabouts,
    _find_thing,
    _find_moved_scene,
    _find_measured_gravity,
)
