"""Parts that a sentence does not name again: "the horns bend and wobble", "it lifts its leg and puts it back down"."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.grammar.mentions import LOOSE, Mention, MentionKind, empty
from physagent_jax.agents.grammar.tables import LEXICON, get_set
from physagent_jax.agents.lexicon import NAMED, Effect, Motion, Place
from physagent_jax.forces.part import is_plural

_MOVED = (Effect.SWAY, Effect.TURN, Effect.PUSH, Effect.LEAN, Effect.SCALE, Effect.FALL, Effect.TOPPLE)
_BESIDE = (*LOOSE, MentionKind.FUNCTION, MentionKind.PACE)
_LIMP = "droop"


def read_subjects(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """Names the part again that a verb goes on with, and lets a part that falls droop: it hangs on the rest."""
    result: list[Mention] = []
    part, subject, own = None, False, False
    begins = [0, *(at for at, mention in enumerate(mentions) if mention.kind is MentionKind.JOIN)]
    for begin, end in zip(begins, [*begins[1:], len(mentions)]):
        segment = mentions[begin:end]
        verb = next((at for at, each in enumerate(segment) if each.kind is MentionKind.VERB), None)
        places = [at for at, each in enumerate(segment) if each.kind is MentionKind.PLACE]
        if part is not None or places:  # "it raises one arm and points up"
            segment = [empty(each) if each.form in ("point", "points") else each for each in segment]
        if part is not None and places and segment[places[0]].words.lower().endswith(" one"):
            segment[places[0]] = _name_one(segment[places[0]], part)
            if verb is None and is_plural(
                part.words
            ):  # "its ears twitch, first the left one, then the right one"
                result = [empty(each) if each == part else each for each in result]
        if verb is not None and part is not None and not (places and places[0] < verb):
            at = _find_reference(segment, verb, part, subject, own, names)
            if at is not None:
                again = replace(part, first=segment[verb if at < verb else at].first)
                taken = at < len(segment) and segment[at].form in get_set("pronouns") | get_set("objects")
                segment[at : at + taken] = [again]
                verb += at <= verb and not taken
                places = [at]
        leads = bool(places) and verb is not None and places[0] < verb
        if places and sticks_out(segment[places[0]]):
            part, subject = replace(segment[places[0]]), leads
        if leads and verb is not None and sticks_out(segment[places[0]]):
            segment = _let_droop(segment, places[0], verb)
        before = {each.phrase for each in segment[:verb]} if verb is not None else set()
        own = not leads and bool(before & (names | get_set("pronouns"))) or own and not before
        result += segment
    return result


def sticks_out(mention: Mention) -> bool:
    """Return whether a mention names a part that sticks out of the object, and no end of it."""
    own = mention.value if mention.kind is MentionKind.PLACE else None
    place = own if own == NAMED else LEXICON.parts.get(_get_noun(mention), own)
    return isinstance(place, Place) and bool(place.role) and place.names != ("down",)


def _get_noun(mention: Mention) -> str:
    return mention.phrase.split()[-1]


def _name_one(mention: Mention, part: Mention) -> Mention:
    """The part that "the right one" is, of those that a part before names."""
    side, noun = " ".join(mention.words.split()[:-1]), _get_noun(part)
    noun = noun if noun in LEXICON.part_nouns else noun.removesuffix("s")
    names = mention.value.names if isinstance(mention.value, Place) else ()
    place = Place(names, LEXICON.part_nouns.get(noun, 2 / 3))
    return replace(mention, value=place, words=f"{side} {noun}", phrase=f"{side.lower()} {noun}")


def _hangs(motion: Motion) -> bool:
    return motion.effect is Effect.HOLD and motion.holds == "top"


def _find_reference(
    segment: list[Mention], verb: int, part: Mention, subject: bool, own: bool, names: frozenset[str]
) -> int | None:
    """Index at which a segment without a part goes on with the one before; None if it is of something else.

    Args:
        segment: The mentions between two connectives.
        verb: Index of its verb.
        part: The last part that was named.
        subject: Whether that moved by itself.
        own: Whether the object itself moved it.
        names: Words for the object.
    """
    motion, several = segment[verb].motion, is_plural(part.words)
    moves = motion is not None and (motion.effect in _MOVED or _hangs(motion))
    if not moves or any(each.phrase in names for each in segment):
        return None
    pronouns = [at for at, each in enumerate(segment) if each.form in ("it", "they", "them")]
    if pronouns:
        at = pronouns[0]
        if (segment[at].form != "it") != several:
            return None
        moved = several or at > verb and own and not _has_subject(segment[:verb])
        return at if moved else None
    return verb if subject and not _has_subject(segment[:verb]) else None


def _has_subject(before: list[Mention]) -> bool:
    """Return whether something else than auxiliaries and adverbs stands before a verb."""
    idle = get_set("auxiliaries") | LEXICON.joins.keys() | {"get", "gets", "keep", "keeps", "start", "starts"}
    return any(
        each.kind not in (*LOOSE, MentionKind.JOIN)
        and each.form not in idle
        or each.kind is MentionKind.UNKNOWN
        for each in before
    )


def _let_droop(segment: list[Mention], place: int, verb: int) -> list[Mention]:
    """Makes a droop of the fall of a part, or of its hanging; what it then rests on is no part that moves."""
    motion, between = segment[verb].motion, segment[place + 1 : verb]
    if motion is None or any(each.kind not in _BESIDE for each in between):
        return segment
    if not _hangs(motion) and (
        motion.effect not in (Effect.FALL, Effect.TOPPLE) or motion.lands or motion.manner
    ):
        return segment
    droop = replace(segment[verb], value=LEXICON.motions[_LIMP], phrase=_LIMP)
    rests = (MentionKind.PLACE, MentionKind.SIDES)
    behind = [empty(each) if each.kind in rests else each for each in segment[verb + 1 :]]
    return [*segment[:verb], droop, *behind]
