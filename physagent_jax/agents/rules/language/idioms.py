"""Expressions whose words mean something else apart: thanks, conditions, prevention, states, what it hits."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.rules.language import modifiers as m
from physagent_jax.agents.rules.language import verbs as v
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.reader import FINITE, OWNING, Reader
from physagent_jax.agents.rules.language.solids import match_solid

_THANKING = frozenset("you very so much a an lot again in advance for your help".split())
_PREVENTING = frozenset({"keep", "keeps", "keeping", "prevent", "prevents", "preventing"})
_SURFACES = frozenset({"ground", "floor", "table"})
_SUBJECTS = OWNING | {"it", "he", "she", "they"}
_THROWN = frozenset({"it", "him", "her"})
_WATCHERS = ("camera", "viewer", "lens")
_COMING = frozenset({"come", "comes", "came", "coming"})
_NEARER = frozenset("toward towards closer nearer forward forwards in up into".split())
_GOALS = frozenset({*m.OBSTACLES, *_WATCHERS, "edge", "border", "us", "me"}) - {"ceiling"}
_WAYS_OF_GOALS = ("left", "right", "back", "front")
_RESTS = frozenset({"still", "motionless", "calm", "quiet", "silence", "stillness", "nothing", "rest"})
_AGAINST = frozenset({"against", "into", "at", "onto", "on", "off"})


def read_solid(reader: Reader, at: int) -> Mention | None:
    """A wall or block; what "hits" it only goes there."""
    found = match_solid(reader.tokens, at, reader.object_words)
    if found is None:
        return None
    solid, behind = found
    if reader.mentions and solid.kind:
        _convert_collision(reader, at)
    used = [index for index in range(at, behind) if index not in reader.used]
    if not solid.kind:  # "between two plates"
        return reader.make_mention(MentionKind.FUNCTION, None, "plates", used)
    return reader.make_mention(MentionKind.SOLID, solid, "solid", used)


def _convert_collision(reader: Reader, at: int) -> None:
    """Makes "hits a wall", "bounces off the wall" the way there: no blow."""
    index = len(reader.mentions) - 1
    while index >= 0 and reader.mentions[index].kind is MentionKind.FUNCTION:
        index -= 1
    verb, between = reader.mentions[index], reader.mentions[index + 1 :]
    if index < 0 or not isinstance(verb.value, v.Verb) or verb.value.gravity:
        return
    strikes = verb.value.effect in (v.Effect.STRIKE, v.Effect.FALL)
    thrown = verb.value.effect is v.Effect.FALL and any(
        e.phrase in _THROWN | reader.object_words for e in between
    )
    if thrown and any(e.form == "off" for e in between):  # "bounce it off the wall"
        reader.mentions[index] = replace(verb, value=v.VERBS["hit"], phrase="hit")
        return
    if not strikes or any(e.phrase in _AGAINST | reader.object_words for e in between):
        return
    if any(e.kind in (MentionKind.VERB, MentionKind.CAUSE) for e in reader.mentions[:index]):
        reader.mentions[index] = replace(verb, kind=MentionKind.FUNCTION, value=None)
    else:
        reader.mentions[index] = replace(verb, value=v.VERBS["move"], phrase="move")


def read_thanks(reader: Reader, at: int) -> Mention | None:
    """Reads "thank you very much", whose "much" is of no motion."""
    if reader.get_text(at) not in ("thank", "thanks"):
        return None
    behind = at + 1
    while reader.get_text(behind) in _THANKING:
        behind += 1
    return reader.make_mention(MentionKind.FUNCTION, None, "thanks", list(range(at, behind)))


def read_once(reader: Reader, at: int) -> Mention | None:
    """Reads "once it has landed": a time, and no count."""
    if reader.get_text(at) != "once" or reader.get_text(at + 1) not in _SUBJECTS | reader.object_words:
        return None
    for token in reader.tokens[at + 1 :]:
        if not token.is_word:
            break
        if token.lemma in v.VERBS or token.text in FINITE:
            return reader.make_mention(MentionKind.JOIN, m.Join.AFTER, "once", [at])
    return None


def read_target(reader: Reader, at: int) -> Mention | None:
    """Reads "smash it on the floor": down, where no other way is told."""
    if reader.tokens[at].text not in _SURFACES or reader.get_preposition(at) not in (
        "on",
        "onto",
        "against",
    ):
        return None
    if not reader.is_striking():
        return None
    told = any(e.kind in (MentionKind.DIRECTION, MentionKind.FROM, MentionKind.JOIN) for e in reader.mentions)
    if told or not any(e.form in reader.object_words | {"it", "him", "her"} for e in reader.mentions):
        return None
    return reader.make_mention(MentionKind.DIRECTION, ("down",), "onto the ground", [at])


def read_so(reader: Reader, at: int) -> Mention | None:
    """Reads "it is hit from the left, so it goes right": what comes of it."""
    subject = reader.get_text(at + 1) in (_SUBJECTS - {"that", "this"}) | reader.object_words
    done = any(isinstance(e.value, v.Verb) for e in reader.mentions)
    if reader.get_text(at) != "so" or not subject or not done:
        return None
    for token in reader.tokens[at + 1 :]:
        if not token.is_word:
            break
        if token.lemma in v.VERBS:
            return reader.make_mention(MentionKind.JOIN, m.Join.RESULT, "so", [at])
    return None


def read_reach(reader: Reader, at: int) -> Mention | None:
    """Reads "up to the wall", "as far as the wall": where it ends, and neither up nor far."""
    words = [reader.get_text(at + i) for i in range(3)]
    size = 2 if words[:2] == ["up", "to"] else 3 if words == ["as", "far", "as"] else 0
    behind = at + size
    while reader.get_text(behind) in OWNING | {*_WAYS_OF_GOALS}:
        behind += 1
    if size and reader.get_text(behind) in _GOALS and reader.get_text(behind) not in reader.object_words:
        size -= reader.get_text(behind) in (*_WATCHERS, "us", "me")  # "to the camera" tells the way
        return reader.make_mention(MentionKind.FUNCTION, None, "up to", list(range(at, at + size)))
    return None


def read_condition(reader: Reader, at: int) -> Mention | None:
    """Reads "does it fall if it is pushed": both happen; a sentence that begins with "what if" tells one thing."""
    if reader.get_text(at) != "if" or reader.get_text(at - 1) == "as":
        return None
    if not any(e.kind is MentionKind.VERB for e in reader.mentions):
        return None
    if not any(token.lemma in v.VERBS for token in reader.tokens[at + 1 :]):
        return None
    return reader.make_mention(MentionKind.JOIN, m.Join.WHILE, "if", [at])


def read_prevention(reader: Reader, at: int) -> Mention | None:
    """Reads "keep it from falling": it does not fall."""
    after = reader.tokens[at + 1] if at + 1 < len(reader.tokens) else None
    prevented = reader.get_text(at) == "from" and any(e.form in _PREVENTING for e in reader.mentions)
    if not prevented or after is None or after.lemma not in v.VERBS or not after.text.endswith("ing"):
        return None
    return reader.make_mention(MentionKind.NOT, None, "from", [at])


def read_state(reader: Reader, at: int) -> Mention | None:
    """An adjective that says what was before: "the fallen robot"; what holds it ("the tied robot") holds it yet."""
    token = reader.tokens[at]
    verb = v.VERBS.get(token.lemma)
    done = token.text != token.lemma and not token.text.endswith(("ing", "s"))
    if verb is None or verb.effect is v.Effect.HOLD or not (done and reader.is_after_determiner(at)):
        return None
    if reader.get_text(at + 1) not in reader.object_words:
        return None
    return reader.make_mention(MentionKind.FUNCTION, None, "state", [at])


def read_floating(reader: Reader, at: int) -> Mention | None:
    """An adjective: "the floating robot" is weightless; elsewhere it is what happens."""
    adjective = reader.tokens[at].text in ("floating", "hovering") and reader.is_after_determiner(at)
    if adjective and reader.get_text(at + 1) in reader.object_words:
        return reader.make_mention(MentionKind.GRAVITY, "none", reader.tokens[at].text, [at])
    return None


def read_nothing(reader: Reader, at: int) -> Mention | None:
    """Reads "for half a second nothing, then ...": stillness."""
    ends = at + 1 == len(reader.tokens) or not reader.tokens[at + 1].is_word
    timed = bool(reader.mentions) and reader.mentions[-1].kind is MentionKind.TIME
    told = timed or reader.get_text(at - 1) == "first" and at == 1
    calms = reader.get_text(at) in _RESTS and reader.get_text(at - 1) in ("then", "finally")
    if not ends or not (calms or told and reader.get_text(at) == "nothing"):
        return None
    return reader.make_mention(MentionKind.VERB, v.VERBS["nothing happens"], "nothing happens", [at])


def read_coming(reader: Reader, at: int) -> Mention | None:
    """Reads "the robot comes towards us": it moves; "a breeze comes" is only there."""
    subject = reader.get_text(at - 1) in reader.object_words | {"it", "he", "she"}
    if not subject or reader.get_text(at) not in _COMING or reader.get_text(at + 1) not in _NEARER:
        return None
    return reader.make_mention(MentionKind.VERB, v.VERBS["move"], "move", [at])


def read_frontal(reader: Reader, at: int) -> Mention | None:
    """Reads "a frontal impact": one that goes away from the viewer."""
    after = reader.tokens[at + 1] if at + 1 < len(reader.tokens) else None
    if (
        reader.get_text(at) != "frontal"
        or after is None
        or not {after.lemma, after.text} & {*v.VERBS, *v.CAUSES}
    ):
        return None
    return reader.make_mention(MentionKind.DIRECTION, ("away",), "frontal", [at])


def read_farther(reader: Reader, at: int) -> Mention | None:
    """The "farther" in "a third of its length farther to the right": the measure and the way say it all."""
    measured = bool(reader.mentions) and reader.mentions[-1].kind is MentionKind.QUANTITY
    if not measured or reader.get_text(at) not in ("farther", "further"):
        return None
    return reader.make_mention(MentionKind.FUNCTION, None, "farther", [at])


def read_apart(reader: Reader, at: int) -> Mention | None:
    """The "apart" in "pull its ends apart": both ways at once."""
    if reader.get_text(at) != "apart" or reader.get_text(at - 1) not in ("ends", "sides"):
        return None
    return reader.make_mention(MentionKind.SIDES, False, "outward", [at])


def read_manner(reader: Reader, at: int) -> Mention | None:
    """The noun in "with great force", "at high speed", ", medium force": its adjective says how it is done."""
    if reader.get_text(at) not in m.MANNERS or not any(e.kind is MentionKind.VERB for e in reader.mentions):
        return None
    before = at - 1
    while reader.get_text(before) in m.INTENSITIES or reader.get_text(before) in (*m.DEGREES, "any"):
        before -= 1
    if reader.get_text(before) not in ("with", "at", ","):
        return None
    return reader.make_mention(MentionKind.FUNCTION, None, "manner", [at])
