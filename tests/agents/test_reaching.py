"""A quantity in its time: what is read, what carries it out, and that it gets there by the definitions of M = 1."""

import math

import pytest

from physagent_jax.forces.calibration import DROP_HEIGHT, GRAVITY, PRESCRIBED_TRAVEL, TURN
from physagent_jax.forces.schema import ActionType, ConstraintType
from physagent_jax.motion.kinds import choose_kinds
from tests.agents.scenes import brief, read
from tests.agents.tellings import ground

SECOND = {"frame_count": 26}  # of 0.04 s
LEFT, RIGHT, UP = (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def planned(prompt, **changes):
    """The reading of a sentence, and the skills that carry it out."""
    scene = brief(**(SECOND | changes))
    reply = read(prompt, scene)
    field = choose_kinds(reply.force_field, reply.expectations, scene).force_field
    return reply, field, scene.frame_count - 1


def travelled(constraint, frames):
    """The distance of a prescribed velocity [body lengths]; `PRESCRIBED_TRAVEL` per clip of at most two seconds."""
    first, until = constraint.active_time
    return PRESCRIBED_TRAVEL * constraint.magnitude * (until - first) / frames


@pytest.mark.parametrize(
    ("words", "frames"),
    [
        ("in half a second", 12),
        ("within half a second", 12),
        ("in a second", 25),
        ("over a second", 25),
        ("within four tenths of a second", 10),
    ],
)
def test_the_time_in_which_a_way_is_gone_is_its_window(words, frames):
    reply, _, _ = planned(f"push it to the left by half of its length {words}")
    (motion,) = reply.expectations
    assert (motion.window, reply.unsure) == ((0, frames), ()) and motion.amount.value == 0.5


def test_seconds_and_a_half():
    reply, _, last = planned("push it left by half its length in a second and a half", frame_count=76)
    assert reply.expectations[0].window == (0, 38) and not reply.unsure and last == 75


def test_the_second_half_need_not_be_named_again():
    reply, _, last = planned("push it left in the first half, then turn it in the second", frame_count=49)
    assert [e.window for e in reply.expectations] == [(0, last / 2), (last / 2, last)] and not reply.unsure
    assert planned("push it to the left in the first half and up in the second")[0].unsure


@pytest.mark.parametrize("way", [0.4, 0.5, 2.0])
def test_a_way_that_no_force_can_start_and_stop_in_time_is_led(way):
    """2 s / (t / T)^2 is beyond 1.6: the prescribed velocity gets there, or it is said that it does not."""
    reply, field, last = planned(f"push it to the left by {way} lengths within 0.68 seconds")
    (hand,) = field.constraints
    assert not field.actions and hand.constraint_type is ConstraintType.PARTICLE_TRANSLATION
    assert hand.vector == LEFT and hand.active_time == (0, 17) and hand.held_until == last
    most = 1.6 * PRESCRIBED_TRAVEL * 17 / last
    assert travelled(hand, last) == pytest.approx(min(way, most), rel=0.01)
    reasons = choose_kinds(reply.force_field, reply.expectations, brief(**SECOND)).reasons
    assert any("as far as the fastest goes" in why for why in reasons) == (way > 1.01 * most)


def test_a_turn_that_no_torque_can_start_and_stop_in_time_is_led():
    _, field, last = planned(
        "turn it by 60 degrees about the vertical, counter-clockwise, within half a second"
    )
    (hand,) = field.constraints
    first, until = hand.active_time
    assert (
        hand.constraint_type is ConstraintType.PARTICLE_ROTATION and until <= 12 and hand.held_until == last
    )
    turned = math.degrees(TURN * hand.magnitude * (until - first) / last)
    assert turned == pytest.approx(60, rel=0.02)


def test_what_a_force_can_do_stays_a_force():
    _, field, _ = planned("push it to the left by a third of its length", frame_count=51)
    assert not field.constraints and {a.action_type for a in field.actions} == {ActionType.TRANSLATION}


@pytest.mark.parametrize("frame_count", [26, 31, 38, 51])
def test_what_is_braked_comes_to_rest_where_it_should(frame_count):
    """As many whole frames of pushing as of braking: 2 (M / T^2) (t / 2)^2 body lengths, and no speed is left."""
    _, field, last = planned("push it to the left by 0.3 lengths", frame_count=frame_count)
    push, brake = field.actions
    (first, middle), (again, end) = push.active_time, brake.active_time
    assert middle == again and middle - first == end - middle and last - end <= 1
    assert (push.vector, push.magnitude) == (LEFT, brake.magnitude) and brake.vector == RIGHT
    assert 2 * push.magnitude * ((middle - first) / last) ** 2 == pytest.approx(0.3, rel=2e-3)


def test_what_is_led_leaves_room_for_the_next_step():
    prompt = "push it left by 0.4 lengths in the first half, then up by 0.3 lengths in the second half"
    _, field, _ = planned(prompt)
    one, two = field.constraints
    assert one.active_time[1] <= two.active_time[0] and (one.held_until or 0) <= two.active_time[0]


@pytest.mark.parametrize(
    ("prompt", "least", "most"),
    [
        ("the robot suddenly moves to the left", 0.4, 0.8),
        ("the robot flinches", 0.1, 0.3),
        ("all at once the robot turns to the left", 60, 120),
    ],
)
def test_what_is_sudden_is_over_at_once(prompt, least, most):
    """It is led as far as words promise of all of the clip; what is slow is pushed to the end."""
    reply, field, last = planned(prompt, frame_count=51, world="ground")
    (hand,), (motion,) = field.constraints, reply.expectations
    first, until = hand.active_time
    assert first == motion.window[0] and until - first <= 13 < last and not field.actions
    turn = math.degrees(TURN) / PRESCRIBED_TRAVEL if motion.kind.value == "rotate" else 1.0
    assert least < travelled(hand, last) * hand.gain * turn < most
    slow, pushed, _ = planned("the robot gradually moves to the left", frame_count=51, world="ground")
    assert not pushed.constraints and slow.expectations[0].window[1] == last


def test_evenly_is_at_one_speed():
    reply, field, last = planned("push it evenly to the left by a quarter of its length", frame_count=51)
    assert reply.expectations[0].even and not reply.unsure
    (hand,) = field.constraints
    assert travelled(hand, last) == pytest.approx(0.25, rel=0.02)
    struck, field, _ = planned("hit it at once so that it flies evenly to the left, by half of its length")
    assert struck.expectations[0].even and field.actions[0].action_type is ActionType.IMPULSE
    assert not planned("stretch it evenly upwards")[0].expectations[0].even


@pytest.mark.parametrize(
    "prompt",
    [
        "stretch it sideways by a fifth within a third of a second and keep it so",
        "it becomes a fifth wider within a third of a second",
        "pull its left and right ends apart: a fifth longer within a third of a second",
        "squeeze it from the left and the right by a twelfth within a third of a second",
    ],
)
def test_a_length_that_is_reached_is_kept(prompt):
    reply, field, last = planned(prompt)
    assert [e.stays for e in reply.expectations] == [True] and not reply.unsure
    assert {c.held_until for c in field.constraints} == {last}
    assert all(c.active_time[1] <= 8 for c in field.constraints)


def test_a_twist_that_is_reached_is_kept():
    reply, field, last = planned("twist it about the vertical by 40 degrees within half a second")
    assert [e.stays for e in reply.expectations] == [True, True] and not reply.unsure
    assert {c.held_until for c in field.constraints} == {last}


def test_a_length_that_is_let_go_is_not_kept():
    reply, field, last = planned("stretch it sideways by a fifth within half a second, then let go")
    assert not reply.expectations[0].stays and all(c.held_until < last for c in field.constraints)


def test_moved_ends_go_as_far_as_the_sentence_says():
    """The middle follows in proportion, so that the whole is a fifth longer."""
    _, field, last = planned("stretch it sideways by 20 percent within half a second")
    one, two = field.constraints
    assert travelled(one, last) + travelled(two, last) == pytest.approx(0.2, rel=0.03)


def test_what_was_squeezed_is_brought_back_before_it_is_stretched():
    """By the same two ends: a plate leaves them nearly where they are, and cannot pull."""
    prompt = "squeeze it from the left and the right by a seventh in the first half, then stretch it the same way by "
    alone = planned("stretch it sideways by a seventh in the second half")[1].constraints
    after = planned(prompt + "a seventh until the end")[1].constraints
    assert {c.constraint_type for c in after} == {ConstraintType.PARTICLE_TRANSLATION} and len(after) == 4
    inward, outward = after[0], after[2]
    assert inward.held_until <= outward.active_time[0] and inward.region == outward.region
    assert inward.vector == tuple(-c for c in outward.vector)
    assert travelled(outward, 25) == pytest.approx(2 * travelled(alone[0], 25), rel=0.05)
    assert travelled(outward, 25) == pytest.approx(2 * travelled(inward, 25), rel=0.05)


def test_back_is_as_far_as_it_is_away():
    reply, _, _ = planned("turn it by 15 degrees counter-clockwise in the first half, then back")
    one, two = reply.expectations
    assert (one.amount, two.direction) == (two.amount, tuple(-c for c in one.direction))
    reply, _, _ = planned("push it left by 0.3 lengths, then left by 0.2 lengths, then back")
    assert [e.amount.value for e in reply.expectations] == pytest.approx([0.3, 0.2, 0.5])


def test_a_swing_in_steps():
    """To one side, through where it began to the other, and back there, in the time of all three."""
    prompt = "it goes to the left by 0.2 lengths, then as far to the right of where it began, and back, in a second"
    reply, field, last = planned(prompt)
    ways = [e.direction[0] * e.amount.value for e in reply.expectations]
    assert ways == pytest.approx([-0.2, 0.4, -0.2]) and not reply.unsure
    assert [e.window for e in reply.expectations] == [(0, 6), (6, 19), (19, 25)]
    assert sum(c.vector[0] * travelled(c, last) for c in field.constraints) == pytest.approx(0, abs=0.02)


def test_what_stands_behind_a_colon_measures_what_stands_before():
    prompt = (
        "wring it: its upper end turns by 40 degrees against its lower end, counter-clockwise seen from above"
    )
    reply, _, _ = planned(prompt)
    up, down = reply.expectations
    assert (up.direction, down.direction, reply.unsure) == (UP, (0, 0, -1), ())
    assert (up.part, down.part) == (UP, (0, 0, -1)) and up.amount.value + down.amount.value == 40


def test_a_thing_that_lands_aside_is_thrown_there():
    """From half its length it falls for sqrt(2 h / g); a blow of M is M body lengths per clip."""
    prompt = (
        "drop it from half its length; as it reaches the ground it is 0.4 of its length farther to the right"
    )
    reply, field, last = planned(prompt, size=0.8)
    (blow,) = field.actions
    seconds = math.sqrt(2 * DROP_HEIGHT * 0.8 / GRAVITY)
    assert (
        field.default_drop
        and not reply.unsure
        and (blow.action_type, blow.vector)
        == (
            ActionType.IMPULSE,
            RIGHT,
        )
    )
    assert blow.magnitude * seconds / (last * 0.04) == pytest.approx(0.4, rel=1e-3)
    move = next(e for e in reply.expectations if e.direction == RIGHT)
    assert move.window == (0, round(seconds / 0.04)) and move.amount.value == 0.4


def test_a_throw_on_the_ground_rises_by_its_magnitude():
    """A throw against weight rises by M body lengths (`forces.opposition`); the fall is not measured by the rise."""
    reply = read("throw it up by six tenths of its length; then it is back where it was", ground())
    (blow,) = reply.force_field.actions
    assert (blow.vector, blow.magnitude) == (UP, 0.6)
    assert [e.amount is None for e in reply.expectations] == [False, True]
