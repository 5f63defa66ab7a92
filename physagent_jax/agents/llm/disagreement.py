"""Two readings of one sentence, compared: where a second one doubts the first."""

from __future__ import annotations

from physagent_jax.agents.llm.prompt import describe_direction, describe_motion
from physagent_jax.agents.schema import ExpectedMotion, MotionKind, SceneBrief, SemanticReply
from physagent_jax.agents.vectors import cosine

_ALIKE = 0.9  # cosine of directions that are called the same
_LINES = (MotionKind.STRETCH, MotionKind.SQUEEZE, MotionKind.SWAY)  # either sense is the same


def find_disagreements(
    reading: SemanticReply, second: SemanticReply, reader: str, brief: SceneBrief
) -> list[str]:
    """Doubts about ``reading``, a sentence each, where ``second`` says another motion, direction or part.

    Strengths, amounts and times are left to the first: a small difference there is none that a viewer would see.
    """

    def doubt(what: str, mine: str, theirs: str) -> str:
        return f"Grammar and model disagree on the {what}: {mine}; {reader} reads {theirs}."

    mine, theirs = (sorted(each.expectations, key=lambda motion: motion.window) for each in (reading, second))
    if [motion.kind for motion in mine] != [motion.kind for motion in theirs]:
        said = [", then ".join(describe_motion(each, brief) for each in side) for side in (mine, theirs)]
        return [doubt("motion", said[0] or "nothing", said[1] or "nothing")]
    doubts = []
    for one, other in zip(mine, theirs):
        if not _go_the_same_way(one, other):
            doubts.append(doubt("direction", describe_motion(one, brief), describe_motion(other, brief)))
        if not _act_on_the_same_part(one, other):
            doubts.append(doubt("part", _describe_part(one, brief), _describe_part(other, brief)))
    return doubts


def _go_the_same_way(one: ExpectedMotion, other: ExpectedMotion) -> bool:
    if one.direction is None or other.direction is None:
        return one.direction is other.direction
    alike = cosine(one.direction, other.direction)
    return (abs(alike) if one.kind in _LINES else alike) > _ALIKE


def _act_on_the_same_part(one: ExpectedMotion, other: ExpectedMotion) -> bool:
    if one.part is None or other.part is None:
        return one.part is other.part and one.partial == other.partial
    return cosine(one.part, other.part) > _ALIKE and one.excludes_part == other.excludes_part


def _describe_part(motion: ExpectedMotion, brief: SceneBrief) -> str:
    if motion.part is None:
        return "a part of it" if motion.partial else "the whole object"
    but = "all but " if motion.excludes_part else ""
    return f"{but}the {describe_direction(motion.part, brief)} end"
