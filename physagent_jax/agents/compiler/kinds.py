"""The kind of each skill of a reply: a body force, or velocity constraints where these do what the sentence says."""

from __future__ import annotations

from physagent_jax.agents.compiler.builder import describe_skill
from physagent_jax.agents.rules.kinds import choose_kinds, find_new_places
from physagent_jax.agents.schema import Evidence, SceneBrief, SemanticReply
from physagent_jax.forces.schema import ForceField


def choose_reply_kinds(reply: SemanticReply, brief: SceneBrief) -> SemanticReply:
    """The reply with velocity constraints where they do what the sentence says and a force does not."""
    fixture = {"base": "the base", "top": "the top", "none": None, None: brief.anchored}[reply.anchor.kind]
    weightless = reply.world.gravity in ("none", "up") or reply.world.ground is False
    scene = brief.model_copy(
        update={
            "anchored": fixture,
            "frame_count": reply.frame_count or brief.frame_count,
            "world": "free" if weightless else "ground" if reply.world.ground else brief.world,
        }
    )
    choice = choose_kinds(reply.force_field, reply.expectations, scene)
    if not choice.reasons:
        return reply
    places = find_new_places(reply.force_field, choice.force_field)
    evidence = [_follow(item, places, choice.force_field) for item in reply.evidence]
    return reply.model_copy(
        update={
            "force_field": choice.force_field,
            "evidence": tuple(evidence),
            "notes": (*reply.notes, *choice.reasons),
        }
    )


def _follow(item: Evidence, places: dict[str, str], force_field: ForceField) -> Evidence:
    """Evidence of an action as that of what stands for it: its new place, and what is there now."""
    place, dot, name = item.field.partition(".")
    new = places.get(place, place)
    group, _, index = new.rstrip("]").partition("[")
    if group != "constraints":
        return item.model_copy(update={"field": new + dot + name})
    name = "constraint_type" if name == "action_type" else name
    values = describe_skill(force_field.constraints[int(index)])
    return item.model_copy(update={"field": f"{new}.{name}", "value": values.get(name, item.value)})
