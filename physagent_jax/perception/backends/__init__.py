"""Implementations of perception's protocols, one file per model, and the names by which a run chooses them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from physagent_jax.core.registry import Choice, Registry

if TYPE_CHECKING:
    from physagent_jax.perception.protocols import PerceptionBackends

_HERE = "physagent_jax.perception.backends"
SEGMENTERS = Registry(
    "`perception.segmenter`",
    {"rgbd": f"{_HERE}.rgbd:RgbdSegmenter", "colour": f"{_HERE}.colour:ColorSegmenter"},
)
DEPTH_ESTIMATORS = Registry("`perception.depth`", {"sensor": f"{_HERE}.depth_sensor:DepthSensor"})
TRACKERS = Registry(
    "`perception.tracker`",
    {"flow": f"{_HERE}.flow:FlowTracker", "gmflow": f"{_HERE}.gmflow:GmflowTracker"},
)


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
