"""The brief of a task's scene: what agents and methods are told of it before anything is simulated."""

from __future__ import annotations

from physagent_jax.motion.schema import DirectionTable, SceneBrief
from physagent_jax.scene.broad_side import find_long_axis
from physagent_jax.scene.camera import find_viewer_directions
from physagent_jax.scene.compile import CompiledScene
from physagent_jax.scene.priors import list_nouns


def make_scene_brief(scene: CompiledScene) -> SceneBrief:
    """The brief of a task's scene for agents; the clip's length is the task's."""
    config = scene.config
    source, timing, anchor = config.source, config.timing, config.anchor
    stands = config.always_gravity and config.gravity[2] < 0
    ground = any(boundary.kind == "half_space" for boundary in config.boundaries)
    return SceneBrief(
        object_name=source.name,
        object_kind=source.kind,
        object_nouns=list_nouns(source.kind),
        anchored=None if anchor.kind == "none" else anchor.reason or anchor.kind,
        frame_count=timing.frame_count,
        frames_fixed=True,
        frame_dt=timing.frame_dt,
        size=source.extent,
        long_axis=find_long_axis(source, config.domain),
        world="ground" if stands and ground else "free",
        directions=DirectionTable(**find_viewer_directions(config.camera)),
    )
