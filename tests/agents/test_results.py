"""Words of a result or a manner: the line, the amount and the support that they tell."""

import pytest

from physagent_jax.agents.compiler import compile_intent
from physagent_jax.agents.grammar.semantic import read_intent
from physagent_jax.core.errors import UserError
from physagent_jax.forces.part import Part
from tests.agents.tellings import ground, read, tell

LEFT, RIGHT, UP, TOWARD = (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)


def plan(prompt, **changes):
    """The reply with its constraints, for something on the ground."""
    scene = ground(**changes)
    return compile_intent(read_intent(prompt, scene), scene)


def test_longer_is_along_the_long_line():
    """A sword gets longer from hilt to point, and something without a long line across."""
    for line in (RIGHT, UP):
        (motion,) = read("stretch it until it is longer", ground(long_axis=line)).expectations
        assert motion.kind.value == "stretch" and motion.direction == line
    (motion,) = read("it gets longer", ground()).expectations
    assert tell(motion) == "stretch right"


@pytest.mark.parametrize(
    "prompt", ["pull it until it is twice as long", "stretch it until it is twice as long"]
)
def test_how_long_it_becomes_is_a_stretch(prompt):
    (motion,) = read(prompt, ground(long_axis=UP)).expectations
    assert motion.kind.value == "stretch" and motion.amount is not None
    assert (motion.amount.value, motion.amount.unit) == (2.0, "factor")


@pytest.mark.parametrize(
    ("prompt", "gravity"),
    [
        ("it slowly rolls over in the air", "none"),
        ("it spins in the air", "none"),
        ("it hovers in the air", "none"),
        ("it jumps and spins in the air", None),
        ("throw it into the air", None),
        ("wave its head in the air", None),
        ("lift it and turn it in the air", None),
    ],
)
def test_what_only_turns_in_the_air_has_no_weight(prompt, gravity):
    assert read(prompt, ground()).world.gravity == gravity


def make_wing(y: float) -> Part:
    return Part(box=((0.4, 0.0, 0.4), (0.6, 1.0, 0.6)), side=(0.0, y, 0.0), roles=("side",))


def test_rolling_over_is_about_the_object_s_own_line():
    """Its long line, if that lies; the line between its wings; else that of sight."""
    for changes, line in (
        ({"long_axis": RIGHT}, RIGHT),
        ({"long_axis": UP}, TOWARD),
        ({}, TOWARD),
    ):
        for prompt, angle in (
            ("it rolls over in the air", 360),
            ("it turns over", 180),
            ("turn it upside down", 180),
            ("it rolls over until it is upside down", 180),
        ):
            (motion,) = read(prompt, ground(**changes)).expectations
            assert motion.direction == line
            assert motion.amount is not None and motion.amount.value == angle
    (motion,) = read("it rolls over to the left", ground(long_axis=RIGHT)).expectations
    assert motion.direction == TOWARD


def test_its_side_is_across_its_own_line():
    """A thing that is long from left to right falls to or from the viewer, one that stands to the left."""
    for line, axis in ((RIGHT, RIGHT), (UP, TOWARD), (None, TOWARD)):
        for prompt in (
            "knock it onto its side",
            "lay it on its side",
            "it tips over so that it lies on its side",
        ):
            turn, fall = read(prompt, ground(long_axis=line)).expectations
            assert fall.kind.value == "fall"
            assert [abs(c) for c in turn.direction] == [abs(c) for c in axis]


@pytest.mark.parametrize(
    "prompt",
    ["lay the bottle down on the floor", "it gets laid on the table", "it is laid flat on its back"],
)
def test_what_stands_is_laid_down_by_tipping_it_over(prompt):
    """It went down into the floor that it stood on; what is held up is put down instead."""
    assert [each.kind.value for each in read(prompt, ground()).expectations] == ["rotate", "fall"]
    lifted = read(f"pick it up, and then {prompt}", ground()).expectations
    assert [each.kind.value for each in lifted] == ["move", "rotate", "move"]


def test_what_turns_over_is_led():
    """A torque about a level line makes it tumble about others, and one about the vertical topples what is slender."""
    for prompt in ("it rolls over in the air", "spin it by 90 degrees"):
        field = plan(prompt).force_field
        assert not field.actions and len(field.constraints) == 1


def test_what_is_thrown_aside_flies_an_arc():
    """It goes up as well, high enough to be seen to fly, and is judged by the way that is told."""
    reply = read("throw it to the left", ground())
    (blow,) = reply.force_field.actions
    assert blow.vector[2] == pytest.approx(-1.6 * blow.vector[0]) and blow.vector[2] > 0.5
    assert tell(reply.expectations[0]) == "hit left"
    (kick,) = read("kick it to the left", ground()).force_field.actions
    assert kick.vector == LEFT


@pytest.mark.parametrize(
    "prompt", ["it takes off and flies to the right", "it rises, then flies to the right"]
)
def test_what_flies_on_stays_up(prompt):
    """It is carried up, and on to the clip's end."""
    up, aside = plan(prompt).force_field.constraints
    assert up.vector == UP and aside.vector == RIGHT
    assert (up.held_until or up.active_time[1]) == aside.active_time[0]


def test_what_was_carried_on_is_set_down():
    up, aside, down = plan("raise it, move it to the left and put it down").force_field.constraints
    assert (up.vector, aside.vector, down.vector) == (UP, LEFT, (0.0, 0.0, -1.0))
    assert aside.held_until is None or aside.held_until <= down.active_time[0]
    lengths = [hand.magnitude * (hand.active_time[1] - hand.active_time[0]) for hand in (up, down)]
    assert lengths[0] == pytest.approx(lengths[1], rel=0.1)


def test_what_floats_goes_at_one_speed():
    """A force would throw it up and let it drop."""
    reply = plan("it floats slowly upwards")
    (hand,) = reply.force_field.constraints
    assert hand.vector == UP and not reply.force_field.actions
    assert reply.expectations[0].even


def test_slowly_takes_longer_for_as_much():
    """An angle or a way that is told is reached later, not missed."""
    lengths = []
    for prompt in ("quickly turn it by 90 degrees", "turn it by 90 degrees", "slowly turn it by 90 degrees"):
        (motion,) = plan(prompt).expectations
        assert motion.amount is not None and motion.amount.value == 90.0
        lengths.append(motion.window[1] - motion.window[0])
    assert lengths[0] <= lengths[1] < lengths[2]


@pytest.mark.parametrize(
    ("prompt", "angle"),
    [
        ("turn it halfway", 180),
        ("spin it halfway round", 180),
        ("turn it halfway to the left", 90),
        ("tilt it halfway to the left", 45),
        ("tilt it all the way to the left", 90),
        ("bend it all the way down", 90),
    ],
)
def test_how_far_is_an_angle(prompt, angle):
    (motion,) = read(prompt, ground()).expectations
    assert motion.amount is not None and motion.amount.value == angle


def test_halfway_through_is_a_time():
    (motion,) = read("halfway through it spins", ground()).expectations
    assert motion.amount is None and motion.window[0] > 10


def test_lying_down_needs_no_invention():
    """Refuse what is put on something else than a side: it is no toppling."""
    with pytest.raises(UserError):
        read("put it on its shelf", ground())


@pytest.mark.parametrize(
    ("prompt", "told"),
    [
        ("drop it, so it squashes and jiggles", ["fall", "sway left x4"]),
        ("it falls to the floor and flattens", ["fall"]),
        ("it falls and squashes flat when it lands", ["fall"]),
        ("drop it, then squash it flat", ["fall", "squeeze up"]),
    ],
)
def test_what_falls_is_squashed_by_the_ground_alone(prompt, told):
    assert [tell(each) for each in plan(prompt).expectations] == told
