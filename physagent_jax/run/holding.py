"""The hold of a run's object, checked against the sentence's motions."""

from __future__ import annotations

from pathlib import Path

from physagent_jax.agents.schema import SemanticReply
from physagent_jax.motion.holds import Hold, HoldOrigin, describe_yielding, refuse_impossible
from physagent_jax.motion.schema import AnchorRequest
from physagent_jax.run.spec import AnchorChoice
from physagent_jax.scene.anchor import select_anchored
from physagent_jax.scene.body import Body
from physagent_jax.scene.config import Anchor
from physagent_jax.scene.priors import choose_anchor

UP = (0.0, 0.0, 1.0)
"""Against gravity, in every scene."""


def find_hold(choice: AnchorChoice, kind: str, said: AnchorRequest) -> Hold | None:
    """The object's hold and its origin; None if nothing holds it.

    A word that describes the object as its kind is anyway ("the potted plant") says no more than the kind.

    Args:
        choice: The spec's.
        kind: The object's kind.
        said: The sentence's words about holding.
    """
    if choice.kind == "auto" and said.kind == "rest":
        return Hold("region", HoldOrigin.SENTENCE, said.words)
    told = None if said.kind == "rest" else said.kind
    place = choose_anchor(kind, told).kind if choice.kind == "auto" else choice.kind
    if place == "none":
        return None
    if choice.kind != "auto":
        return Hold(place, HoldOrigin.OPTION)
    implied = said.kind is None or said.described and said.kind == choose_anchor(kind).kind
    return Hold(place, HoldOrigin.KIND) if implied else Hold(place, HoldOrigin.SENTENCE, said.words)


def check_hold(
    hold: Hold, anchor: Anchor, body: Body, reply: SemanticReply, base_dir: Path
) -> tuple[str, ...]:
    """Warnings about a hold that goes badly with the plan.

    Args:
        hold: What holds the object.
        anchor: The same as a part of the scene.
        body: The object at rest.
        reply: The plan.
        base_dir: Folder that a relative mask path starts from.

    Raises:
        UserError: The hold makes a planned motion impossible.
    """
    index, count = body.particles.gaussian_index, body.cloud.count
    held = select_anchored(anchor, body.particles.x, index, base_dir, gaussian_count=count)
    refuse_impossible(hold, reply.plan, UP, whole=bool(held.all()))
    yielding = describe_yielding(hold, reply.plan, UP)
    return () if yielding is None else (yielding,)
