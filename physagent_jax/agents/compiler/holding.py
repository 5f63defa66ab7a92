"""Held things: a hold keeps what was just done, or it anchors the object."""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents import intent
from physagent_jax.agents.compiler.words import Meaning, WayKind
from physagent_jax.agents.lexicon import Effect, read_lexicon
from physagent_jax.agents.schema import AnchorRequest

_HOLDABLE = (Effect.PUSH, Effect.LEAN, Effect.SCALE, Effect.SWELL, Effect.TURN)
_RISING = (Effect.PUSH, Effect.STRIKE, Effect.JUMP)


def apply_holding(meanings: list[Meaning], held: intent.Held | None) -> list[Meaning]:
    """Holding what was just moved keeps it there; holding what is then let go is no anchor."""
    result: list[Meaning] = []
    for index, meaning in enumerate(meanings):
        last = result[-1] if result else None
        follows = next((each for each in meanings[index + 1 :] if not each.clause.negated), None)
        alike = last is not None and last.motion and meaning.has_effect(last.motion.effect)
        if last is not None and meaning.stays and meaning.is_bare and alike:
            last.stays = True  # "compress it and keep it compressed"
            continue
        if _hangs_in_the_air(meaning, last):
            if follows is not None and follows.has_effect(Effect.FALL):
                continue  # "thrown up, it hangs there and falls": so does all that turns back
            meaning = _wait(meaning)
        if _is_bare_hold(meaning) and held is None:
            result += _hold(meaning, last, follows)
        else:
            result.append(meaning)
    return result


def _hold(meaning: Meaning, last: Meaning | None, follows: Meaning | None) -> list[Meaning]:
    """A bare hold as an anchor, as a time of rest, or (nothing) as a property of what was done before."""
    timed = meaning.timing != intent.Timing()
    moved = last is not None and not last.clause.negated and last.has_effect(*_HOLDABLE)
    let_go = follows is not None and follows.has_effect(Effect.RELEASE) and follows.is_bare
    if moved and last is not None and let_go and last.timing == intent.Timing():
        last.timing = meaning.timing  # "hold it for a second, then release it"
    elif follows is not None and timed:
        return [_wait(meaning)]  # "hold it for a second, then"
    elif moved and last is not None and meaning.clause.order != "together":
        last.stays = follows is None
    elif follows is None or not follows.has_effect(Effect.FALL, Effect.RELEASE):
        return [meaning]
    return []


def choose_anchor(told: intent.Held | None, meanings: list[Meaning]) -> AnchorRequest:
    """Choose the hold: an adjective ("rooted"), a motion ("hold the pot"), or an end that "does not move"."""
    if told is not None:
        return AnchorRequest(kind=told.end, words=told.text, described=told.described)
    for meaning in meanings:
        motion = meaning.motion
        if motion is not None and motion.effect is Effect.HOLD:
            end = "none" if meaning.clause.negated else _find_held_end(meaning, motion.holds)
        elif keeps_end(meaning, meanings):
            end = _find_held_end(meaning, None)
        else:
            continue
        return AnchorRequest.model_validate({"kind": end, "words": meaning.text})
    return AnchorRequest()


def keeps_end(meaning: Meaning, meanings: list[Meaning]) -> bool:
    """Return whether a clause says of an end that it is still while the rest moves."""
    still = meaning.has_effect(Effect.STILL) and not meaning.clause.negated
    beside = meaning is meanings[0] or meaning.clause.order != "then"
    return still and beside and _find_held_end(meaning, None) is not None


def _find_held_end(meaning: Meaning, otherwise: str | None) -> str | None:
    """The end that a clause names: "base" or "top"; other parts cannot be held."""
    if not meaning.parts:
        return otherwise
    names = meaning.parts[0].place.names
    return "base" if "down" in names else "top" if "up" in names else None


def _is_bare_hold(meaning: Meaning) -> bool:
    """Return whether a clause only holds the object."""
    motion = meaning.motion
    holds = motion is not None and motion.effect is Effect.HOLD and motion.holds == "base"
    return holds and not meaning.parts and not meaning.clause.negated


def _hangs_in_the_air(meaning: Meaning, last: Meaning | None) -> bool:
    """Return whether what hangs has just been moved, and nothing is told that it hangs from."""
    if meaning.phrase != "hang" or meaning.clause.negated or meaning.clause.order == "together":
        return False
    if last is None or last.clause.negated or meaning.pick(WayKind.FROM, WayKind.PLANE):
        return False
    return last.has_effect(*_RISING)


def _wait(meaning: Meaning) -> Meaning:
    """The same for a time in which nothing moves."""
    return replace(meaning, verb=read_lexicon().motions["wait"], phrase="wait", cause=None)
