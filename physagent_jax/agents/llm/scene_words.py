"""A scene in words, for prompts."""

from __future__ import annotations

import json
from collections.abc import Sequence

from physagent_jax.agents.context import Round
from physagent_jax.agents.llm.templates import quote
from physagent_jax.agents.schema import ExpectedMotion, SceneBrief
from physagent_jax.agents.vectors import cosine
from physagent_jax.forces.schema import ForceField

_ALONG = 0.9  # cosine from which a direction is called by a viewer's word


def describe_scene(brief: SceneBrief) -> dict[str, object]:
    """Values for the placeholders that speak of the scene."""
    last = brief.frame_count - 1
    return {
        "object": quote(brief.object_name),
        "held": quote(brief.anchored) if brief.anchored else "nowhere",
        "world": "it stands on the ground under gravity" if brief.world == "ground" else "it floats freely",
        "last_frame": last,
        "seconds": f"{last * brief.frame_dt:.3g}",
        "directions": list_directions(brief),
    }


def list_directions(brief: SceneBrief) -> str:
    """The viewer's directions as vectors, a line each."""
    table = brief.directions.model_dump()
    return "\n".join(
        f"- {name}: [{', '.join(f'{c + 0.0:.4g}' for c in vector)}]" for name, vector in table.items()
    )


def write_field(field: ForceField) -> str:
    """A force field as JSON on one line."""
    return json.dumps(field.model_dump(mode="json", exclude_none=True))


def describe_rounds(rounds: Sequence[Round]) -> str:
    """Earlier rounds: what was tried, and what was said of it; empty if there is none."""
    if not rounds:
        return ""
    lines = ["Earlier rounds, oldest first:"]
    for number, each in enumerate(rounds, 1):
        said = each.judgement.suggestion or each.judgement.verdict.value
        lines.append(f"{number}. {write_field(each.force_field)} -> {quote(said)}")
    return "\n" + "\n".join(lines) + "\n"


def describe_motion(motion: ExpectedMotion, brief: SceneBrief) -> str:
    """An expected motion in a few words: "move left", "rotate about up", "stretch along left"."""
    kind = motion.kind.value
    if motion.direction is None:
        return kind
    link = {"rotate": " about", "stretch": " along", "squeeze": " along", "sway": " along"}.get(kind, "")
    return f"{kind}{link} {describe_direction(motion.direction, brief)}"


def describe_direction(vector: Sequence[float], brief: SceneBrief) -> str:
    """A direction in the viewer's words."""
    x, y, z = vector
    table = brief.directions.model_dump()
    close = {name: cosine((x, y, z), tuple(way)) for name, way in table.items()}
    nearest = max(close, key=lambda name: close[name])
    if close[nearest] > _ALONG:
        return nearest
    parts = sorted((name for name in close if close[name] > 1 - _ALONG), key=lambda name: -close[name])
    return " and ".join(parts)
