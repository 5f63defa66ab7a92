"""Finds the lexicon's phrases in a sentence: a list of mentions in the order of the words."""

from __future__ import annotations

import enum
from dataclasses import dataclass, replace

from physagent_jax.agents.rules.language import modifiers as m
from physagent_jax.agents.rules.language import verbs as v
from physagent_jax.agents.rules.language.quantities import match_quantity
from physagent_jax.agents.rules.language.solids import match_solid
from physagent_jax.agents.rules.language.timing import match_time, parse_moment, parse_number
from physagent_jax.agents.rules.language.tokens import FORMS, tokenise

GAP = "~"
LONGEST_GAP = 4
_DETERMINERS = frozenset(
    {"the", "its", "his", "her", "their", "a", "an", "this", "that", "your", "my", "some"}
)


class MentionKind(enum.Enum):
    """What a mention says; in brackets the type of its value."""

    VERB = enum.auto()  # Verb
    CAUSE = enum.auto()  # Verb
    DIRECTION = enum.auto()  # names
    FROM = enum.auto()  # names: where the cause comes from
    AXIS = enum.auto()  # names
    PLANE = enum.auto()  # names
    SIDES = enum.auto()  # bool: all around
    SENSE = enum.auto()  # int
    VIEW = enum.auto()  # names
    INTENSITY = enum.auto()  # float
    DEGREE = enum.auto()  # float
    COMPARATIVE = enum.auto()  # float
    REPEAT = enum.auto()  # Repeat
    PLACE = enum.auto()  # Place
    EXCLUDED = enum.auto()  # Place that is not meant
    EXCEPT = enum.auto()  # None: what is not meant is not understood
    TIME = enum.auto()  # TimeSpan
    QUANTITY = enum.auto()  # Quantity
    REVERSAL = enum.auto()  # None: the other way
    ORDINAL = enum.auto()  # int: "the second time"
    SOLID = enum.auto()  # Solid
    GRAVITY = enum.auto()  # str: where to
    ANCHOR = enum.auto()  # str
    JOIN = enum.auto()  # Join
    NOT = enum.auto()  # None
    FUNCTION = enum.auto()  # None
    UNKNOWN = enum.auto()  # None


@dataclass(frozen=True)
class Mention:
    """A phrase of the lexicon as it stands in the prompt.

    Attributes:
        kind, value: What it says.
        words: The words in the prompt.
        phrase: The entry of the lexicon.
        first: Index of its first token.
        form: The first token's text ("pushing"), to tell participles.
    """

    kind: MentionKind
    value: object
    words: str
    phrase: str
    first: int
    form: str


def _build_lexicon() -> dict[str, list[tuple[tuple[str, ...], MentionKind, object]]]:
    """All phrases by their first word, longest first; at equal length the earlier table wins."""
    tables: list[tuple[MentionKind, dict]] = [
        (MentionKind.REPEAT, m.REPEATS),
        (MentionKind.VERB, v.VERBS),
        (MentionKind.CAUSE, v.CAUSES),
        (MentionKind.GRAVITY, m.GRAVITY),
        (MentionKind.ANCHOR, m.ANCHORS),
        (MentionKind.SENSE, m.SENSES),
        (MentionKind.VIEW, m.VIEWS),
        (MentionKind.AXIS, m.AXES),
        (MentionKind.PLANE, m.PLANES),
        (MentionKind.SIDES, m.SIDES),
        (MentionKind.PLACE, m.PLACES),
        (MentionKind.DIRECTION, m.DIRECTIONS),
        (MentionKind.COMPARATIVE, m.COMPARATIVES),
        (MentionKind.INTENSITY, m.INTENSITIES),
        (MentionKind.DEGREE, m.DEGREES),
        (MentionKind.JOIN, m.JOINS),
        (MentionKind.REVERSAL, dict.fromkeys(m.REVERSALS)),
        (MentionKind.EXCEPT, dict.fromkeys(m.EXCEPTIONS)),
        (MentionKind.TIME, {phrase: parse_moment(phrase) for phrase in m.MOMENTS}),
        (MentionKind.NOT, dict.fromkeys(m.NEGATIONS)),
        (MentionKind.FUNCTION, dict.fromkeys(m.FUNCTION_PHRASES)),
    ]
    by_first: dict[str, list[tuple[tuple[str, ...], MentionKind, object]]] = {}
    for kind, table in tables:
        for phrase, value in table.items():
            words = tuple(phrase.split())
            by_first.setdefault(words[0], []).append((words, kind, value))
    for entries in by_first.values():
        entries.sort(key=lambda entry: -len(entry[0]))
    return by_first


_LEXICON = _build_lexicon()


class MentionParser:
    """Reads one sentence into mentions.

    Attributes:
        prompt: The sentence.
        tokens: Its tokens.
        mentions: What was found, in order of the first words.
    """

    def __init__(self, prompt: str, object_words: frozenset[str]):
        self.prompt, self.tokens = prompt, tokenise(prompt)
        self._object_words, self._used = object_words, set()
        self.mentions: list[Mention] = []
        for at in range(len(self.tokens)):
            if at not in self._used:
                self.mentions.append(self._parse(at))
        self.mentions = _mark_exceptions(_spread_from(self.mentions))

    def _parse(self, at: int) -> Mention:
        token = self.tokens[at]
        if not token.is_word:
            join = m.Join.COMMA if token.text in (",", ":") else m.Join.THEN
            return self._make_mention(MentionKind.JOIN, join, token.text, [at])
        if token.text in self._object_words and (token.lemma not in v.VERBS or self._is_after_determiner(at)):
            return self._make_mention(MentionKind.FUNCTION, None, token.text, [at])
        return (
            self._match_solid(at)
            or self._match_thanks(at)
            or self._match_once(at)
            or self._match_condition(at)
            or self._match_prevention(at)
            or self._match_state(at)
            or self._match_target(at)
            or self._match_floating(at)
            or self._match_quantity(at)
            or self._match_ordinal(at)
            or self._match_place(at)
            or self._match_time_or_count(at)
            or self._match_phrase(at)
            or self._match_word(at)
        )

    def _match_solid(self, at: int) -> Mention | None:
        """A wall or block; what "hits" it only goes there."""
        found = match_solid(self.tokens, at, self._object_words)
        if found is None:
            return None
        solid, behind = found
        if self.mentions and solid.kind:
            self._convert_collision(at)
        used = [index for index in range(at, behind) if index not in self._used]
        if not solid.kind:  # "between two plates"
            return self._make_mention(MentionKind.FUNCTION, None, "plates", used)
        return self._make_mention(MentionKind.SOLID, solid, "solid", used)

    def _convert_collision(self, at: int) -> None:
        """Makes "hits a wall", "bounces off the wall" the way there: no blow."""
        index = len(self.mentions) - 1
        while index >= 0 and self.mentions[index].kind is MentionKind.FUNCTION:
            index -= 1
        verb, between = self.mentions[index], self.mentions[index + 1 :]
        if index < 0 or not isinstance(verb.value, v.Verb) or verb.value.gravity:
            return
        strikes = verb.value.effect in (v.Effect.STRIKE, v.Effect.FALL)
        if not strikes or any(e.phrase in _AGAINST | self._object_words for e in between):
            return
        if any(e.kind in (MentionKind.VERB, MentionKind.CAUSE) for e in self.mentions[:index]):
            self.mentions[index] = replace(verb, kind=MentionKind.FUNCTION, value=None)
        else:
            self.mentions[index] = replace(verb, value=v.VERBS["move"], phrase="move")

    def _match_thanks(self, at: int) -> Mention | None:
        """Reads "thank you very much", whose "much" is of no motion."""
        if self._get_text(at) not in ("thank", "thanks"):
            return None
        behind = at + 1
        while self._get_text(behind) in _THANKING:
            behind += 1
        return self._make_mention(MentionKind.FUNCTION, None, "thanks", list(range(at, behind)))

    def _match_once(self, at: int) -> Mention | None:
        """Reads "once it has landed": a time, and no count."""
        if self._get_text(at) != "once" or self._get_text(at + 1) not in _SUBJECTS | self._object_words:
            return None
        for token in self.tokens[at + 1 :]:
            if not token.is_word:
                break
            if token.lemma in v.VERBS or token.text in _FINITE:
                return self._make_mention(MentionKind.JOIN, m.Join.AFTER, "once", [at])
        return None

    def _match_target(self, at: int) -> Mention | None:
        """Reads "smash it on the floor": down, where no other way is told."""
        if self.tokens[at].text not in _SURFACES or self._get_preposition(at) not in (
            "on",
            "onto",
            "against",
        ):
            return None
        if not self._is_striking():
            return None
        told = any(
            e.kind in (MentionKind.DIRECTION, MentionKind.FROM, MentionKind.JOIN) for e in self.mentions
        )
        if told or not any(e.form in self._object_words | {"it", "him", "her"} for e in self.mentions):
            return None
        return self._make_mention(MentionKind.DIRECTION, ("down",), "onto the ground", [at])

    def _match_condition(self, at: int) -> Mention | None:
        """Reads "does it fall if it is pushed": both happen; a sentence that begins with "what if" tells one thing."""
        if self._get_text(at) != "if" or self._get_text(at - 1) == "as":
            return None
        if not any(e.kind is MentionKind.VERB for e in self.mentions):
            return None
        if not any(token.lemma in v.VERBS for token in self.tokens[at + 1 :]):
            return None
        return self._make_mention(MentionKind.JOIN, m.Join.WHILE, "if", [at])

    def _match_prevention(self, at: int) -> Mention | None:
        """Reads "keep it from falling": it does not fall."""
        after = self.tokens[at + 1] if at + 1 < len(self.tokens) else None
        prevented = self._get_text(at) == "from" and any(e.form in _PREVENTING for e in self.mentions)
        if not prevented or after is None or after.lemma not in v.VERBS or not after.text.endswith("ing"):
            return None
        return self._make_mention(MentionKind.NOT, None, "from", [at])

    def _match_state(self, at: int) -> Mention | None:
        """An adjective that says what was before: "the fallen robot"; what holds it ("the tied robot") holds it yet."""
        token = self.tokens[at]
        verb = v.VERBS.get(token.lemma)
        done = token.text != token.lemma and not token.text.endswith(("ing", "s"))
        if verb is None or verb.effect is v.Effect.HOLD or not (done and self._is_after_determiner(at)):
            return None
        if self._get_text(at + 1) not in self._object_words:
            return None
        return self._make_mention(MentionKind.FUNCTION, None, "state", [at])

    def _match_floating(self, at: int) -> Mention | None:
        """An adjective: "the floating robot" is weightless; elsewhere it is what happens."""
        adjective = self.tokens[at].text in ("floating", "hovering") and self._is_after_determiner(at)
        if adjective and self._get_text(at + 1) in self._object_words:
            return self._make_mention(MentionKind.GRAVITY, "none", self.tokens[at].text, [at])
        return None

    def _match_quantity(self, at: int) -> Mention | None:
        found = match_quantity(self.tokens, at)
        if found is None:
            return None
        quantity, behind = found
        used = [index for index in range(at, min(behind, len(self.tokens))) if index not in self._used]
        if quantity.dimension == "strength":
            return self._make_mention(MentionKind.COMPARATIVE, quantity.value, "as strong", used)
        return self._make_mention(MentionKind.QUANTITY, quantity, "quantity", used)

    def _match_ordinal(self, at: int) -> Mention | None:
        """Reads "the second time", "the second harder": one of several strokes."""
        order = {"second": 2, "third": 3, "last": -1}.get(self._get_text(at))
        if order is None or self._get_text(at - 1) != "the":
            return None
        after = self._get_text(at + 1)
        counted = after in ("time", "one") and self._get_text(at - 2) != "for"
        if counted or after in m.COMPARATIVES or after in m.INTENSITIES or after in ("more", "much"):
            return self._make_mention(MentionKind.ORDINAL, order, "ordinal", [at, at + 1][: 1 + counted])
        return None

    def _is_striking(self) -> bool:
        """Whether the last verb is a blow."""
        verbs = [e.value for e in self.mentions if isinstance(e.value, v.Verb)]
        return bool(verbs) and verbs[-1].effect is v.Effect.STRIKE

    def _comes_to_lie(self, at: int) -> bool:
        """Whether a side is what it falls or tips on ("falls on its back"): it goes over that way."""
        if self._get_preposition(at) not in ("on", "onto") or not self.mentions:
            return False
        index = len(self.mentions) - 1
        while index > 0 and self.mentions[index].kind in (MentionKind.FUNCTION, MentionKind.INTENSITY):
            index -= 1
        verb = self.mentions[index].value
        if not isinstance(verb, v.Verb) or verb.effect not in _GOING_OVER:
            return False
        if verb.effect is not v.Effect.TOPPLE:
            self.mentions[index] = replace(self.mentions[index], value=v.VERBS["topple"], phrase="topple")
        return True

    def _match_place(self, at: int) -> Mention | None:
        """Places and directions that share words: "the left arm", "its upper half", "the top", "from the front"."""
        if self.tokens[at].text in _LYING and self._comes_to_lie(at):
            return self._make_mention(
                MentionKind.DIRECTION, _LYING[self.tokens[at].text], self.tokens[at].text + " side", [at]
            )
        for size in (2, 1):
            phrase = " ".join(t.text for t in self.tokens[at : at + size])
            names, part = m.PART_ADJECTIVES.get(phrase), self._get_text(at + size)
            plural = part != "sides" and FORMS.get(part) is None  # "from the left tips it over"
            part = part.removesuffix("s") if plural else part
            towards = self._get_preposition(at) in ("to", "toward", "towards", "from", "into")
            if names and part in m.PARTS:
                used = list(range(at, at + size + 1))
                if part == "side" and self._comes_to_lie(at):
                    return self._make_mention(MentionKind.DIRECTION, names, phrase, used)
                if towards:
                    return self._make_direction(names, phrase, used)
                return self._make_mention(
                    MentionKind.PLACE, m.Place(names, m.PARTS[part]), f"{phrase} {part}", used
                )
            struck = self._get_preposition(at) in ("on", "at") and self._is_after_determiner(at)
            if names and struck and phrase in ("left", "right") and self._is_striking():
                return self._make_mention(MentionKind.PLACE, m.Place(names, 2 / 3), f"{phrase} side", [at])
            if names is None or phrase not in m.ENDS or self._is_longer_phrase(at):
                continue
            if self._get_text(at - 1) in ("a", "an") and part in v.VERBS:
                return self._make_mention(MentionKind.DIRECTION, names, phrase, [at])  # "a front flip"
            if towards:
                return self._make_direction(names, phrase, [at])
            if phrase == "back" and self._is_told_where(at):
                return self._make_mention(MentionKind.FUNCTION, None, phrase, [at])  # "back to the left"
            owned = at > 0 and self.tokens[at - 1].possessive
            if phrase != "back" or owned or self._is_after_determiner(at):
                return self._make_mention(MentionKind.PLACE, m.Place(names, 2 / 3), phrase, [at])
            return self._make_mention(MentionKind.DIRECTION, names, phrase, [at])
        return None

    def _is_told_where(self, at: int) -> bool:
        """Whether "back" goes a way that is named ("back to the left"), not to where it came from."""
        if self._get_text(at + 1) not in ("to", "toward", "towards"):
            return False
        return any(self._get_text(at + reach) in (*m.DIRECTIONS, *m.ENDS, *m.PLACES) for reach in (2, 3))

    def _is_longer_phrase(self, at: int) -> bool:
        """Whether a fixed phrase begins here: "back and forth" is not the back."""
        return any(
            len(words) > 1 and self._match(words, at)
            for words, _, _ in _LEXICON.get(self.tokens[at].text, ())
        )

    def _make_direction(self, names: m.Names, phrase: str, used: list[int]) -> Mention:
        kind = MentionKind.FROM if self._get_preposition(used[0]) == "from" else MentionKind.DIRECTION
        return self._make_mention(kind, names, phrase, used)

    def _match_time_or_count(self, at: int) -> Mention | None:
        found = match_time(self.tokens, at)
        if found:
            return self._make_mention(MentionKind.TIME, found[0], "time", list(range(at, found[1])))
        counted = parse_number(self.tokens, at)
        if (
            counted
            and self._get_text(counted[1]) in ("times", "time")
            and self.tokens[at].text not in ("a", "an")
        ):
            # A count beyond any clip's frames means nothing more than "very often".
            repeat = m.Repeat(int(min(max(counted[0], 1), 1000)))
            return self._make_mention(MentionKind.REPEAT, repeat, "times", list(range(at, counted[1] + 1)))
        if counted and counted[0] > 1 and counted[1] < len(self.tokens):
            behind = counted[1] + (self._get_text(counted[1]) in m.INTENSITIES)
            thing = self.tokens[min(behind, len(self.tokens) - 1)]  # "three gusts", "two small jumps"
            if thing.text.endswith("s") and (thing.lemma in v.VERBS or thing.text in v.CAUSES):
                repeat = m.Repeat(int(min(counted[0], 1000)))
                return self._make_mention(MentionKind.REPEAT, repeat, "times", list(range(at, counted[1])))
        return None

    def _match_phrase(self, at: int) -> Mention | None:
        """The longest phrase of the lexicon that begins here."""
        token = self.tokens[at]
        entries = {id(e): e for word in (token.text, token.lemma) for e in _LEXICON.get(word, ())}
        matches = [(e, used) for e in entries.values() if (used := self._match(e[0], at))]
        matches = [(e, used) for e, used in matches if not self._is_noun(e, at)]
        if not matches:
            return None
        if token.text == "up" and self._get_text(at + 1) == "to" and match_quantity(self.tokens, at + 2):
            return self._make_mention(
                MentionKind.FUNCTION, None, "up to", [at, at + 1]
            )  # "by up to 20 degrees"
        (words, kind, value), used = max(
            matches, key=lambda match: (len(match[0][0]), GAP not in match[0][0])
        )
        if kind is MentionKind.VERB and self._is_means(value, at):
            kind = MentionKind.CAUSE
        if kind is MentionKind.DIRECTION and (
            self._get_preposition(at) == "from" or self._is_locating_cause(words)
        ):
            kind = MentionKind.FROM
        elif kind is MentionKind.NOT and "why" in [self._get_text(at - back) for back in (1, 2)]:
            kind = MentionKind.FUNCTION  # "why don't you push it"
        elif kind is MentionKind.DIRECTION and words == ("away",) and self._is_way_told_behind(at):
            kind, value = MentionKind.FUNCTION, None  # "flies away to the right"
        elif kind is MentionKind.INTENSITY and self._is_thing(at, len(used)):
            kind, value = MentionKind.UNKNOWN, None  # "towards the light"
        elif kind is MentionKind.INTENSITY and self._is_describing_thing(at, len(used)):
            kind, value = MentionKind.FUNCTION, None
        return self._make_mention(kind, value, " ".join(words), used)

    def _match(self, words: tuple[str, ...], at: int) -> list[int]:
        """Indices of the tokens that make up ``words`` from ``at`` on; empty if they do not."""
        used, position = [], at
        for index, word in enumerate(words):
            if word == GAP:
                position = self._skip_gap(position, words[index + 1])
                continue
            if position >= len(self.tokens) or position in self._used:
                return []
            token = self.tokens[position]
            if word not in (token.text, token.lemma):
                return []
            used.append(position)
            position += 1
        return used

    def _skip_gap(self, position: int, until: str) -> int:
        """The place of ``until`` at most `LONGEST_GAP` words on; past the end if it is not there."""
        for reach in range(1, LONGEST_GAP + 1):
            there = position + reach
            if there >= len(self.tokens) or not self._is_in_noun_phrase(there - 1):
                break
            if until in (self.tokens[there].text, self.tokens[there].lemma):
                return there
        return len(self.tokens)

    def _is_in_noun_phrase(self, at: int) -> bool:
        """Whether a word can stand between a verb and its particle: in "push it until it tips over" one cannot."""
        token = self.tokens[at]
        joins = m.JOINS.get(token.text, m.Join.AND) is not m.Join.AND
        if not token.is_word or joins or token.text in _FINITE:
            return False
        named = token.text in self._object_words or self._is_after_determiner(at)
        return named or token.lemma not in v.VERBS

    def _is_noun(self, entry: tuple[tuple[str, ...], MentionKind, object], at: int) -> bool:
        """Whether this reading is wrong because the word stands as a noun, or is the object or an agent."""
        words, kind, _ = entry
        before, text = self._get_text(at - 1), self.tokens[at].text
        if kind is MentionKind.PLACE:
            owned = before in ("the", "its", "his", "her", "their") or (
                at > 0 and self.tokens[at - 1].possessive
            )
            return text in m.AGENT_NOUNS and not owned
        phrase, behind = " ".join(words), at + len(words)
        if phrase.endswith(" back") and (self._get_text(behind), self._get_text(behind + 1)) == (
            "and",
            "forth",
        ):
            return True  # "swings back and forth" does not swing back
        listed = before == "first" or [self._get_text(behind + i) for i in (0, 1)] == ["and", "then"]
        if phrase == "left and then right" and listed:
            return True
        if phrase == "and back" and before == "front":
            return True  # "from the front and back"
        if phrase.endswith(" over") and kind is MentionKind.VERB and self._is_over_and_over(at):
            return True  # "push it over and over" does not push it over
        if phrase.endswith("~ over") and self._is_over_something(at):
            return True  # nor does "push it over 3 seconds", "over the edge"
        if kind is not MentionKind.VERB or len(words) > 1:
            return False
        inflected = text != self.tokens[at].lemma and not text.endswith(("ing", "s"))
        if inflected and self._is_after_determiner(at) and self._get_text(at + 1) not in self._object_words:
            return True  # "in this shot"
        if text in v.CAUSES:  # "a hard blow", "an invisible force" are nouns, "they blow" a verb
            return before in _DETERMINERS or before in m.INTENSITIES or self._get_text(at - 2) in ("a", "an")
        described = before in m.INTENSITIES and self._get_text(at - 2) in ("the", "its", "a")
        return phrase in v.NOUNS_AFTER_THE and (described or before in ("the", "its", "a"))

    def _is_over_and_over(self, at: int) -> bool:
        texts = [token.text for token in self.tokens[at : at + LONGEST_GAP + 6]]
        return any(texts[i : i + 3] == ["over", "and", "over"] for i in range(len(texts)))

    def _is_over_something(self, at: int) -> bool:
        over = next(
            (i for i in range(at, len(self.tokens)) if self.tokens[i].text == "over"), len(self.tokens)
        )
        behind = self._get_text(over + 1)
        counted = parse_number(self.tokens, over + 1)
        return behind in _DETERMINERS or (counted is not None and self._get_text(counted[1]) in m.UNITS)

    def _is_means(self, verb: object, at: int) -> bool:
        """Whether a push or blow tells how it is done: "with a sudden jerk it is lifted"."""
        if not isinstance(verb, v.Verb) or verb.effect not in (v.Effect.PUSH, v.Effect.STRIKE):
            return False
        before = at - 1
        while self._get_text(before) in m.INTENSITIES or self._get_text(before) in m.MOMENTS:
            before -= 1
        article = self._get_text(before) in ("a", "an", "one")
        return article and self._get_text(before - 1) == "with"

    def _is_locating_cause(self, words: tuple[str, ...]) -> bool:
        """Whether a place tells where a cause is: "an explosion *beneath* the robot" drives it up."""
        return words[0] in m.LOCATIONS and bool(self.mentions) and self.mentions[-1].kind is MentionKind.CAUSE

    def _is_way_told_behind(self, at: int) -> bool:
        return self._get_text(at + 1) == "to" and self._get_text(at + 3) in ("left", "right")

    def _is_thing(self, at: int, size: int) -> bool:
        """Whether a word for strength stands as a noun: "the light", "a high"."""
        after = self.tokens[at + size] if at + size < len(self.tokens) else None
        return size == 1 and self._is_after_determiner(at) and (after is None or after.text in _BEHIND_NOUNS)

    def _is_describing_thing(self, at: int, size: int) -> bool:
        """Whether an adjective belongs to a thing ("the heavy robot") rather than to what happens ("a heavy blow")."""
        after = self._get_text(at + size)
        copula = at - 1 - (self._get_text(at - 1) in m.DEGREES)
        if self._get_text(copula) in ("is", "are", "was") and not after.isalpha():
            return self._get_text(copula - 1) in self._object_words | {"it", "he", "she"}  # "it is too heavy"
        if not self._is_after_determiner(at) or not after.isalpha():
            return False
        known = after in _LEXICON or self.tokens[at + size].lemma in _LEXICON or after in m.FUNCTION_WORDS
        return after in self._object_words or not known

    def _match_word(self, at: int) -> Mention:
        kind = MentionKind.FUNCTION if self.tokens[at].text in m.FUNCTION_WORDS else MentionKind.UNKNOWN
        return self._make_mention(kind, None, self.tokens[at].text, [at])

    def _make_mention(self, kind: MentionKind, value: object, phrase: str, used: list[int]) -> Mention:
        self._used.update(used)
        words = self.prompt[self.tokens[used[0]].start : self.tokens[used[-1]].end]
        return Mention(kind, value, words, phrase, used[0], self.tokens[used[0]].text)

    def _get_text(self, at: int) -> str:
        return self.tokens[at].text if 0 <= at < len(self.tokens) else ""

    def _is_after_determiner(self, at: int) -> bool:
        return self._get_text(at - 1) in _DETERMINERS

    def _get_preposition(self, at: int) -> str:
        """The word before, past a determiner."""
        before = at - 2 if self._is_after_determiner(at) else at - 1
        return self._get_text(before)


_GOING_OVER = (v.Effect.LEAN, v.Effect.TOPPLE, v.Effect.FALL)
_LYING: dict[str, m.Names] = {
    "back": ("away",),
    "front": ("toward",),
    "face": ("toward",),
    "belly": ("toward",),
}
_ORIGINS = frozenset(
    {"left", "right", "top", "bottom", "front", "back", "above", "below", "behind", "beneath"}
)
_THANKING = frozenset("you very so much a an lot again in advance for your help".split())
_PREVENTING = frozenset({"keep", "keeps", "keeping", "prevent", "prevents", "preventing"})
_SURFACES = frozenset({"ground", "floor", "table"})
_SUBJECTS = _DETERMINERS | {"it", "he", "she", "they"}
_FINITE = frozenset({"is", "are", "was", "were", "has", "have", "will", "would", "can", "should"})
_BEHIND_NOUNS = frozenset(
    {".", ",", ";", "!", "?", "and", "on", "in", "at", "from", "to", "of", "above", "below"}
)
_AGAINST = frozenset({"against", "into", "at", "onto", "on", "off"})


def _spread_from(mentions: list[Mention]) -> list[Mention]:
    """Makes what is listed behind "from" a place that it comes from: "from the left, the right and above"."""
    result: list[Mention] = []
    listing = False
    for mention in mentions:
        joins = mention.kind is MentionKind.JOIN and mention.value in (m.Join.AND, m.Join.COMMA)
        if listing and mention.phrase in _ORIGINS:
            if mention.kind is MentionKind.DIRECTION:
                mention = replace(mention, kind=MentionKind.FROM)
            elif isinstance(mention.value, m.Place):  # "from top and bottom"
                mention = replace(mention, kind=MentionKind.FROM, value=mention.value.names)
        listing = mention.kind is MentionKind.FROM or listing and (joins or mention.phrase in _DETERMINERS)
        result.append(mention)
    return result


def _mark_exceptions(mentions: list[Mention]) -> list[Mention]:
    """Makes the place in "except the head", "but not the head", "everything but the head" an excluded one."""
    result: list[Mention] = []
    at = 0
    while at < len(mentions):
        mention = mentions[at]
        place = _find_exception(mentions, at)
        if place is None:
            result.append(mention)
            at += 1
            continue
        result.append(replace(mentions[place], kind=MentionKind.EXCLUDED))
        at = place + 1
    return result


def _find_exception(mentions: list[Mention], at: int) -> int | None:
    """Index of the excluded place if an exception begins at ``at``."""
    mention = mentions[at]
    contrasts = mention.kind is MentionKind.JOIN and mention.value is m.Join.BUT
    if mention.kind is not MentionKind.EXCEPT and not contrasts:
        return None
    behind = at + 1
    negated = False
    while behind < len(mentions) and mentions[behind].kind in (MentionKind.FUNCTION, MentionKind.NOT):
        negated = negated or mentions[behind].kind is MentionKind.NOT
        behind += 1
    if behind >= len(mentions) or mentions[behind].kind is not MentionKind.PLACE:
        return None
    if not contrasts:
        return behind
    segment = [e for e in mentions[:at] if e.kind in (MentionKind.FUNCTION, MentionKind.JOIN)]
    joins = [i for i, e in enumerate(segment) if e.kind is MentionKind.JOIN]
    whole = any(e.phrase in m.WHOLE_WORDS for e in segment[joins[-1] + 1 if joins else 0 :])
    after = mentions[behind + 1] if behind + 1 < len(mentions) else None
    if whole and not negated:
        return behind
    return behind if negated and (after is None or after.kind is MentionKind.JOIN) else None


def find_mentions(prompt: str, object_words: frozenset[str]) -> list[Mention]:
    """The mentions of ``prompt``; ``object_words`` are names of the object and never verbs after "the"."""
    return MentionParser(prompt, object_words).mentions
