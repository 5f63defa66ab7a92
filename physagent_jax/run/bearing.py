"""Parts that take the whole object along: what bears the rest, and the end at which something stiff is lifted.

A pot bears its plant, a plinth its statue. Pushed alone it would be sheared off what stands on it, or slip out from
under it; whoever pushes it sees all of it go. A bumper that is lifted does not come off either: the car tilts.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from physagent_jax.agents.compiler.limbs import find_roles
from physagent_jax.agents.schema import Evidence, SemanticReply
from physagent_jax.forces.calibration import GAIN_MAX, MAGNITUDE_MAX, MAGNITUDE_MIN, TRAVEL, find_magnitude
from physagent_jax.forces.driving import PartDriver
from physagent_jax.forces.part import Part, split_name
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.forces.schema import Action, ActionType, CellsRegion, Region, VelocityConstraint
from physagent_jax.motion.limbs import PLACES
from physagent_jax.motion.schema import Amount, AnchorRequest, ExpectedMotion, MotionKind
from physagent_jax.run.denting import dent
from physagent_jax.scene.body import Body
from physagent_jax.scene.world import SOLE, find_foot

BORNE = 0.9  # share of the feet that a part holds which bears the object
_DOWN = -0.3  # vertical component below which a way presses it onto the ground
_BELOW = -0.7  # of the way to an end of the object that is its foot
_NO_WAY = (0.0, 0.0, 0.0)
_FIGURE = frozenset(("head", "arm", "ear", "wing", "leg"))  # roles of parts of animals and people
_UP = 0.7  # vertical component from which on a way lifts
_ASIDE, _LOW = (
    0.8,
    0.3,
)  # level component from which on a part is at an end, and upward one up to which it is low
_TILTED, _ON_END = 25.0, 80.0  # [degrees] by which a plain word tilts it, and brings it to stand on its end
_TILT_TIME = 1.2  # [s] in which a plain word does
_BEARS = "'{}': that part bears the rest, so all of the object goes along."
_TILTS = "'{}': that part is fixed to the rest, so all of the object is tilted by it."
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
        part = parts[limbs[0]]
        if part.origin == "option":  # whoever marked it means just that
            return reply
        if len(set(limbs)) == 1 and len(limbs) == len(kept) and not _bears(part.moved, body):
            reply = dent(reply, body, part, frame_dt)
        if len(set(limbs)) != 1 or len(limbs) != len(kept) or not all(_goes(each) for each in kept):
            return reply
        if len(kept) == 1 and _is_end(part, parts, kept[0].words) and (kept[0].direction or _NO_WAY)[2] > _UP:
            return _tilt_whole(reply, kept[0], part, frame_dt)
        return _lead_whole(reply, part.moved, frame_dt) if _bears(part.moved, body) else reply
    regions = [each.region for each in reply.force_field.actions if _is_borne_by(each, body)]
    below = [each for each in kept if _goes(each) and each.part is not None and each.part[2] < _BELOW]
    if not regions or not below:
        return reply
    actions = tuple(
        each.model_copy(update=dict(region=None)) if each.region in regions else each
        for each in reply.force_field.actions
    )
    return _free(reply, actions, below, reply.evidence, _BEARS)


def _goes(motion: ExpectedMotion) -> bool:
    """Return whether a part is to go somewhere, but down or off."""
    way, alone = motion.direction, ("bend", "hinge", "detach")
    plain = motion.kind is MotionKind.MOVE and motion.repeats == 1 and motion.manner not in alone
    return plain and motion.partial and not motion.excludes_part and way is not None and way[2] > _DOWN


def _is_borne_by(action: Action, body: Body) -> bool:
    return action.region is not None and action.action_type in _MOVES and _bears(action.region, body)


def _bears(region: Region, body: Body) -> bool:
    """Return whether a region holds what the object stands on."""
    x = np.asarray(body.particles.x, float)
    feet = x[:, 2] <= find_foot(body) + SOLE * body.extent
    return bool(make_region_mask(region, x)[feet].mean() >= BORNE)


def _is_end(part: Part, parts: Sequence[Part], words: str) -> bool:
    """Return whether it is a piece at an end of something stiff, low down, by which the whole is tilted, or a handle.

    What has a joint is raised alone: a limb, a lid, a lever; and so is what a figure holds. ``words`` name the part.
    """
    if any(not _FIGURE.isdisjoint(find_roles(each.name)) for each in parts if each.name):
        return False
    level = float(np.hypot(*part.side[:2]))
    if "handle" in split_name(words):  # a pot's, a pan's; a bail on top turns
        return level > _ASIDE
    plain = set(find_roles(part.name)) <= {*PLACES, "stern", "bow"}
    return part.origin == "file" and part.moved.rigid and plain and level > _ASIDE and part.side[2] < _LOW


def _tilt_whole(reply: SemanticReply, motion: ExpectedMotion, part: Part, frame_dt: float) -> SemanticReply:
    """The reply in which the object is turned over the far edge of its feet; onto its end if it is then to stand."""
    level = float(np.hypot(*part.side[:2]))
    axis = (part.side[1] / level, -part.side[0] / level, 0.0)
    stands = any(each.kind is MotionKind.STILL and each.partial for each in reply.expectations)
    angle = _ON_END if stands else min(_TILTED * motion.strength, _ON_END)
    if motion.amount is not None and motion.amount.unit == "degrees":
        angle = motion.amount.value
    last, first = max(each.window[1] for each in reply.expectations), motion.window[0]
    until = min(motion.window[1], first + max(_TILT_TIME * np.sqrt(angle / _TILTED) / frame_dt, 1.0))
    stop = None if motion.released or until >= last else last
    driver = PartDriver(part, frame_dt, round(last) + 1, held=False)
    turn = driver.turn(axis, angle, (first, round(until)), stop)
    turn = turn.model_copy(update=dict(region=None, pivot=None))
    kept = _drop(reply.force_field.constraints, part.moved)
    field = reply.force_field.model_copy(update=dict(constraints=(*kept, turn)))
    seen = dict(
        kind=MotionKind.ROTATE,
        direction=axis,
        amount=Amount(value=angle, unit="degrees"),
        stays=not motion.released,
    )
    free = reply.model_copy(update=dict(force_field=field, anchor=AnchorRequest()))
    evidence = tuple(each for each in reply.evidence if not each.field.startswith("constraints["))
    told = _free(free, field.actions, [motion], evidence, _TILTS)
    whole = dict(partial=False, part=None)
    expectations = tuple(
        each.model_copy(update=seen | dict(leaves_place=False))
        if each.words == motion.words
        else each.model_copy(update=whole)
        if each.kind is MotionKind.STILL
        else each
        for each in told.expectations
    )
    return told.model_copy(update=dict(expectations=expectations))


def _drop(constraints: Sequence[VelocityConstraint], moved: CellsRegion) -> tuple[VelocityConstraint, ...]:
    """The constraints without those of a part, however it is labelled."""
    regions = [each.region.inside if isinstance(each.region, CellsRegion) else None for each in constraints]
    return tuple(each for each, inside in zip(constraints, regions) if inside != moved.inside)


def _lead_whole(reply: SemanticReply, moved: CellsRegion, frame_dt: float) -> SemanticReply:
    """The reply in which pushes of the whole stand for what leads one part."""
    pushed = [each for each in reply.expectations if _goes(each)]
    kept = _drop(reply.force_field.constraints, moved)
    field = reply.force_field.model_copy(update=dict(constraints=kept))
    actions = (*field.actions, *(_push(each, frame_dt) for each in pushed))
    evidence = tuple(each for each in reply.evidence if not each.field.startswith("constraints["))
    anchor = AnchorRequest() if reply.anchor.kind == "rest" else reply.anchor
    free = reply.model_copy(update=dict(force_field=field, anchor=anchor))
    return _free(free, actions, pushed, evidence, _BEARS)


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
    reply: SemanticReply,
    actions: tuple,
    pushed: list[ExpectedMotion],
    evidence: tuple[Evidence, ...],
    note: str,
) -> SemanticReply:
    """The reply with motions of the whole in place of a part's."""
    whole = dict(partial=False, part=None, limb=None, leaves_place=True)
    expectations = tuple(
        each.model_copy(update=whole) if each in pushed else each for each in reply.expectations
    )
    return reply.model_copy(
        update=dict(
            force_field=reply.force_field.model_copy(update=dict(actions=actions)),
            expectations=expectations,
            evidence=evidence,
            notes=(
                note.format(pushed[0].words),
                *(each for each in reply.notes if "the rest is held" not in each),
            ),
        )
    )
