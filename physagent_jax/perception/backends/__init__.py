"""Implementations of perception's protocols, one file per model, and the names by which a run chooses them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from physagent_jax.core.names import explain_unknown_name
from physagent_jax.core.registry import Choice, Registry

if TYPE_CHECKING:
    from physagent_jax.perception.protocols import PerceptionBackends

_HERE = "physagent_jax.perception.backends"
SEGMENTERS = Registry(
    "`perception.segmenter`",
    {
        "rgbd": f"{_HERE}.rgbd:RgbdSegmenter",
        "colour": f"{_HERE}.colour:ColorSegmenter",
        "sam2": f"{_HERE}.sam2:Sam2Segmenter",
        "salient": f"{_HERE}.salient:SalientSegmenter",
    },
)
DEPTH_ESTIMATORS = Registry(
    "`perception.depth`",
    {
        "sensor": f"{_HERE}.depth_sensor:DepthSensor",
        "ground_contact": f"{_HERE}.ground_contact:GroundContact",
        "depth_anything": f"{_HERE}.depth_anything:DepthAnything",
        "depth_anything_3": f"{_HERE}.depth_anything_3:DepthAnything3",
    },
)
TRACKERS = Registry(
    "`perception.tracker`",
    {
        "flow": f"{_HERE}.flow:FlowTracker",
        "cotracker": f"{_HERE}.cotracker:CoTracker",
        "gmflow": f"{_HERE}.gmflow:GmflowTracker",
    },
)
PRESETS = {
    "rgbd": {"segmenter": "rgbd", "depth": "sensor", "tracker": "flow"},
    "rgb": {"segmenter": "colour", "depth": "ground_contact", "tracker": "flow"},
}
"""Backends by role, none of which needs weights: with the depth channel of a camera, and from pictures alone."""


def parse_choice(text: str) -> dict[str, str]:
    """The names of backends by role.

    Args:
        text: One of `PRESETS`, and what differs from it: "rgb,tracker=cotracker".

    Raises:
        UserError: There is no such preset or role.
    """
    name, *changes = (each.strip() for each in text.split(","))
    if name not in PRESETS:
        raise explain_unknown_name("`perception`", name, PRESETS)
    roles = dict(PRESETS[name])
    for role, _, chosen in (each.partition("=") for each in changes):
        if role not in roles:
            raise explain_unknown_name("a role of perception", role, roles)
        roles[role] = chosen
    return roles


def make_backends(
    segmenter: Choice = "rgbd", depth: Choice = "sensor", tracker: Choice = "flow"
) -> PerceptionBackends:
    """The backends of these names; those that need no weights by default.

    Raises:
        UserError: There is no such backend, the package that it needs is missing, or it has no such options.
    """
    # Names can be checked without the arrays.
    from physagent_jax.perception.protocols import PerceptionBackends

    return PerceptionBackends(
        SEGMENTERS.make(segmenter), DEPTH_ESTIMATORS.make(depth), TRACKERS.make(tracker)
    )
