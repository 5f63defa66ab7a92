"""The brief of a scene for agents."""

from __future__ import annotations

from physagent_jax.forces.part import Part
from physagent_jax.motion.parts import label_parts
from physagent_jax.motion.schema import DirectionTable, FootEdge, SceneBrief
from physagent_jax.scene.broad_side import find_edges, find_extents, find_long_axis
from physagent_jax.scene.camera import find_viewer_directions
from physagent_jax.scene.config import MaterialModel
from physagent_jax.scene.placement import WALL_CELLS
from physagent_jax.scene.priors import list_nouns
from physagent_jax.scene.template import SceneTemplate

_AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def make_brief(
    template: SceneTemplate, *, frames_fixed: bool = False, parts: tuple[Part, ...] = ()
) -> SceneBrief:
    """The facts about a scene that agents may use.

    Args:
        template: The scene without its force field.
        frames_fixed: Whether the clip's length is the user's.
        parts: The object's parts.
    """
    directions = DirectionTable(**find_viewer_directions(template.camera))
    ways = (directions.right, directions.up, directions.toward)
    timing, anchor = template.preset.timing, template.anchor
    domain, extent = template.preset.domain, template.source.extent
    middle = template.source.center or (0.5 * domain.size,) * 3
    reach = min(min(each, domain.size - each) for each in middle) - WALL_CELLS * domain.dx
    return SceneBrief(
        object_name=template.source.name,
        object_kind=template.source.kind,
        object_nouns=list_nouns(template.source.kind),
        anchored=None if anchor.kind == "none" else anchor.reason or anchor.kind,
        frame_count=timing.frame_count,
        frames_fixed=frames_fixed,
        frame_dt=timing.frame_dt,
        size=template.source.extent,
        long_axis=find_long_axis(template.source, template.preset.domain),
        extents=find_extents(template.source, template.preset.domain, ways),
        box=find_extents(template.source, template.preset.domain, _AXES),
        edges=tuple(
            FootEdge(way=way, reach=reach)
            for way, reach in find_edges(template.source, template.preset.domain)
        ),
        world="ground" if template.world.gravity == "down" and template.world.ground else "free",
        reach=max(reach / extent, 0.0),
        rigid=template.material.model is MaterialModel.RIGID,
        directions=directions,
        parts=label_parts(parts, directions),
    )
