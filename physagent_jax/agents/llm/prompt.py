"""Prompts: files `prompts/NAME.md` with {{placeholders}}, and a scene in words to fill them with."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from importlib import resources

from physagent_jax.agents.context import AgentContext, Round
from physagent_jax.agents.llm.forms import SETTINGS, list_motions
from physagent_jax.chat.base import ChatMessage
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.judging.comparing import name_direction
from physagent_jax.motion.schema import ExpectedMotion, SceneBrief

_PLACE = re.compile(r"\{\{(\w+)\}\}")
_LINKS = {"rotate": " about", "stretch": " along", "squeeze": " along", "sway": " along"}


def write_messages(
    name: str, context: AgentContext, pictures: tuple[bytes, ...] = (), **values: str
) -> list[ChatMessage]:
    """The system's and the user's message of a prompt, in the file ``name`` without its suffix.

    Placeholders are filled from the context and ``values``. A value is put in once and not looked into, so that braces
    in a user's sentence stay what they are.
    """
    values = _describe_context(context) | values
    file = resources.files("physagent_jax.agents.llm").joinpath("prompts", f"{name}.md")
    parts = file.read_text("utf-8").split("\n=== user ===\n")
    system, user = (_PLACE.sub(lambda found: values[found[1]], part) for part in parts)
    return [ChatMessage("system", system.strip()), ChatMessage("user", user.strip(), pictures)]


def quote(text: str) -> str:
    """A user's text as one quoted line: no quotation mark or line break in it ends the quotation."""
    return json.dumps(" ".join(text.split()), ensure_ascii=False)


def list_rows(rows: Mapping[str, str]) -> str:
    """Names with their meanings, a line each."""
    return "\n".join(f"- {name}: {meaning}" for name, meaning in rows.items())


def _describe_context(context: AgentContext) -> dict[str, str]:
    """Texts for the placeholders of every prompt; the viewer's directions are vectors, a line each."""
    brief, last = context.brief, context.brief.frame_count - 1
    ways = brief.directions.model_dump().items()
    vectors = {name: f"[{', '.join(f'{c + 0.0:.4g}' for c in way)}]" for name, way in ways}
    return {
        "object": quote(brief.object_name),
        "held": quote(brief.anchored) if brief.anchored else "nowhere",
        "world": "it stands on the ground under gravity" if brief.world == "ground" else "it floats freely",
        "last_frame": str(last),
        "seconds": f"{last * brief.frame_dt:.3g}",
        "directions": list_rows(vectors),
        "sentence": quote(context.prompt),
        "skills": context.skills.text,
        "motions": list_rows(list_motions()),
        "settings": ", ".join(SETTINGS),
        "rounds": _describe_rounds(context.rounds),
    }


def write_field(field: ForceField) -> str:
    """A force field as JSON on one line."""
    return json.dumps(field.model_dump(mode="json", exclude_none=True))


def _describe_rounds(rounds: Sequence[Round]) -> str:
    """Earlier rounds: what was tried, and what was said of it; empty if there is none."""
    lines = ["", "Earlier rounds, oldest first:"]
    for number, each in enumerate(rounds, 1):
        said = each.judgement.suggestion or each.judgement.verdict.value
        lines.append(f"{number}. {write_field(each.force_field)} -> {quote(said)}")
    return "\n".join([*lines, ""]) if rounds else ""


def describe_motion(motion: ExpectedMotion, brief: SceneBrief) -> str:
    """An expected motion in a few words: "move left", "rotate about up", "stretch along left"."""
    kind = motion.kind.value
    if motion.direction is None:
        return kind
    return f"{kind}{_LINKS.get(kind, '')} {name_direction(motion.direction, brief.directions)}"
