"""What stands behind the protocols of perception, one file per model, and by which names a run chooses."""

from __future__ import annotations

from physagent_jax.core.registry import Registry

_HERE = "physagent_jax.perception.backends"
SEGMENTERS = Registry("`perception.segmenter`", {"colour": f"{_HERE}.colour:ColorSegmenter"})
DEPTH_ESTIMATORS = Registry("`perception.depth`", {"sensor": f"{_HERE}.depth_sensor:DepthSensor"})
TRACKERS = Registry("`perception.tracker`", {"flow": f"{_HERE}.flow:FlowTracker"})
