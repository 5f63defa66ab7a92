"""The scopes of "from", "except", "not" and "held"."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.rules.language import modifiers as m
from physagent_jax.agents.rules.language import verbs as v
from physagent_jax.agents.grammar.clauses import OPPOSITES
from physagent_jax.agents.grammar.mentions import Mention, MentionKind, empty
from physagent_jax.agents.rules.language.reader import OWNING
from physagent_jax.agents.grammar.tokens import is_participle

_ORIGINS = frozenset(
    {"left", "right", "top", "bottom", "front", "back", "above", "below", "behind", "beneath"}
)


def spread_from(mentions: list[Mention]) -> list[Mention]:
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
        listing = mention.kind is MentionKind.FROM or listing and (joins or mention.phrase in OWNING)
        result.append(mention)
    return result


def mark_exceptions(mentions: list[Mention]) -> list[Mention]:
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
        said = any(e.kind is MentionKind.VERB for e in mentions[:at])
        does = after is not None and after.kind is MentionKind.VERB
        return None if said and does else behind  # "all of it is still, but the top sways"
    return behind if negated and (after is None or after.kind is MentionKind.JOIN) else None


def read_delays(mentions: list[Mention]) -> list[Mention]:
    """Makes one order of "it does not fall until it is pushed" and "it falls after it is pushed"."""
    result = list(mentions)
    for at, mention in enumerate(mentions):
        if mention.kind is MentionKind.JOIN and _is_earlier(mentions, at):
            result[at] = replace(mention, value=m.Join.AFTER, phrase="after")
        if mention.phrase != "until" or mention.kind is not MentionKind.JOIN:
            continue
        before, behind = mentions[:at], mentions[at + 1 :]
        verbs = [i for i, e in enumerate(before) if e.kind is MentionKind.VERB]
        joins = [i for i, e in enumerate(before) if e.kind is MentionKind.JOIN]
        denials = [i for i, e in enumerate(before) if e.kind is MentionKind.NOT]
        denied = denials and verbs and denials[-1] < verbs[-1] and denials[-1] > (joins or [-1])[-1]
        happens = any(e.kind is MentionKind.VERB for e in behind)
        verb = mentions[next(i for i in verbs if i > denials[-1])].value if denied else None
        if denied and happens and isinstance(verb, v.Verb) and not verb.generic:
            if verb.effect not in (v.Effect.STILL, v.Effect.RELEASE, v.Effect.HOLD):
                result[denials[-1]] = empty(mentions[denials[-1]])
                result[at] = replace(mention, value=m.Join.AFTER, phrase="after")
    return result


def _is_earlier(mentions: list[Mention], at: int) -> bool:
    """Return whether what stands behind came first: "lift it, having pushed it left", "push it, but lift it first"."""
    done = any(e.kind is MentionKind.VERB for e in mentions[:at])
    behind = mentions[at + 1 :]
    end = next((i for i, e in enumerate(behind) if e.kind is MentionKind.JOIN), len(behind))
    segment = behind[:end]
    does = any(e.kind is MentionKind.VERB for e in segment)
    having = mentions[at].words == "," and bool(segment) and segment[0].form == "having"
    first = mentions[at].value is m.Join.BUT and bool(segment) and segment[-1].form == "first"
    return done and does and (having or first)


def read_returns(mentions: list[Mention]) -> list[Mention]:
    """Makes steps of "turn it over and back", "up 10 cm and back down": there, then back."""
    result = list(mentions)
    for at, mention in enumerate(mentions):
        if mention.kind is not MentionKind.REPEAT or mention.phrase not in ("and back", "and back again"):
            continue
        verb = next((e.value for e in reversed(mentions[:at]) if e.kind is MentionKind.VERB), None)
        turns = isinstance(verb, v.Verb) and verb.effect is v.Effect.TURN
        told = at + 1 < len(mentions) and mentions[at + 1].kind is MentionKind.DIRECTION
        turns = turns or not told and _is_swinging_by_steps(mentions[:at])
        if told or turns:
            result[at] = replace(mention, kind=MentionKind.JOIN, value=m.Join.THEN, phrase="then")
        if turns and not told:
            back = replace(mention, kind=MentionKind.DIRECTION, value=("away",), phrase="back", words="back")
            return [*result[: at + 1], back, *result[at + 1 :]]
    return result


def _is_swinging_by_steps(mentions: list[Mention]) -> bool:
    """Return whether a measured way is followed by one against it: "left by a half, then right by a half, and back"."""
    ways = [e.value for e in mentions if e.kind is MentionKind.DIRECTION]
    steps = any(e.kind is MentionKind.JOIN and e.value is m.Join.THEN for e in mentions)
    measured = sum(e.kind is MentionKind.QUANTITY for e in mentions)
    return (
        steps
        and measured > 1
        and len(ways) > 1
        and any({ways[-2], ways[-1]} == set(pair) for pair in OPPOSITES)
    )


def part_substitutes(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """Ends what is not done before what is: "instead of moving left the robot jumps"."""
    result = list(mentions)
    for at, mention in enumerate(mentions[:-1]):
        denied = mention.kind is MentionKind.NOT and mention.phrase in ("instead of", "rather than")
        if not denied or not is_participle(mentions[at + 1].form):
            continue
        for behind in range(at + 2, len(mentions) - 1):
            if mentions[behind].kind is MentionKind.JOIN:
                break
            subject = mentions[behind].phrase in names | {"it", "he", "she"}
            if subject and mentions[behind + 1].kind is MentionKind.VERB:
                result.insert(
                    behind, replace(mention, kind=MentionKind.JOIN, value=m.Join.COMMA, phrase=",", words=",")
                )
                break
    return result


def drop_asides(mentions: list[Mention]) -> list[Mention]:
    """Empties parts and ways that belong to something else than what is done.

    "Its feet planted" tells what is held, "away from the wind" which way the wind blows, and "not only the head but all
    of it" that it is more than the head.
    """
    result = list(mentions)
    for at, mention in enumerate(mentions):
        after = next((e for e in mentions[at + 1 :] if e.kind is not MentionKind.FUNCTION), None)
        if isinstance(mention.value, m.Place) and mention.kind is MentionKind.PLACE:
            held = after is not None and after.kind is MentionKind.ANCHOR and after.value == "base"
            if (
                held
                and mention.value.names == ("down",)
                or _is_outdone(mentions, at)
                or _is_spared(mentions, at)
            ):
                result[at] = empty(mention)
        elif mention.kind is MentionKind.ANCHOR and mention.form in ("free", "loose"):
            if after is not None and isinstance(after.value, m.Place):
                result[at] = empty(mention)  # "the free end"
        elif mention.kind is MentionKind.INTENSITY and mention.form == "low" and _is_leaning(mentions, at):
            result[at] = empty(mention)  # "it bows low"
        elif mention.kind is MentionKind.INTENSITY and mention.form == "high" and _is_way(mentions, at):
            result[at] = replace(mention, kind=MentionKind.DIRECTION, value=("up",), phrase="up")
        elif mention.kind is MentionKind.DIRECTION and mention.phrase == "away":
            from_it = any(e.form == "from" for e in mentions[at + 1 : at + 2])
            if from_it and after is not None and isinstance(after.value, v.Verb) and after.value.wind:
                result[at] = empty(mention)
            elif not from_it and _is_blown_off(mentions[:at]):
                result[at] = empty(mention)
    return result


def _is_blown_off(before: list[Mention]) -> bool:
    """Return whether a wind whose side is told blows it "away": off, wherever that is."""
    sided = any(e.kind is MentionKind.FROM and e.value in (("left",), ("right",)) for e in before)
    return sided and any(isinstance(e.value, v.Verb) and e.value.wind for e in before)


def _is_spared(mentions: list[Mention], at: int) -> bool:
    """Return whether "instead of" stands before what is not done to a part: it is not held either."""
    segment = []
    for mention in reversed(mentions[:at]):
        if mention.kind is MentionKind.JOIN:
            break
        segment.append(mention)
    denied = [e for e in segment if e.kind is MentionKind.NOT]
    return bool(denied) and denied[0].phrase in ("instead of", "rather than")


def _is_leaning(mentions: list[Mention], at: int) -> bool:
    """Return whether a verb of leaning stands just before."""
    verb = mentions[at - 1].value if at else None
    return isinstance(verb, v.Verb) and verb.effect is v.Effect.LEAN


def _is_way(mentions: list[Mention], at: int) -> bool:
    """Return whether "high" stands beside a way: "high and to the right", "to the left and high"."""
    joins = [i for i in (at - 1, at + 1) if 0 <= i < len(mentions) and mentions[i].phrase == "and"]
    ends = at + 1 == len(mentions) or mentions[at + 1].kind is MentionKind.JOIN
    if not joins or not ends:
        return False
    beside = mentions[at + 2 : at + 5] if joins[0] > at else mentions[max(at - 3, 0) : at - 1]
    return any(e.kind is MentionKind.DIRECTION for e in beside)


def _is_outdone(mentions: list[Mention], at: int) -> bool:
    """Return whether "not only" stands before a part and "but all" behind it."""
    only = any(e.phrase == "not only" for e in mentions[max(at - 3, 0) : at])
    behind = [e.phrase for e in mentions[at + 1 : at + 6]]
    return only and "but" in behind and bool({*behind} & m.WHOLE_WORDS)
