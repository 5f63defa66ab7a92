"""The audit of ways: whether every way that a sentence tells is in some motion that was read of it.

A way may get lost where the grammar joins what belongs apart: "raise it to the left" would only go left.
"""

from __future__ import annotations

from collections.abc import Sequence

from physagent_jax.agents.rules.language.clauses import TURNING, Clause, get_verb
from physagent_jax.agents.rules.language.mentions import Mention, MentionKind
from physagent_jax.agents.rules.language.modifiers import Names
from physagent_jax.agents.rules.language.verbs import Effect
from physagent_jax.agents.schema import DirectionTable, ExpectedMotion, MotionKind, ObstacleRequest
from physagent_jax.agents.vectors import add, cosine, cross, scale
from physagent_jax.core.strict import Vector

_ALONG = 0.3  # cosine from which a motion goes a way at least in part
_GOING = (Effect.PUSH, Effect.STRIKE, Effect.LEAN, Effect.JUMP, Effect.ROLL)
_TO_AND_FRO = (MotionKind.STRETCH, MotionKind.SQUEEZE, MotionKind.SWAY)


def find_lost_ways(
    clauses: Sequence[Clause],
    motions: Sequence[ExpectedMotion],
    obstacles: Sequence[ObstacleRequest],
    directions: DirectionTable,
) -> list[str]:
    """Plain sentences about ways that no motion, part or obstacle has."""
    doubts = []
    for clause in clauses:
        if clause.head is None or clause.negated or get_verb(clause.head).effect not in _GOING:
            continue
        told = clause.select(MentionKind.DIRECTION, MentionKind.FROM)
        ways = [(m, names) for m in told if (names := _get_names(m))]
        verb = get_verb(clause.head)
        if verb.bound and verb.direction is not None and not clause.inherited and verb.effect not in TURNING:
            ways.append((clause.head, (verb.direction,)))
        for mention, names in ways:
            way = add(getattr(directions, name) for name in names)
            way = scale(way, -1.0) if mention.kind is MentionKind.FROM else way
            met = any(cosine(way, _to_vector(o.direction)) > _ALONG for o in obstacles)
            if not met and not any(_has_way(motion, way, directions.up) for motion in motions):
                doubts.append(f"Where '{mention.words}' leads here is not understood.")
    return doubts


def find_odd_measures(motions: Sequence[ExpectedMotion], up: Vector) -> list[str]:
    """Plain sentences about measures that the motion cannot have, or that were counted as well."""
    doubts = []
    for motion in motions:
        amount = motion.amount
        if amount is None:
            continue
        upright = motion.direction is not None and abs(cosine(_to_vector(motion.direction), up)) > _ALONG
        shifts = motion.kind is MotionKind.MOVE and amount.unit == "degrees" and upright
        again = amount.unit == "factor" and motion.repeats > 1 and motion.repeats == amount.value
        if shifts or again or amount.value == 0:
            doubts.append(f"What the measure of '{motion.words}' means is not understood.")
    return doubts


def _get_names(mention: Mention) -> Names:
    """The way that a mention tells; none if it may be a return ("pull it back") or a place ("bolted to the floor")."""
    value = mention.value
    if mention.words.lower() == "back" or mention.phrase.endswith(("floor", "ground")):
        return ()
    if not isinstance(value, tuple) or not all(name in DirectionTable.model_fields for name in value):
        return ()
    return value


def _has_way(motion: ExpectedMotion, way: Vector, up: Vector) -> bool:
    """Return whether a motion goes that way, turns its top there, or is of the part that lies there."""
    if motion.part is not None and abs(cosine(_to_vector(motion.part), way)) > _ALONG:
        return True
    if motion.kind in (MotionKind.FALL, MotionKind.STILL):
        return motion.kind is MotionKind.STILL or cosine(way, up) < -_ALONG
    if motion.direction is None:
        return True
    along = _to_vector(motion.direction)
    if motion.kind is MotionKind.ROTATE:
        return (
            cosine(along, cross(up, way)) > _ALONG
            or abs(cosine(along, up)) > _ALONG
            or abs(cosine(way, up)) > _ALONG
        )
    alike = cosine(along, way)
    return (abs(alike) if motion.kind in _TO_AND_FRO else alike) > _ALONG


def _to_vector(values: Sequence[float]) -> Vector:
    return (values[0], values[1], values[2])
