"""A hold that the executor adds: what is to bend, sway, stretch or twist, and goes over as a whole instead."""

from __future__ import annotations

from physagent_jax.agents.context import AgentContext, Round
from physagent_jax.forces.skills import get_skill
from physagent_jax.motion.holds import find_leaving
from physagent_jax.motion.matching import AXIAL
from physagent_jax.motion.schema import ExpectedMotion, MotionKind
from physagent_jax.motion.swaying import bends

_DEFORMS = (*AXIAL, MotionKind.SWAY)


def should_hold(context: AgentContext, failed: Round) -> bool:
    """Return whether the object should be held at its base in the next round.

    It stands free, and nothing in the sentence needs it so or says that it is. It is to change its shape, or one of its
    parts alone is to move; but as a whole it turns or goes somewhere that nobody asked for.
    """
    brief, reading = context.brief, context.reading
    free = brief.anchored is None and brief.may_be_held and brief.world == "ground"
    if not free or reading is None or reading.anchor.kind is not None:
        return False
    if any(get_skill(each).prescribes for each in failed.force_field.constraints):
        return False  # what is led and held at once is torn
    if failed.force_field.default_drop or find_leaving(reading.plan, brief.directions.up) is not None:
        return False
    motions = [each for each in context.expectations if each.kind is not MotionKind.STILL]
    supported = bool(motions) and all(_needs_support(each) for each in motions)
    wrong = {check.aspect for check in failed.judgement.checks if check.passed is False}
    return supported and not wrong.isdisjoint(("collateral", "part"))


def _needs_support(motion: ExpectedMotion) -> bool:
    return motion.kind in _DEFORMS or motion.partial or motion.part is not None or bends(motion)
