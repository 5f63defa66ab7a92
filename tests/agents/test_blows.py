"""Blows from above, dents, raised sides, and falls and tilts of what stands: what the sentences come to."""

from __future__ import annotations

import math

import numpy as np
import pytest

from physagent_jax.agents.grammar.semantic import GrammarSemanticAgent
from physagent_jax.agents.schema import SemanticReply
from physagent_jax.forces.schema import ActionType, CellsRegion, ConstraintType
from physagent_jax.motion.holds import find_blow
from physagent_jax.motion.schema import MotionKind
from tests.agents.scenes import asked, brief

ON_THE_GROUND = brief(object_name="statue", object_kind="object", world="ground")
PLATE, TURN = ConstraintType.MOVING_PLATE, ConstraintType.PARTICLE_ROTATION
BLOW = 0.25  # [s] within which a blow is over


def compile_whole(prompt: str, **changes) -> SemanticReply:
    scene = ON_THE_GROUND.model_copy(update=changes)
    return GrammarSemanticAgent().compile(asked(prompt, scene)).value


@pytest.mark.parametrize(
    "prompt", ["hit the statue from above with a hammer", "slam a fist down on it", "strike it from above"]
)
def test_a_blow_from_above_presses_what_stands_for_a_moment(prompt):
    """The ground bears it: what was pushed down as a whole showed nothing, or jumped."""
    reply = compile_whole(prompt)
    (plate,) = reply.force_field.constraints
    assert not reply.force_field.actions
    assert plate.constraint_type is PLATE and plate.vector == (0.0, 0.0, -1.0) and plate.held_until is None
    assert plate.active_time is not None
    assert (plate.active_time[1] - plate.active_time[0]) * ON_THE_GROUND.frame_dt <= BLOW


def test_each_of_several_blows_from_above_presses():
    """One after the other, and no two at once."""
    plates = compile_whole("hit the statue three times from above").force_field.constraints
    spans = [each.active_time or (0.0, 0.0) for each in plates]
    assert [each.constraint_type for each in plates] == [PLATE] * 3
    assert all(before[1] <= after[0] for before, after in zip(spans, spans[1:]))


def test_a_dent_is_made_at_once_and_stays():
    """A slow squeeze is no blow, and what springs back no dent."""
    reply = compile_whole("a heavy blow dents the statue from above")
    (plate,) = reply.force_field.constraints
    (motion,) = reply.expectations
    assert motion.sudden and motion.stays and not motion.released
    assert plate.active_time is not None and plate.held_until == ON_THE_GROUND.last
    assert (plate.active_time[1] - plate.active_time[0]) * ON_THE_GROUND.frame_dt <= BLOW


@pytest.mark.parametrize(
    ("prompt", "way"),
    [
        ("dent the left side of the statue", "right"),
        ("the statue gets a dent in its right side", "left"),
        ("dent the front of the statue", "away"),
        ("dent the side of the statue", "right"),
        ("dent the statue in the side", "right"),
    ],
)
def test_a_side_is_dented_from_there(prompt, way):
    """It was pressed from above, whichever side was named."""
    reply = compile_whole(prompt)
    (hand,), (motion,) = reply.force_field.constraints, reply.expectations
    assert hand.constraint_type is ConstraintType.PARTICLE_TRANSLATION and isinstance(
        hand.region, CellsRegion
    )
    assert hand.vector == pytest.approx(getattr(ON_THE_GROUND.directions, way))
    assert np.dot(np.subtract(hand.region.inside[0], 0.5), hand.vector) == pytest.approx(-0.5)
    assert hand.held_until == ON_THE_GROUND.last and motion.kind is MotionKind.SQUEEZE and motion.stays


@pytest.mark.parametrize(
    ("prompt", "where"),
    [
        ("hit the statue from above", "down"),
        ("dent the left side of the statue", "right"),
        ("hit the statue from the left", None),
        ("hit the head of the statue from above", None),
        ("hit the statue from above, then push it to the left", None),
        ("dent the statue", None),
    ],
)
def test_blows_that_would_make_it_hop_or_slide_are_told(prompt, where):
    table = ON_THE_GROUND.directions
    way = find_blow(compile_whole(prompt).expectations, table.up)
    assert way == (where and pytest.approx(getattr(table, where)))


def test_what_is_held_at_its_feet_is_pressed_as_well():
    (plate,) = compile_whole(
        "hit the statue from above", anchored="its feet are held"
    ).force_field.constraints
    assert plate.constraint_type is PLATE


def test_what_is_raised_at_one_side_is_tilted_over_its_foot_and_let_go_to_drop():
    """The right side goes up: the top goes to the left. A force on half of it tore it, or did nothing."""
    reply = compile_whole("lift the right side of the statue and let it drop")
    (hand,) = reply.force_field.constraints
    fall = next(each for each in reply.expectations if each.kind is MotionKind.FALL)
    assert hand.constraint_type is TURN and hand.region is None and hand.vector == (0.0, -1.0, 0.0)
    assert hand.held_until == fall.window[0] and not reply.force_field.default_drop


@pytest.mark.parametrize(
    ("prompt", "axis"),
    [
        ("the statue falls to the left", (0.0, -1.0, 0.0)),
        ("the statue falls backwards", (-1.0, 0.0, 0.0)),
        ("the statue falls forward onto its face", (1.0, 0.0, 0.0)),
    ],
)
def test_what_stands_and_falls_aside_tips_over(prompt, axis):
    """It was raised into the air, dropped and pushed."""
    field = compile_whole(prompt).force_field
    assert not field.default_drop and not field.actions
    assert [(each.constraint_type, each.vector) for each in field.constraints] == [(TURN, axis)]


def test_what_was_lifted_still_falls():
    """In the air nothing tips over."""
    reply = compile_whole("lift the statue and let it fall to the left")
    assert all(each.action_type is not ActionType.TORQUE for each in reply.force_field.actions)


@pytest.mark.parametrize(
    "prompt",
    [
        "tilt the statue a little to the left, then let it rock back",
        "tilt it to the left and let it rock back upright",
        "the statue nearly tips over to the left",
        "tip it to the left until it almost falls",
    ],
)
def test_a_tilt_that_comes_back_is_led_there_and_back(prompt):
    """Pushes to and fro slid it, and a torque went on past the balance."""
    hand, back = compile_whole(prompt).force_field.constraints
    assert hand.constraint_type is back.constraint_type is TURN
    assert hand.vector == (0.0, -1.0, 0.0) and back.vector == (0.0, 1.0, 0.0)


@pytest.mark.parametrize("world", ["ground", "free"])
def test_what_topples_is_not_let_fall_from_above(world):
    """An object that cannot stand is without weight until then, and falls over where it is."""
    reply = compile_whole("the statue topples to the left", world=world)
    assert not reply.force_field.default_drop or reply.world.drop_height == 0.0


@pytest.mark.parametrize(
    "way",
    [
        "throw the statue to the ground",
        "the statue is hurled at the hard floor",
        "it gets chucked on the ground",
        "toss it down onto the table",
        "it is pitched against the floor",
    ],
)
def test_what_is_thrown_to_the_ground_falls_fast(way):
    """It stood on the ground, where a blow downwards shows nothing."""
    field = compile_whole(way).force_field
    assert field.default_drop
    assert [each.vector for each in field.actions] == [(0.0, 0.0, -1.0)]


@pytest.mark.parametrize("way", ["slammed onto the table", "banged on the counter", "smashed down hard"])
def test_what_is_slammed_down_falls(way):
    (fall,) = compile_whole(f"the statue is {way}").expectations
    assert fall.kind is MotionKind.FALL


def test_what_is_thrown_aside_is_seen_to_fly_and_lands_about_as_far():
    """A blow of M rises M body lengths upwards: v^2 = 2 g M s with a rise s = sin; rise M s^3, range 4 M s^2 c."""
    (throw,) = compile_whole("throw the statue to the left").force_field.actions
    across, up = math.hypot(*throw.vector[:2]), throw.vector[2]
    assert 0.2 < throw.magnitude * up**3 < 0.4
    assert 0.5 < 4 * throw.magnitude * up**2 * across < 0.9


def test_a_shove_is_short():
    """It accelerated for all of the clip, like a strong wind, and took the object to the end of the domain."""
    (push,) = compile_whole("shove the statue hard to the left").force_field.actions
    assert push.active_time is not None
    assert (push.active_time[1] - push.active_time[0]) * ON_THE_GROUND.frame_dt <= 0.8


@pytest.mark.parametrize(("prompt", "count"), [("the statue hops twice", 2), ("it jumps up three times", 3)])
def test_what_leaps_several_times_lands_before_the_next_leap(prompt, count):
    """It was still in the air, or being pressed by its landing: only the first leap was seen."""
    blows = compile_whole(prompt, frames_fixed=False).force_field.actions
    begins = [each.active_time[0] for each in blows if each.active_time is not None]
    seconds = np.diff(begins).min() * ON_THE_GROUND.frame_dt
    assert len(begins) == count
    for each in blows:
        aloft = math.sqrt(8 * each.magnitude * ON_THE_GROUND.size / 9.8)  # of what rises by M body lengths
        assert 0.3 < aloft <= 0.8 * seconds


@pytest.mark.parametrize(
    "prompt",
    [
        "it drives to the right and then tips over",
        "it slides to the left, then it falls over",
        "tip it over",
    ],
)
def test_what_is_long_and_low_tips_over_across_its_length(prompt):
    """It stood on its nose, and turned a somersault."""
    field = compile_whole(prompt, long_axis=(1.0, 0.0, 0.0), frames_fixed=False).force_field
    (turn,) = [each for each in field.actions if each.action_type is ActionType.TORQUE]
    assert abs(turn.vector[0]) == pytest.approx(1)


@pytest.mark.parametrize(
    "prompt",
    [
        "the statue gets picked up, held in the air for a second, then dropped",
        "the statue is lifted, held up for a second and then dropped",
        "the statue hovers in the air for a second and then drops",
    ],
)
def test_what_is_held_up_for_a_time_rises_first_and_has_its_weight(prompt):
    """The air took its weight from it, or the time was that of its rise."""
    reply = compile_whole(prompt)
    rise, rest, fall = reply.expectations
    assert reply.world.gravity in (None, "down") and not reply.unsure
    assert [each.kind for each in (rise, rest, fall)] == [MotionKind.MOVE, MotionKind.STILL, MotionKind.FALL]
    (hand,) = reply.force_field.constraints
    assert rise.window[1] <= rest.window[0] and hand.held_until == rest.window[1] <= fall.window[0]


def test_what_was_carried_up_is_thrown_up_again_where_it_lands():
    reply = compile_whole("the statue is lifted, dropped, and bounces twice")
    fall = reply.expectations[-1]
    (hand,), kicks = reply.force_field.constraints, reply.force_field.actions
    assert fall.rebounds == len(kicks) == 2
    assert all(each.vector == (0.0, 0.0, 1.0) and each.active_time[0] > hand.active_time[1] for each in kicks)
    heights = [each.magnitude * each.gain for each in kicks]
    assert heights[0] > heights[1]


@pytest.mark.parametrize("told", ["it gets squashed and comes back up", "it squishes and springs back"])
def test_what_is_pressed_and_gives_way_is_pressed_once(told):
    (squeeze,) = compile_whole(f"something heavy presses the statue down, {told}").expectations
    assert squeeze.kind is MotionKind.SQUEEZE and squeeze.released


@pytest.mark.parametrize(
    "told", ["something pushes it from behind and it tips over", "it gets pushed from behind and falls over"]
)
def test_who_is_pushed_over_after_leaps_falls_after_them(told):
    """It tipped over in the air, from the first frame on."""
    reply = compile_whole(f"the statue jumps twice, then {told}")
    leap = next(each for each in reply.expectations if each.kind is MotionKind.MOVE)
    turn = next(each for each in reply.expectations if each.kind is MotionKind.ROTATE)
    assert turn.window[0] >= leap.window[1]
    (hand,) = [each for each in reply.force_field.constraints if each.constraint_type is TURN]
    assert hand.touched


@pytest.mark.parametrize(("told", "turns"), [("a couple of times", 2), ("a few times", 3)])
def test_turns_that_are_counted_vaguely_are_counted(told, turns):
    (turn,) = compile_whole(f"the statue spins around {told}").expectations
    assert turn.amount is not None and turn.amount.value == 360.0 * turns


@pytest.mark.parametrize("before", ["", "the statue rolls to the right, then ", "the statue jumps up, then "])
@pytest.mark.parametrize("thing", ["something heavy", "something", "a heavy weight"])
def test_something_that_comes_down_presses_it_wherever_it_is(before, thing):
    """The statue itself fell, or its ends were moved as they had stood at first."""
    reply = compile_whole(f"{before}{thing} comes down and squashes it flat")
    plates = [each for each in reply.force_field.constraints if each.constraint_type is PLATE]
    assert [each.vector for each in plates] == [(0.0, 0.0, -1.0)] and not reply.force_field.default_drop
    assert reply.expectations[-1].kind is MotionKind.SQUEEZE
