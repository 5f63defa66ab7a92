"""Chunks: the longest phrases of the lexicon in a sentence, inflections undone."""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Iterator

from physagent_jax.agents.grammar.measures import make_moment
from physagent_jax.agents.grammar.mentions import Mention, MentionKind, Reader, get_last_motion
from physagent_jax.agents.grammar.tables import LEXICON, NUMBERS, get_set, read_sections
from physagent_jax.agents.grammar.tokens import FORMS
from physagent_jax.agents.lexicon import Effect, Join, Motion, Place, Repeat

GAP = "~"
LONGEST_GAP = 4
_ENDS = ("end", "heels", "tail", "head", "nose")  # "end over end" turns on and on
_ADVERBS = 6  # words from "from" to "up"
_ON_FEET = (Effect.SWAY, Effect.TURN, Effect.JUMP, Effect.ROLL)
Entry = tuple[tuple[str, ...], MentionKind, object]


@dataclasses.dataclass(frozen=True)
class Node:
    """The words that may follow those of a phrase: a trie, as one verb begins some 1,500 of them.

    Attributes:
        entries: The phrases that end here, with their place in the order of the tables.
        following: The nodes of the next words.
    """

    entries: list[tuple[int, Entry]] = dataclasses.field(default_factory=list)
    following: dict[str, Node] = dataclasses.field(default_factory=dict)


def _sort_phrases() -> dict[str, list[tuple[int, str, MentionKind, object]]]:
    """All phrases of the lexicon by their first word, with their place; at equal length the earlier table wins."""
    lexicon, found = LEXICON, {}
    tables: tuple[tuple[MentionKind, dict], ...] = (
        (MentionKind.REPEAT, lexicon.repeats), (MentionKind.POSE, lexicon.poses),
        (MentionKind.VERB, lexicon.motions), (MentionKind.CAUSE, lexicon.causes),
        (MentionKind.GRAVITY, lexicon.gravity), (MentionKind.ANCHOR, lexicon.anchors),
        (MentionKind.SENSE, lexicon.senses), (MentionKind.VIEW, lexicon.views),
        (MentionKind.AXIS, lexicon.axes), (MentionKind.PLANE, lexicon.planes),
        (MentionKind.SIDES, {phrase: side == "all" for phrase, side in lexicon.sides.items()}),
        (MentionKind.PLACE, lexicon.parts), (MentionKind.DIRECTION, lexicon.directions),
        (MentionKind.COMPARATIVE, lexicon.comparatives), (MentionKind.INTENSITY, lexicon.intensities),
        (MentionKind.DEGREE, lexicon.degrees), (MentionKind.JOIN, lexicon.joins),
        (MentionKind.REVERSAL, lexicon.reversals), (MentionKind.PACE, lexicon.paces),
        (MentionKind.EXCEPT, dict.fromkeys(lexicon.exceptions)),
        (MentionKind.TIME, {p: make_moment(m.starts, m.lasts) for p, m in lexicon.moments.items()}),
        (MentionKind.NOT, dict.fromkeys(lexicon.negations)),
        (MentionKind.FUNCTION, dict.fromkeys(lexicon.phrases)),
        (MentionKind.IGNORED, dict.fromkeys(get_set("ignored_phrases")))
    )  # fmt: skip
    phrases = ((phrase, kind, value) for kind, each in tables for phrase, value in each.items())
    for place, (phrase, kind, value) in enumerate(phrases):
        found.setdefault(phrase.partition(" ")[0], []).append((place, phrase, kind, value))
    return found


PHRASES = _sort_phrases()


@functools.cache
def _index_phrases(first: str) -> Node:
    """The phrases that begin with a word, by the words that follow: a sentence needs few of the 40,000 nodes."""
    root = Node()
    for place, phrase, kind, value in PHRASES[first]:
        words, node = tuple(phrase.split()), root
        for word in words[1:]:
            node = node.following.setdefault(word, Node())
        node.entries.append((place, (words, kind, value)))
    return root


def read_phrase(reader: Reader, at: int) -> Mention | None:
    """The longest phrase of the lexicon that begins at a token."""
    token = reader.tokens[at]
    matches = [
        match
        for word in dict.fromkeys((token.text, token.lemma))
        for match in match_phrases(reader, word, at)
    ]
    matches = [(entry, used) for entry, used in matches if not _is_noun(reader, entry, used)]
    if not matches:
        return None
    (words, kind, value), used = max(matches, key=lambda match: (len(match[0][0]), GAP not in match[0][0]))
    crosses = kind is MentionKind.DIRECTION and _is_crossing(reader, at)
    if _says_nothing(reader, (words, kind, value), used):
        kind, value = MentionKind.FUNCTION, None
    elif kind is MentionKind.VERB and isinstance(value, Motion) and _is_means(reader, value, at):
        kind = MentionKind.CAUSE
    elif crosses and _is_repeated(reader, at + 3):
        kind, value, used = MentionKind.REPEAT, Repeat(alternate=True, names=words), [at, at + 1, at + 2]
    elif crosses or kind is MentionKind.DIRECTION and reader.get_preposition(at) == "from":
        kind = MentionKind.FROM
    elif kind is MentionKind.DIRECTION and words[0] in LEXICON.locations:
        caused = [mention.kind for mention in reader.mentions[-1:]] == [MentionKind.CAUSE]
        kind = MentionKind.FROM if caused else kind  # "an explosion beneath the robot" drives it up
    return reader.make_mention(kind, value, " ".join(words), used)


def _says_nothing(reader: Reader, entry: Entry, used: list[int]) -> bool:
    """Return whether a phrase of the lexicon means nothing where it stands."""
    (words, kind, value), at, text = entry, used[0], reader.get_text
    if kind is MentionKind.PLACE:  # "wobble it on its base", "lift it by the end of its handle": all of it
        assert isinstance(value, Place)
        return is_standing(reader, at, value)
    if kind is MentionKind.JOIN:  # "don't make it jump", "make it jump", "and makes a jump": no result
        does = text(at - 1) in ("and", "then") and text(at + 1) in ("a", "an") and text(at).startswith("make")
        return (
            does or text(at) == "make" and (not text(at - 1).isalnum() or text(at - 1) in get_set("asking"))
        )
    if kind is MentionKind.INTENSITY:
        return _is_describing_object(reader, at, len(used))
    if words == ("pinch",):  # "pinch the tip and bend it": a grip
        behind = itertools.takewhile(lambda k: reader.tokens[k].is_word, range(at, len(reader.tokens)))
        ends = [k + 1 for k in behind if text(k) == "and" and text(k + 2) == "it"]
        return any(reader.tokens[end].lemma in LEXICON.motions for end in ends)
    if kind is not MentionKind.DIRECTION:
        return False
    if words == ("up",):  # "from ridiculously high up"
        before = [text(at - step) for step in range(1, _ADVERBS)]
        return before[0] in ("high", "far") and "from" in before
    if words == ("away",):  # "flies away to the right"
        return text(at + 1) == "to" and text(at + 3) in ("left", "right")
    if words == ("right",):  # "hit it right on the head": just there
        on = text(at + 1) in ("on", "in") and reader.is_after_determiner(at + 3)
        return on and reader.is_striking()
    if words == ("left",):  # "until only a puddle is left", "with nothing left of it"
        return text(at - 1) in get_set("copulas") | get_set("remains") | {"nothing"}
    back = itertools.takewhile(lambda each: each.kind is not MentionKind.JOIN, reversed(reader.mentions))
    return words[0] in ("off", "clear") and any(each.kind is MentionKind.PLACE for each in back)


def match_phrases(reader: Reader, first: str, at: int) -> list[tuple[Entry, list[int]]]:
    """Phrases that begin with ``first`` at a token, in the order of the tables, and the tokens that each is made of."""
    if at in reader.used or first not in PHRASES:
        return []
    found = _follow(reader, _index_phrases(first), [at], at + 1)
    return [(entry, used) for (_, entry), used in sorted(found, key=lambda match: match[0][0])]


def _follow(
    reader: Reader, node: Node, used: list[int], position: int
) -> Iterator[tuple[tuple[int, Entry], list[int]]]:
    """The phrases from a node on, whose next word is at ``position``, or behind a gap from there on."""
    for entry in node.entries:
        yield entry, used
    gaps = node.following[GAP].following if GAP in node.following else {}
    steps = [(child, _skip_gap(reader, position, word)) for word, child in gaps.items()]
    if position < len(reader.tokens):
        token = reader.tokens[position]
        words = dict.fromkeys((token.text, token.lemma))
        steps += [(node.following[word], position) for word in words if word in node.following]
    for child, there in steps:
        if there < len(reader.tokens) and there not in reader.used:
            yield from _follow(reader, child, [*used, there], there + 1)


def begins_longer_phrase(reader: Reader, at: int) -> bool:
    """Return whether a fixed phrase of several words begins at a token: "back and forth" is not the back."""
    matches = match_phrases(reader, reader.get_text(at), at)
    return any(len(words) > 1 and GAP not in words for (words, _, _), _ in matches)


def read_word(reader: Reader, at: int) -> Mention:
    """A word of no phrase: of grammar, or unknown."""
    text = reader.tokens[at].text
    behind = [reader.get_text(at + step) for step in (1, 2, 3)]
    done = LEXICON.motions.get(FORMS.get(behind[0], "")) if text == "all" else None
    if done is not None and done.effect is Effect.SCALE and _is_past(reader, at + 1):  # "all squashed"
        value = LEXICON.intensities["completely"]
        return reader.make_mention(MentionKind.INTENSITY, value, "completely", [at])
    counts = text in NUMBERS and any(word.removesuffix("s") in LEXICON.part_nouns for word in behind)
    told = text in LEXICON.words or counts  # "its six little legs"
    return reader.make_mention(MentionKind.FUNCTION if told else MentionKind.UNKNOWN, None, text, [at])


def _skip_gap(reader: Reader, position: int, until: str) -> int:
    """The place of ``until`` at most `LONGEST_GAP` words on; past the end if it is not there."""
    for there in range(position + 1, min(position + LONGEST_GAP + 1, len(reader.tokens))):
        if not _is_in_noun_phrase(reader, there - 1):
            break
        if until in (reader.tokens[there].text, reader.tokens[there].lemma):
            return there
    return len(reader.tokens)


def _is_in_noun_phrase(reader: Reader, at: int) -> bool:
    """Return whether a word can stand between a verb and its particle: in "push it until it tips over" one cannot."""
    token = reader.tokens[at]
    joins = LEXICON.joins.get(token.text, Join.AND) is not Join.AND
    named = token.text in reader.names or reader.is_after_determiner(at)
    if not token.is_word or joins or not named and token.text in get_set("finite"):
        return False
    return named or token.lemma not in LEXICON.motions


def _is_noun(reader: Reader, entry: Entry, used: list[int]) -> bool:
    """Return whether this reading is wrong because the word stands as a noun, or is the object or an agent."""
    (words, kind, value), at = entry, used[0]
    if (done := _is_done(reader, at)) and kind is MentionKind.PLACE:
        return True
    before, text, behind = (reader.get_text(place) for place in (at - 1, at, used[-1] + 1))
    if kind is MentionKind.PLACE:
        assert isinstance(value, Place)
        owner = _find_owner(reader, at)
        possessive = owner >= 0 and reader.tokens[owner].possessive
        possessive &= reader.get_text(owner) not in get_set("persons")
        owned = reader.get_text(owner) in get_set("owners_of_parts") or possessive
        # "Lifts a leg", "one arm".
        owned |= any(m.kind is MentionKind.VERB and m.first == at - 2 for m in reader.mentions)
        compound = before in reader.names and reader.get_text(at - 2) not in ("a", "an")
        owned |= compound and text != "head"  # "the robot arm"; a deer head may be all there is
        owned |= before in ("one", "each", "every") and reader.get_text(at - 2) not in ("with", "by", "of")
        if words[0] in ("one", "a", "an") and before in (*get_set("before_ways"), words[-1] != "of" and "on"):
            return True  # "it rolls to one side of the room", "stand it on one end"
        owned &= not (text in LEXICON.agents and _is_of_person(reader, owner, at))
        another = before in ("a", "an") and not set(words) & LEXICON.one_of_many
        return (text in LEXICON.agents and not owned) or another and reader.get_text(at + 1) != "of"
    if kind is MentionKind.POSE and words[-1] in ("down", "up") and reader.is_after_determiner(at):
        return True  # "pull the tip down"
    if kind is MentionKind.ANCHOR and value == "none":  # "the free end"
        return behind in LEXICON.part_adjectives or behind in LEXICON.part_nouns
    if kind is not MentionKind.VERB:
        return False
    if text == "beat" and (reader.is_after_determiner(at) or not (before.isalpha() or behind.isalpha())):
        return True  # "it waits for a beat", "Beat. Then it falls"
    if len(words) > 1:  # "push it over and over" does not push it over, "push it over the edge" neither
        told = behind in get_set("determiners") or behind in NUMBERS or behind.isdigit()
        over = words[-2:] == (GAP, "over") and told
        over |= words[-2:] == (GAP, "over") and {behind, reader.get_text(used[-1] - 1)} <= set(_ENDS)
        # "knock it upside down"
        over |= words[-2:] == (GAP, "down") and reader.get_text(used[-1] - 1) == "upside"
        away = words[-1] == "away" and words[0] not in LEXICON.motions  # "it backs away from us"
        return over or not away and begins_longer_phrase(reader, used[-1])
    described = before in LEXICON.intensities and not before.endswith("ly")
    article = reader.get_text(at - 2) in ("the", "its", "a", "an")
    strange = any(m.first == at - 1 and m.kind is MentionKind.UNKNOWN for m in reader.mentions[-1:])
    placed = reader.get_text(at - 3) in get_set("prepositions") - {"until"}
    placed |= (reader.get_text(at - 4), reader.get_text(at - 3)) == ("one", "of")
    noun = text in LEXICON.part_nouns or reader.tokens[at].lemma in LEXICON.nouns
    if strange and article and placed and noun:
        return True  # "on the rusty tip", "by one of its iron rings"
    owned = before in reader.names and article or reader.get_text(_find_owner(reader, at)) in ("the", "its")
    finite = FORMS.get(behind, behind) != behind and behind.endswith("s")
    if text == reader.tokens[at].lemma and owned and finite:
        return True  # "the ribbon bow flutters"
    if text == reader.tokens[at].lemma and reader.is_after_determiner(at):
        if behind in LEXICON.part_nouns or behind in reader.names:
            return True  # "on the narrow tip"
    if before in NUMBERS and text.endswith("s") and reader.tokens[at].lemma in LEXICON.causes:
        return True  # "three blows"
    if text in LEXICON.causes:  # "a hard blow", "an invisible force" are nouns, "they blow" a verb
        return reader.is_after_determiner(at) or described or reader.get_text(at - 2) in ("a", "an")
    if _is_past(reader, at) and reader.is_after_determiner(at) and behind not in reader.names:
        return True  # "in this shot"
    acts = before in get_set("finite") | get_set("pronouns") | reader.names
    if text in get_set("camera_words") and not acts and behind not in get_set("determiners"):
        return True  # "a close shot of it", but "close the lid"
    plural = text.endswith("s") and text != reader.tokens[at].lemma
    if plural and before in get_set("before_nouns"):
        return True  # "on waves"
    told = described and article or before in ("the", "its", "a")
    return not done and " ".join(words) in LEXICON.nouns and told


def _is_of_person(reader: Reader, owner: int, at: int) -> bool:
    """Return whether it is somebody's own hand or foot: "someone slams his fist on it", "pokes it with her finger"."""
    texts = [token.text for token in reader.tokens]
    acts = not get_set("persons").isdisjoint(texts[:owner]) and texts[owner] in get_set("pronouns_of_owners")
    onto = not get_set("against").isdisjoint(texts[at + 1 : at + 3])
    onto &= not {"it", *reader.names}.isdisjoint(texts[at + 1 : at + 5])
    return acts and (onto or texts[owner] == "their" or texts[owner - 1] == "with")


def _is_done(reader: Reader, at: int) -> bool:
    """Return whether a noun is what is done: "it makes a deep bow", "gives a quick wave"."""
    article = at - 1
    while article > at - LONGEST_GAP and reader.get_text(article) in LEXICON.intensities:
        article -= 1
    light = reader.get_text(article) in ("a", "an") and reader.get_text(article - 1) in get_set("light_verbs")
    # "Make a rock fall".
    return light and reader.tokens[at].text in FORMS and reader.get_text(at + 1) not in FORMS


def _find_owner(reader: Reader, at: int) -> int:
    """Index of the word before a noun and its adjectives: "the kid's" of "the kid's big head"."""
    for before in range(at - 1, at - LONGEST_GAP, -1):
        text = reader.get_text(before)
        known = any(text in each for each in (LEXICON.words, LEXICON.agents, FORMS, reader.names))
        adjective = text in LEXICON.intensities or not known and text.isalpha()
        if before < 0 or reader.tokens[before].possessive or not adjective:
            return before
    return at - 1


def is_standing(reader: Reader, at: int, place: Place) -> bool:
    """Return whether what is done last is done on the spot: what it stands on is no part that is moved."""
    motion = get_last_motion(reader.mentions)
    rests = motion is not None and motion.effect is Effect.STILL
    if rests and reader.get_preposition(at) == "of":
        at -= 2 + reader.is_after_determiner(at)  # "it balances on the end of its handle"
    below = place.names == ("down",) or place.role.startswith("leg")
    goes = motion is not None and (motion.bounces or motion.effect in _ON_FEET)
    pushed = motion if motion is not None and motion.effect is Effect.PUSH else None
    goes |= pushed is not None and (pushed.generic or pushed.direction == "ahead")
    if rests or not (goes and below):
        return rests and reader.get_preposition(at) == "on"
    at -= 1
    while reader.get_text(at) in get_set("determiners") | get_set("owners_of_feet") | {"one"}:
        at -= 1  # "hops on one foot"
    return reader.get_text(at) == "on"


def _is_past(reader: Reader, at: int) -> bool:
    text = reader.tokens[at].text
    return text != reader.tokens[at].lemma and not text.endswith(("ing", "s"))


def _is_means(reader: Reader, motion: Motion, at: int) -> bool:
    """Return whether a push or a blow tells how it is done: "with a sudden jerk it is lifted"."""
    before = at - 1
    told = LEXICON.intensities.keys() | LEXICON.moments.keys() | LEXICON.paces.keys()
    while reader.get_text(before) in told:
        before -= 1
    means = reader.get_text(before) in ("a", "an", "one") and reader.get_text(before - 1) == "with"
    return means and motion.effect in (Effect.PUSH, Effect.STRIKE)


def _is_crossing(reader: Reader, at: int) -> bool:
    """Return whether it goes "left to right": from there to the other side."""
    pair = (reader.get_text(at), reader.get_text(at + 2))
    return reader.get_text(at + 1) == "to" and pair in (("left", "right"), ("right", "left"))


def _is_repeated(reader: Reader, at: int) -> bool:
    """Return whether it is told there how often: "left to right a few times" goes to and fro."""
    times = (*read_sections()["times"], "twice", "thrice")
    return any(reader.get_text(at + step) in times for step in range(4))


def _is_describing_object(reader: Reader, at: int, size: int) -> bool:
    """Return whether an adjective belongs to the object or a part, as in "its little wings", not to a motion."""
    behind = [reader.get_text(at + size + step) for step in range(LONGEST_GAP)]
    noun = next((word for word in behind if word not in LEXICON.intensities), "")
    owner = _find_owner(reader, at)
    owned = reader.get_text(owner) in get_set("determiners") or owner >= 0 and reader.tokens[owner].possessive
    part = noun.removesuffix("s") in LEXICON.part_nouns or (noun,) in reader.parts
    return owned and (noun in reader.names or part)
