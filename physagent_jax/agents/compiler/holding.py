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
        if last is not None and meaning.stays and meaning.bare and _has_effect(last, _get_effect(meaning)):
            last.stays = True  # "compress it and keep it compressed"
            continue
        if _hangs_in_the_air(meaning, last):
            if _has_effect(follows, Effect.FALL):
                continue  # "thrown up, it hangs there and falls": so does all that turns back
            meaning = _wait(meaning)
        if not _is_bare_hold(meaning) or held is not None:
            result.append(meaning)
            continue
        moved = last is not None and not last.clause.negated and _has_effect(last, *_HOLDABLE)
        let_go = _has_effect(follows, Effect.RELEASE) and follows is not None and follows.bare
        timed = meaning.timing != intent.Timing()
        if moved and last is not None and let_go and last.timing == intent.Timing():
            last.timing = meaning.timing  # "hold it for a second, then release it"
        elif follows is not None and timed:
            result.append(_wait(meaning))  # "hold it for a second, then"
        elif moved and last is not None and meaning.clause.order != "together":
            last.stays = follows is None
        elif not _has_effect(follows, Effect.FALL, Effect.RELEASE):
            result.append(meaning)
    return result


def choose_anchor(told: intent.Held | None, meanings: list[Meaning]) -> AnchorRequest:
    """Choose the hold: an adjective ("rooted"), a motion ("hold the pot"), or an end that "does not move"."""
    if told is not None:
        return AnchorRequest(kind=told.end, words=told.text, described=told.described)
    for meaning in meanings:
        motion, negated = meaning.motion, meaning.clause.negated
        if motion is not None and motion.effect is Effect.HOLD:
            end = "none" if negated else _find_held_end(meaning, motion.holds)
            return AnchorRequest.model_validate({"kind": end, "words": meaning.text})
        if keeps_end(meaning, meanings):
            return AnchorRequest.model_validate(
                {"kind": _find_held_end(meaning, None), "words": meaning.text}
            )
    return AnchorRequest()


def keeps_end(meaning: Meaning, meanings: list[Meaning]) -> bool:
    """Return whether a clause says of an end that it is still while the rest moves."""
    still = _has_effect(meaning, Effect.STILL) and not meaning.clause.negated
    beside = meaning is meanings[0] or meaning.clause.order != "then"
    return still and beside and _find_held_end(meaning, None) is not None


def _find_held_end(meaning: Meaning, otherwise: str | None) -> str | None:
    """The end that a clause names: "base" or "top"; other parts cannot be held."""
    for part in meaning.parts:
        if "down" in part.place.names:
            return "base"
        return "top" if "up" in part.place.names else None
    return otherwise


def _get_effect(meaning: Meaning) -> Effect:
    assert meaning.motion is not None
    return meaning.motion.effect


def _has_effect(meaning: Meaning | None, *effects: Effect) -> bool:
    return meaning is not None and meaning.motion is not None and meaning.motion.effect in effects


def _is_bare_hold(meaning: Meaning) -> bool:
    """Return whether a clause only holds the object."""
    holds = (
        _has_effect(meaning, Effect.HOLD) and meaning.motion is not None and meaning.motion.holds == "base"
    )
    return holds and not meaning.parts and not meaning.clause.negated


def _hangs_in_the_air(meaning: Meaning, last: Meaning | None) -> bool:
    """Return whether what hangs has just been moved, and nothing is told that it hangs from."""
    if meaning.phrase != "hang" or meaning.clause.negated or meaning.clause.order == "together":
        return False
    if last is None or last.clause.negated or meaning.pick(WayKind.FROM, WayKind.PLANE):
        return False
    return _has_effect(last, *_RISING)


def _wait(meaning: Meaning) -> Meaning:
    """The same for a time in which nothing moves."""
    return replace(meaning, verb=read_lexicon().motions["wait"], phrase="wait", cause=None)
