"""Poses: how the object is turned as it falls, or lies in the end, and what it only comes to stand on.

"Drop it upside down", "onto its leaves" and "nose first" tell how it is turned before it falls. "Lands face down" and
"falls on its back" tell where it tips over to. What it "ends up on" after any other motion ("on its wheels") is no part
that is moved.
"""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.grammar.mentions import MOTIONS, WAYS, Mention, MentionKind, empty, get_last_motion
from physagent_jax.agents.grammar.tables import LEXICON, get_set, read_sections
from physagent_jax.agents.intent import Quantity
from physagent_jax.agents.lexicon import Effect, Place

_NOUNS = (MentionKind.PLACE, MentionKind.UNKNOWN, MentionKind.DIRECTION)
_NOUNS += (MentionKind.PLANE, MentionKind.FUNCTION)
_OVERTURNING = (Effect.LEAN, Effect.PUSH, Effect.STRIKE, Effect.TURN, Effect.ROLL, Effect.FALL, Effect.TOPPLE)
_OVER = 180.0  # [degrees]
_SET = dict(up="put upside down", down="put ~ the right way up")
_SET |= dict.fromkeys(("toward", "away", "left", "right", "beside"), "put on its side")
_ENDING = (Effect.TURN, Effect.ROLL, Effect.JUMP, Effect.TOPPLE, Effect.FALL)


def read_poses(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Tells poses of falls from parts, and empties what else comes to stand on: "rolls and ends up on its wheels"."""
    result, verbs = list(mentions), []
    for at, mention in enumerate(mentions):
        if mention.motion is not None and mention.phrase != "upside down":
            lands = mention.phrase.startswith(("land on", "land upside"))
            if lands and _find_drop(mentions, verbs) is not None:
                side = mention.motion.direction if mention.motion.effect is Effect.TOPPLE else "up"
                result[at] = replace(mention, kind=MentionKind.POSE, value=side, phrase="pose")
            else:
                verbs.append(at)
            continue
        first, side = _find_side(mentions, at)
        motion = mentions[verbs[-1]].motion if verbs else None
        if side is None or motion is None:
            continue
        places = any(each.kind is MentionKind.PLACE for each in mentions[verbs[-1] : first])
        lowers = motion.puts_back or mentions[verbs[-1]].phrase == "lower"
        if lowers and side in _SET and not places:
            phrase, result[first : at + 1] = _SET[side], map(empty, mentions[first : at + 1])
            told = LEXICON.motions[phrase]
            told = replace(told, direction=side) if told.effect is Effect.TOPPLE else told
            result[verbs[-1]] = replace(mentions[verbs[-1]], value=told, phrase=phrase)
            continue  # "put it back on the table on its side"
        if mention.phrase == "upside down" and motion.generic and motion.effect is Effect.PUSH:
            result[at] = replace(mention, kind=MentionKind.UNKNOWN, value=None)  # "it flies upside down"
        if (fall := _find_drop(mentions, verbs)) is not None:
            told = any(m.kind is MentionKind.POSE for m in result[fall:at])
            result[first : at + 1] = map(empty, mentions[first : at + 1])
            if side and not told:
                result[at] = replace(mention, kind=MentionKind.POSE, value=side, phrase="pose")
            if motion.lands or motion.effect is Effect.STILL:  # "so that it lands on its head"
                result[verbs[-1]] = empty(mentions[verbs[-1]])
        elif first < at and mention.phrase not in read_sections()["lying"] and motion.effect in _ENDING:
            back = first > 0 and mentions[first - 1].phrase == "back"
            result[first - back : at + 1] = map(empty, mentions[first - back : at + 1])
            if side == "askew" and motion.lands:
                result[at] = replace(mention, kind=MentionKind.POSE, value=side, phrase="pose")
            foot = LEXICON.parts.get(mention.form)
            if foot is not None and (foot.names == ("down",) or foot.role.startswith("leg")):
                _turn_round(result, verbs)
    return result


def _turn_round(mentions: list[Mention], verbs: list[int]) -> None:
    """Makes a whole turn of what turns over and stands again: "flips over and lands on its wheels" is no fall."""
    done = [mentions[at].motion for at in verbs]
    lands = done[-1] is not None and done[-1].lands
    turns = next((at for at in reversed(verbs) if (m := mentions[at].motion) and not m.lands), None)
    motion = mentions[turns].motion if turns is not None else None
    if turns is None or motion is None or motion.effect is not Effect.TURN or motion.direction != "own":
        return
    if motion.angle == _OVER:
        mentions[turns] = replace(mentions[turns], value=LEXICON.motions["roll over"], phrase="roll over")
    if lands and not any(each is not None and each.gravity for each in done):
        mentions[verbs[-1]] = empty(mentions[verbs[-1]])


def _find_side(mentions: list[Mention], at: int) -> tuple[int, str | None]:
    """The first mention of a pose that ends at ``at`` and its side; "" = a side that is not known, None = no pose."""
    mention = mentions[at]
    if mention.kind is MentionKind.POSE:
        return at, str(mention.value)
    if mention.phrase == "upside down":
        return at, "up"
    first = at - 1
    ends = all(each.form != "of" for each in mentions[at + 1 : at + 2])
    if first > 0 and mentions[first].form == "the" and mention.phrase == "side" and ends:
        first -= 1  # "it falls on the side"
    # "On a corner", "on one of its edges".
    edge = mention.phrase.split()[-1].removesuffix("s") in get_set("edges")
    owners = get_set("owners_of_feet") | (get_set("determiners") | {"one"} if edge else set())
    while first > 0 and mentions[first].form in owners:
        first -= 1  # "on all four of its feet"
    if first in (0, at - 1) or mentions[first].form not in ("on", "onto") or mention.kind not in _NOUNS:
        return at, None
    if (side := read_sections()["lying"].get(mention.phrase)) is not None:
        return first, side
    side = "askew" if edge else " ".join(mention.value.names) if isinstance(mention.value, Place) else ""
    return first, side if side in ("up", "down", "toward", "away", "left", "right", "askew") else ""


def _find_drop(mentions: list[Mention], verbs: list[int]) -> int | None:
    """Index of the fall through the air that the last verb is, or is the end of; what stands and falls tips over."""
    last = mentions[verbs[-1]].motion if verbs else None
    for at in reversed(verbs):
        motion = mentions[at].motion
        if motion is not None and motion.effect is Effect.STILL and motion.generic and at != verbs[0]:
            continue  # "drop it so that it ends up lying on its side"
        if motion is None or motion.effect is not Effect.FALL or motion.gives:
            return None
        aloft = motion.topples and _is_from_above(mentions, at)
        if aloft or not (motion.topples or motion.lands or motion.bounces):
            return at
        if not (motion.lands and last is not None and last.lands):
            return None
    return None


def _is_from_above(mentions: list[Mention], fall: int) -> bool:
    """Return whether the words behind a fall tell from how high it is: "falls from 3 metres on its nose"."""
    end = next((at for at in range(fall + 1, len(mentions)) if mentions[at].kind in MOTIONS), None)
    return any(
        isinstance(each.value, Quantity)
        and each.value.unit in ("metres", "lengths")
        or each.kind is MentionKind.GRAVITY
        and each.form == "from"
        or each.phrase == "above"
        for each in mentions[fall:end]
    )


def read_landings(mentions: list[Mention], _names: frozenset[str]) -> list[Mention]:
    """Makes a toppling of what ends on a side: "it falls on its back", "push it so that it lies on its side".

    How an object lies while it goes is no part that is moved: "it slides to the left on its back".
    """
    result, verbs, ways = list(mentions), [], []
    for at, side in enumerate(mentions):
        if side.motion is not None and side.phrase != "flat":  # "flat on its back"
            verbs.append(at)
        ways += [at] if side.kind in WAYS else []
        first, way = _find_side(result, at)
        told = side.kind is MentionKind.POSE or side.phrase in read_sections()["lying"]
        if not verbs or not told or way not in read_sections()["lying"].values() or first <= verbs[-1]:
            continue
        if _find_drop(mentions, verbs) is not None:
            continue
        on = mentions[first]
        lies = mentions[verbs[-1]].phrase == "lie" and len(verbs) > 1
        moving = [at for at in verbs[:-1] if (m := mentions[at].motion) and m.effect is not Effect.STILL]
        lies = lies and bool(moving)  # "tips over and stays lying on its face"
        acts = moving[-1] if lies else verbs[-1]
        verb, motion = mentions[acts], get_last_motion(mentions[: acts + 1])
        effect = None if motion is None else motion.effect
        overturns = effect in _OVERTURNING and (lies or on.form != "on") or effect is Effect.TOPPLE
        if overturns or verb.phrase in get_set("landing"):
            for place in range(acts + 1, at):
                if place == first or mentions[place].phrase in ("flat", "lie"):
                    result[place] = empty(mentions[place])
            result[acts] = replace(verb, value=LEXICON.motions["topple"], phrase="topple")
            # "over to the right, so that it lies on its side"
            known = side.phrase == "side" and bool(ways)
            lying = replace(side, kind=MentionKind.DIRECTION, value=(way,), phrase="to lie on a side")
            result[at] = empty(side) if known else lying
        elif on.form == "on" and motion is not None and motion.generic and way in ("away", "toward"):
            result[at] = empty(side)
    return result
