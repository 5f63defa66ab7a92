"""The words of a clause with their meanings in the lexicon.

An intent may come from a grammar, which takes its words from the lexicon, or from a language model, which takes them
from anywhere: articles are ignored, inflected verbs are known, and a word that is not known is a doubt.
"""

from __future__ import annotations

import difflib
import re
from dataclasses import replace

from physagent_jax.agents import intent
from physagent_jax.agents.compiler.events import Event, KnownPart, KnownWay, WayKind
from physagent_jax.agents.lexicon import NAMED, Motion, Names, Place, read_forms, read_lexicon
from physagent_jax.agents.lexicon.types import OPPOSITES
from physagent_jax.forces.part import split_name

_ARTICLE = re.compile(r"^(the )?(an? )?(its )?")
_AROUND = re.compile(r"^((to|from|towards?) )?((the|an?|its) )?|( side)?( direction)?$")
_BASE = frozenset(name for pair in OPPOSITES for name in pair)
_REVERSALS = {"same": "same", "other": "other", "opposite": "other"}  # single words, as models write them
_SIDES = {"apart": "both", "together": "both"}
_NEAREST = 3
_ALIKE = 0.6  # similarity of spelling, 0 .. 1
_ENDS_AT = 2 / 3  # of the extent: where "the top" or "its left" begins
_NOT_LESS, _NOT_MORE = 0.8, 1.2  # factors of "not hard" and "not gently"


def look_up(clause: intent.Clause, named: frozenset[tuple[str, ...]] = frozenset()) -> Event:
    """The meanings of a clause's words; ``named`` are phrases for parts that have names of their own."""
    senses = {1: "counterclockwise", -1: "clockwise"}
    found = Event(clause, clause.timing, clause.stays)
    _look_up_motion(found)
    for way in clause.ways:
        known, sense = find_way(way), read_lexicon().senses.get(normalise(way.word))
        if sense is not None and clause.turning in (None, senses[sense]):
            found.clause = clause.model_copy(update={"turning": senses[sense]})
        elif known is not None:
            found.ways.append(known)
        elif way.relation is intent.Relation.TO and (place := _find_part(way.word, named)):
            text = way.text or way.word
            found.ways.append(KnownWay(WayKind.TO, place.names, normalise(way.word), text, place))
        else:
            found.doubts.append(f"The way '{way.word}' is not understood.")
    for part in clause.parts:
        place = _find_part(part.word, named)
        if place is None:
            found.doubts.append(f"The part '{part.word}' is not understood.")
        else:
            known_part = KnownPart(place, normalise(part.word), part.text or part.word)
            (found.excluded if part.excluded else found.parts).append(known_part)
    for words in clause.strength:
        told = [words] if find_strength(words) else words.split()  # "very hard"
        known_words = [each for each in map(find_strength, told) if each is not None]
        found.strengths += known_words
        if len(known_words) < len(told):
            found.doubts.append(f"The strength '{words}' is not understood.")
    return found


def _find_part(word: str, named: frozenset[tuple[str, ...]]) -> Place | None:
    """The place of a part, which may have a name of its own."""
    return find_place(word) or (NAMED if split_name(normalise(word)) in named else None)


def _look_up_motion(found: Event) -> None:
    """Fills verb and cause; either word may name the other."""
    lexicon, clause = read_lexicon(), found.clause
    found.phrase = _find_phrase(clause.motion, lexicon.motions)
    found.verb = lexicon.motions.get(found.phrase)
    if found.verb is None and clause.motion:
        found.cause_phrase = _find_phrase(clause.motion, lexicon.causes)
        if not found.cause_phrase:
            found.doubts.append(f"The motion '{clause.motion}' is not understood.")
    if clause.cause and clause.cause != "gravity":
        noun = _find_phrase(clause.cause, lexicon.causes) or _find_phrase(clause.cause, lexicon.motions)
        found.cause_phrase = noun or found.cause_phrase
        if not (noun or found.verb or found.cause_phrase):
            found.doubts.append(f"The cause '{clause.cause}' is not understood.")
    found.cause = lexicon.causes.get(found.cause_phrase) or lexicon.motions.get(found.cause_phrase)
    if found.verb and clause.manner:
        found.verb = replace(found.verb, manner=clause.manner)
    found.motion = found.verb or found.cause or found.motion


def _find_phrase(word: str, table: dict[str, Motion]) -> str:
    """The phrase of ``table`` for a verb or noun in whatever form; empty if there is none."""
    text = normalise(word)
    head, _, rest = text.partition(" ")
    lemma = f"{read_forms().get(head, head)} {rest}".strip()
    forms = (text, lemma, lemma.removesuffix(" it"), lemma.replace(" it ", " ~ "), text.removesuffix("s"))
    return next((phrase for phrase in forms if phrase in table), "")


def normalise(word: str) -> str:
    """A word in lower case, with single spaces for hyphens and without articles."""
    return _ARTICLE.sub("", " ".join(word.lower().replace("-", " ").replace("_", " ").split()))


def find_way(way: intent.Way) -> KnownWay | None:
    """The way that a direction word with its relation is; None if the word is not known."""
    text = normalise(way.word)
    for said in (" ".join(way.word.lower().split()), text, _AROUND.sub("", text)):
        kind, names = _classify_way(said, way.relation)
        if names:
            return KnownWay(kind, names, text, way.text or way.word)
    return None


def _classify_way(said: str, relation: intent.Relation) -> tuple[WayKind, Names]:
    """Kind and names of a direction word; no names if it is not known."""
    lexicon = read_lexicon()
    if name := lexicon.reversals.get(said) or _REVERSALS.get(said):
        return WayKind.AGAIN, (name,)
    if name := lexicon.sides.get(said) or _SIDES.get(said):
        return WayKind.SIDES, (name,)
    line = lexicon.axes.get(said) or ((said,) if said in ("x", "y", "z", "long") else ())
    plane = lexicon.planes.get(said) or lexicon.planes.get(said + "ly") or ()
    named = _find_directions(said)
    match relation:
        case intent.Relation.IN if plane or line or named:
            return WayKind.PLANE, plane or line or named
        case intent.Relation.ALONG | intent.Relation.ABOUT if line or named or plane:
            return WayKind.LINE, line or named or plane
    if named:
        return WayKind.FROM if relation is intent.Relation.FROM else WayKind.TO, named
    return (WayKind.LINE, line) if line else (WayKind.PLANE, plane)


def _find_directions(text: str) -> Names:
    """Names of a phrase of directions, or of several bare ones: "up left"; empty if there are none."""
    lexicon = read_lexicon()
    if found := lexicon.directions.get(text) or lexicon.ends.get(text) or lexicon.part_adjectives.get(text):
        return found
    words = text.replace(" and ", " ").split()
    found = [(word,) if word in _BASE else lexicon.directions.get(word, ()) for word in words]
    names = tuple(name for each in found for name in each)
    cancelling = any(one in names and other in names for one, other in OPPOSITES)
    return names if all(found) and not cancelling else ()


def find_place(word: str) -> Place | None:
    """The place of a part: a noun, a side with a noun ("upper half"), or a side alone ("left")."""
    lexicon, text = read_lexicon(), normalise(word)
    forms = (" ".join(word.lower().split()), text, text.removesuffix("s"))  # "a corner of" has its article
    if place := next(filter(None, map(lexicon.parts.get, forms)), None):
        return place
    side, _, noun = text.rpartition(" ")
    start = lexicon.part_nouns.get(noun) or lexicon.part_nouns.get(noun.removesuffix("s"))
    if start is not None and (names := _find_directions(side)):
        return Place(names, start)
    names = _find_directions(text)
    return Place(names, _ENDS_AT) if names else None


def find_strength(word: str) -> tuple[str, float] | None:
    """("degree", "absolute" or "relative", factor) of a word for strength."""
    lexicon, text = read_lexicon(), " ".join(word.lower().split())
    if text.startswith("not "):
        told = find_strength(text.removeprefix("not "))
        return told and ("absolute", _NOT_LESS if told[1] > 1 else _NOT_MORE)
    tables = (lexicon.degrees, lexicon.intensities, lexicon.comparatives)
    kinds = zip(("degree", "absolute", "relative"), tables)
    forms = (text, normalise(text))
    return next(((kind, table[said]) for kind, table in kinds for said in forms if said in table), None)


def suggest_motions(word: str) -> list[str]:
    """The known motions that are spelled most like a word; none for an empty one."""
    lexicon, text = read_lexicon(), normalise(word)
    known = [phrase for phrase in (*lexicon.motions, *lexicon.causes) if "~" not in phrase]
    return difflib.get_close_matches(read_forms().get(text, text), known, _NEAREST, _ALIKE) if text else []
