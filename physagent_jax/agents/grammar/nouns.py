"""Nouns: the object's names, its parts with their places ("the left arm", "its top"), and walls and blocks."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise

from physagent_jax.agents.compiler.events import KnownPart
from physagent_jax.agents.compiler.limbs import find_limbs
from physagent_jax.agents.grammar.chunks import PHRASES, begins_longer_phrase, is_standing
from physagent_jax.agents.grammar.mentions import MOTIONS, Mention, MentionKind, Reader
from physagent_jax.agents.grammar.tables import LEXICON, get_set, read_sections
from physagent_jax.agents.grammar.tokens import FORMS, tokenise
from physagent_jax.agents.intent import Solid
from physagent_jax.agents.lexicon import NAMED, Effect, Names, Place
from physagent_jax.forces.part import Part
from physagent_jax.motion.parts import list_names
from physagent_jax.motion.schema import SceneBrief

_HEADS = frozenset(("head", "heads"))
_LEAST = 4  # letters of half a name that stands for all of it
_REACH = 12  # words before "the right one" in which the part is named


def collect_names(sentence: str, brief: SceneBrief) -> frozenset[str]:
    """The words of ``sentence`` that name the object: its name and kind, or a noun for its kind, singular and plural.

    A noun that the lexicon has another meaning for is none, nor is one beside the object's own name, unless both are
    one name ("the teddy bear", "the loaf of bread"): then it is a part, or another thing.
    """
    parts = {word for phrase in list_names(brief) for word in phrase[-1:]}
    name = [word for word in _split(brief.object_name) if word not in parts]  # "pot with lid": pot, lid
    name = name if is_telling(" ".join(name)) else _split(brief.object_name)
    own = set(_add_plurals([*name, *_split(brief.object_kind)]))
    others = LEXICON.agents if is_telling(brief.object_name) else frozenset()  # an anvil falls on a robot
    nouns = _find_unmistakable(brief.object_nouns) - parts - others
    tokens = tokenise(sentence)
    texts = [token.text for token in tokens]
    own |= _find_halves(name, texts) | (_HEADS if _is_a_head(brief.parts) else frozenset())
    if f" {' '.join(_split(brief.object_name))} " in f" {' '.join(texts)} ":
        own.update(_split(brief.object_name))  # "the robot arm", whose parts are arms too
    places = [at for at, text in enumerate(texts) if text in own]
    if not places:
        found = nouns.intersection(texts)
        found = found - get_set("persons") or found or _find_wholes(texts, brief)  # "a man pushes the statue"
        return frozenset(own | found)
    beside = set()
    for at in places:
        before, behind = texts[max(at - 2, 0) : at], texts[at + 1 : at + 3]
        beside |= {*before[-1 - (before[-1:] == ["of"]) :]}
        beside |= {*behind[tokens[at].possessive : 1 + (behind[:1] == ["of"])]}
    return frozenset(own | (beside & nouns))


def _find_wholes(texts: list[str], brief: SceneBrief) -> set[str]:
    """Nouns for a part that the object lacks, and that are all of others: "the dish tips"; no leaf, no head."""
    known = {word: place for word in brief.object_nouns if (place := LEXICON.parts.get(word))}
    return {
        noun
        for article, noun, behind in zip(texts, texts[1:], [*texts[2:], ""])
        if article == "the" and noun in known and "up" not in known[noun].names and behind != "on"
        if not (known[noun].names and FORMS.get(behind) in ("stay", "remain", "keep"))  # the pot of a plant
        if not find_limbs(KnownPart(known[noun], noun, noun), brief)
    }


def _is_a_head(parts: Sequence[Part]) -> bool:
    """Return whether an object is a head and no more: it has ears and horns, and no head, limbs or named part."""
    roles = {each.roles[0] if each.roles and not each.name else "" for each in parts}
    return roles == {"ear", "horn"}


def is_telling(name: str) -> bool:
    """Return whether a name says what the object is; a noun that is not its own is then hardly the object."""
    return any(len(word) > 2 and word not in get_set("names_of_files") for word in _split(name))


def _split(name: str) -> list[str]:
    """The words of a name, "ExplodingBarrel" of two."""
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
    return re.findall(r"[^\W\d_]+", apart.lower())


def _find_halves(name: Iterable[str], texts: list[str]) -> set[str]:
    """The words of a sentence that a name runs together ("goat head" of "goathead"), and longer ones ("sailboat")."""
    found = set()
    for word in name:
        found |= {half for pair in pairwise(texts) if "".join(pair) == word for half in pair}
        ends = {text for text in texts if word.startswith(text) or word.endswith(text)}
        found |= {t for t in ends if _LEAST <= len(t) <= len(word) - 3 and not _has_other_meaning(t)}
        found |= {text for text in texts if _LEAST <= len(word) <= len(text) - 3 and text.endswith(word)}
    return found


def _add_plurals(words) -> list[str]:
    return [form for word in words for form in (word, word + "s", word + "es")]


@functools.lru_cache(maxsize=64)
def _find_unmistakable(nouns: tuple[str, ...]) -> frozenset[str]:
    """Nouns of a kind, singular and plural, that mean nothing else."""
    return frozenset(word for word in _add_plurals(nouns) if not _has_other_meaning(word))


def _has_other_meaning(word: str) -> bool:
    return word in LEXICON.words or word in LEXICON.parts or word in FORMS


def read_named_part(reader: Reader, at: int) -> Mention | None:
    """Reads a part that has a name of its own; words that are verbs too need an article."""
    pieces, start = get_set("servings"), at  # "the lemon slice", "a slice of lemon"
    if reader.get_text(at) in pieces and reader.get_text(at + 1) == "of":
        at += 2 + (reader.get_text(at + 2) in get_set("determiners"))
    for size in range(max(map(len, reader.parts), default=0), 0, -1):
        phrase = tuple(token.text for token in reader.tokens[at : at + size])
        if len(phrase) < size or phrase not in reader.parts or begins_longer_phrase(reader, at + size - 1):
            continue  # "rock the chair back and forth"
        known = phrase[0] in reader.names | LEXICON.part_adjectives.keys() | LEXICON.parts.keys()
        if size > 1 or not known and (phrase[0] not in FORMS or reader.is_after_determiner(at)):
            used = list(range(start, at + size + (reader.get_text(at + size) in pieces)))
            whole = phrase == ("body",) and reader.get_text(at - 1) in ("whole", "entire")  # of a truck
            kind, value = (MentionKind.FUNCTION, None) if whole else (MentionKind.PLACE, NAMED)
            return reader.make_mention(kind, value, " ".join(phrase), used)
    owned = reader.is_after_determiner(at) or reader.get_text(at - 1) == "all"
    names = [phrase[0] for phrase in reader.parts if owned and len(phrase) == 1]
    found = [each for each in {*names} - reader.names if _begins_compound(reader.get_text(at), each)]
    return reader.make_mention(MentionKind.PLACE, NAMED, min(found, key=len), [at]) if found else None


def _begins_compound(word: str, name: str) -> bool:
    """Return whether a word is the first of those that a part's name runs together: "the keys" are its keycaps."""
    stem, tail = word.removesuffix("s"), name.removesuffix("s")
    strange = not any(_has_other_meaning(each) for each in (word, stem)) and len(stem) > 2
    rest = tail.removeprefix(stem)
    alike = (stem != word) == (tail != name) and stem != tail != rest
    return strange and alike and (rest in LEXICON.parts or rest in LEXICON.part_nouns)


def read_part(reader: Reader, at: int) -> Mention | None:
    """Reads parts, and directions that share words with them: "the left arm", "the top", "from the front"."""
    for size in (2, 1):
        phrase = " ".join(token.text for token in reader.tokens[at : at + size])
        names = LEXICON.part_adjectives.get(phrase)
        if names is not None and (mention := _read_side(reader, at, size, phrase, names)):
            noun = LEXICON.parts.get(mention.phrase.split()[-1])
            aside = noun is not None and is_standing(reader, at, noun) and mention.kind is MentionKind.PLACE
            return replace(mention, kind=MentionKind.FUNCTION, value=None) if aside else mention
    return None


def _read_side(reader: Reader, at: int, size: int, phrase: str, names: Names) -> Mention | None:
    """Reads a side with the noun behind it, or alone where it is an end as well."""
    noun = reader.get_text(at + size)
    for end in (at + size + 3, at + size + 2):  # "the left ear cup" is no ear
        name = tuple(token.text for token in reader.tokens[at + size : end])
        if name in reader.parts and end <= len(reader.tokens):
            place = Place(names, LEXICON.part_nouns.get(name[-1], 2 / 3))
            return reader.make_mention(MentionKind.PLACE, place, " ".join((phrase, *name)), [*range(at, end)])
    # "From the left tips it over".
    plural = noun not in ("sides", "faces", *LEXICON.part_nouns) and FORMS.get(noun) is None
    part = noun.removesuffix("s") if plural else noun
    used = list(range(at, at + size + 1))
    towards = reader.get_preposition(at) in get_set("before_ways")
    parted = any(mention.kind is MentionKind.PLACE for mention in reader.mentions[-_REACH:])
    if noun == "one" and parted:  # "its left arm goes up, the right one down"
        return reader.make_mention(MentionKind.PLACE, Place(names, 2 / 3), f"{phrase} side", used)
    if part in LEXICON.part_nouns:
        if towards:
            return _make_direction(reader, names, phrase, used)
        return reader.make_mention(
            MentionKind.PLACE, Place(names, LEXICON.part_nouns[part]), f"{phrase} {part}", used
        )
    if _is_part_with_name(reader, at, noun):
        place = Place(names, 0.5 if names in (("up",), ("down",)) else 2 / 3)
        return reader.make_mention(MentionKind.PLACE, place, f"{phrase} part", used)
    struck = reader.get_preposition(at) in ("on", "at") and reader.is_after_determiner(at)
    if struck and phrase in ("left", "right") and reader.is_striking():
        return reader.make_mention(MentionKind.PLACE, Place(names, 2 / 3), f"{phrase} side", [at])
    if phrase not in LEXICON.ends or begins_longer_phrase(reader, at):
        return None
    if towards or reader.get_text(at - 1) in ("a", "an") and noun in LEXICON.motions:  # "a front flip"
        return _make_direction(reader, names, phrase, [at])
    if phrase != "back" or at > 0 and reader.tokens[at - 1].possessive or reader.is_after_determiner(at):
        return reader.make_mention(MentionKind.PLACE, Place(names, 2 / 3), phrase, [at])
    if noun in ("to", "toward", "towards") and _is_way(reader, at + 2):
        return reader.make_mention(MentionKind.FUNCTION, None, phrase, [at])  # "back to the left"
    return reader.make_mention(MentionKind.DIRECTION, names, phrase, [at])


def _is_way(reader: Reader, at: int) -> bool:
    """Return whether a way is told within two words."""
    told = LEXICON.directions.keys() | LEXICON.ends.keys() | get_set("speakers")
    return any(reader.get_text(i) in told for i in (at, at + 1))


def _make_direction(reader: Reader, names: Names, phrase: str, used: list[int]) -> Mention:
    kind = MentionKind.FROM if reader.get_preposition(used[0]) == "from" else MentionKind.DIRECTION
    return reader.make_mention(kind, names, phrase, used)


def _is_part_with_name(reader: Reader, at: int, noun: str) -> bool:
    """Return whether a side stands before a noun that the lexicon lacks: "the upper shelves", "its left sleeve"."""
    side = reader.get_text(at) in get_set("sides_of_parts")
    owners = get_set("pronouns_of_owners") if side else get_set("owners_of_parts")
    if reader.get_text(at - 1) not in owners or not noun.isalpha() or noun in reader.names:
        return False
    known = noun in PHRASES or FORMS.get(noun, noun) in PHRASES or noun in LEXICON.words - {"body"}
    return not known and reader.get_preposition(at) not in get_set("before_ways") | {"on", "onto", "at", "in"}


_SIDE = "left|right|front|back|rear"
_NOUN = "|".join(sorted(LEXICON.obstacles, key=len, reverse=True))
_OF_IT = r"(?: (?:of )?(?:it|him|her|(?:the )(?P<owner>\S+)))?"
_PLACES = "|".join(read_sections()["places_of_walls"])
_WALL = re.compile(
    rf"(?:(?P<side>{_SIDE}) )?(?:(?:{_NOUN}) )?(?P<noun>{_NOUN})(?P<where> (?:(?P<place>{_PLACES}|in front){_OF_IT}"
    rf"|(?P<to>on|at|to) (?:the |its |his |our )?(?P<beside>{_SIDE})(?: side| hand)?"
    r"(?P<of> of (?:it|him|her|the \S+))?))?(?= )"
)
_PAIR = re.compile(
    r"walls (?:(?:on )?(?:the |its )?left and (?:on )?(?:the |its )?right|on (?:both|either) (?:its )?sides?)"
    r"(?: of (?:it|the \S+))?(?= )"
)


def read_solid(reader: Reader, at: int) -> Mention | None:
    """A wall or block with its place: "the wall on the right", "into the left wall"; what "hits" it only goes there."""
    if (pair := reader.words.match(_PAIR, at)) is not None:
        solid = Solid(sides=("left",), opposite=("right",))
        return reader.make_span(MentionKind.SOLID, solid, "solid", at, reader.words.find_behind(at, pair))
    if reader.get_text(at) not in get_set("plates") | get_set("sides_of_parts") | LEXICON.obstacles.keys():
        return None
    before = at - 1
    while reader.get_text(before) in get_set("before_walls"):
        before -= 1
    way = reader.get_text(before)
    if way == "beside" or (reader.get_text(before - 1), way) == ("next", "to"):
        return reader.make_mention(MentionKind.FUNCTION, None, "beside", [at])  # nothing goes against it
    if way == "between" and reader.get_text(at) in get_set("plates"):
        return reader.make_mention(MentionKind.FUNCTION, None, "plates", [at])
    match = reader.words.match(_WALL, at)
    if match is None or match["noun"] in reader.names:
        return None
    kind = LEXICON.obstacles[match["noun"]]
    stops = reader.get_text(reader.words.find_behind(at, match)) in ("stops", "stop", "blocks", "halts")
    if (kind == "block" or match["noun"] == "ceiling") and way not in get_set("against") and not stops:
        return None
    _convert_collision(reader)
    side, behind = _find_where(reader, at, match)
    if not side:
        below = "down" if kind == "block" and way in ("on", "onto") else ""
        side = "up" if match["noun"] == "ceiling" else below
    solid = Solid.model_validate({"kind": kind, "sides": (side,) if side else ()})
    return reader.make_span(MentionKind.SOLID, solid, "solid", at, behind)


def _find_where(reader: Reader, at: int, match: re.Match[str]) -> tuple[str, int]:
    """The side of a wall, and the index behind; "against the wall to the left" tells the way instead."""
    places = {**read_sections()["places_of_walls"], "in front": "toward"}
    name = match["place"] and places[match["place"]]
    beside = None if match["to"] == "to" and not match["of"] else match["beside"]
    name = name or {"front": "toward", "back": "away", "rear": "away"}.get(
        beside or match["side"] or "", beside or match["side"]
    )
    behind = reader.words.find_behind(at, match)
    return name or "", behind - (0 if match["place"] or beside else (match["where"] or "").count(" "))


def _convert_collision(reader: Reader) -> None:
    """Makes "hits a wall", "bounces off the wall" the way there: no blow."""
    told = (i for i, each in enumerate(reader.mentions) if each.kind is not MentionKind.FUNCTION)
    index = max(told, default=-1)
    verb = reader.mentions[index].motion if index >= 0 else None
    if verb is None or verb.gravity or verb.effect not in (Effect.STRIKE, Effect.FALL):
        return
    between = {mention.phrase for mention in reader.mentions[index + 1 :]}
    if verb.effect is Effect.FALL and between & (reader.names | {"it", "him", "her"}) and "off" in between:
        motion = "hit"  # "bounce it off the wall"
    elif between & (get_set("against") | reader.names):
        return
    elif any(mention.kind in MOTIONS for mention in reader.mentions[:index]):
        reader.mentions[index] = replace(reader.mentions[index], kind=MentionKind.FUNCTION, value=None)
        return
    else:
        motion = "move"
    reader.mentions[index] = replace(reader.mentions[index], value=LEXICON.motions[motion], phrase=motion)
