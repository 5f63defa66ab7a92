"""Things that meet the object: "drop a brick on it", "a ball is thrown at its head", "an anvil lands on the robot".

Nothing else than the object is simulated, so that such a thing is the blow that it gives.
"""

from __future__ import annotations

from dataclasses import replace

from physagent_jax.agents.grammar.mentions import LOOSE, Mention, MentionKind, empty, list_segments
from physagent_jax.agents.grammar.tables import LEXICON, get_set
from physagent_jax.agents.lexicon import Effect

_FLYING = (Effect.FALL, Effect.ROLL, Effect.STRIKE, Effect.JUMP)
_ON, _AT = frozenset(("on", "onto", "upon")), frozenset(("at", "in", "into", "against"))
_BEHIND = 5  # mentions behind the preposition among which the target is


def read_missiles(mentions: list[Mention], names: frozenset[str]) -> list[Mention]:
    """Makes a blow of what another thing does that falls on the object, rolls into it, or is thrown at it."""
    result = list(mentions)
    for begin, end in list_segments(mentions):
        segment = result[begin:end]
        at = next((k for k, m in enumerate(segment) if m.kind is MentionKind.VERB), None)
        motion = None if at is None else segment[at].motion
        if at is None or motion is None:
            continue
        # A hand that pushes on it does not fly into it.
        if motion.effect not in _FLYING and not (motion.effect is Effect.PUSH and motion.generic):
            continue
        hits = next((k for k, m in enumerate(segment) if k > at and m.form in _ON | _AT), None)
        owned = None if hits is None else _find_target(segment[hits + 1 :], names)
        if hits is None or owned is None:
            continue
        free = [*range(at), *range(at + 1, hits)]
        thing = next((k for k in free if _is_thing(segment, k, names, owned)), None)
        if thing is None or any(_is_object(m, names) for m in segment[:hits]):
            continue
        falls = motion.effect is Effect.FALL or segment[hits].form in _ON
        segment[at] = replace(segment[at], value=LEXICON.motions["hit"], phrase="hit", form="hit")
        if falls:
            segment[hits] = replace(segment[hits], kind=MentionKind.DIRECTION, value=("down",), phrase="down")
        result[begin:end] = [
            empty(m) if k == thing or k in free and m.kind in LOOSE[:2] else m for k, m in enumerate(segment)
        ]
    return result


def _is_object(mention: Mention, names: frozenset[str]) -> bool:
    """Return whether a mention is of the object, or of a part."""
    return (
        mention.phrase in names | get_set("pronouns") | get_set("objects")
        or mention.kind is MentionKind.PLACE
    )


def _find_target(behind: list[Mention], names: frozenset[str]) -> bool | None:
    """Return whether the part that is met is "its" own, as of whoever is the subject; None if no object is met."""
    for at, each in enumerate(behind[:_BEHIND]):
        if _is_object(each, names):
            return any(m.form in get_set("pronouns_of_owners") for m in behind[:at])
        if each.kind not in (MentionKind.FUNCTION, *LOOSE):
            return None
    return None


def _is_thing(segment: list[Mention], at: int, names: frozenset[str], owned: bool) -> bool:
    """Return whether a mention is a noun for another thing: one that is known, or after "a" any that is not."""
    noun = segment[at]
    if noun.phrase in LEXICON.agents | {"something"} and noun.phrase not in names:
        return True
    before = next((m for m in reversed(segment[:at]) if m.kind not in LOOSE), None)
    last = at + 1 == len(segment) or segment[at + 1].kind not in LOOSE
    new = before is not None and before.form in ("a", "an", "another")
    return noun.kind is MentionKind.UNKNOWN and last and new and not owned
