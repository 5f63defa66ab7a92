"""Motions that were read of a sentence, held against each other: what no sentence means in one breath.

Two motions at once that no word joins, the same motion twice, and a held end that leaves its place are traces of words
that were read twice or in the wrong clause.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from physagent_jax.agents.rules.language.tokens import Token, is_participle
from physagent_jax.agents.schema import DirectionTable, ExpectedMotion, MotionKind
from physagent_jax.agents.vectors import cosine, cross
from physagent_jax.core.strict import Vector

_SAME = 0.9  # cosine of directions that are the same, or opposed
# Words that put two motions at the same time; "for a while" is none.
_JOINING = frozenset(
    "while simultaneously same together as whilst with during when once meanwhile both whenever under".split()
)
# What may stand between two things that are done; without it, one brings about the other: "a kick topples it".
_PARTING = frozenset({"and", ",", ";", ".", ":", "!", "?"})
_SHAPES = (MotionKind.STRETCH, MotionKind.SQUEEZE)
# Words that let a motion come twice.
_REPEATING = frozenset(
    "again then another more harder softer faster next second third once twice after before release let less gentler "
    "finally back later first times".split()
)


def find_incoherences(
    tokens: Sequence[Token], motions: Sequence[ExpectedMotion], anchor: str | None, directions: DirectionTable
) -> list[str]:
    """Plain sentences about motions that do not go together."""
    words = [token.text for token in tokens]
    doubts = _find_unjoined(words, motions, directions) + _find_echoes(words, motions)
    if anchor in ("base", "top"):
        doubts += _find_leaving(motions, anchor, directions)
    return list(dict.fromkeys(doubts))


def _find_unjoined(
    words: list[str], motions: Sequence[ExpectedMotion], directions: DirectionTable
) -> list[str]:
    """Motions at the same time, of different words, that are one motion twice or that no word joins."""
    doubts = []
    joined = bool(_JOINING & {w for b, w in zip(["", *words], words) if (b, w) != ("a", "while")})
    joined = joined or not _PARTING & set(words[:-1]) or any(is_participle(word) for word in words)
    for first, second in itertools.combinations(motions, 2):
        apart = first.window[1] <= second.window[0] or second.window[1] <= first.window[0]
        several = first.part is not None and second.part is not None and first.part != second.part
        if apart or first.words == second.words or several:
            continue
        twice = first.kind is second.kind and _is_along(first, second) != 0
        if first.part != second.part and not twice:
            continue  # a part may do something else than the whole
        if twice or not joined and not _is_one_motion(first, second, directions):
            doubts.append(
                f"Whether '{first.words}' and '{second.words}' happen at the same time is not understood."
            )
    return doubts


def _is_one_motion(first: ExpectedMotion, second: ExpectedMotion, directions: DirectionTable) -> bool:
    """Return whether two kinds go together: wider and flatter, pushed and tilted left, falling and turning."""
    if first.kind in _SHAPES and second.kind in _SHAPES:
        return True
    turn, other = (first, second) if first.kind is MotionKind.ROTATE else (second, first)
    if turn.kind is not MotionKind.ROTATE or turn.direction is None:
        return False
    if other.kind is MotionKind.FALL:
        return True
    if other.kind is not MotionKind.MOVE or other.direction is None:
        return False
    way = _to_vector(other.direction)
    if abs(cosine(way, directions.up)) > _SAME:
        return True
    return cosine(_to_vector(turn.direction), cross(directions.up, way)) > _SAME


def _find_echoes(words: list[str], motions: Sequence[ExpectedMotion]) -> list[str]:
    """A motion that comes a second time though nothing says so."""
    if _REPEATING & set(words):
        return []
    return [
        f"Whether '{second.words}' is one more motion is not understood."
        for first, second in zip(motions, motions[1:])
        if first.kind is second.kind
        and first.part == second.part
        and first.window[1] <= second.window[0]
        and _is_along(first, second) > 0
    ]


def _find_leaving(motions: Sequence[ExpectedMotion], anchor: str, directions: DirectionTable) -> list[str]:
    """Find contradictions: what hangs and yet falls or goes up, and what stands fast and yet leaps."""
    doubts = []
    for motion in motions:
        if motion.partial:
            continue
        height = 0.0 if motion.direction is None else cosine(_to_vector(motion.direction), directions.up)
        upright = motion.kind is MotionKind.MOVE and abs(height) > _SAME
        if anchor == "top" and (motion.kind is MotionKind.FALL or upright):
            doubts.append(f"How '{motion.words}' goes with being held at the top is not understood.")
        elif anchor == "base" and upright and height > 0 and motion.sudden:
            doubts.append(f"How '{motion.words}' goes with being held at the base is not understood.")
    return doubts


def _is_along(first: ExpectedMotion, second: ExpectedMotion) -> int:
    """1 if they go the same way, -1 if they go opposite ways, else 0."""
    if first.direction is None or second.direction is None:
        return 0
    alike = cosine(_to_vector(first.direction), _to_vector(second.direction))
    return 1 if alike > _SAME else -1 if alike < -_SAME else 0


def _to_vector(values: Sequence[float]) -> Vector:
    return (values[0], values[1], values[2])
