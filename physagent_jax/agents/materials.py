"""Materials that a sentence names: "made of jelly", "a metal robot", "turns to sand", "wobbles like jelly".

The words are data (`lexicon/materials.yaml`). A word counts only where it is said of the object: not the sand that it
falls onto, the rubber band that pulls it, or the water in "the water bottle".
"""

from __future__ import annotations

import functools
import re
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass

from physagent_jax.agents.lexicon import read_forms, read_lexicon
from physagent_jax.core.reading import read_packaged_yaml
from physagent_jax.motion.schema import SceneBrief

UNKNOWN_KIND = "object"
SOFT = ("jelly", "ecoflex")
"""Presets of what wobbles when it is tapped."""
GIVING = (*SOFT, "pillow", "food", "cloth", "clay", "muscle", "natural_rubber", "pu_foam")
"""Presets of what a finger or a fist goes into."""
FLOWS = tuple("honey liquid melt molten_chocolate mud olive_oil sand snow soil toothpaste wet_sand".split())
"""Presets of what does not stand by itself."""
DENTED = ("clay", *FLOWS)
"""Presets of what keeps the shape that a blow gives it."""
YIELDS = (*FLOWS, "clay", "brittle")
"""Presets of what gives way to its own weight, or has a word of its own for it."""
YIELDING = "yielding"
"""The word for what matter becomes that sags and has no other word for it."""
BROKEN = "breaks"
"""The same for what snaps."""
CRUSHED = "clay"
"""The same for what a wall crumples."""
LIMP = ("plant", "cloth")
"""Kinds of objects that sag without becoming anything else."""
_SUBJECTS = frozenset(("he", "he's", "it", "it's", "its", "she", "she's"))
_LONGEST = 4  # words of the longest name of a material
_TOKEN = re.compile(r"[^\W\d_]+(?:'[^\W\d_]+)?|\d+|[^\w\s]")


@dataclass(frozen=True)
class MaterialWord:
    """The meaning of a word for a material.

    Attributes:
        preset: Kind or library entry that stands for it.
        near: Whether that is only the nearest there is.
        becomes: Whether it is a verb by which matter becomes it, whatever it was: "melts".
    """

    preset: str
    near: bool = False
    becomes: bool = False


@dataclass(frozen=True)
class MaterialMention:
    """A material that a sentence names of its object.

    Attributes:
        word: The word for it, in lower case; one that is not in the lexicon too ("chocolate").
        phrase: The words in the sentence that say it: "made of jelly".
        turns: Whether the object becomes it in the course of the clip.
        named: Whether the word is a part of the object's own name ("the rubber duck" of a rubber duck).
        span: The phrase's first character in the sentence and the one after its last; None = it is not there.
        masked: The same of what tells nothing but the material: "like jelly" in "wobbles like jelly".
    """

    word: str
    phrase: str
    turns: bool = False
    named: bool = False
    span: tuple[int, int] | None = None
    masked: tuple[int, int] | None = None


@dataclass(frozen=True)
class MaterialLexicon:
    """The lexicon of materials.

    Attributes:
        words: Every word with its meaning.
        adjectives: The forms that tell a material before a noun.
        compounds: Names in which such a word tells none.
        around: The words that stand around them, by section of the file, which says what they are.
    """

    words: dict[str, MaterialWord]
    adjectives: frozenset[str]
    compounds: frozenset[str]
    around: dict[str, frozenset[str]]


@functools.cache
def read_material_words() -> MaterialLexicon:
    """The lexicon of the package."""
    content = read_packaged_yaml("physagent_jax.agents.lexicon", "materials.yaml")
    words: dict[str, MaterialWord] = {}
    adjectives: set[str] = set()
    for row in content.pop("materials"):
        forms = _split(row.get("adjectives", ""))
        meaning = MaterialWord(row["preset"], row.get("near", False), row.get("becomes", False))
        words |= dict.fromkeys([*_split(row["words"]), *forms], meaning)
        adjectives |= set(forms)
    compounds = frozenset(_split(content.pop("compounds")))
    around = {section: frozenset(listed.split()) for section, listed in content.items()}
    return MaterialLexicon(words, frozenset(adjectives), compounds, around)


def find_meaning(word: str) -> MaterialWord | None:
    """The meaning of a word for a material; None if the lexicon does not have it."""
    return read_material_words().words.get(" ".join(word.lower().replace("-", " ").split()))


def find_materials(text: str, brief: SceneBrief) -> tuple[MaterialMention, ...]:
    """Find the materials that a sentence says its object (known by name and nouns) is made of, becomes, or is like."""
    return tuple(_Finder(text, brief).find())


def mask_materials(text: str, mentions: Iterable[MaterialMention]) -> str:
    """A sentence with blanks for what tells nothing but a material, so that motions can be read without it.

    Materials of the object's own name stay.
    """
    for mention in mentions:
        if mention.masked is not None and not mention.named:
            start, end = mention.masked
            text = text[:start] + " " * (end - start) + text[end:]
    return text


def shows_by_drop(mention: MaterialMention, text: str) -> bool:
    """Return whether a drop is to show a material: of one that gives, or as it is asked to be made of; no question."""
    meaning, words = find_meaning(mention.word), text.lower().split()
    asks = words[0] in read_material_words().around["being"]  # "is it made of rubber?"
    gives = meaning is not None and meaning.preset in GIVING
    return not asks and (gives or words[0] == mention.phrase.lower().split()[0])


def _split(words: str) -> list[str]:
    return [each.strip() for each in words.split(",") if each.strip()]


class _Finder:
    """A search for material words by the words that stand before and after them."""

    def __init__(self, text: str, brief: SceneBrief):
        self.text, self.lexicon = text, read_material_words()
        self.around = self.lexicon.around
        self.before = self.around["determiners"] | self.around["qualifiers"]
        self.within = self.before - {"of"}
        self.described = self.around["qualifiers"] - {"of"}
        self.unnamed = self.before - {"the"}
        self.no_material = self.before | self.around["of"] | self.around["function_words"]
        found = list(_TOKEN.finditer(text.replace("-", " ").replace("\u2019", "'")))
        self.tokens = ["of" if match.group().lower() == "outta" else match.group().lower() for match in found]
        self.spans = [match.span() for match in found]
        self.own = set(re.findall(r"[^\W\d_]+", brief.object_name.lower()))
        nouns = set(brief.object_nouns) | {f"{noun}s" for noun in brief.object_nouns}
        sure = nouns if brief.object_kind != UNKNOWN_KIND else set()
        self.names = (self.own | sure) - set(self.lexicon.words)
        self.nouns = self.names | self.around["generic"] | nouns
        self.no_adjectives = self.no_material | self.nouns | self.own | self.around["objects"]
        self.no_adjectives |= self.lexicon.words.keys()

    def find(self) -> Iterator[MaterialMention]:
        """Every mention, the longest words first at each place, each material once."""
        words, adjectives, compounds = self.lexicon.words, self.lexicon.adjectives, self.lexicon.compounds
        told, at = set(), 0
        while at < len(self.tokens):
            length = self._measure(at)
            word = " ".join(self.tokens[at : at + length])
            found = None
            if " ".join(self.tokens[at : at + length + 1]) in compounds:
                length += 1
            elif length and words[word].becomes:
                found = None if self._get(at - 1) in self.before else (at, at + length, True)
            elif length and not (word in self.described and self._describes(at)):
                found = self._read(at, at + length, word in adjectives)
            elif self._is_noun(at) and not self._describes(at) and (begin := self._find_made(at)) is not None:
                found = (begin, at + 1, False)
                word = self.tokens[at]
            if found is not None and word not in told and not self._is_negated(found[0]):
                told.add(word)
                first, last, turns = found
                start, end = self.spans[first][0], self.spans[last - 1][1]
                named = first == at and word in self.own
                masked = (self.spans[self._find_masked(first, at)][0], self.spans[at + max(length, 1) - 1][1])
                masked = None if length and words[word].becomes else masked
                yield MaterialMention(word, self.text[start:end], turns, named, (start, end), masked)
            at += max(length, 1)

    def _measure(self, at: int) -> int:
        """The length of the longest word for a material that begins at a token; 0 = none does."""
        words = self.tokens[at : at + _LONGEST]
        return next((n for n in range(len(words), 0, -1) if " ".join(words[:n]) in self.lexicon.words), 0)

    def _find_masked(self, first: int, at: int) -> int:
        """The first token that tells nothing but the material: a motion or a noun before it stays."""
        told = ("changing", "made", "make", "being")
        telling = any(self.tokens[first] in self.around[each] for each in told)
        said = self._get(first - 1) == "as" and self._get(first - 2) not in self.around["being"]
        telling |= said and self.tokens[first] not in read_forms()  # "as limp as a noodle, it ..."
        return first if telling or first == at else first + 1

    def _read(self, begin: int, end: int, adjective: bool) -> tuple[int, int, bool] | None:
        """The phrase of tokens in which a material is said of the object, and whether the object turns to it."""
        looks = [self._find_made, self._find_of]
        if self._ends(end):
            looks += [self._find_turn, self._find_likeness, self._find_object, self._find_contracted]
            looks += [self._find_predicate] if adjective or self._get(begin - 1) in ("a", "an") else []
        for look in looks:
            if (first := look(begin)) is not None:
                return first, end, look == self._find_turn
        last = self._find_noun(begin, end) if adjective else None
        return None if last is None else (begin, last, False)

    def _get(self, at: int) -> str:
        return self.tokens[at] if 0 <= at < len(self.tokens) else ""

    def _is_noun(self, at: int) -> bool:
        """Return whether a word may be a noun for a material that the lexicon does not have."""
        word = self.tokens[at]
        return word.isalpha() and word not in self.no_material and word not in self.names

    def _describes(self, at: int) -> bool:
        """Return whether a word tells what the material behind it is like: "really squishy rubber"."""
        known = (place for place in range(at + 1, at + 4) if self._measure(place))
        plain = self.tokens[at].endswith("y") and not self._ends(at + 1)
        plain = plain and self._get(at + 1) not in self.nouns | read_forms().keys()
        return plain or any(self._skip(place, self.described) < at for place in known)

    def _skip(self, at: int, over: Collection[str]) -> int:
        """The place before a material and whatever words tell what it is like, besides ``over``."""
        said = {word for word in self.tokens[max(at - 4, 0) : at] if word.isalpha()} - self.no_adjectives
        verbs = {word for word in said & read_forms().keys() if not word.endswith(("ed", "ing"))}
        return self._back(at, (said - verbs).union(over))

    def _ends(self, end: int) -> bool:
        """Return whether the noun phrase ends here: "like water", not "like water balloons"."""
        after = self._get(end)
        return not after.isalpha() or after in self.around["function_words"] or after.endswith("ly")

    def _back(self, at: int, over: Collection[str], most: int = 4) -> int:
        """The first place before ``at`` whose token is none of ``over``."""
        place = at - 1
        while place >= 0 and at - place <= most and self.tokens[place] in over:
            place -= 1
        return place

    def _find_made(self, at: int) -> int | None:
        """The beginning of "made of" or "make it of" before this token, if it is said of the object; None = of none."""
        link = self._skip(at, self.within) if self._measure(at) else self._back(at, self.within)
        place = self._back(link, self.around["of"])
        if self._get(link) not in ("of", "from"):
            return None
        if self._get(place) not in self.around["made"]:
            return self._find_make(place)
        owner = self._back(place, self.around["fillers"] | {",", "itself"} | _SUBJECTS, 6)
        alone = not self._get(owner).isalpha() or self._get(owner) == "like"
        between = {*self.tokens[owner + 1 : place]}
        told = ({"if", "though"} | _SUBJECTS) & between or "," in between and not self._is_other_noun(owner)
        named = self._get(owner) in self.own  # "a wine glass made of rubber"
        return place if alone or told or named or self._is_object(owner) else None

    def _find_make(self, owner: int) -> int | None:
        """The "make" before the object, if that is what stands here."""
        verb = self._back(owner, self.before | self.names | self.own)  # "make the honey jar of rubber"
        meant = self._is_object(owner) or self._get(owner) in self.around["objects"] | self.own
        return verb if meant and self._get(verb) in self.around["make"] else None

    def _is_other_noun(self, at: int) -> bool:
        """Return whether a word with an article is a thing and no way: "a table", but not "away" or "the left"."""
        ways = read_lexicon().directions
        return self._get(at) not in ways and self._get(at - 1) in self.around["determiners"]

    def _is_object(self, at: int) -> bool:
        """Return whether a noun is the object: by its name, or as one that may name it and is no place of anything."""
        noun = self._get(at)
        known = noun in self.names or (noun in self.nouns and not self._is_placed(at))
        before = self.before | {self._get(at - 1)}  # "the gift box is made of clay"
        only = self._get(at + 1) in self.around["being"] and self._back(at, before) < 0 < at
        apart = noun in self.around["parts"] or not self.names.isdisjoint(self.tokens)
        return known or only and not apart and self._is_noun(at)  # "the gizmo is made of jelly"

    def _is_placed(self, at: int) -> bool:
        """Return whether a preposition stands before a noun: it is the place of something."""
        return self._get(self._back(at, self.before)) in self.around["prepositions"]

    def _find_of(self, at: int) -> int | None:
        """The beginning of "bear of sand"."""
        place = self._back(at, self.unnamed - {"of"})
        no_owners = self.around["containers"] | {"it", "one", "itself"}
        said = self._get(place) == "of" and self._get(place - 1) not in no_owners
        return place - 1 if said and self._is_object(place - 1) else None

    def _find_turn(self, at: int) -> int | None:
        """The beginning of "turns to"; scenery has an article ("collapses into the sand")."""
        place = self._skip(at, self.unnamed)
        if self._get(place) in ("into", "to", "in"):
            place -= 1
            changer = self._back(place, self.before)
            told = self._get(place) in self.around["objects"] or self._is_object(place)
            if told and self._get(changer) in self.around["changing"]:
                return changer  # "turn it into cloth"
        elif self._get(place) not in self.around["becoming"]:
            return None
        return place if self._get(place) in self.around["turns"] else None

    def _find_likeness(self, at: int) -> int | None:
        """The beginning of "wobbles like", "soft as" or "it's like": a likeness in deforming, or of the whole."""
        like = self._skip(at, self.described | {"a", "an"})
        before = self._back(like, self.around["adverbs"] | {"it", "as", "itself"}, 5)
        word = self._get(before)
        deforms = word.startswith(tuple(self.around["deforms"])) or word in self.around["acts"]
        whole = word in self.around["contracted"] and self._get(like) == "like" and before == like - 1
        return before if (deforms or whole) and self._get(like) in ("like", "as") else None

    def _find_contracted(self, at: int) -> int | None:
        """The beginning of "it's rubber", and of "pretend its rubber"."""
        place = self._skip(at, self.described)
        supposed = self._get(place - 1) in self.around["supposing"]
        said = self._get(place) in self.around["contracted"] and ("'" in self._get(place) or supposed)
        return place if said else None

    def _find_object(self, begin: int) -> int | None:
        """The beginning of "make the robot rubber"."""
        if self.tokens[begin] in read_lexicon().motions:
            return None  # "makes it rock"
        return self._find_make(self._skip(begin, self.described))

    def _find_noun(self, begin: int, end: int) -> int | None:
        """The end of "metal robot": the adjective stands before the object's noun, maybe with others between."""
        place = end
        if self._get(place) == "like":
            place += 1
        while place - end < 3 and self._get(place) in self.described:
            place += 1
        noun = self._get(place)
        if noun not in self.nouns or noun in ("it", "itself") or self._get(place + 1) in self.around["parts"]:
            return None
        elsewhere = self._is_placed(begin) or self._get(place + 1) in self.around["contacts"]
        return place + 1 if noun in self.names or not elsewhere else None

    def _find_predicate(self, begin: int) -> int | None:
        """The beginning of "is metal", said of the object."""
        place = self._back(begin, self.around["qualifiers"] | {"now", "a", "an"})
        subject = self._get(place - 1)
        return place if self._get(place) in self.around["being"] and subject in self.nouns else None

    def _is_negated(self, first: int) -> bool:
        return any(self._get(place) in self.around["negations"] for place in (first - 1, first - 2))
