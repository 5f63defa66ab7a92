"""Parts that stick out of the object: which one a word means, and how it is moved.

A force on a limb drags the whole object along and bends the limb little. A viewer expects the limb to turn about its
joint while the rest stays, so that is prescribed: the limb turns about its joint, or moves along itself, and where a
sentence moves limbs alone the rest is held.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from physagent_jax.agents.compiler.events import Event, KnownPart, is_landing_meanwhile
from physagent_jax.agents.lexicon import Effect, read_lexicon
from physagent_jax.agents.schema import Evidence, SemanticReply
from physagent_jax.forces.part import is_plural, split_name
from physagent_jax.forces.schema import ConstraintType, VelocityConstraint
from physagent_jax.motion.detaching import detach, hold_rest, unsettles
from physagent_jax.motion.hinges import find_hinge
from physagent_jax.motion.joints import Turning, is_undone
from physagent_jax.motion.limbs import LOOSE, LOW, PLACES, STEMS, choose_parts, find_front, sum_directions
from physagent_jax.motion.parts import find_named, join_rest
from physagent_jax.motion.schema import AnchorRequest, ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.motion.swaying import FOOT, find_fold, leads_aside, lies
from physagent_jax.motion.vectors import add, cosine, scale

_DONE = {
    ConstraintType.PARTICLE_ROTATION: "turns about its joint",
    ConstraintType.MOVING_PLATE: "is pressed by a plate of its size",
}
_FOLIAGE = ("leaves", "fronds", "branches", "foliage")
# Roles of shapes that leaves may have.
_LEAVES = ("side", "arm", "wing", "ear", "horn", "tail", "spike", "top")
_LEAF = 0.2  # share of the object, at most
_POTS = frozenset(("pot", "flowerpot", "planter", "bucket", "vase"))
_WITH_ALL = (Effect.SWAY, Effect.LEAN, Effect.TOPPLE, Effect.TURN, Effect.ROLL, Effect.PUSH, Effect.STRIKE)
_WITH_ALL += (Effect.JUMP, Effect.FALL)
_BENDING = (Effect.LEAN, Effect.SWAY, Effect.TURN, Effect.PUSH)
_DRIVEN = (MotionKind.MOVE, MotionKind.SWAY, MotionKind.ROTATE)


def find_limbs(part: KnownPart, brief: SceneBrief) -> tuple[int, ...]:
    """Places in the brief's parts of what a part's word means; several for a plural without a side, none if unknown."""
    plural = is_plural(part.text)
    seen_there = not {"leftmost", "rightmost"}.isdisjoint(part.text.split())
    parts = [] if seen_there else brief.parts  # so in the picture, whatever the file says
    if named := find_named(parts, part.phrase, plural=plural):
        return named
    toward, every = brief.directions.toward, [*enumerate(brief.parts)]
    if alike := find_named(parts, part.phrase, plural=True):  # "its axe", of two: that seen best
        seen = {k: (round(cosine(p.side, toward), 1), p.share) for k, p in every if k in alike}
        return (max(seen, key=lambda k: seen[k]),)
    whole = part.phrase in read_lexicon().parts
    adjective, _, noun = ("", "", part.phrase) if whole else part.phrase.rpartition(" ")
    if noun in _FOLIAGE and not adjective:
        leaves = [k for k, p in every if {*p.roles[:1]} & {*_LEAVES} and p.share < _LEAF]
        if len(leaves) > 2:  # a palm's, a potted plant's, a pineapple's
            return tuple(leaves)
    said = noun if adjective else part.text.lower()
    roles = find_roles(noun) or ([said] if said not in PLACES else [])
    side, front = None, find_front(brief.parts)
    if adjective:
        turned = dict(toward=front, away=front and scale(front, -1.0))
        side = add(turned.get(name) or sum_directions((name,), brief) for name in part.place.names)
    told = [(find_roles(p.name) or split_name(p.name)[-1:], p) for p in brief.parts]
    known = [each.model_copy(update=dict(roles=(*words[:1], *each.roles))) for words, each in told]
    return choose_parts(known, roles, side, plural, "" if seen_there else adjective, toward)


def find_support(clauses: Sequence[Event], brief: SceneBrief, soft: bool = False) -> AnchorRequest:
    """The hold of a free object that sways where it stands, or that is ``soft`` and wobbles: it would slide."""
    resting = (Effect.STILL, Effect.HOLD, Effect.RELEASE)
    acting = [each for each in clauses if each.effect not in resting and not each.motion.lands]
    falls = any(is_landing_meanwhile(*pair) for pair in pairwise(clauses))
    if not brief.may_be_held or brief.world != "ground" or brief.anchored is not None or not acting or falls:
        return AnchorRequest()
    feet = (e.motion.manner == "bend" and not e.parts and leads_aside(e.direction, brief) for e in acting)
    if all(feet) and not any(e.effect in (Effect.LEAN, Effect.TURN) and lies(brief) for e in acting):
        return AnchorRequest(kind="rest", words=acting[0].words, region=FOOT)
    if all(each.motion.manner == "fold" and not each.parts for each in acting):
        return AnchorRequest(kind="rest", words=acting[0].words, region=find_fold(brief).rest)
    if not soft or not all(each.motion.wobbles for each in acting):
        return AnchorRequest()
    for each in (event for event in acting if event.motion.taps):
        each.verb = replace(each.motion, effect=Effect.STRIKE)
    return AnchorRequest(kind="base", words=acting[0].words)


def bears_all(event: Event, brief: SceneBrief) -> bool:
    """Return whether a part that bends, sways or twists is the stem that all the rest stands on."""
    noun = event.parts[0].text.split()[-1] if event.parts else ""
    if noun not in STEMS or event.effect not in _BENDING or brief.object_kind == "plant" or lies(brief):
        return noun in STEMS and event.effect in _BENDING and not lies(brief)
    limbs = [brief.parts[index] for index in find_limbs(event.parts[0], brief)]
    # A mug's handle bears nothing.
    limbs = [each for each in limbs if "nose" not in each.roles and each.roles[:1] != ("handle",)]
    low = [min(place[2] for place in each.moved.inside) < LOW for each in limbs]
    return low == [True] and noun not in ("stem", "stalk")  # a mushroom's bends alone


def moves_pot(event: Event, brief: SceneBrief) -> bool:
    """Return whether the pot of a plant is moved, with all that stands in it: it is then not rooted."""
    noun = event.parts[0].text.lower().split()[-1] if event.parts else ""
    return brief.object_kind == "plant" and noun in _POTS and event.effect in _WITH_ALL


def sticks_out(part: KnownPart) -> bool:
    """Return whether a word means something that sticks out, whatever side it tells: no end of the object."""
    return bool({*find_roles(part.phrase)[:1]} - {*PLACES, "head", "tip", "crown", "neck"})


def find_roles(name: str) -> list[str]:
    """The roles that a part of this name may have, likeliest first; none if its noun tells none."""
    nouns = [word for word in split_name(name) if not word.isdigit()] or [""]
    parts = read_lexicon().parts
    place = parts.get(name) or parts.get(nouns[-1]) or parts.get(nouns[-1].removesuffix("s"))
    return [] if place is None else place.role.split()


def drive_limbs(reply: SemanticReply, brief: SceneBrief) -> SemanticReply:
    """The reply in which limbs are turned about their joints, and the rest is held if nothing else is to move."""
    limbs = [each for each in reply.expectations if each.limb is not None]
    asked = [each for each in limbs if each.kind in _DRIVEN]
    if not limbs:
        return reply
    frame_count = reply.frame_count or brief.frame_count
    moved = [brief.parts[each.limb].moved for each in asked if each.limb is not None]
    kept = [index for index, each in enumerate(reply.force_field.actions) if each.region not in moved]
    actions = tuple(reply.force_field.actions[index] for index in kept)
    alone = all(each in limbs or each.kind is MotionKind.STILL for each in reply.expectations)
    gone = [brief.parts[each.limb] for each in asked if each.manner == "detach" and each.limb is not None]
    falls, anchor = unsettles(gone, brief), reply.anchor  # "the wheels fall off": what stood on them falls
    held = alone and not falls or anchor.kind in ("base", "top") or brief.anchored is not None
    constraints, expectations = list(reply.force_field.constraints), []
    for each in reply.expectations:
        expected = each
        if each in asked:
            more, expected = _drive(each, asked, brief, frame_count, held)
            constraints += more
        expectations.append(expected)
    moving = [each for each in limbs if each.kind is not MotionKind.STILL]  # what is to be still is held
    driven = {e.limb: brief.parts[e.limb] for e in moving or limbs if e.limb is not None}
    turns = bool(asked) and all(e.kind is MotionKind.ROTATE and brief.parts[e.limb or 0].axle for e in asked)
    if falls:
        constraints.append(hold_rest(gone, constraints, brief))
        anchor = anchor if anchor.kind else AnchorRequest(kind="none", words=limbs[0].words)
    elif alone and (anchor.kind is None or anchor.kind == "base" and turns):
        region = join_rest([driven[limb] for limb in sorted(driven)])
        anchor = AnchorRequest(kind="rest", words=limbs[0].words or "a part", region=region)
    elif not alone and brief.anchored is None and anchor.kind in (None, "none"):
        constraints = [_carry(each, [part.moved for part in driven.values()]) for each in constraints]
    field = reply.force_field.model_copy(update=dict(actions=actions, constraints=tuple(constraints)))
    kinds = {each.constraint_type for each in constraints}
    done = next((words for kind, words in _DONE.items() if kind in kinds), "is moved alone")
    moved_parts = ", ".join(each.moved.label or "a part" for each in driven.values())
    note = f"{moved_parts}: it {done}" + (", and the rest is held." if anchor.kind == "rest" else ".")
    told = dict(expectations=tuple(expectations), evidence=_follow(reply.evidence, kept))
    notes = (*reply.notes, note)
    return reply.model_copy(update=dict(told, force_field=field, anchor=anchor, notes=notes))


def _carry(constraint: VelocityConstraint, moved: Sequence) -> VelocityConstraint:
    """A limb's constraint that goes along with the rest, which moves as well: the joint would stay behind."""
    leading = (ConstraintType.PARTICLE_ROTATION, ConstraintType.PARTICLE_TRANSLATION)
    leads = constraint.constraint_type in leading and constraint.region in moved
    return constraint.model_copy(update=dict(carried=True)) if leads else constraint


def _follow(items: Sequence[Evidence], kept: list[int]) -> tuple[Evidence, ...]:
    """Evidence at the actions' new places, without that of actions which a constraint has replaced."""
    places = {f"actions[{old}]": f"actions[{new}]" for new, old in enumerate(kept)}
    found = []
    for item in items:
        place, dot, name = item.field.partition(".")
        if place in places or not place.startswith("actions["):
            found.append(item.model_copy(update=dict(field=f"{places.get(place, place)}{dot}{name}")))
    return tuple(found)


def _drive(
    motion: ExpectedMotion, asked: list[ExpectedMotion], brief: SceneBrief, frame_count: int, held: bool
) -> tuple[list[VelocityConstraint], ExpectedMotion]:
    """The constraints that bring about a limb's motion, and the motion as it is then expected."""
    assert motion.limb is not None
    part = brief.parts[motion.limb]
    if motion.manner == "detach":
        return detach(part, brief, frame_count, motion, held=held)
    before = [e for e in asked if e.limb == motion.limb and e.window[1] <= motion.window[0] + 0.5]
    if motion.manner == "hinge" and (hinge := find_hinge(part, brief)):
        part = part.model_copy(update=dict(joint=hinge.joint))
        first = next(e.limb for e in asked if e.words == motion.words and e.limb is not None)
        motion = hinge.swing(find_hinge(brief.parts[first], brief), motion, before)
    slides = part.seated and (part.origin == "place" or LOOSE.issuperset(find_roles(part.name)))
    later = [e.window[0] for e in asked if e.limb == motion.limb and e.window[0] > motion.window[0] + 0.5]
    until, turning = min([frame_count - 1.0, *later]), Turning(part, brief, frame_count, slides, held=held)
    # Tilted in the air, a lid is still as high as it was lifted.
    before = [e for e in before if e.kind in (motion.kind, MotionKind.MOVE) or not part.seated]
    if before and is_undone(before[-1], motion):
        return turning.undo(before[-1], motion, until)
    if before and motion.kind is MotionKind.SWAY and not before[-1].released:
        return turning.swing_on(before[-1], motion, until)
    return turning.drive(motion, until)
