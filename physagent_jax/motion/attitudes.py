"""Attitudes: how something is turned before it falls, by the side of it that a sentence says points down."""

from __future__ import annotations

from physagent_jax.core.strict import Vector
from physagent_jax.forces.part import split_name
from physagent_jax.motion.axes import find_lean_axis
from physagent_jax.motion.limbs import find_front, find_level_line, find_way_ahead, sum_directions
from physagent_jax.motion.schema import SceneBrief
from physagent_jax.motion.swaying import lies
from physagent_jax.motion.vectors import dot, normalise, scale

_FLAT = 0.8  # height over breadth, below which something lies flat
_THIN, _ROUND = 0.5, 0.8  # height over breadth of a disc, below; shorter over longer level extent, above
_BACKED = frozenset(
    "couch sofa settee chair armchair bench seat throne".split()
)  # whose back leans on nothing
_ASKEW = 35.0  # [degrees]
_LOOKING_AHEAD = {"head": ("up", "toward"), "away": ("behind", "up"), "belly": ("toward", "down")}
_SIDE, _OVER = 90.0, 180.0  # [degrees]


def find_attitude(side: str, brief: SceneBrief) -> tuple[float, float]:
    """The turn about a level line that brings a side of something down: its rotation vector, x and y [degrees].

    Args:
        side: "up" (it is upside down), "down" (it is as it stands), "head", "toward" (its front), "behind" (its rear
            end), "away" (its back), "belly", "left", "right" or "beside" (a side), "askew".
        brief: The scene.
    """
    front = find_way_ahead(brief)
    if side in _LOOKING_AHEAD:  # a person's back is behind, a horse's on top
        side = _LOOKING_AHEAD[side][has_back_on_top(brief)]
    if side in ("up", "down"):
        axis, angle = find_level_line(brief), _OVER if side == "up" else 0.0
    else:
        beside = normalise(sum_directions(("beside",), brief)) or front
        hidden = dot(beside, brief.directions.toward) < 0  # it would show the viewer its underside
        ways = {
            "beside": scale(beside, -1.0 if hidden else 1.0),
            "toward": front,
            "behind": scale(front, -1.0),
            "askew": brief.directions.right,
        }
        axis = find_lean_axis(ways.get(side) or normalise(sum_directions((side,), brief)) or front, brief)
        angle = _ASKEW if side == "askew" else _SIDE
    x, y, _ = scale(axis, angle)
    return x, y


def stand_on_edge(way: Vector, brief: SceneBrief) -> tuple[float, float] | None:
    """The turn that sets a lying disc on its edge, along a level way: its rotation vector, x and y [degrees].

    What was on top faces the viewer, as far as the way allows. None = it is no disc, or stands on something.

    Args:
        way: The way that it is to roll, a unit vector.
        brief: The scene.
    """
    if brief.box is None:
        return None
    x, y, height = brief.box
    if height > _THIN * min(x, y) or min(x, y) < _ROUND * max(x, y) or find_front(brief.parts) is not None:
        return None
    seen = way[1] * brief.directions.toward[0] - way[0] * brief.directions.toward[1]  # of the way across up
    axis = scale(way, -_SIDE if seen < 0 else _SIDE)
    return axis[0], axis[1]


def has_back_on_top(brief: SceneBrief) -> bool:
    """Return whether its back is on top, and not behind: it is long or flat as it lies, or goes on legs."""
    width, height, depth = brief.extents
    if _BACKED.intersection(split_name(brief.object_name)):
        return False
    return lies(brief) or find_front(brief.parts) is not None or height < _FLAT * min(width, depth)
