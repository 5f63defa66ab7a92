"""What agents are told about a scene."""

from __future__ import annotations

from physagent_jax.agents.schema import DirectionTable, SceneBrief
from physagent_jax.scene.camera import find_viewer_directions
from physagent_jax.scene.fuse import SceneTemplate


def make_brief(template: SceneTemplate) -> SceneBrief:
    """The facts about a scene that agents may use."""
    timing, anchor = template.preset.timing, template.anchor
    return SceneBrief(
        object_name=template.source.name,
        object_kind=template.source.kind,
        anchored=None if anchor.kind == "none" else anchor.reason or anchor.kind,
        frame_count=timing.frame_count,
        frame_dt=timing.frame_dt,
        directions=DirectionTable(**find_viewer_directions(template.camera)),
    )
