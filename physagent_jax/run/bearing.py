"""Parts that bear the rest: what moves one of them takes the whole object along.

A pot bears its plant, a plinth its statue. Pushed alone it would be sheared off what stands on it, or slip out from
under it; whoever pushes it sees all of it go.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from physagent_jax.agents.schema import Evidence, SemanticReply
from physagent_jax.forces.calibration import GAIN_MAX, MAGNITUDE_MAX, MAGNITUDE_MIN, TRAVEL, find_magnitude
from physagent_jax.forces.part import Part
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.forces.schema import Action, ActionType, CellsRegion, Region
from physagent_jax.motion.schema import AnchorRequest, ExpectedMotion, MotionKind
from physagent_jax.scene.body import Body
from physagent_jax.scene.world import SOLE, find_foot

BORNE = 0.9  # share of the feet that a part holds which bears the object
_DOWN = -0.3  # vertical component below which a way presses it onto the ground
_BELOW = -0.7  # of the way to an end of the object that is its foot
_MOVES = (ActionType.TRANSLATION, ActionType.IMPULSE)


def carry_along(reply: SemanticReply, body: Body, parts: Sequence[Part], frame_dt: float) -> SemanticReply:
    """The reply in which a part that bears the rest is not moved without it.

    What is pressed down, turned or bent stays as it is, and so does what the sentence holds.

    Args:
        reply: A semantic agent's.
        body: The object at rest, which stands on the ground.
        parts: Its parts, in the order that the reply counts them in.
        frame_dt: Seconds per frame [s].
    """
    if reply.anchor.kind in ("base", "top"):
        return reply
    kept = [each for each in reply.expectations if each.kind is not MotionKind.STILL]
    limbs = [each.limb for each in kept if each.limb is not None]
    if limbs:
        alone = len(set(limbs)) == 1 and len(limbs) == len(kept)
        moved = parts[limbs[0]].moved
        if not alone or not all(_goes(each) for each in kept) or not _bears(moved, body):
            return reply
        return _lead_whole(reply, moved, frame_dt)
    regions = {each.region for each in reply.force_field.actions if _is_borne_by(each, body)}
    below = [each for each in kept if _goes(each) and each.part is not None and each.part[2] < _BELOW]
    if not regions or not below:
        return reply
    actions = tuple(
        each.model_copy(update=dict(region=None)) if each.region in regions else each
        for each in reply.force_field.actions
    )
    return _free(reply, actions, below, reply.evidence)


def _goes(motion: ExpectedMotion) -> bool:
    """Return whether a part is to go somewhere, but down."""
    way = motion.direction
    plain = motion.kind is MotionKind.MOVE and motion.repeats == 1 and motion.manner != "bend"
    return plain and motion.partial and not motion.excludes_part and way is not None and way[2] > _DOWN


def _is_borne_by(action: Action, body: Body) -> bool:
    return action.region is not None and action.action_type in _MOVES and _bears(action.region, body)


def _bears(region: Region, body: Body) -> bool:
    """Return whether a region holds what the object stands on."""
    x = np.asarray(body.particles.x, float)
    feet = x[:, 2] <= find_foot(body) + SOLE * body.extent
    return bool(make_region_mask(region, x)[feet].mean() >= BORNE)


def _lead_whole(reply: SemanticReply, moved: CellsRegion, frame_dt: float) -> SemanticReply:
    """The reply in which pushes of the whole stand for what leads one part."""
    pushed = [each for each in reply.expectations if _goes(each)]
    kept = tuple(each for each in reply.force_field.constraints if each.region != moved)
    field = reply.force_field.model_copy(update=dict(constraints=kept))
    actions = (*field.actions, *(_push(each, frame_dt) for each in pushed))
    evidence = tuple(each for each in reply.evidence if not each.field.startswith("constraints["))
    anchor = AnchorRequest() if reply.anchor.kind == "rest" else reply.anchor
    free = reply.model_copy(update=dict(force_field=field, anchor=anchor))
    return _free(free, actions, pushed, evidence)


def _push(motion: ExpectedMotion, frame_dt: float) -> Action:
    assert motion.direction is not None
    (first, last), wanted = motion.window, motion.strength
    told = motion.amount
    if told is not None and told.unit == "lengths" and not motion.sudden:
        seconds = (last - first) * frame_dt
        wanted = find_magnitude(told.value / TRAVEL, seconds, seconds, braked=False)
    size = min(max(wanted, MAGNITUDE_MIN), MAGNITUDE_MAX)
    return Action(
        action_type=ActionType.IMPULSE if motion.sudden else ActionType.TRANSLATION,
        vector=motion.direction,
        magnitude=round(size, 3),
        gain=round(min(max(wanted / size, 1.0), GAIN_MAX), 3),
        active_time=(first, first + 1.0 if motion.sudden else last),
    )


def _free(
    reply: SemanticReply, actions: tuple, pushed: list[ExpectedMotion], evidence: tuple[Evidence, ...]
) -> SemanticReply:
    """The reply with motions of the whole in place of a part's."""
    whole = dict(partial=False, part=None, limb=None, leaves_place=True)
    expectations = tuple(
        each.model_copy(update=whole) if each in pushed else each for each in reply.expectations
    )
    note = f"'{pushed[0].words}': that part bears the rest, so all of the object goes along."
    return reply.model_copy(
        update=dict(
            force_field=reply.force_field.model_copy(update=dict(actions=actions)),
            expectations=expectations,
            evidence=evidence,
            notes=(note, *reply.notes),
        )
    )
