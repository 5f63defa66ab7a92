"""Outcomes: what a motion is for, what it leads to, and how the object comes to rest, none of which is a motion.

"Bend it to touch its toes", "lift it so that its feet leave the ground", "melt it, leaving a low heap", "it ends up
lying flat".
"""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.grammar.mentions import (
    LOOSE,
    MOTIONS,
    WAYS,
    Mention,
    MentionKind,
    empty,
    get_last_motion,
    get_phrase,
    has_motion,
    ignore,
    list_segments,
)
from physagent_jax.agents.grammar.tables import LEXICON, get_set, read_sections
from physagent_jax.agents.lexicon import Effect, Join

_STRANGE = (MentionKind.UNKNOWN, MentionKind.IGNORED)
_BESIDE = (MentionKind.FUNCTION, MentionKind.PLACE, *LOOSE)
_AIMING = ("point", "look", "face", "facing")
_RESTING = (Effect.STILL, Effect.TOPPLE)


def read_outcomes(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Ignores a purpose ("to touch its toes") and what only comes of a motion: "so its feet leave the ground"."""
    result = list(mentions)
    for begin, end in list_segments(mentions):
        first, last = _find_outcome(result, begin, end)
        result[first:last] = map(ignore, mentions[first:last])
    return result


def _find_outcome(mentions: list[Mention], begin: int, end: int) -> tuple[int, int]:
    """The span of an outcome in a segment."""
    segment = mentions[begin:end]
    comes = _is_leaving_ground(segment) or _is_becoming(segment) or _is_left_over(segment)
    comes |= get_phrase(mentions, begin - 1) in ("that", "so much") and _is_strangers(
        mentions[begin - 1 : end]
    )
    if _is_result(mentions, begin) and comes:
        return begin, end
    for at in range(begin, end):
        if _is_dangling(mentions, at):
            return at, at + 2
        if _begins_outcome(mentions, begin, at, end):
            behind = range(at + 1, end)
            return at, next((place for place in behind if mentions[place].kind not in _BESIDE), end)
    return end, end


def _is_result(mentions: list[Mention], begin: int) -> bool:
    """Return whether a segment that begins there says what the motion before it leads to."""
    return begin > 0 and mentions[begin - 1].value is Join.RESULT and has_motion(mentions[:begin])


def _is_dangling(mentions: list[Mention], at: int) -> bool:
    """Return whether a part hangs as it does by itself from what is lifted: "lift it and let its legs dangle"."""
    part, hangs = mentions[at], mentions[at + 1].motion if at + 1 < len(mentions) else None
    if part.kind is not MentionKind.PLACE or hangs is None or hangs.effect is not Effect.HOLD:
        return False
    last = max((i for i in range(at) if mentions[i].motion is not None), default=None)
    lift = None if last is None else mentions[last].motion
    lifted = lift is not None and lift.effect is Effect.PUSH and lift.direction == "up" and not lift.manner
    return hangs.holds == "top" and lifted and not any(m.kind is MentionKind.PLACE for m in mentions[last:at])


def read_aims(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Makes a way of what a motion is to point at, unless one is told: "bend it until it points at the sky"."""
    result = list(mentions)
    for begin, end in list_segments(mentions):
        ways = [at for at in range(begin, end) if mentions[at].kind is MentionKind.DIRECTION]
        aims = [at for at in ways if mentions[at].phrase.startswith(_AIMING)]
        if not aims:
            continue
        last = max((at for at in range(begin) if mentions[at].motion is not None), default=begin)
        told, verb = {mention.kind for mention in mentions[last:begin]}, mentions[last].motion
        follows = _is_result(mentions, begin)
        aside = mentions[aims[0]].form.endswith("ing") or has_motion(mentions[:end])
        if follows and told & {*WAYS}:
            result[begin:end] = map(empty, mentions[begin:end])
        elif not follows and aside:  # "it rises, looking at the sky"
            for at in aims:
                result[at] = empty(mentions[at])
        elif MentionKind.PLACE in told:
            parts = (at for at in range(begin, end) if mentions[at].kind is MentionKind.PLACE)
            for at in parts:
                result[at] = empty(mentions[at])  # "tip its head until its face points at the ceiling"
        elif not follows or verb is not None and verb.effect in (Effect.LEAN, Effect.TURN):
            for at in aims:  # which end of it is to point there, is not said
                result[at] = replace(mentions[at], kind=MentionKind.UNKNOWN, phrase=mentions[at].form)
    return result


def _begins_outcome(mentions: list[Mention], begin: int, at: int, end: int) -> bool:
    """Return whether a purpose, or what is left, begins at ``at`` in a segment: "to touch", "leaving a heap"."""
    form = mentions[at].form
    if form not in get_set("leading_to") and form != "to":
        return False
    before = get_last_motion(mentions[:at] if at == begin else mentions[begin:at])
    if before is None or before.generic:
        return False
    if form != "to":
        told = {mention.kind for mention in mentions[at:end]}
        return not told & {MentionKind.PLACE, *MOTIONS, *WAYS}
    aim = mentions[at + 1] if at + 2 < end else None
    if aim is None:
        return False
    strange = aim.kind is MentionKind.UNKNOWN and aim.phrase not in get_set("paths") | get_set("worlds")
    return strange and not aim.form.endswith("s") or aim.form in get_set("aims")


def _is_leaving_ground(segment: list[Mention]) -> bool:
    """Return whether a part comes off the ground, as it does by itself: "so the front wheels leave the ground"."""
    forms = {mention.form for mention in segment}
    kinds = {mention.kind for mention in segment}
    plain = MentionKind.PLACE in kinds and kinds <= {*_BESIDE, *WAYS}
    return plain and bool(forms & get_set("leaving")) and bool(forms & (LEXICON.ground | {"table"}))


def _is_strangers(segment: list[Mention]) -> bool:
    """Return whether a part nobody knows is what moves: "so hard that his bum wiggles along with it"."""
    verb = next((at for at, each in enumerate(segment) if each.motion is not None), len(segment))
    kinds = {each.kind for each in segment[:verb]}
    owned = not {each.form for each in segment[:2]}.isdisjoint(get_set("owners_of_parts"))
    return owned and MentionKind.UNKNOWN in kinds and MentionKind.PLACE not in kinds


def _is_left_over(segment: list[Mention]) -> bool:
    """Return whether a segment tells what is still seen in the end: "until only the roof sticks out"."""
    moved = [each.motion for each in segment if each.motion is not None]
    only = any(each.form in ("only", "just") for each in segment[:2])
    return only and all(motion.effect in (Effect.HOLD, Effect.STILL) for motion in moved)


def _is_becoming(segment: list[Mention]) -> bool:
    """Return whether a segment tells a look that comes of a motion: "so that its round opening turns oval"."""
    if len(segment) < 2 or segment[-2].form not in get_set("becoming"):
        return False
    word = segment[-1]
    sized = word.form in read_sections()["results"] or word.form.endswith("ing")
    return word.kind in _STRANGE and not sized


def read_ends(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Empties how something stands or lies at rest: "it comes to rest level", "ends up lying flat"."""
    result = list(mentions)
    motion, lies = None, None
    for at, mention in enumerate(mentions):
        flat = mention.phrase == "flat" and mention.motion is not None
        if mention.kind is MentionKind.JOIN:
            leans = motion is not None and motion.effect is Effect.LEAN
            motion, lies = motion if leans else None, None
        elif motion is not None and (flat or mention.form in get_set("ends_of_rest")):
            if motion.effect in _RESTING or motion.lands or flat and motion.topples:
                result[at] = empty(mention)
            if flat and lies is not None and not has_motion(mentions[:lies]):  # "it lies flat"
                result[lies] = replace(mentions[lies], value=LEXICON.motions["lie down"], phrase="lie down")
        elif mention.motion is not None:
            back = mention.phrase.startswith("settle back")
            # "Tilt it, then it settles back level".
            if back and motion is not None and motion.effect is Effect.LEAN:
                result[at] = replace(mention, value=LEXICON.motions["return"], phrase="return")
            motion, lies = mention.motion, at if mention.phrase == "lie" else None
    return result


def read_tumbles(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Turns over what spins or is thrown "end over end": no top does that."""
    result: list[Mention] = []
    last: int | None = None
    for mention in mentions:
        over = mention.motion is not None and mention.motion.generic and mention.motion.tumbles
        verb = None if last is None else result[last].motion
        last = len(result) if mention.motion is not None and not over else last
        if not over or last is None or verb is None:
            result.append(mention)
        elif verb.effect is Effect.TURN and not verb.tumbles:
            result[last] = replace(result[last], value=LEXICON.motions["tumble"], phrase="tumble")
            result.append(empty(mention))
        elif verb.gravity or verb.effect is Effect.FALL:
            result.append(replace(mention, kind=MentionKind.JOIN, value=Join.WHILE, phrase="while"))
            result.append(replace(mention, value=LEXICON.motions["tumble"], phrase="tumble"))
        else:
            result.append(mention)
    return result
