"""The reason of a FAIL in one plain sentence."""

from __future__ import annotations

from collections.abc import Sequence

from physagent_jax.motion.judging.comparing import read_words
from physagent_jax.motion.schema import Check

_REASONS = {
    "direction": "goes another way than the sentence says",
    "repeats": "is not seen as often as the sentence says",
    "return": "does not end as it should: it comes back where it should stay, or stays where it should come back",
    "stillness": "is not still",
    "part": "is not done by the named part alone: the rest moves too",
    "order": "does not come at its time",
}
_BESIDE = {
    "collateral": "something else that nobody asked for hides or contradicts it",
    "integrity": "the object does not hold together",
}


def explain_failure(
    failed: Sequence[Check], unseen: Sequence[Check], words: Sequence[str], *, motionless: bool = False
) -> str:
    """Explain why a clip is no success, for people; empty where nothing failed and all was seen.

    That it falls to pieces goes before what was asked, that before what else happens, and its direction before its
    amount.

    Args:
        failed: The checks that failed, the worst first.
        unseen: The checks that could not be made.
        words: The sentence's words for each expected motion.
        motionless: Whether nothing is seen to move in the whole clip.
    """
    broken = [each for each in failed if each.aspect == "integrity"]
    own = broken or [each for each in failed if each.aspect not in _BESIDE] or failed
    check = next((each for each in own if each.aspect == "direction"), None) or next(iter(own), None)
    if check is not None:
        asked = words[check.expectation] and f"'{words[check.expectation]}'"
        if motionless:
            return f"Nothing moves, although the sentence asks for {asked or 'a motion'}."
        return _explain(check, asked or "The motion")
    if unseen:
        asked = f"'{words[unseen[0].expectation]}'" if words[unseen[0].expectation] else "the motion"
        return f"It cannot be told from the pictures whether {asked} came true."
    return ""


def _explain(check: Check, asked: str) -> str:
    beside = _BESIDE.get(check.aspect)
    if beside is not None:
        seen = next(
            (each.get("plain", "") for each in read_words().values() if each["question"] == check.question),
            "",
        )
        return f"{asked} may be there, but {beside}{seen and f': {seen}'}."
    if check.aspect in _REASONS:
        return f"{asked} {_REASONS[check.aspect]}."
    gain = check.gain
    if gain is None:
        return f"{asked} is not seen as the sentence says."
    if gain < 0:
        return f"{asked} goes the wrong way."
    return f"{asked} is seen too {'little' if gain > 1 else 'much'}."
