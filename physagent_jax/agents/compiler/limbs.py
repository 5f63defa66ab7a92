"""Parts that stick out of the object: which one a word means, and how it is moved.

A force on a limb drags the whole object along and bends the limb little. A viewer expects the limb to turn about its
joint while the rest stays, so that is prescribed: the limb turns about its joint, or moves along itself, and where a
sentence moves limbs alone the rest is held.
"""

from __future__ import annotations

from physagent_jax.agents.compiler.directions import sum_directions
from physagent_jax.agents.compiler.events import KnownPart
from physagent_jax.agents.lexicon import read_lexicon
from physagent_jax.agents.schema import Evidence, SemanticReply
from physagent_jax.forces.part import split_name
from physagent_jax.forces.schema import ConstraintType, VelocityConstraint
from physagent_jax.motion.limbs import (
    LOOSE,
    PLACES,
    Turning,
    choose_parts,
    find_angle,
    find_front,
    find_swing,
)
from physagent_jax.motion.parts import find_named, join_rest
from physagent_jax.motion.schema import AnchorRequest, ExpectedMotion, MotionKind, SceneBrief
from physagent_jax.motion.vectors import add, scale
from physagent_jax.motion.windows import divide

_TIME = 1.0  # [s] in which a limb gets where it goes, at most
_SWINGS = 2  # of a limb that wags, unless the sentence counts them
_DRIVEN = (MotionKind.MOVE, MotionKind.SWAY, MotionKind.ROTATE)


def find_limbs(part: KnownPart, brief: SceneBrief) -> tuple[int, ...]:
    """Places in the brief's parts of what a part's word means; several for a plural without a side, none if unknown."""
    if named := find_named(brief.parts, part.phrase, plural=_is_plural(part.text)):
        return named
    adjective, _, noun = part.phrase.rpartition(" ")
    said = noun if adjective else part.text.lower()
    roles = _find_roles(noun) or ([said] if said not in PLACES else [])
    side, front = None, find_front(brief.parts)
    if adjective:
        turned = dict(toward=front, away=front and scale(front, -1.0))
        side = add(turned.get(name) or sum_directions((name,), brief) for name in part.place.names)
    known = [
        each.model_copy(update=dict(roles=(*_find_roles(each.name)[:1], *each.roles))) for each in brief.parts
    ]
    return choose_parts(known, roles, side, _is_plural(part.text))


def _find_roles(name: str) -> list[str]:
    """The roles that a part of this name may have, likeliest first; none if its noun tells none."""
    nouns = [word for word in split_name(name) if not word.isdigit()] or [""]
    parts = read_lexicon().parts
    place = parts.get(nouns[-1]) or parts.get(nouns[-1].removesuffix("s"))
    return [] if place is None else place.role.split()


def _is_plural(text: str) -> bool:
    word = text.split()[-1].lower() if text.split() else ""
    return word.endswith("s") or word == "feet"


def drive_limbs(reply: SemanticReply, brief: SceneBrief) -> SemanticReply:
    """The reply in which limbs are turned about their joints, and the rest is held if nothing else is to move."""
    asked = [each for each in reply.expectations if each.limb is not None and each.kind in _DRIVEN]
    if not asked:
        return reply
    frame_count = reply.frame_count or brief.frame_count
    moved = [brief.parts[each.limb].moved for each in asked if each.limb is not None]
    kept = [index for index, each in enumerate(reply.force_field.actions) if each.region not in moved]
    actions = tuple(reply.force_field.actions[index] for index in kept)
    constraints, expectations = list(reply.force_field.constraints), []
    for each in reply.expectations:
        expected = each
        if each in asked:
            more, expected = _drive(each, asked, brief, frame_count)
            constraints += more
        expectations.append(expected)
    alone = all(each.limb is not None or each.kind is MotionKind.STILL for each in reply.expectations)
    anchor = reply.anchor
    if alone and anchor.kind is None:
        limbs = sorted({each.limb for each in asked if each.limb is not None})
        words = asked[0].words or "a part"
        anchor = AnchorRequest(kind="rest", words=words, region=join_rest([brief.parts[k] for k in limbs]))
    field = reply.force_field.model_copy(update=dict(actions=actions, constraints=tuple(constraints)))
    turns = any(each.constraint_type is ConstraintType.PARTICLE_ROTATION for each in constraints)
    done = "turns about its joint" if turns else "moves as a whole"
    note = f"A part {done}" + (", and the rest is held." if anchor.kind == "rest" else ".")
    return reply.model_copy(
        update=dict(
            force_field=field,
            expectations=tuple(expectations),
            anchor=anchor,
            evidence=tuple(_follow(each, kept) for each in reply.evidence if _is_kept(each, kept)),
            notes=(*reply.notes, note),
        )
    )


def _is_kept(item: Evidence, kept: list[int]) -> bool:
    """Return whether an item is about something else than an action that a constraint has replaced."""
    index = _find_action(item)
    return index is None or index in kept


def _follow(item: Evidence, kept: list[int]) -> Evidence:
    """Evidence of an action at the action's new place."""
    index = _find_action(item)
    if index is None:
        return item
    _, dot, name = item.field.partition(".")
    return item.model_copy(update=dict(field=f"actions[{kept.index(index)}]{dot}{name}"))


def _find_action(item: Evidence) -> int | None:
    group, _, index = item.field.partition(".")[0].rstrip("]").partition("[")
    return int(index) if group == "actions" else None


def _drive(
    motion: ExpectedMotion, asked: list[ExpectedMotion], brief: SceneBrief, frame_count: int
) -> tuple[list[VelocityConstraint], ExpectedMotion]:
    """The constraints that bring about a limb's motion, and the motion as it is then expected."""
    assert motion.limb is not None
    part, last = brief.parts[motion.limb], frame_count - 1.0
    slides = part.seated and LOOSE.issuperset(_find_roles(part.name))
    turning = Turning(part, brief, frame_count, slides)
    first, end = motion.window
    if motion.kind is MotionKind.SWAY:
        way = motion.direction or find_swing(part, brief)
        swings = max(motion.repeats, _SWINGS)
        windows = divide((first, end), [0.5, *[1.0] * (2 * swings - 1), 0.5])
        windows = [window for window in windows if window[1] - window[0] >= 1.0] or [(first, end)]
        angle = find_angle(motion) * 0.6
        made = []
        for index, window in enumerate(windows):
            share = (window[1] - window[0]) / max(each[1] - each[0] for each in windows)
            made.append(turning.bring(way, motion, (-1) ** index * angle * 2 * share, window, None))
        return made, motion.model_copy(update=dict(direction=way, repeats=swings, limb=motion.limb))
    later = [e.window[0] for e in asked if e.limb == motion.limb and e.window[0] > first + 0.5]
    until = min([last, *later])
    window = (first, min(end, first + max(_TIME / brief.frame_dt, 2.0), until))
    stop = None if motion.released or until <= window[1] else until
    if motion.kind is MotionKind.ROTATE and motion.direction is not None:
        made = turning.driver.turn(motion.direction, find_angle(motion), window, stop)
    else:
        angle = find_angle(motion)
        way = turning.find_course(motion.direction or find_swing(part, brief), angle)
        made = turning.bring(way, motion, angle, window, stop)
        motion = motion if motion.direction is None else motion.model_copy(update=dict(direction=way))
    return [made], motion
