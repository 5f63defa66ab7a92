"""Poses in which a clip leaves what stood at first: on its feet, on its side, or lying.

People see the clip to its true end, some frames after the planned ones (`simulation.ending`). Where a sentence is about
such a pose, those frames are looked at too.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from physagent_jax.motion.judging.asked import Asked
from physagent_jax.motion.judging.comparing import check_limit
from physagent_jax.motion.judging.seen import View
from physagent_jax.motion.schema import Check, ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.motion.vectors import clamp, cosine, dot, rotate

UPRIGHT = re.compile(
    r"\bupright\b|\b(without|not|never)\b.{0,20}\b(fall|tip|toppl|roll)|n't (fall|tip|toppl|roll)"
)
"""Words of who asks that it does not fall over."""
_ON_ITS_FEET = re.compile(
    r"\b(on|onto|to) (its|his|her|their|all|both) (own )?(four |two )?"
    r"(feet|foot|legs|paws|wheels|hooves|base|bottom|fours)\b"
)
_ON_ITS_SIDE = re.compile(r"(?<!rim )(?<!edge )\b(on|onto) (its|his|her|their|one) (left |right )?side\b")
_LEAPS = re.compile(r"\b(jump|hop|leap)(s|ing|ed|ping|ped|t)?\b")
_LEVEL = 0.5  # sine of a way's slope
_STANDS = 45.0  # [degrees] from upright at the end of what is left standing
_LIES_ASIDE = 50.0  # [degrees] off a right angle of what is left on its side, on whatever it lies there
_AS_TALL = 0.1  # [1] of its height, by which the outline's height may differ of what stands as at first
_ROUND = 1.25  # times its shortest side: the longest of what rolls as a ball does
_LEAPT = (MotionKind.MOVE, MotionKind.FALL, MotionKind.SWAY, MotionKind.STILL)


def tells_pose(sentence: str, expectations: Sequence[ExpectedMotion], brief: SceneBrief) -> bool:
    """Return whether it matters for what is asked how what stands free is left when all is over."""
    if brief.world != "ground" or brief.anchored is not None:
        return False
    told, up = sentence.lower(), brief.directions.up
    turns = (e for e in expectations if e.kind is MotionKind.ROTATE and e.part is None and e.limb is None)
    tips = any(e.direction is None or abs(dot(e.direction, up)) < _LEVEL for e in turns)
    return tips or _stands(told, expectations, brief) or _ON_ITS_SIDE.search(told) is not None


def check_pose(view: View) -> list[Check]:
    """Check that it is left standing or on its side, where the sentence says so, or asks for a leap alone."""
    told, turns = view.sentence.lower(), view.turns(0, view.last)
    if not turns or not view.grounded or view.anchored or not view.expectations:
        return []
    blamed = Asked(len(view.expectations) - 1, view.expectations[-1], view)
    lean, sigma = find_last_lean(view), view.sigma("rotation")
    if _ON_ITS_SIDE.search(told):
        return [check_limit(blamed, "on_its_side", abs(lean - 90.0), _LIES_ASIDE, sigma, lean=lean)]
    if _stands(told, view.expectations, view.brief):
        return [check_limit(blamed, "stands", lean, _STANDS, sigma)]
    return []


def find_last_lean(view: View) -> float:
    """The angle between upright and where that has come to when all is over [degrees]."""
    up = view.brief.directions.up
    if any(map(view.is_aloft, view.expectations)) and view.report.rotation_degrees[-1] is None:
        heights = view.lengths(up, 0, view.last)
        if heights and abs(heights[-1][1]) < _AS_TALL:  # its outline stands as it stood, or upside down
            return 180.0 * (view.count_half_turns() % 2)
    top = rotate(up, view.turns(0, view.last)[-1][1])
    after = [turn for turn in view.ending.rotation if turn is not None] if view.ending else []
    top = rotate(top, after[-1]) if after else top
    return math.degrees(math.acos(clamp(cosine(top, up), -1.0, 1.0)))


def _stands(told: str, expectations: Sequence[ExpectedMotion], brief: SceneBrief) -> bool:
    """Return whether it is to be left standing: it is told so, or it leaps and no more, and is not round as a ball.

    What lands on its feet and then topples is not.
    """
    last = max((e.window[0] for e in expectations if e.kind is not MotionKind.STILL), default=0.0)
    late = [e for e in expectations if e.window[0] >= last - 0.5 and last > 0 and e.part is None]
    if {MotionKind.FALL, MotionKind.ROTATE} <= {e.kind for e in late}:
        return False
    if _ON_ITS_FEET.search(told) or UPRIGHT.search(told):
        return True
    up = brief.directions.up
    straight = (e.direction is None or abs(dot(e.direction, up)) > _LEVEL for e in expectations)
    leaps = _LEAPS.search(told) is not None and all(straight) and all(e.kind in _LEAPT for e in expectations)
    return leaps and max(brief.extents) > _ROUND * min(brief.extents)
