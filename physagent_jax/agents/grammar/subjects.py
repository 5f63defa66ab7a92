"""Parts that a sentence does not name again: "the horns bend and wobble", "it lifts its leg and puts it back down"."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

from physagent_jax.agents.grammar.mentions import (
    LOOSE,
    Mention,
    MentionKind,
    empty,
    get_last_motion,
    has_motion,
    read_as,
)
from physagent_jax.agents.grammar.tables import LEXICON, get_set
from physagent_jax.agents.lexicon import NAMED, Effect, Motion, Place
from physagent_jax.forces.part import is_plural

_MOVED = (Effect.SWAY, Effect.TURN, Effect.PUSH, Effect.LEAN, Effect.SCALE, Effect.FALL, Effect.TOPPLE)
_BESIDE = (*LOOSE, MentionKind.FUNCTION, MentionKind.PACE)
_LIMP = "droop"


@dataclass(frozen=True)
class _Part:
    """The part that was named last.

    Attributes:
        mention: Its mention.
        leads: Whether it moved by itself: "the horns bend".
        own: Whether the object itself moved it: "the horse lifts its leg".
        raised: Whether it is to be raised, lowered or bent.
        away: Whether it is taken off or out of the rest.
    """

    mention: Mention
    leads: bool
    own: bool
    raised: bool
    away: bool

    @property
    def several(self) -> bool:
        """Return whether it is a plural."""
        return is_plural(self.mention.words)


def read_subjects(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """Names the part again that a verb goes on with, and lets a part that falls droop: it hangs on the rest."""
    result: list[Mention] = []
    part: _Part | None = None
    begins = [0, *(at for at, mention in enumerate(mentions) if mention.kind is MentionKind.JOIN)]
    for begin, end in zip(begins, [*begins[1:], len(mentions)]):
        segment = mentions[begin:end]
        if part is not None:
            segment = _choose_one(segment, part)
            chosen = any(map(_is_one, segment)) and _find(segment, MentionKind.VERB) is None
            if part.several and chosen:  # "its ears twitch, first the left one"
                result = [empty(each) if each == part.mention else each for each in result]
            segment = _name_again(_name_one(segment, part.mention), part, names)
        verb, place = _find(segment, MentionKind.VERB), _find(segment, MentionKind.PLACE)
        whole = verb is not None and place is None and any(e.phrase in names for e in segment[:verb])
        if part is not None and whole:  # "its head nods, the horse leaps and tilts forward"
            part = replace(part, leads=False)
        if place is not None or part is not None:  # "it raises one arm and points up"
            points = [m.form in ("point", "points") and m.kind is not MentionKind.DIRECTION for m in segment]
            segment = [empty(each) if idle else each for each, idle in zip(segment, points)]
        flops = verb is not None and segment[verb].phrase.startswith("flop")  # leaves do as well
        flops |= part is not None and place is not None and segment[place].phrase == part.mention.phrase
        flops |= verb is not None and segment[verb].phrase == "unscrew"  # "unscrew the top and lift it off"
        if place is not None and (flops or sticks_out(segment[place])):
            if verb is not None and verb < place and segment[verb].phrase.startswith("let "):
                let, own = segment[verb], replace(segment[place], first=segment[verb].first)  # "lets it drop"
                segment = [*segment[:verb], own, let, *segment[verb + 1 : place], *segment[place + 1 :]]
                place, verb = verb, verb + 1
            leads = verb is not None and place < verb
            off = part is not None and part.away
            segment = _let_droop(segment, place, verb, result, off) if leads and verb else segment
            before = {each.phrase for each in segment[:verb]} if verb is not None else set()
            itself = not before.isdisjoint(names | get_set("pronouns"))
            first = None if verb is None or leads else segment[verb].motion
            raised = bool(first and (first.bound and first.effect is Effect.PUSH or first.manner == "bend"))
            away = verb is not None and _takes_off(segment[verb], segment[verb + 1 :])
            again = part is not None and segment[place].value == part.mention.value
            again &= _find(mentions[begin:end], MentionKind.PLACE) is None
            part = part if again else _Part(segment[place], leads, itself and not leads, raised, away)
        result += segment
    return result


def read_lists(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Marks the parts of a list behind the first: "its ears and its tail wiggle"; of "each wheel" all are meant."""
    result = list(mentions)
    for before, (at, each) in zip(mentions, enumerate(mentions[1:], 1)):
        if each.kind is MentionKind.PLACE and before.form in ("each", "every"):
            result[at] = replace(each, words=f"{before.form} {each.words}")
    ends = [0, *(at for at, each in enumerate(mentions) if each.kind is MentionKind.JOIN), len(mentions)]
    for before, at in pairwise(at for at, each in enumerate(mentions) if each.kind is MentionKind.PLACE):
        between = mentions[before + 1 : at]
        links = {each.phrase for each in between if each.kind is MentionKind.JOIN}
        idle = get_set("determiners") | {"both"}
        beside = all(
            each.kind in (*LOOSE, MentionKind.JOIN) or each.kind is MentionKind.FUNCTION and each.form in idle
            for each in between
        )
        first, last = max(k for k in ends if k <= before), min(k for k in ends if k > at)
        acts = has_motion(mentions[first:before]) and has_motion(mentions[at:last])
        if beside and "and" in links and links <= {"and", ","} and not acts:
            result[at] = replace(mentions[at], kind=MentionKind.LISTED)
    return result


def _find(segment: list[Mention], kind: MentionKind) -> int | None:
    return next((at for at, each in enumerate(segment) if each.kind is kind), None)


def sticks_out(mention: Mention) -> bool:
    """Return whether a mention names a part that sticks out of the object, and no end of it."""
    own = mention.value if mention.kind is MentionKind.PLACE else None
    place = own if own == NAMED else LEXICON.parts.get(mention.phrase.split()[-1], own)
    return isinstance(place, Place) and bool(place.role) and place.names != ("down",)


def _is_one(mention: Mention) -> bool:
    return mention.kind is MentionKind.PLACE and mention.words.lower().endswith(" one")


def _name_one(segment: list[Mention], part: Mention) -> list[Mention]:
    """The segment with the part that "the right one" is, of those that a part before names."""
    noun = part.phrase.split()[-1]
    noun = noun if noun in LEXICON.part_nouns else noun.removesuffix("s")

    def name(one: Mention) -> Mention:
        words = f"{one.words[: -len('one')]}{noun}"
        names = one.value.names if isinstance(one.value, Place) else ()
        place = Place(names, LEXICON.part_nouns.get(noun, 2 / 3))
        return replace(one, value=place, words=words, phrase=words.lower())

    return [name(each) if _is_one(each) else each for each in segment]


def _choose_one(segment: list[Mention], part: _Part) -> list[Mention]:
    """The segment with the part that "the other" is, or "the left": of "its ears wiggle, first the left"."""
    sided = part.several or getattr(part.mention.value, "names", ())
    result, named = list(segment), _find(segment, MentionKind.PLACE) is not None
    for at, each in enumerate(segment):
        behind, before = segment[at + 1 :], [m.form for m in segment[:at]]
        ends = all(m.form == "one" or m.kind is MentionKind.VERB for m in behind[:1])
        other = each.words.lower() in ("other", "another") and each.kind in (*LOOSE, MentionKind.FUNCTION)
        side = each.kind is MentionKind.DIRECTION and sided and before[-1:] == ["the"] and not behind
        if other and ends and not named:
            noun = part.mention.words.split()[-1]
            result[at] = replace(part.mention, first=each.first, words=f"other {noun}")
        elif side and not named and set(before) <= {",", "and", "then", "first", "the"}:
            names: Any = each.value
            result[at] = replace(
                each, kind=MentionKind.PLACE, value=Place(names, 2 / 3), words=f"{each.words} one"
            )
    return result


def _takes_off(verb: Mention, behind: list[Mention]) -> bool:
    """Return whether a part is taken off the rest, or out of it, and has not fallen by that."""
    motion, forms = verb.motion, {*verb.phrase.split(), *(each.form for each in behind)}
    if motion is None or motion.effect is not Effect.PUSH or motion.manner == "detach":
        return False
    return motion.draws or "off" in forms


def _hangs(motion: Motion) -> bool:
    return motion.effect is Effect.HOLD and motion.holds == "top"


def _name_again(segment: list[Mention], part: _Part, names: frozenset[str]) -> list[Mention]:
    """The segment with the part where it goes on with that: for a pronoun, or before a verb without a subject."""
    verb, place = _find(segment, MentionKind.VERB), _find(segment, MentionKind.PLACE)
    motion = None if verb is None else segment[verb].motion
    if verb is None or motion is None or place is not None and place < verb:
        return segment
    # "Tips over and falls off the cake"; what is out of it may fall beside it.
    told = segment[:verb] if motion.manner == "detach" or part.away else segment
    if not (motion.effect in _MOVED or _hangs(motion)) or any(each.phrase in names for each in told):
        return segment
    begins = not _has_subject(segment[:verb])
    lets = begins and motion.effect is Effect.FALL and segment[verb].phrase.startswith("let ")
    off = (
        begins and part.away or _takes_off(segment[verb], segment[verb + 1 :])
    )  # "unscrew the cap, lift it off"
    for at, each in enumerate(segment):
        if each.form in ("it", "they", "them"):
            alike = (each.form != "it") is part.several
            goes_on = part.several or part.own and (_hangs(motion) or begins and at > verb)
            goes_on |= part.raised and (_hangs(motion) or begins and at > verb)  # "raise its arm, lower it"
            goes_on |= off and at > verb
            if not (alike and goes_on):
                return segment  # "its head is hit, and it falls"
            falls = part.away and at > verb and motion.effect is Effect.FALL
            does = read_as(segment[verb], "fall off") if falls else segment[verb]
            segment = [*segment[:verb], does, *segment[verb + 1 :]]
            return [*segment[:at], replace(part.mention, first=each.first), *segment[at + 1 :]]
    if not (part.leads and begins or part.away and lets):  # "lets it fall"
        return segment
    return [*segment[:verb], replace(part.mention, first=segment[verb].first), *segment[verb:]]


def _has_subject(before: list[Mention]) -> bool:
    """Return whether something else than auxiliaries and adverbs stands before a verb."""
    idle = get_set("auxiliaries") | LEXICON.joins.keys() | {"get", "gets", "keep", "keeps", "start", "starts"}
    beside = (MentionKind.JOIN, MentionKind.INTENSITY, MentionKind.DEGREE)
    return any(each.kind not in beside and each.form not in idle for each in before)


def _let_droop(
    segment: list[Mention], place: int, verb: int, told: list[Mention], away: bool
) -> list[Mention]:
    """Makes a droop of the fall of a part, or of its hanging; what it then rests on is no part that moves.

    It comes off where it falls "off the edge", or was taken off before; what it "flops back" from was told before, or
    it goes to its back.
    """
    motion, between = segment[verb].motion, segment[place + 1 : verb]
    if motion is None or any(each.kind not in _BESIDE for each in between):
        return segment
    if _hangs(motion) and get_last_motion(told) is LEXICON.motions[_LIMP]:
        return [empty(each) for each in segment]  # "it flops over and dangles there"
    falls = motion.effect in (Effect.FALL, Effect.TOPPLE) and not (motion.lands or motion.manner)
    back = motion.alone == "fall" and not (get_last_motion(told) or motion.lets_go)
    if not (falls or back or _hangs(motion)):
        return segment
    phrase = "fall off" if away or "off" in segment[verb].phrase.split() else _LIMP
    droop = read_as(segment[verb], phrase)
    way = dict(kind=MentionKind.DIRECTION, value=("away",), words="", phrase="back")
    rests = (MentionKind.PLACE, MentionKind.SIDES)
    behind = [empty(each) if each.kind in rests else each for each in segment[verb + 1 :]]
    return [*segment[:verb], droop, *([replace(droop, **way)] if back else []), *behind]
