"""Consequences of an act, and of a landing: a fall, a bow, a dent, a wobble."""

import pytest

from physagent_jax.motion.schema import MotionKind
from tests.agents.scenes import brief, read


@pytest.mark.parametrize("still", ["but the legs stay put", "and the legs stay still"])
def test_a_part_that_stays_put_does_so_while_the_other_moves(still):
    reply = read(f"the top of the robot sways in a storm {still}")
    windows = {each.window for each in reply.expectations}
    assert len(windows) == 1


PLANT = brief(object_name="ficus", object_kind="plant", world="ground", anchored="base", may_be_held=True)


@pytest.mark.parametrize(
    "prompt", ["push the pot to the right", "a small shove makes the pot rock", "the pot tips over"]
)
def test_a_pot_that_moves_takes_its_plant_along_and_is_not_rooted(prompt):
    reply = read(prompt, PLANT)
    assert reply.anchor.kind == "none" and not reply.unknown_parts
    assert all(each.part is None and not each.partial for each in reply.expectations)


@pytest.mark.parametrize(
    "prompt",
    [
        "the robot falls over when it is hit from the left",
        "when it is hit from the left, the robot falls over",
        "it is hit from the left so that it falls over",
    ],
)
def test_what_happens_when_it_is_acted_on_comes_of_that(prompt):
    """It fell over by itself, no way told, and was hit as well."""
    seen = read(prompt, brief(world="ground")).expectations
    (turn,) = [each for each in seen if each.kind is MotionKind.ROTATE]
    assert turn.direction == (0.0, 1.0, 0.0)


@pytest.mark.parametrize(
    "prompt",
    [
        "the robot crumples when a hand presses on it from above",
        "the robot is pressed from above and crumples",
    ],
)
def test_what_is_pressed_and_crumples_is_pressed_once(prompt):
    first = read(prompt, brief(world="ground")).expectations[0]
    assert first.kind is MotionKind.SQUEEZE and first.direction == (0.0, 0.0, -1.0)


@pytest.mark.parametrize(
    "prompt",
    [
        "punch the robot in the stomach so it folds forward",
        "the robot folds forward",
        "hit it so that it doubles over",
    ],
)
def test_what_is_hit_in_the_stomach_bows_as_a_whole(prompt):
    (seen,) = read(prompt, brief(world="ground")).expectations
    assert seen.kind is MotionKind.ROTATE and seen.part is None and not seen.partial
    assert seen.direction == (1.0, 0.0, 0.0)  # its top towards us


def test_what_stands_straight_again_comes_back():
    (seen,) = read("the robot leans back slowly, then stands straight again").expectations
    assert seen.kind is MotionKind.ROTATE and seen.released


@pytest.mark.parametrize(
    "prompt",
    ["it is struck on its left side and keeps the dent", "hit it on its left side so that a dent stays"],
)
def test_a_dent_is_left_where_it_was_struck(prompt):
    (seen,) = read(prompt).expectations
    assert seen.kind is MotionKind.SQUEEZE and seen.stays and seen.part == (-1.0, 0.0, 0.0)


def test_what_is_lifted_off_goes_up_and_is_put_back_down():
    up, down = read("someone lifts the top off and puts it back").expectations
    assert up.direction == (0.0, 0.0, 1.0) and down.direction == (0.0, 0.0, -1.0) and down.put_back


@pytest.mark.parametrize("prompt", ["drop it, no bouncing just a heavy thud", "drop it without bouncing"])
def test_what_is_not_to_bounce_is_not_thrown_up_again(prompt):
    reply = read(prompt, brief(world="ground"))
    assert not reply.force_field.actions and reply.force_field.default_drop


@pytest.mark.parametrize(
    ("prompt", "count", "counted"),
    [
        ("the robot is made of rubber, it gets dropped, squashes on the floor and bounces back up", 2, False),
        ("drop the robot so that it bounces right back up", 2, False),
        ("drop the robot and let it bounce a couple of times", 2, False),
        ("drop the robot and let it bounce three times", 3, True),
    ],
)
def test_what_bounces_back_up_is_thrown_up_again_and_that_is_looked_for(prompt, count, counted):
    reply = read(prompt, brief(world="ground"))
    (fall,) = reply.expectations
    assert (fall.kind, fall.rebounds, fall.counted) == (MotionKind.FALL, count, counted)
    assert len(reply.force_field.actions) == count and not reply.force_field.constraints


@pytest.mark.parametrize(
    "prompt",
    [
        "throw the robot down onto the floor so that it bounces back up",
        "it is hurled to the ground and bounces",
    ],
)
def test_what_is_thrown_down_bounces(prompt):
    """It was thrown up first, or fell twice."""
    reply = read(prompt, brief(world="ground"))
    (fall,) = reply.expectations
    assert fall.kind is MotionKind.FALL and fall.rebounds and reply.force_field.default_drop


@pytest.mark.parametrize(
    ("prompt", "kinds"),
    [
        ("the robot falls down and bursts into pieces", [MotionKind.FALL]),
        ("the robot falls and explodes", [MotionKind.FALL, MotionKind.STRETCH]),
        ("drop the robot so that it explodes", [MotionKind.FALL, MotionKind.STRETCH]),
        ("drop it from high up so it bursts open", [MotionKind.FALL, MotionKind.STRETCH]),
        ("let the robot fall so it pops", [MotionKind.FALL, MotionKind.STRETCH]),
    ],
)
def test_what_falls_and_bursts_does_so_where_it_lands(prompt, kinds):
    reply = read(prompt, brief(world="ground"))
    assert [each.kind for each in reply.expectations] == kinds
    assert all(each.window[0] > 10 for each in reply.expectations[1:])


def test_what_is_soft_wobbles_by_itself_as_it_lands():
    """Led to and fro, it hung where it had bounced to."""
    scene = brief(object_name="jelly", object_kind="jelly", world="ground")
    reply = read("the jelly is dropped and wobbles when it lands", scene)
    assert [each.kind for each in reply.expectations] == [MotionKind.FALL]
    firm = read("the robot is dropped and wobbles when it lands", brief(world="ground"))
    assert MotionKind.SWAY in {each.kind for each in firm.expectations}


@pytest.mark.parametrize(
    "prompt",
    [
        "the robot falls over to the left, then it gets up again",
        "tip the robot over to the left and stand it back upright",
        "it is blown over to the left yet rights itself",
        "knock it over to the left, then put it back on its feet",
        "the robot tips over to the left and is pushed back onto its base",
    ],
)
def test_what_has_fallen_over_is_turned_upright_again(prompt):
    """Its weight does not do that; it was read as the end of the fall."""
    *fallen, raised = read(prompt, brief(world="ground")).expectations
    assert raised.kind is MotionKind.ROTATE and raised.put_back and raised.amount.value == 90
    over = next(each for each in fallen if each.kind is MotionKind.ROTATE)
    assert raised.direction == tuple(-c for c in over.direction) and raised.window[0] >= over.window[1]


@pytest.mark.parametrize(
    "prompt", ["a ball hits its head and the robot rocks", "a nudge and it rocks a little"]
)
def test_what_sets_it_rocking_does_not_push_it_away(prompt):
    (seen,) = read(prompt, brief(world="ground")).expectations
    assert seen.kind is MotionKind.SWAY and seen.manner == "rock"


@pytest.mark.parametrize("part", ["foot", "base"])
def test_a_kick_at_what_it_stands_on_goes_sideways(part):
    (seen,) = read(f"kick the robot at its {part}", brief(world="ground")).expectations
    assert seen.direction == (-1.0, 0.0, 0.0)


def test_what_acts_in_vain_is_said_to_be_left_out():
    notes = read("kick the robot hard, but it does not move", brief(world="ground")).notes
    assert any("'kick' acts on it, but it is not to move" in each for each in notes)
    assert not any("acts on it" in each for each in read("the robot stays still").notes)


@pytest.mark.parametrize("verb", ["sways", "springs", "leans", "eases", "rises"])
@pytest.mark.parametrize("end", ["back upright", "upright again", "straight again"])
def test_what_is_bent_comes_back_upright_by_itself(verb, end):
    plant = brief(object_name="plant", object_kind="plant", anchored="the base", world="ground")
    reply = read(f"a gust bends the plant over to the left, then it {verb} {end}", plant)
    (bent,) = reply.expectations
    assert bent.kind is MotionKind.MOVE and bent.released and not reply.unsure


@pytest.mark.parametrize(
    "end", ["then they lift their hand", "and removes their fingers", "then pulls their foot away"]
)
def test_the_hand_of_whoever_presses_is_taken_away_and_no_part_of_the_object(end):
    reply = read(f"someone pushes down hard on the robot, {end} and it springs back", brief(world="ground"))
    (pressed,) = reply.expectations
    assert pressed.released and not reply.unsure and not reply.unknown_parts


@pytest.mark.parametrize(
    ("prompt", "kinds"),
    [
        ("a heavy block squashes the robot, then it is taken away again", "squeeze"),
        ("the robot is pressed down by a big stone which then rolls off", "squeeze"),
        ("an elephant sits on the robot and gets up again", "squeeze"),
        ("a thumb presses the robot flat, then the thumb is withdrawn", "squeeze"),
        ("a palm comes down and flattens the robot, then it pulls back", "squeeze"),
        ("a hand squeezes the robot and lifts it away", "squeeze move"),
        ("someone squashes the robot, then it is lifted away", "squeeze move"),
        ("the robot gets pressed flat and is then lifted off the ground", "squeeze move"),
    ],
)
def test_what_presses_and_goes_away_is_not_the_object(prompt, kinds):
    reply = read(prompt, brief(world="ground"))
    assert " ".join(each.kind.value for each in reply.expectations) == kinds
    assert reply.expectations[0].released == (kinds == "squeeze") and not reply.unsure


def test_what_is_lifted_and_held_there_for_a_time_is_up_there_so_long():
    raised, held, fall = read(
        "lift the robot, hold it there for a second, then let go", brief(world="ground", frames_fixed=False)
    ).expectations
    assert (raised.kind, held.kind, fall.kind) == (MotionKind.MOVE, MotionKind.STILL, MotionKind.FALL)
    assert raised.amount is None and (held.window[1] - held.window[0]) * 0.04 == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize(
    ("words", "counted"), [("a few times", False), ("several times", False), ("twice", True)]
)
def test_only_a_number_is_counted(words, counted):
    (sway,) = read(f"the robot sways left and right {words}", brief(anchored="base")).expectations
    assert sway.counted is counted
