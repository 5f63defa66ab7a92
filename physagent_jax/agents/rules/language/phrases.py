"""The lexicon's phrases in a sentence, and whether a word stands as what the lexicon has it for."""

from __future__ import annotations

from physagent_jax.agents.rules.language import modifiers as m
from physagent_jax.agents.rules.language import verbs as v
from physagent_jax.agents.rules.language.lexicon import LEXICON, Entry
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import AGENT_NOUNS, FUNCTION_WORDS
from physagent_jax.agents.rules.language.quantities import match_quantity
from physagent_jax.agents.rules.language.reader import FINITE, OWNING, Reader
from physagent_jax.agents.rules.language.timing import parse_number

GAP = "~"
_ASKING = frozenset({"not", ",", ";", ".", "!", "please"})  # before a verb in its plain form
LONGEST_GAP = 4
_PERSONS = frozenset({"somebody", "someone", "person", "player", "child", "giant", "man", "woman"})
_BEHIND_NOUNS = frozenset(
    {".", ",", ";", "!", "?", "and", "on", "in", "at", "from", "to", "of", "above", "below"}
)


def read_phrase(reader: Reader, at: int) -> Mention | None:
    """The longest phrase of the lexicon that begins here."""
    token = reader.tokens[at]
    entries = {id(e): e for word in (token.text, token.lemma) for e in LEXICON.get(word, ())}
    matches = [(e, used) for e in entries.values() if (used := match_words(reader, e[0], at))]
    matches = [(e, used) for e, used in matches if not _is_noun(reader, e, at)]
    if not matches:
        return None
    if token.text == "up" and reader.get_text(at + 1) == "to" and match_quantity(reader.tokens, at + 2):
        return reader.make_mention(MentionKind.FUNCTION, None, "up to", [at, at + 1])  # "by up to 20 degrees"
    (words, kind, value), used = max(matches, key=lambda match: (len(match[0][0]), GAP not in match[0][0]))
    if kind is MentionKind.VERB and _is_means(reader, value, at):
        kind = MentionKind.CAUSE
    if kind is MentionKind.VERB and token.text == "blows" and _is_counted(reader, at):
        kind, value = MentionKind.CAUSE, v.CAUSES["blow"]  # "three blows from the left"
    if kind is MentionKind.DIRECTION and (
        reader.get_preposition(at) == "from" or _is_crossed(reader, at) or _is_locating_cause(reader, words)
    ):
        kind = MentionKind.FROM
    elif kind is MentionKind.NOT and "why" in [reader.get_text(at - back) for back in (1, 2)]:
        kind = MentionKind.FUNCTION  # "why don't you push it"
    elif kind is MentionKind.JOIN and token.text == "make" and reader.get_text(at - 1) in _ASKING:
        kind, value = MentionKind.FUNCTION, None  # "don't make it jump": a request, and no result
    elif kind is MentionKind.DIRECTION and words == ("away",) and _is_way_told_behind(reader, at):
        kind, value = MentionKind.FUNCTION, None  # "flies away to the right"
    elif kind is MentionKind.INTENSITY and _is_thing(reader, at, len(used)):
        kind, value = MentionKind.UNKNOWN, None  # "towards the light"
    elif kind is MentionKind.INTENSITY and _is_describing_thing(reader, at, len(used)):
        kind, value = MentionKind.FUNCTION, None
    return reader.make_mention(kind, value, " ".join(words), used)


def match_words(reader: Reader, words: tuple[str, ...], at: int) -> list[int]:
    """Indices of the tokens that make up ``words`` from ``at`` on; empty if they do not."""
    used, position = [], at
    for index, word in enumerate(words):
        if word == GAP:
            position = _skip_gap(reader, position, words[index + 1])
            continue
        if position >= len(reader.tokens) or position in reader.used:
            return []
        token = reader.tokens[position]
        if word not in (token.text, token.lemma):
            return []
        used.append(position)
        position += 1
    return used


def _skip_gap(reader: Reader, position: int, until: str) -> int:
    """The place of ``until`` at most `LONGEST_GAP` words on; past the end if it is not there."""
    for reach in range(1, LONGEST_GAP + 1):
        there = position + reach
        if there >= len(reader.tokens) or not _is_in_noun_phrase(reader, there - 1):
            break
        if until in (reader.tokens[there].text, reader.tokens[there].lemma):
            return there
    return len(reader.tokens)


def _is_in_noun_phrase(reader: Reader, at: int) -> bool:
    """Return whether a word can stand between a verb and its particle: in "push it until it tips over" one cannot."""
    token = reader.tokens[at]
    joins = m.JOINS.get(token.text, m.Join.AND) is not m.Join.AND
    if not token.is_word or joins or token.text in FINITE:
        return False
    named = token.text in reader.object_words or reader.is_after_determiner(at)
    return named or token.lemma not in v.VERBS


def _is_noun(reader: Reader, entry: Entry, at: int) -> bool:
    """Return whether this reading is wrong because the word stands as a noun, or is the object or an agent."""
    words, kind, _ = entry
    before, text = reader.get_text(at - 1), reader.tokens[at].text
    if kind is MentionKind.PLACE:
        owner = at > 0 and reader.tokens[at - 1].possessive and before not in _PERSONS
        owned = before in ("the", "its", "his", "her", "their") or owner
        stands = isinstance(entry[2], m.Place) and entry[2].names == ("down",)
        if stands and reader.get_preposition(at) == "on" and _is_standing(reader):
            return True  # "wobble it on its base"
        another = before in ("a", "an") and not set(words) & m.ONE_OF_MANY
        return (text in AGENT_NOUNS and not owned) or another and reader.get_text(at + 1) != "of"
    phrase, behind = " ".join(words), at + len(words)
    if phrase.endswith(" back") and (reader.get_text(behind), reader.get_text(behind + 1)) == (
        "and",
        "forth",
    ):
        return True  # "swings back and forth" does not swing back
    if phrase in ("right now", "right away") and before == "the":
        return True  # "tip it to the right now"
    listed = before == "first" or [reader.get_text(behind + i) for i in (0, 1)] == ["and", "then"]
    if phrase == "left and then right" and listed:
        return True
    if phrase == "and back" and before == "front":
        return True  # "from the front and back"
    if phrase.endswith(" over") and kind is MentionKind.VERB and _is_over_and_over(reader, at):
        return True  # "push it over and over" does not push it over
    if phrase.endswith("~ over") and _is_over_something(reader, at):
        return True  # nor does "push it over 3 seconds", "over the edge"
    if words == ("up",) and kind is MentionKind.DIRECTION and reader.get_text(at + 1) == "against":
        return True  # "push it up against the wall"
    if words == ("right",) and kind is MentionKind.DIRECTION and _is_adverb(reader, at):
        return True  # "right in the middle"
    if kind is not MentionKind.VERB or len(words) > 1:
        return False
    if text == "shot" and (reader.get_text(at + 1) in ("of", ":", ",") or reader.is_after_determiner(at)):
        return True  # "a close shot of it"
    plural = text.endswith("s") and text != reader.tokens[at].lemma
    if plural and before in ("on", "in", "over", "through", "across", "under", "among"):
        return True  # "on waves"
    inflected = text != reader.tokens[at].lemma and not text.endswith(("ing", "s"))
    if inflected and reader.is_after_determiner(at) and reader.get_text(at + 1) not in reader.object_words:
        return True  # "in this shot"
    if text in v.CAUSES:  # "a hard blow", "an invisible force" are nouns, "they blow" a verb
        described = before in m.INTENSITIES and not before.endswith("ly")  # "gently blow on it" is none
        return before in OWNING or described or reader.get_text(at - 2) in ("a", "an")
    compound = (
        text == phrase
        and before not in reader.object_words
        and before not in LEXICON
        and before not in FUNCTION_WORDS
        and reader.get_text(at - 2) in ("the", "its", "a")
    )
    if compound and phrase in v.NOUNS_AFTER_THE:
        return True  # "a tidal wave"
    described = before in m.INTENSITIES and reader.get_text(at - 2) in ("the", "its", "a")
    return phrase in v.NOUNS_AFTER_THE and (described or before in ("the", "its", "a"))


def _is_standing(reader: Reader) -> bool:
    """Return whether what is done last is done on the spot: what it stands on is no part that is moved."""
    verbs = [e.value for e in reader.mentions if isinstance(e.value, v.Verb)]
    return bool(verbs) and verbs[-1].effect in (v.Effect.SWAY, v.Effect.TURN, v.Effect.JUMP, v.Effect.STILL)


def _is_adverb(reader: Reader, at: int) -> bool:
    """Return whether "right" only stresses a place: "right in the middle", "right back", "right on its head"."""
    behind = [reader.get_text(at + reach) for reach in (1, 2, 3)]
    if behind[0] in ("back", "off", "there", "through"):
        return True
    article = behind[1] in OWNING
    part = behind[2] if article else behind[1]
    if behind[0] in ("at", "from", "in") and part in ("start", "beginning", "outset", "end", "moment"):
        return True  # "right at the start"
    return behind[0] in ("in", "on", "at", "into") and (part in m.PLACES or part in m.ENDS)


def _is_over_and_over(reader: Reader, at: int) -> bool:
    texts = [token.text for token in reader.tokens[at : at + LONGEST_GAP + 6]]
    return any(texts[i : i + 3] == ["over", "and", "over"] for i in range(len(texts)))


def _is_over_something(reader: Reader, at: int) -> bool:
    over = next(
        (i for i in range(at, len(reader.tokens)) if reader.tokens[i].text == "over"), len(reader.tokens)
    )
    behind = reader.get_text(over + 1)
    counted = parse_number(reader.tokens, over + 1)
    return behind in OWNING or (counted is not None and reader.get_text(counted[1]) in m.UNITS)


def _is_means(reader: Reader, verb: object, at: int) -> bool:
    """Return whether a push or blow tells how it is done: "with a sudden jerk it is lifted"."""
    if not isinstance(verb, v.Verb) or verb.effect not in (v.Effect.PUSH, v.Effect.STRIKE):
        return False
    before = at - 1
    while reader.get_text(before) in m.INTENSITIES or reader.get_text(before) in m.MOMENTS:
        before -= 1
    article = reader.get_text(before) in ("a", "an", "one")
    return article and reader.get_text(before - 1) == "with"


def _is_counted(reader: Reader, at: int) -> bool:
    """Return whether a number stands before it, past adjectives."""
    before = at - 1
    while reader.get_text(before) in m.INTENSITIES or reader.get_text(before) in ("quick", "consecutive"):
        before -= 1
    return reader.get_text(before) in m.NUMBERS or reader.get_text(before).isdigit()


def _is_crossed(reader: Reader, at: int) -> bool:
    """Return whether it goes "left to right": from there to the other side."""
    pair = (reader.get_text(at), reader.get_text(at + 2))
    return reader.get_text(at + 1) == "to" and pair in (("left", "right"), ("right", "left"))


def _is_locating_cause(reader: Reader, words: tuple[str, ...]) -> bool:
    """Return whether a place tells where a cause is: "an explosion *beneath* the robot" drives it up."""
    return words[0] in m.LOCATIONS and bool(reader.mentions) and reader.mentions[-1].kind is MentionKind.CAUSE


def _is_way_told_behind(reader: Reader, at: int) -> bool:
    return reader.get_text(at + 1) == "to" and reader.get_text(at + 3) in ("left", "right")


def _is_thing(reader: Reader, at: int, size: int) -> bool:
    """Return whether a word for strength stands as a noun: "the light", "a high"."""
    after = reader.tokens[at + size] if at + size < len(reader.tokens) else None
    behind = reader.get_text(at + size + 1)
    if (
        after is not None
        and after.text == ","
        and (behind in m.INTENSITIES or behind in FUNCTION_WORDS - OWNING)
    ):
        return False  # "a slow, steady push"
    return size == 1 and reader.is_after_determiner(at) and (after is None or after.text in _BEHIND_NOUNS)


def _is_describing_thing(reader: Reader, at: int, size: int) -> bool:
    """Return whether an adjective belongs to a thing ("the heavy robot") rather than to a motion ("a heavy blow")."""
    after = reader.get_text(at + size)
    copula = at - 1 - (reader.get_text(at - 1) in m.DEGREES)
    if reader.get_text(copula) in ("is", "are", "was") and (
        not after.isalpha() or after in ("that", "and", "but")
    ):
        return reader.get_text(copula - 1) in reader.object_words | {"it", "he", "she"}  # "it is too heavy"
    if not reader.is_after_determiner(at) or not after.isalpha():
        return False
    known = after in LEXICON or reader.tokens[at + size].lemma in LEXICON or after in FUNCTION_WORDS
    return after in reader.object_words or not known


def read_word(reader: Reader, at: int) -> Mention:
    """A word of no phrase: of grammar, or unknown."""
    kind = MentionKind.FUNCTION if reader.tokens[at].text in FUNCTION_WORDS else MentionKind.UNKNOWN
    return reader.make_mention(kind, None, reader.tokens[at].text, [at])
