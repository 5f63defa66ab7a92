"""Words outside the grammar: ignored ones, which no motion depends on, and doubtful ones, which may change it.

Words of looks, scenery, camera, light, mood and talk are ignored wherever they stand (`lexicon/scenery.yaml`). Other
unknown words are judged by their place: what stands where a verb, an object or a part would stand is doubtful; what
tells a place, describes, accompanies or stands in a fragment of its own is ignored.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from physagent_jax.agents.compiler.events import KnownPart
from physagent_jax.agents.compiler.limbs import find_limbs
from physagent_jax.agents.grammar.mentions import (
    LOOSE,
    MOTIONS,
    Mention,
    MentionKind,
    get_phrase,
    has_motion,
    list_segments,
)
from physagent_jax.agents.grammar.nouns import is_telling
from physagent_jax.agents.grammar.tables import LEXICON, NUMBERS, get_set, read_sections
from physagent_jax.agents.lexicon import Effect, Motion, Place
from physagent_jax.agents.materials import UNKNOWN_KIND, read_material_words
from physagent_jax.motion.schema import SceneBrief

_LEAST_WORDS, _MOST_UNKNOWN = 3, 0.5
_REACH = 40  # words to either side that tell the place of a word: keeps long texts linear
_LOOKS = frozenset(word for name in read_sections(("scenery",)) for word in get_set(name)) | LEXICON.moods


@dataclass(frozen=True)
class Coverage:
    """The words of a sentence that the grammar has no place for.

    Attributes:
        ignored: Words that do not bear on the motion.
        doubtful: Words that may bear on it.
        parts: Those of them that stand for a part of the object.
        taken: Words taken for the object's name.
    """

    ignored: tuple[str, ...] = ()
    doubtful: tuple[str, ...] = ()
    parts: tuple[str, ...] = ()
    taken: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Spot:
    """The place of an unknown word.

    Attributes:
        mentions, names: The sentence, and words for the object.
        index: Index of the word.
        begin, end: What stands between the connectives around it.
        motion: The last motion before it.
        captions: Whether it is a caption: a motion among words of looks.
        brief: The object.
    """

    mentions: list[Mention]
    names: frozenset[str]
    index: int
    begin: int
    end: int
    motion: Motion | None
    captions: bool
    brief: SceneBrief

    @property
    def word(self) -> str:
        """The word."""
        return self.mentions[self.index].phrase

    def get(self, step: int) -> str:
        """The phrase of a mention so many places away."""
        return get_phrase(self.mentions, self.index + step)

    @property
    def first(self) -> int:
        """Index of the first word of the noun's phrase: its article, or its first adjective."""
        first = self.index
        while first > self.begin and self.mentions[first - 1].kind in LOOSE:
            first -= 1
        return first - (get_phrase(self.mentions, first - 1) in get_set("determiners"))

    @property
    def preposition(self) -> str:
        """The word before the noun's phrase."""
        return get_phrase(self.mentions, self.first - 1)

    def is_behind(self, kind: MentionKind) -> bool:
        """Return whether such a mention stands before it in its segment."""
        return any(each.kind is kind for each in self.mentions[self.begin : self.index])

    @property
    def is_parting(self) -> bool:
        """Return whether the object breaks or bursts."""
        return self.motion is not None and (self.motion.gives or self.motion.effect is Effect.BURST)

    @property
    def is_in_wind(self) -> bool:
        """Return whether a wind acts."""
        return self.motion is not None and self.motion.wind

    @property
    def is_met(self) -> bool:
        """Return whether a blow, a pull or a press acts there: "tug at the collar", but not "press it on the anvil"."""
        motion, before = self.motion, self.mentions[self.begin : self.first]
        whole = any(each.phrase in self.names | get_set("objects") for each in before)
        pressed = motion is not None and motion.effect is Effect.SCALE and motion.sign < 0 and not whole
        return pressed or motion is not None and (motion.effect is Effect.STRIKE or motion.pulls)

    def skip(self, step: int, helps: frozenset[str] = frozenset()) -> Mention | None:
        """The nearest mention in a direction past adjectives, adverbs and ``helps``."""
        at = self.index + step
        while self.begin <= at < self.end and (
            self.mentions[at].kind in LOOSE or self.mentions[at].phrase in helps
        ):
            at += step
        return self.mentions[at] if 0 <= at < len(self.mentions) else None


def sort_words(mentions: list[Mention], names: frozenset[str], brief: SceneBrief) -> Coverage:
    """The unknown words of a sentence by whether they may bear on the motion; ``names`` are words for the object."""
    named = any(mention.phrase in names for mention in mentions)
    nameless = not is_telling(brief.object_name)
    own = bool(brief.object_nouns) and brief.object_kind == UNKNOWN_KIND  # it may be called anything
    found: dict[str, list[str]] = {"ignored": [], "doubtful": [], "parts": [], "taken": []}
    seen: set[str] = set()
    for spot in _list_spots(mentions, names, brief):
        tells = _is_telling_a_part(spot)
        look = is_look(spot.word) and not (tells or _is_moved_part(spot))
        unnamed = nameless or own and not (look or tells or _is_a_part(spot))
        if unnamed and spot.word.isalpha() and _is_named_here(spot, named, found["taken"]):
            kind = "taken"
        elif look or mentions[spot.index].kind is MentionKind.IGNORED:
            kind = "ignored"
        else:
            ignored = next((ignored for rule, ignored in _RULES if rule(spot)), False)
            kind = "ignored" if ignored else "doubtful"
        known = mentions[spot.index].kind is MentionKind.FUNCTION
        if spot.word not in seen and not (known and kind == "ignored"):
            found[kind].append(spot.word)
            seen.add(spot.word)
            if kind == "doubtful" and _names_a_part(spot):
                found["parts"].append(spot.word)
    return Coverage(**{kind: tuple(words) for kind, words in found.items()})


def _list_spots(mentions: list[Mention], names: frozenset[str], brief: SceneBrief) -> Iterator[_Spot]:
    """The places of words that are not understood."""
    motion: Motion | None = None
    captions = _is_caption(mentions)
    for begin, end in list_segments(mentions):
        for index in range(begin, end):
            mention = mentions[index]
            motion = mention.motion or motion
            strange = mention.kind in LOOSE[:2] and mention.phrase not in names
            if strange or mention.kind is MentionKind.FUNCTION and mention.phrase in get_set("particles"):
                reach = max(begin, index - _REACH), min(end, index + _REACH)
                yield _Spot(mentions, names, index, *reach, motion, captions, brief)


def _is_caption(mentions: list[Mention]) -> bool:
    """Return whether a motion stands among words of looks."""
    moves = any(mention.kind in MOTIONS for mention in mentions)
    looks = (
        m.kind is MentionKind.IGNORED or m.kind is MentionKind.UNKNOWN and is_look(m.phrase) for m in mentions
    )
    return moves and any(looks)


def ignore_captions(mentions: list[Mention]) -> list[Mention]:
    """The mentions with numbers ignored that a caption tells by themselves: ", golden hour, 35mm,"."""
    if not _is_caption(mentions):
        return mentions
    result = list(mentions)
    for begin, end in list_segments(mentions):
        if {each.kind for each in mentions[begin:end]} <= {MentionKind.QUANTITY, MentionKind.UNKNOWN}:
            for at in range(begin, end):
                if mentions[at].kind is MentionKind.QUANTITY:
                    words = mentions[at].words
                    result[at] = Mention(MentionKind.IGNORED, None, words, words, mentions[at].first, words)
    return result


def is_mostly_unknown(mentions: list[Mention], coverage: Coverage) -> bool:
    """Return whether so little was understood that what was is probably misunderstood: another language, say."""
    words = [m for m in mentions if m.kind is not MentionKind.JOIN or m.words.isalpha()]
    strange = set(coverage.doubtful) | {word for word in coverage.ignored if not is_look(word)}
    unknown = sum(m.kind is MentionKind.UNKNOWN and m.phrase in strange for m in mentions)
    return len(words) >= _LEAST_WORDS and unknown >= _MOST_UNKNOWN * len(words)


def is_look(word: str) -> bool:
    """Return whether a word tells a look, a mood, a light, a camera or the like: "merrily", "naughty", "cinematic"."""
    stem = word.removesuffix("ly")
    stems = (stem, stem.removesuffix("i") + "y", stem + "le", stem.removesuffix("al")) if stem != word else ()
    return not _LOOKS.isdisjoint((word, *stems))


def _is_named_here(spot: _Spot, named: bool, taken: list[str]) -> bool:
    """Return whether a noun is the object, which is not named otherwise: "knock the chess piece over"."""
    owners = get_set("determiners") - get_set("pronouns_of_owners")
    done_to = spot.get(-1) in owners and spot.get(-2) not in get_set("prepositions")
    verb, before = spot.skip(1, get_set("auxiliaries")), spot.mentions[spot.begin : spot.index]
    noun = has_motion(before) or verb is not None and verb.kind in MOTIONS  # "the gizmo zorps": a verb
    noun = noun or spot.get(1) in get_set("copulas")  # "the gift box gets squashed"
    return spot.get(-1) in taken and noun or not named and not taken and done_to


def _is_a_particle(spot: _Spot) -> bool:
    """A particle that tells where a motion ends, in no known phrase ("slides off the table"); a fall ends below."""
    falls = spot.motion is not None and spot.motion.effect in (Effect.FALL, Effect.TOPPLE)
    lifted = spot.word == "off" and spot.motion is not None and spot.motion.bound
    behind = {m.kind for m in spot.mentions[spot.index : spot.index + 4]}
    told = MentionKind.SOLID in behind or spot.get(1)[:2] == "to" and MentionKind.DIRECTION in behind
    return spot.word in get_set("particles") and not (falls or lifted or told)


def _is_interjection(spot: _Spot) -> bool:
    """A word by itself before or behind all else: "timber, it goes over", "it falls, duh"; no verb of a list."""
    ends = spot.begin == 0 or spot.end == len(spot.mentions)
    around = (*spot.mentions[spot.begin - 1 : spot.begin], *spot.mentions[spot.end : spot.end + 1])
    apart = bool(around) and all(not m.words.isalnum() for m in around)
    alone = spot.end - spot.begin == 1 and not spot.word.endswith(("s", "ing", "ed", "ly", "wise"))
    return ends and apart and alone


def _is_landing_on_its_own(spot: _Spot) -> bool:
    """A particle before what it stands on then: "back onto its front wheels"."""
    behind = [m.kind for m in spot.mentions[spot.index + 1 : spot.index + 6]]
    return spot.word == "onto" and spot.get(1) in get_set("owners_of_parts") and MentionKind.PLACE in behind


def _is_asking(spot: _Spot) -> bool:
    """Somebody speaks: "I was wondering whether it could bow", "my daughter wants it to", "I am over the moon"."""
    before = spot.mentions[spot.begin : spot.index]
    told = any(m.kind in MOTIONS or m.phrase in spot.names for m in before)
    done_to = {spot.get(1), spot.get(2)} & (get_set("objects") | spot.names)
    return any(m.form in get_set("speakers") for m in before) and not told and not done_to


def _is_described(spot: _Spot) -> bool:
    """A state of something: "she is fragile", "until he was dizzy"."""
    named = spot.word in get_set("stand_ins")  # "it is an ice sculpture"
    before = spot.skip(-1, get_set("determiners") if named else frozenset())
    return before is not None and before.form in get_set("copulas") and not spot.word.endswith(("ing", "ed"))


def _is_a_part(spot: _Spot) -> bool:
    """A part of the object: "the corners", "the handle", "its lid"."""
    owned = spot.get(-1) in get_set("pronouns_of_owners") and spot.get(-2) not in get_set("prepositions")
    noun = spot.skip(1)
    owned &= noun is None or noun.kind is not MentionKind.PLACE  # "its stubby tail"
    known = spot.word in LEXICON.unplaced or spot.word.removesuffix("s") in LEXICON.part_nouns
    return known or owned or _is_listed(spot)


def _is_listed(spot: _Spot) -> bool:
    """A noun behind a part: "the cap and the band wobble"."""
    before = spot.mentions[max(spot.first - 2, 0) : spot.first]
    parts = [each.kind is MentionKind.PLACE for each in before[:1]] == [True] and before[-1].phrase == "and"
    return parts and spot.get(-1) in get_set("determiners")


def _is_moved_part(spot: _Spot) -> bool:
    """A part that something is done to, though it may be scenery elsewhere: "open the door", "press on the corner"."""
    at = spot.index - (3 if spot.preposition in ("on", "at") else 2)
    verb = spot.mentions[at] if at >= 0 else None
    told = verb is not None and verb.kind is MentionKind.VERB and spot.get(-1) in get_set("determiners")
    return told and (spot.word in LEXICON.unplaced or spot.word.removesuffix("s") in LEXICON.part_nouns)


def _names_a_part(spot: _Spot) -> bool:
    """A noun of the object's, or a word for parts, that is acted on or moves: "the robot's axe", "press on the jaw"."""
    after, at = spot.mentions[spot.index + 1 :], spot.index - 1
    while at > spot.begin and spot.mentions[at].kind in LOOSE:
        at -= 1
    owner, own = spot.mentions[max(at, 0)], spot.names | get_set("objects")
    named = owner.phrase in spot.names and owner.words.endswith(("'s", "\u2019s", "s'"))
    owned = named or owner.phrase in get_set("pronouns_of_owners")
    owned |= spot.get(1) in ("of", "on") and not own.isdisjoint(map(spot.get, range(2, 6)))
    part = spot.word in LEXICON.unplaced or spot.word.removesuffix("s") in LEXICON.part_nouns
    noun = after and after[0].kind is MentionKind.UNKNOWN and not after[0].phrase.startswith("wide")
    if noun or not (owned or part and owner.phrase == "the"):
        return False
    start = at - (named and get_phrase(spot.mentions, at - 1) in get_set("determiners"))
    before = spot.mentions[max(start - 1, 0)]
    struck = before.phrase in ("on", "at") and spot.motion is not None
    if struck or before.kind in (*MOTIONS, MentionKind.EXCEPT):
        return True
    skipped = own | get_set("auxiliaries") | get_set("determiners") | {"of", "on"}
    then = next((each for each in after if each.phrase not in skipped), None)
    first = before in (owner, spot.mentions[0]) or before.kind is MentionKind.JOIN
    return first and then is not None and then.kind in MOTIONS


def _is_telling_a_part(spot: _Spot) -> bool:
    """The adjective of a part that tells it from others: "the red part", "the blue corner"; an object has one head."""
    after = spot.mentions[spot.index + 1] if spot.index + 1 < len(spot.mentions) else None
    if after is None or spot.get(-1) not in get_set("owners_of_parts"):
        return False
    if not isinstance(after.value, Place):
        return after.phrase in LEXICON.part_nouns
    alike = find_limbs(KnownPart(after.value, after.phrase, f"{after.words}s"), spot.brief)
    if after.words.endswith("s") and len(alike) > 1 and is_look(spot.word):
        return False  # "the green leaves": all of them
    one = after.phrase not in LEXICON.one_of_many and (len(alike) == 1 or not alike and after.value.names)
    several = LEXICON.part_nouns.keys() | LEXICON.one_of_many
    return not one and (" " in after.phrase or after.phrase in several)  # "the pointed front end" is but one


def _is_its_own_path(spot: _Spot) -> bool:
    """A circle in which something rolls or rocks, an arc in which it flies or swings: all do so by themselves."""
    if spot.motion is None:
        return False
    rolls = spot.motion.effect is Effect.ROLL or spot.motion.manner == "rock"
    flies = spot.motion.gravity or spot.motion.effect in (Effect.LEAN, Effect.SWAY, Effect.TOPPLE)
    flies &= spot.preposition == "in"
    word = spot.get(1) if spot.word == "half" else spot.word
    return rolls and "circle" in word or (rolls or flies) and word in ("arc", "arcs")


def _is_speech(spot: _Spot) -> bool:
    """Speech with its verb: "it says boo and jumps"."""
    said = spot.mentions[spot.begin : spot.index + 1]
    return any(each.form in get_set("speaking") for each in said) and not has_motion(said)


def _is_placed_part(spot: _Spot) -> bool:
    """A thing whose place is told, which is moved then: "the bird nest at the top shakes"."""
    behind = [m for m in spot.mentions[spot.index + 1 : spot.end] if m.kind not in LOOSE]
    end = next((m for m in behind if m.phrase not in get_set("determiners") | {"on", "at"}), spot.mentions[0])
    told = bool(behind) and end.kind is MentionKind.PLACE and behind[0].phrase in ("on", "at")
    told &= end.phrase in LEXICON.ends
    return told and has_motion(behind) and not has_motion(spot.mentions[spot.begin : spot.index])


def _is_in_a_fragment(spot: _Spot) -> bool:
    """A segment of nouns alone beside a motion, in a caption: ", soft focus, volumetric,"."""
    inside = spot.mentions[spot.begin : spot.end]
    around = (*spot.mentions[spot.begin - 1 : spot.begin], *spot.mentions[spot.end : spot.end + 1])
    told = {m.kind for m in inside} - {MentionKind.FUNCTION, *LOOSE}
    apart = all(not m.words.isalnum() for m in around)
    linked = spot.names | get_set("pronouns") | get_set("repeating") | get_set("linking")
    nouns = not any(m.phrase in linked or m.phrase.endswith(("ly", "wise", "ways")) for m in inside)
    return spot.captions and apart and not told and nouns


def _is_describing(spot: _Spot) -> bool:
    """An adjective: "the old robot", "the polished floor", "the howling wind", "the slender neck"."""
    noun = spot.skip(1, frozenset(LEXICON.intensities))
    if noun is None:
        return False
    known = noun.phrase in spot.names | get_set("stand_ins") or noun.form in LEXICON.scene_nouns
    return known or noun.kind is MentionKind.PLACE or noun.motion is not None and noun.motion.wind


def _is_predicate(spot: _Spot) -> bool:
    """The place of a verb: behind the object as its subject, or before it as its object."""
    subject = spot.skip(-1, get_set("auxiliaries"))
    behind = spot.get(2) if spot.get(1) in get_set("determiners") else spot.get(1)
    after_subject = subject is not None and subject.phrase in spot.names | get_set("pronouns")
    before_object = behind in spot.names | get_set("objects")
    noun = spot.get(-1) in get_set("determiners") | get_set("prepositions")
    return after_subject and not spot.word.endswith("ly") or before_object and not noun


def _is_acting(spot: _Spot) -> bool:
    """The agent of a motion: "the baker presses the bread", "Alice nudges it"."""
    verb = spot.skip(1, get_set("auxiliaries"))
    if verb is None or verb.kind not in MOTIONS:
        return False
    behind = spot.mentions[spot.index : spot.index + _REACH]
    end = next((i for i, m in enumerate(behind) if m.words == "."), len(behind))
    return any(m.phrase in spot.names | get_set("objects") for m in behind[:end])


# In their order: the first that holds decides whether the word is ignored; what none holds for is doubtful.
_RULES: tuple[tuple[Callable[[_Spot], bool], bool], ...] = (
    (_is_landing_on_its_own, True),
    (_is_a_particle, False),
    (lambda s: s.mentions[s.index].kind is MentionKind.FUNCTION, True),
    (_is_interjection, True),
    (_is_speech, True),
    # All of it: "the stack of pancakes"; a part of whoever acts: "with your palm".
    (lambda s: s.word in get_set("measures") and s.get(1) == "of" and s.get(2) in s.names, True),
    (lambda s: s.get(-1) in ("my", "your", "our") and s.preposition in ("with", "by", "between", "in"), True),
    (lambda s: any(a == b == c for a, b, c in zip(s.word, s.word[1:], s.word[2:])), True),  # "noooo"
    (lambda s: not get_set("styles").isdisjoint((s.word, s.get(1))), True),  # "accordion style"
    # Of what a part is, is seen by how it moves: "her legs are rubber".
    (lambda s: s.word in read_material_words().words and s.is_behind(MentionKind.PLACE), True),
    (lambda s: s.word in get_set("remains") and s.motion is not None, True),
    # "Into thousands of pieces".
    (lambda s: s.is_parting and s.word in get_set("crowds") | get_set("paths") | NUMBERS.keys(), True),
    (lambda s: s.word == "head" and s.mentions[s.index - 1].words in s.names and s.motion is None, True),
    (_is_its_own_path, True),
    # "In a spiral", "on the moon"; "a wave lifts the boat".
    (lambda s: s.word in get_set("paths") | get_set("worlds") and not _is_acting(s), False),
    # "3.2 Push it", "Run 3:".
    (lambda s: s.word[0].isdigit() and (s.index == 0 or s.get(1) in (":", ".")), True),
    (_is_in_a_fragment, True),
    (lambda s: not s.word.isalpha() or s.word == "minus", False),  # "by -45 degrees"
    # "A third of its length farther to the right".
    (lambda s: s.index > 0 and s.mentions[s.index - 1].kind is MentionKind.QUANTITY, True),
    (_is_asking, True),
    (_is_described, True),
    # "A gust catches the sign".
    (lambda s: s.is_behind(MentionKind.CAUSE) and not s.is_behind(MentionKind.VERB) and s.is_in_wind, True),
    (_is_a_part, False),
    (_is_telling_a_part, False),
    (_is_placed_part, True),
    (lambda s: s.preposition in ("at", "on", "against") and s.is_met, False),  # "tap it on the forehead"
    (lambda s: s.preposition in ("into", "toward", "towards", "like"), False),  # "bend it into a knot"
    (lambda s: s.preposition in get_set("prepositions"), True),  # "in the garden", "with a spoon"
    (_is_describing, True),
    (_is_predicate, False),
    (_is_acting, True),
)
