"""The k of entries that act on a part, or on what is held: measured (`scene.response`), and looked up here."""

from __future__ import annotations

from physagent_jax.forces.schema import Action, Response, SkillScaling, VelocityConstraint
from physagent_jax.forces.skills import get_skill


def find_response(scaling: SkillScaling, entry: Action | VelocityConstraint) -> Response | None:
    """The response that was measured for an entry: of its quantity and region, with the nearest vector; None = none."""
    quantity = get_skill(entry).quantity
    alike = [r for r in scaling.responses if r.quantity == quantity and r.region == entry.region]

    def find_nearness(response: Response) -> float:
        return abs(sum(a * b for a, b in zip(response.vector, entry.vector)))

    return max(alike, key=find_nearness, default=None)


def scale_entry(scaling: SkillScaling, entry: Action | VelocityConstraint) -> SkillScaling:
    """The meaning of M = 1 for one entry: the scene's, or what was measured of the part that it acts on."""
    response = find_response(scaling, entry)
    if response is None:
        return scaling
    changes = {response.quantity: response.k, "holding": None, "measured": True, "share": response.share}
    changes["swing"] = None if response.answer is None else response.swing
    if response.share is not None and scaling.opposition is not None:
        opposition = scaling.opposition  # a part bears the weight of the whole
        more = {name: getattr(opposition, name) / response.share for name in ("weight", "tipping")}
        changes["opposition"] = opposition.model_copy(update=more)
    return scaling.model_copy(update=changes)
