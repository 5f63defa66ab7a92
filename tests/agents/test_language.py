"""Effects of quantities, times, exceptions, surroundings and holding in a sentence."""

import math

import pytest

from physagent_jax.agents.compiler.schedule import LONGEST, STEP
from physagent_jax.core.errors import UserError
from physagent_jax.forces import calibration
from physagent_jax.forces.schema import ConstraintType
from physagent_jax.motion.kinds import choose_kinds
from physagent_jax.motion.schema import MotionKind
from physagent_jax.motion.vectors import cosine
from tests.agents.scenes import read
from tests.agents.sentences import load_table
from tests.agents.tellings import NAMES, ground

TABLE = load_table("quantities.yaml")
UP, LEFT, RIGHT = (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0)


def plant():
    return ground(object_name="plant", object_kind="plant", anchored="it is rooted")


def first(prompt, scene=None):
    return read(prompt, scene or ground()).expectations[0]


def travel(actions, frame_dt=0.04):
    """Displacement that pushes along x give a free body [lengths]: M = 1 is 2 L / T^2 with T = 2 s."""
    speed = place = at = 0.0
    for action in actions:
        begin, end = (frame * frame_dt for frame in action.active_time)
        place += speed * (begin - at)
        a = 2 * calibration.TRAVEL / calibration.REFERENCE_TIME**2 * action.magnitude * action.vector[0]
        place += speed * (end - begin) + 0.5 * a * (end - begin) ** 2
        speed += a * (end - begin)
        at = end
    return place, speed


@pytest.mark.parametrize(
    "words", ["a tenth of a body length", "half a body length", "one body length", "3 body lengths"]
)
def test_a_push_reaches_its_distance_and_stops(words):
    """Closed form: push and brake bring a free body there and to rest, however far it is."""
    lengths = {"a": 0.1, "half": 0.5, "one": 1.0, "3": 3.0}[words.split()[0]]
    words = words.replace("a tenth of a body length", "0.1 body lengths")
    place, speed = travel(read(f"push it {words} to the right", ground()).force_field.actions)
    assert place == pytest.approx(lengths, rel=0.06) and speed == pytest.approx(0.0, abs=0.08)


@pytest.mark.parametrize("degrees", [20, 90, 180, 720])
def test_a_turn_reaches_its_angle(degrees):
    """The same for torques: M = 1 is a quarter turn in 2 s."""
    actions = read(f"spin it by {degrees} degrees counterclockwise", ground()).force_field.actions
    (a, b) = actions
    seconds = 0.04 * (a.active_time[1] - a.active_time[0])
    rate = 2 * calibration.TURN / calibration.REFERENCE_TIME**2 * a.magnitude * a.gain
    assert math.degrees(rate * seconds**2) == pytest.approx(degrees, rel=0.06)
    assert a.magnitude == b.magnitude and a.gain == b.gain and a.vector[2] == -b.vector[2]


@pytest.mark.parametrize(("prompt", "window"), TABLE["times"].items())
def test_told_times_are_the_causes_own(prompt, window):
    """Nothing brakes inside the time that is told."""
    first, last = read(prompt, ground()).force_field.actions[0].active_time
    assert f"{first:g}-{last:g}" == window


@pytest.mark.parametrize(
    ("prompt", "seconds"),
    [
        ("push it left", 2.0), ("push it left, then up, then right", 2 * 1.73 + STEP),
        ("wait two seconds, then push it left", 2 + STEP),
        ("bend left, then let go", 2 * STEP), ("push it left for 3 seconds", 3.0),
        ("after 3 seconds push it left", 3 + 2.0),
        ("sway eight times", 6.0), ("push it left for 99 seconds", LONGEST),
    ],
)  # fmt: skip
def test_the_clip_is_as_long_as_the_sentence_needs(prompt, seconds):
    """A step takes a second and a half at least, a braked one more; the default clip is the least of all."""
    scene = ground()
    reply = read(prompt, scene)
    count = reply.frame_count or scene.frame_count
    assert (count - 1) * 0.04 == pytest.approx(seconds, abs=0.05)
    assert all(a.active_time[1] <= count - 1 for a in reply.force_field.actions)
    fixed = read(prompt, ground(frames_fixed=True))
    assert fixed.frame_count is None
    assert all(a.active_time[1] <= 50 for a in fixed.force_field.actions)


@pytest.mark.parametrize(
    "prompt",
    [
        "push everything except the head to the left", "push the robot to the left, but not the head",
        "everything but the head moves to the left", "push all of it but the head to the left",
    ],
)  # fmt: skip
def test_exceptions_are_not_acted_on(prompt):
    """The region is the rest, and the named end is the one that should not move."""
    reply = read(prompt, ground())
    seen = reply.expectations[0]
    assert seen.excludes_part and seen.part == UP and not reply.unsure
    region = reply.force_field.actions[0].region
    assert cosine(region.normal, UP) == pytest.approx(-1.0)
    assert region.point[2] == pytest.approx(0.72)


def test_named_ends_are_parts():
    """An end is a direction; the middle is a part without one."""
    assert first("push the head to the left").part == UP
    assert first("push the left arm up").part == LEFT
    middle = first("push the middle to the left")
    assert middle.partial and middle.part is None


@pytest.mark.parametrize(("prompt", "gravity"), TABLE["gravity"].items())
def test_gravity_is_told(prompt, gravity):
    """Gravity in the sentence goes into the world; an object that falls upwards is expected there."""
    reply = read(prompt, ground())
    assert reply.world.gravity == gravity
    falls = [e for e in reply.expectations if e.kind is MotionKind.FALL]
    assert gravity != "up" or (falls[0].direction == UP and not reply.force_field.default_drop)


@pytest.mark.parametrize(("prompt", "expected"), TABLE["obstacles"].items())
def test_obstacles_stand_where_the_motion_goes(prompt, expected):
    """A wall is where the sentence puts it, else in the way, and the motion goes there."""
    reply = read(prompt, ground())
    (solid,) = reply.world.obstacles
    assert f"{solid.kind} {NAMES[solid.direction]}" == expected
    moves = [e for e in reply.expectations if e.kind is MotionKind.MOVE]
    assert all(e.direction == solid.direction for e in moves)
    assert moves or solid.kind == "block"


@pytest.mark.parametrize(
    "prompt",
    [
        "bend it to the left and hold it there",
        "hold the plant bent to the left",
        "bend it left and keep it bent",
    ],
)
def test_holding_what_was_moved_keeps_it_there(prompt):
    """It stays, and no part is anchored by it."""
    reply = read(prompt, plant())
    assert reply.expectations[0].stays and not reply.expectations[0].released
    assert reply.anchor.kind is None


def test_holding_before_letting_go_is_no_anchor():
    """A hold that ends in a fall is not a hold of the whole clip."""
    reply = read("hold the robot, then let it fall", ground())
    assert reply.anchor.kind is None and reply.force_field.default_drop


@pytest.mark.parametrize(
    "prompt", ["lift it, then release it", "it is lifted, then dropped", "lift it, then let it fall"]
)
def test_what_is_lifted_and_let_go_falls(prompt):
    """Nothing is pushed down where gravity acts."""
    reply = read(prompt, ground())
    assert [e.kind for e in reply.expectations] == [MotionKind.MOVE, MotionKind.FALL]
    assert [a.vector for a in reply.force_field.actions] == [UP]


def test_strokes_of_their_own():
    """One plain kick and one hard one."""
    a, b = read("kick it twice, the second harder", ground()).force_field.actions
    assert (a.magnitude, b.magnitude) == (1.0, 1.4)


def test_the_other_way():
    """ "The other way" is opposite to the way before."""
    turns = [e for e in read("spin it, stop, spin it the other way", ground()).expectations if e.direction]
    assert turns[0].direction == (0, 0, 1) and turns[1].direction == (0, 0, -1)


def test_counted_blows_with_an_adjective():
    """The number stands before its adjective."""
    assert first("the robot makes two small jumps").repeats == 2


@pytest.mark.parametrize(
    "prompt", ["der Roboter rollt left in die Ecke hinein", "lorem ipsum dolor sit amet left consectetur"]
)
def test_mostly_unknown_words_are_refused(prompt):
    """A few words that happen to be known do not make it a sentence."""
    with pytest.raises(UserError, match="Most words"):
        read(prompt)


def ends(prompt, scene):
    """End, axis and quantity of each turn that is expected."""
    turns = [e for e in read(prompt, scene).expectations if e.kind is MotionKind.ROTATE]
    return [(turn.part, turn.direction, turn.amount and turn.amount.value) for turn in turns]


def test_a_twist_turns_one_end_against_the_other():
    """About the axis that is told, else about the long one; a quantity is the angle between the ends."""
    assert ends("twist it", ground()) == [(UP, UP, None), ((0, 0, -1), (0, 0, -1), None)]
    assert ends("wring it", ground(long_axis=RIGHT)) == [(RIGHT, RIGHT, None), (LEFT, LEFT, None)]
    told = ends("twist it by 90 degrees about the vertical axis", ground(long_axis=RIGHT))
    assert told == [(UP, UP, 45), ((0, 0, -1), (0, 0, -1), 45)]
    reply = read("twist it by 90 degrees", ground())
    assert len(reply.force_field.actions) == 2  # nothing drifts on, so that nothing is braked


def test_a_twist_of_what_is_held_turns_its_free_end():
    assert ends("twist it", plant()) == [(UP, UP, None)]
    assert ends("twist it", plant().model_copy(update=dict(long_axis=RIGHT))) == [(UP, UP, None)]
    assert ends("twist the top", ground()) == [(UP, UP, None)]
    assert ends("spin it", ground()) == [(None, UP, None)]


@pytest.mark.parametrize("degrees", [60, 120])
def test_a_twist_reaches_its_angle(degrees):
    scene = ground()
    reply = read(f"twist it by {degrees} degrees", scene)
    clip = scene.model_copy(update={"frame_count": reply.frame_count or scene.frame_count})
    constraints = choose_kinds(reply.force_field, reply.expectations, clip).force_field.constraints
    assert [c.constraint_type for c in constraints] == [ConstraintType.PARTICLE_ROTATION] * 2
    reference = calibration.find_reference_time(False, (clip.frame_count - 1) * clip.frame_dt)
    for constraint in constraints:
        first, last = constraint.active_time
        turn = calibration.TURN / reference * abs(constraint.magnitude) * (last - first) * scene.frame_dt
        assert math.degrees(turn) == pytest.approx(degrees / 2, rel=0.01)


@pytest.mark.parametrize(
    "sentence",
    ["the robot is floating in space and slowly spins", "floating in space, the robot slowly spins"],
)
def test_floating_is_where_it_is_and_not_what_has_to_be_still(sentence):
    reply = read(sentence)
    assert [each.kind.value for each in reply.expectations] == ["rotate"]
    assert reply.world.gravity == "none" and not reply.unsure
    assert [each.kind.value for each in read("the robot floats in space").expectations] == ["still"]


def test_what_stays_put_is_held_and_a_pause_is_still():
    """A held end is no motion of its own; holding for a time, before something else, is stillness."""
    reply = read("twist the top while the bottom stays put", ground())
    assert reply.anchor.kind == "base" and not reply.unsure
    kinds = [m.kind for m in read("lift it, hold it for one second, then drop it", ground()).expectations]
    assert kinds == [MotionKind.MOVE, MotionKind.STILL, MotionKind.FALL]
    together = read("while it falls, it rotates", ground()).expectations
    assert together[0].window == together[1].window


def test_a_word_for_strength_outweighs_the_verbs_own():
    """Whatever flutters strongly is seen to be strong."""
    assert first("it flutters strongly").strength >= 1.2
    assert first("slam it gently to the left").strength <= 0.7
