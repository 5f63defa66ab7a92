"""Tipping over, spinning and flipping as sentences tell them: how slowly, how far, and in the air."""

import math

import pytest

from physagent_jax.agents.grammar.semantic import GrammarSemanticAgent, read_sentence
from physagent_jax.forces.calibration import GRAVITY, MOST_DROP, REFERENCE_TIME, TURN
from physagent_jax.forces.schema import ActionType, ConstraintType
from physagent_jax.motion.schema import MotionKind
from physagent_jax.motion.tipping import tip
from physagent_jax.motion.vectors import dot
from tests.agents.scenes import asked, brief, judge, make_report, ramp
from tests.agents.test_named_parts import make_part

ON_THE_GROUND = brief(object_name="statue", object_kind="object", world="ground", frames_fixed=False)
SLIM, BROAD = (0.3, 1.0, 0.3), (1.0, 0.5, 1.0)
LEFT, RIGHT = (0.0, -1.0, 0.0), (0.0, 1.0, 0.0)


def compile_whole(prompt: str, **changes):
    scene = ON_THE_GROUND.model_copy(update=dict(extents=SLIM) | changes)
    return GrammarSemanticAgent().compile(asked(prompt, scene)).value


def find_degrees(turn, reply):
    """Angle and time [s] of a turn that is led."""
    seconds = (turn.active_time[1] - turn.active_time[0]) * ON_THE_GROUND.frame_dt
    clip = ((reply.frame_count or ON_THE_GROUND.frame_count) - 1) * ON_THE_GROUND.frame_dt
    rate = math.degrees(TURN) * turn.magnitude * turn.gain / min(REFERENCE_TIME, clip)
    return rate * seconds, seconds


@pytest.mark.parametrize(
    ("prompt", "axis"),
    [
        ("the statue slowly tilts to the left and falls over", LEFT),
        ("the statue slowly topples over to the right", RIGHT),
        ("gently tip the statue over to the left", LEFT),
        ("tilt the statue slowly to the right until it tips over", RIGHT),
        ("the statue leans further and further to the right until it falls over", RIGHT),
    ],
)
def test_what_tips_over_slowly_is_led_over_its_edge(prompt, axis):
    """It lay within half a second, however slowly it was to tip."""
    reply = compile_whole(prompt)
    (turn,) = reply.force_field.constraints
    degrees, seconds = find_degrees(turn, reply)
    assert not reply.force_field.actions and turn.region is None and turn.pivot is None
    assert turn.vector == axis and 40 < degrees < 66 and seconds > 1.4 and turn.held_until is None
    assert reply.frame_count is not None
    assert reply.frame_count * ON_THE_GROUND.frame_dt > seconds + 1.2  # it is then seen to fall, and to lie
    assert {each.kind for each in reply.expectations} == {MotionKind.ROTATE, MotionKind.FALL}


def test_what_is_broad_is_turned_by_a_torque_however_slowly():
    scene = ON_THE_GROUND.model_copy(update=dict(extents=BROAD))
    assert not tip(scene, scene.directions.left, 0.6, (0.0, 80.0))
    (action,) = compile_whole("slowly tip the statue over", extents=BROAD).force_field.actions
    assert action.action_type is ActionType.TORQUE


@pytest.mark.parametrize(
    ("prompt", "stays"),
    [
        ("tip the statue over onto its side", True),
        ("the statue falls over onto its left side", True),
        ("someone pushes the statue over onto its side and it lies there", True),
        ("the statue gets tipped onto its side, then slides to the left", False),
    ],
)
def test_what_is_broad_is_led_onto_its_side_and_kept_there(prompt, stays):
    """A pan went over onto its top."""
    reply = compile_whole(prompt, extents=BROAD)
    turn = reply.force_field.constraints[0]
    assert find_degrees(turn, reply)[0] == pytest.approx(90, rel=0.02) and turn.region is None
    last = (reply.frame_count or ON_THE_GROUND.frame_count) - 1
    assert (turn.held_until == last) is stays and turn.held_until > turn.active_time[1]


@pytest.mark.parametrize("prompt", ["tip it over onto its back", "turn it upside down"])
def test_what_is_broad_is_turned_onto_its_top_by_half_a_turn(prompt):
    reply = compile_whole(prompt, extents=BROAD, object_name="cake")
    assert [each.amount.value for each in reply.expectations] == [180.0]


@pytest.mark.parametrize(
    "prompt",
    [
        "the statue is dropped and tips over to the left",
        "the statue gets dropped and tips over onto its side when it lands",
        "drop it; it falls over to the left when it hits the floor",
    ],
)
def test_what_is_dropped_tips_over_once_it_has_landed(prompt):
    """It hung in the air while it was tipped over."""
    falls, *tips = compile_whole(prompt).expectations
    assert falls.kind is MotionKind.FALL and {MotionKind.ROTATE} <= {each.kind for each in tips}
    assert all(each.window[0] >= falls.window[1] for each in tips)


@pytest.mark.parametrize("prompt", ["the statue stands up on the edge of its plate and slides to the left"])
def test_what_is_set_up_on_an_edge_is_kept_upright_as_it_goes_on(prompt):
    reply = compile_whole(prompt, extents=(1.0, 0.1, 0.9))
    turn, move = reply.force_field.constraints
    assert find_degrees(turn, reply)[0] == pytest.approx(90.0, rel=0.1)
    assert turn.held_until == move.active_time[0] and not reply.force_field.actions


def test_what_leans_to_one_side_and_then_to_the_other_passes_the_upright():
    """Measured from where it leant, it would only stand again."""
    reply = compile_whole("the statue leans to the left, then to the right, then to the left")
    turns = [find_degrees(each, reply)[0] for each in reply.force_field.constraints]
    assert turns[1] == pytest.approx(2 * turns[0], rel=0.1) and turns[2] == pytest.approx(turns[1], rel=0.1)


@pytest.mark.parametrize(
    "prompt",
    [
        "the van drives to the left, brakes hard and tips up on its front wheels",
        "the van rolls to the left, slams on the brakes and tilts forward onto its front wheels",
        "the van drives to the left, stops and does a stoppie",
    ],
)
def test_a_vehicle_that_brakes_stands_on_its_front_wheels_once_it_has_stopped(prompt):
    """One wheel was raised, or the front, while it drove on."""
    reply = compile_whole(prompt, extents=(1.0, 0.5, 0.4), object_name="van", object_kind="vehicle")
    drives, tips = (e for e in reply.expectations if e.kind is not MotionKind.STILL)
    assert drives.kind is MotionKind.MOVE and tips.kind is MotionKind.ROTATE and tips.limb is None
    first, turn = reply.force_field.actions[0], reply.force_field.constraints[-1]
    assert turn.active_time[0] >= drives.window[1] - 0.5 > first.active_time[1]
    top = (turn.vector[1], -turn.vector[0])  # where it goes: up times the axis
    rears = compile_whole("the van rears up on its back wheels", extents=(1.0, 0.5, 0.4), object_name="van")
    (other,) = rears.force_field.constraints
    assert dot((*top, 0.0), (other.vector[1], -other.vector[0], 0.0)) < -0.9


@pytest.mark.parametrize(
    "prompt",
    [
        "knock the statue over",
        "a ball hits the statue and knocks it over",
        "a strong wind hits the statue and knocks it over",
        "kick the statue and it falls on its side",
        "the statue slides to the left and then tips over",
        "the statue jumps up and then falls over",
        "the statue rocks to and fro and then falls over",
        "the statue rocks to and fro three times and tips over",
        "the statue shakes a little and then tips over backwards",
    ],
)
def test_no_push_goes_on_after_its_balance(prompt):
    """A torque took what was broad or round over the next edge as well, onto its head."""
    reply = compile_whole(prompt)
    turns = [
        c for c in reply.force_field.constraints if c.constraint_type is ConstraintType.PARTICLE_ROTATION
    ]
    degrees, seconds = find_degrees(turns[-1], reply)
    assert 40 < degrees < 70 and seconds < 1.0 and turns[-1].held_until is None
    assert all(each.action_type is not ActionType.TORQUE for each in reply.force_field.actions)
    struck = [each for each in reply.expectations if each.sudden and "jumps" not in prompt]
    assert not (struck and reply.force_field.actions) and all(each.strength <= 1 for each in struck)


def test_what_lies_on_wheels_is_led_over_these_and_what_is_round_or_long_that_way_is_not():
    car = dict(extents=(1.0, 0.4, 0.45), long_axis=(1.0, 0.0, 0.0), world="ground")
    edges = [dict(way=way, reach=reach) for way, reach in [((1.0, 0, 0), 0.45), ((0, 1.0, 0), 0.2)]]
    scenes = [brief(object_name="car", **car), brief(object_name="car", edges=edges, **car)]
    assert [bool(tip(each, (0.0, 1.0, 0.0), 1.0, (0.0, 60.0))) for each in scenes] == [False, True]
    assert not tip(scenes[1], (1.0, 0.0, 0.0), 1.0, (0.0, 60.0))


def test_what_tips_goes_over_an_edge_of_its_foot_and_over_no_corner():
    box = brief(
        object_name="box",
        extents=(1.2, 0.8, 1.1),
        world="ground",
        edges=[
            dict(way=(c * x, s, 0.0), reach=0.4) for c, s in [(0.8, 0.6), (0.8, -0.6)] for x in (1.0, -1.0)
        ],
    )
    (turn,) = tip(box, (-1.0, 0.0, 0.0), 1.0, (0.0, 60.0))
    assert abs(turn.vector[0]) == pytest.approx(0.6) and turn.vector[1] == pytest.approx(-0.8)
    (turn,) = tip(box, (0.0, 1.0, 0.0), 1.0, (0.0, 60.0))
    assert turn.vector == pytest.approx((-1.0, 0.0, 0.0))


@pytest.mark.parametrize("prompt", ["gently tip it over", "knock it over", "a violent storm blows it over"])
def test_what_tips_over_turns_until_it_lies_however_hard(prompt):
    (turn,) = [each for each in compile_whole(prompt).expectations if each.kind is MotionKind.ROTATE]
    assert turn.strength == 1.0


def test_a_lean_another_way_or_at_another_time_is_no_beginning_of_a_fall():
    for prompt in ("it tilts to the left, then suddenly falls over", "it tilts left, then falls over right"):
        first = compile_whole(prompt).expectations[0]
        assert first.manner == "rock" and first.kind is MotionKind.ROTATE


@pytest.mark.parametrize(
    ("prompt", "degrees"),
    [("the statue spins around", 360), ("it turns around", 180), ("it twirls", 360), ("it spins twice", 720)],
)
def test_what_spins_on_the_ground_turns_all_the_way(prompt, degrees):
    """A quarter turn was shown."""
    reply = compile_whole(prompt)
    (turn,) = reply.force_field.constraints
    assert turn.constraint_type is ConstraintType.PARTICLE_ROTATION
    shown, seconds = find_degrees(turn, reply)
    assert shown == pytest.approx(degrees, rel=0.02)
    assert 1.0 < seconds < 3.5


def test_a_slow_spin_takes_longer_and_a_part_turns_as_before():
    replies = [compile_whole(f"the statue spins {way}") for way in ("quickly", "", "slowly")]
    times = [find_degrees(each.force_field.constraints[0], each)[1] for each in replies]
    assert times[0] < times[1] < times[2]
    assert compile_whole("turn the statue").expectations[0].amount is None


@pytest.mark.parametrize(
    "prompt",
    ["flip the statue into the air", "toss it into the air so that it spins", "it jumps up and spins around"],
)
def test_what_is_flipped_into_the_air_turns_once_while_it_is_there(prompt):
    """It was tipped over, or hardly turned; or it turned on as it came down."""
    reply = compile_whole(prompt)
    blow, turn, stop = reply.force_field.actions
    assert stop.vector == tuple(-c for c in turn.vector) and stop.magnitude == turn.magnitude
    assert stop.active_time is not None
    assert blow.action_type is ActionType.IMPULSE and turn.action_type is ActionType.TORQUE
    assert turn.active_time is not None and blow.active_time is not None
    push = (turn.active_time[1] - turn.active_time[0]) * ON_THE_GROUND.frame_dt
    rate = 2 * TURN / ON_THE_GROUND.reference_seconds**2 * turn.magnitude * turn.gain * push  # [rad/s]
    aloft = math.sqrt(8 * blow.magnitude * ON_THE_GROUND.size / GRAVITY)
    assert turn.active_time[0] == blow.active_time[1] and push < 0.2
    turning = (stop.active_time[0] - turn.active_time[0]) * ON_THE_GROUND.frame_dt
    assert math.degrees(rate * turning) == pytest.approx(360, rel=0.1) and turning < aloft
    kinds = {each.kind for each in reply.expectations}
    assert kinds == {MotionKind.MOVE, MotionKind.ROTATE, MotionKind.FALL}


def test_what_is_picked_up_and_thrown_is_thrown_from_where_it_is():
    reply = compile_whole("pick the statue up and throw it to the right")
    lift, throw = reply.expectations[:2]
    assert lift.window[1] <= throw.window[0]


@pytest.mark.parametrize(
    ("prompt", "told"),
    [
        ("push it gently until it tips over", "rotate fall"),
        ("push it so hard that it falls over", "rotate fall"),
        ("the wind pushes it slowly to the right until it falls", "rotate fall"),
        ("it loses its balance and falls over", "rotate fall"),
        ("it trips and falls forward", "rotate fall"),
        ("it is knocked to the ground", "rotate fall"),
        ("it stumbles and falls", "move rotate fall"),
        ("it slides to the left and falls over", "move rotate fall"),
        ("it slips and lands on its back", "move rotate fall"),
        ("it moves to the left and is dropped", "move fall"),
        ("it moves to the left, then falls", "move fall"),
        ("it moves to the left, then falls", "move fall"),
        ("lift it and let it fall", "move fall"),
        ("lift it and turn it upside down", "move rotate"),
        ("it falls", "fall"),
    ],
)
def test_how_something_comes_to_fall_over(prompt, told):
    """It fell from nowhere, or slid while it was to tip over."""
    reply = compile_whole(prompt)
    assert " ".join(each.kind.value for each in reply.expectations) == told
    assert reply.force_field.default_drop == (prompt == "it falls") and not reply.unsure
    windows = [each.window for each in reply.expectations]
    if told.startswith("move"):
        assert windows[0][1] <= windows[1][0]


@pytest.mark.parametrize(
    ("prompt", "way"),
    [
        ("throw the statue across the room", (-1, 0, 0)),
        ("it is thrown across the yard to the right", (1, 0, 0)),
    ],
)
def test_what_is_thrown_across_something_flies_aside(prompt, way):
    reply = compile_whole(prompt)
    assert reply.expectations[0].direction == pytest.approx(way) and reply.expectations[0].manner == "fly"


@pytest.mark.parametrize("prompt", ["it rises like a balloon", "it floats up like a feather"])
def test_a_comparison_of_what_rises_tells_nothing_more(prompt):
    assert not compile_whole(prompt).unsure


@pytest.mark.parametrize(
    ("prompt", "height"),
    [
        ("it falls from a great height", 1.2),
        ("drop it from high up", 1.2),
        ("someone drops it from pretty high up", 1.2),
        ("it is dropped from the sky and bounces", 1.2),
        ("drop it from twice its height", 1.0),
        ("drop it from a metre", 1.0),
        ("drop it from half its length", 0.5),
        ("it drops", None),
    ],
)
def test_what_falls_from_high_up_is_let_fall_from_there(prompt, height):
    """Everything fell from half its length."""
    reply = compile_whole(prompt, extents=(1.0, 0.5, 1.0))
    assert reply.force_field.default_drop and not reply.unsure and reply.world.drop_height == height


def test_a_fall_that_there_is_no_room_for_is_told():
    reply = compile_whole("drop it from five times its height")
    assert reply.world.drop_height == MOST_DROP and any("room" in note for note in reply.notes)


def test_what_is_thrown_hard_flies_farther_than_it_hops():
    """It hopped aside by less than its height, and landed on its feet."""
    (plain,) = compile_whole("throw the statue to the left").force_field.actions
    (hard,) = compile_whole("throw the statue hard to the left").force_field.actions
    assert hard.magnitude > 1.7 * plain.magnitude


@pytest.mark.parametrize(
    "prompt", ["a statue made of honey collapses", "the statue is made of sand and collapses"]
)
def test_what_flows_collapses_where_it_stands(prompt):
    """It fell from the air."""
    reply = compile_whole(prompt)
    assert not reply.force_field.default_drop and not reply.unsure
    assert [each.kind for each in reply.expectations] == [MotionKind.SQUEEZE]
    hard = compile_whole("the wooden statue collapses")  # so does what is hard, as it becomes soft
    assert not hard.force_field.default_drop and set(hard.materials) == {"wooden", "yielding"}


def find_failures(prompt, show):
    """Questions of the checks that fail of what ``show`` tells of a frame: place [body lengths], turn [degrees]."""
    reply = compile_whole(prompt)
    scene = ON_THE_GROUND.model_copy(update=dict(extents=SLIM, frame_count=reply.frame_count))
    shown = [show(frame / scene.last) for frame in range(scene.frame_count)]
    windows = [(round(each.window[0]), round(each.window[1])) for each in reply.expectations]
    seen = make_report([place for place, _ in shown], [turn for _, turn in shown], windows=windows)
    checks = judge(prompt, reply, seen, scene).judgement.checks
    return [each.question for each in checks if each.passed is False]


@pytest.mark.parametrize(("rolled", "wrong"), [(0.0, 0), (90.0, 0), (-90.0, 0)])
def test_a_fall_over_is_judged_until_it_lies(rolled, wrong):
    """Rolling about itself afterwards made its whole turn one about another axis."""

    def show(share):
        down, roll = ramp(share, 0.3, 0.6), ramp(share, 0.65, 0.9)
        return (0.4 * down, 0.0, -0.4 * down), (rolled * roll, 85.0 * down, 0.0)

    assert len(find_failures("gently tip the statue over to the right", show)) == wrong


def test_a_fall_over_another_way_is_none_that_was_asked_for():
    def show(share):
        down = ramp(share, 0.3, 0.6)
        return (0.0, 0.4 * down, -0.4 * down), (-85.0 * down, 0.0, 0.0)

    assert find_failures("gently tip the statue over to the right", show)


@pytest.mark.parametrize(("back", "met"), [(1.0, True), (0.2, False)])
def test_what_is_put_down_goes_as_far_as_it_was_lifted(back, met):
    """It was asked for a quarter of its length, and had been lifted by less."""

    def show(share):
        return (0.0, 0.0, 0.24 * (ramp(share, 0.0, 0.3) - back * ramp(share, 0.5, 0.75))), (0.0, 0.0, 0.0)

    failed = find_failures("lift the statue slowly, then put it down again", show)
    assert ("how far does it move?" not in failed) == met


@pytest.mark.parametrize(
    "prompt", ["turn it a quarter turn to the left and then drop it", "it spins, then falls"]
)
def test_what_stands_is_lifted_before_it_is_dropped(prompt):
    """Nothing falls that stands on the ground; the lift is a means, and "falls" alone is a fall over."""
    motions = compile_whole(prompt).expectations
    lifted = [each.kind for each in motions if each.means]
    assert lifted == ([MotionKind.MOVE] if "drop" in prompt else [])
    assert [each.kind for each in compile_whole("lift it and then drop it").expectations if each.means] == []


def test_what_is_tipped_and_let_rock_back_is_tilted_by_as_much_as_is_told():
    reply = compile_whole(
        "tip the statue halfway over to the left, then let it rock back upright", extents=BROAD
    )
    (motion,) = reply.expectations
    assert motion.kind is MotionKind.ROTATE and motion.released
    assert motion.amount is not None and motion.amount.value == pytest.approx(45.0)


@pytest.mark.parametrize("foot", ["its foot", "the narrow tip", "the rusty tip"])
def test_what_loses_its_balance_and_topples_does_so_once(foot):
    """Between a determiner and a part, "narrow" is no verb; nor is "tip" behind an adjective that is not known."""
    prompt = f"the statue loses its balance on {foot} and topples over to the right"
    falls = compile_whole(prompt).expectations
    turned = [each for each in falls if each.kind is MotionKind.ROTATE]
    assert [each.direction for each in turned] == [RIGHT]


@pytest.mark.parametrize(
    ("prompt", "moves"),
    [
        ("someone shoves the statue to the left and it falls over, stiff as a board", False),
        ("push the statue to the left and it topples", False),
        ("push the statue to the left, then it falls over", True),
        ("push the statue to the left and tip it over to the right", True),
        ("the statue slides to the left and falls over to the left", True),
    ],
)
def test_a_push_until_it_falls_over_is_how_it_does(prompt, moves):
    reply = compile_whole(prompt)
    assert (MotionKind.MOVE in [each.kind for each in reply.expectations]) is moves
    assert not reply.unsure


def test_what_is_turned_over_and_put_upright_is_turned_back():
    over, back = compile_whole("turn the statue upside down, then put it upright again").expectations
    assert over.kind is back.kind is MotionKind.ROTATE
    assert over.amount == back.amount and over.direction == tuple(-c for c in back.direction)


def test_a_vehicle_tips_onto_two_wheels_and_comes_down_on_all_four():
    prompt = "the statue tips onto two wheels and comes back down on all four wheels"
    (motion,) = compile_whole(prompt, extents=BROAD).expectations
    assert motion.kind is MotionKind.ROTATE and motion.released and motion.amount is not None


@pytest.mark.parametrize(
    ("prompt", "seconds"),
    [
        ("the statue slides to the left until it stops", 0.9),
        ("the statue drives forward and comes to a halt", 0.9),
        ("the statue spins until it stops", 0.9),
        ("the statue rocks to and fro until it stops", 1.6),
        ("the statue falls over to the left and comes to rest", 1.6),
    ],
)
def test_a_clip_ends_soon_after_what_moves_has_stopped(prompt, seconds):
    """It waited for four seconds, in which nothing swung."""
    *_, rest = compile_whole(prompt).expectations
    assert rest.kind is MotionKind.STILL
    assert 0.4 < (rest.window[1] - rest.window[0]) * ON_THE_GROUND.frame_dt <= seconds


def test_what_falls_over_rocks_when_it_lies():
    reply = compile_whole("the statue falls over to the left and rocks until it stops")
    falls = [each for each in reply.expectations if each.kind is MotionKind.ROTATE]
    (sways,) = [each for each in reply.expectations if each.kind is MotionKind.SWAY]
    assert sways.window[0] >= falls[0].window[1] - 0.5


def test_what_has_reared_up_hangs_there_in_the_air():
    """It hangs from nothing: no top is held."""
    prompt = "the statue rears up on its back wheels, hangs there for a moment, then comes down again"
    assert compile_whole(prompt, extents=BROAD).anchor.kind is None


def test_round_and_round_is_more_than_once():
    for words in ("spins round and round", "is turned around and around", "goes round and round"):
        (motion,) = compile_whole(f"the statue {words}").expectations
        assert motion.kind is MotionKind.ROTATE and (motion.amount is None or motion.amount.value == 720.0)
    (motion,) = compile_whole("the statue spins round and round on the floor").expectations
    assert motion.amount is not None and motion.amount.value == 720.0


def stand(**changes):
    return brief(**dict(object_name="thing", world="ground", frames_fixed=False) | changes)


@pytest.mark.parametrize(
    "prompt",
    [
        "the thing lifts off, hovers for a moment, and falls back down again",
        "raise the thing, then let it drop back",
        "the thing rises, waits a bit and thumps back down",
    ],
)
def test_what_is_up_in_the_air_and_drops_back_falls(prompt):
    reply = read_sentence(prompt, stand())
    assert reply.expectations[-1].kind is MotionKind.FALL and reply.expectations[0].kind is MotionKind.MOVE
    assert not reply.expectations[0].released and not reply.unsure


@pytest.mark.parametrize(
    "prompt",
    [
        "hoist the front wheels of the cart up",
        "the front tyres of the cart come off the floor",
        "lift the front wheels, then put them back down",
    ],
)
def test_an_end_is_tilted_by_the_wheels_that_bear_it(prompt):
    wheels = [make_part(f"{side} wheel", (x, -0.6, -0.6)) for side, x in (("left", -0.5), ("right", 0.5))]
    (tilt,) = read_sentence(prompt, stand(object_name="cart", parts=tuple(wheels))).expectations
    assert tilt.kind is MotionKind.ROTATE and tilt.limb is None and tilt.part is None


def test_what_is_raised_at_its_lower_rim_until_it_tips_does_so_as_a_whole():
    reply = read_sentence("lift the bottom rim of the thing until it tips", stand())
    (tilt,) = reply.expectations
    assert tilt.kind is MotionKind.ROTATE and tilt.part is None and not reply.unsure


def test_what_slides_as_it_is_nudged_does_so_before_it_wobbles():
    reply = read_sentence("the thing slides to the left when someone nudges it, then wobbles", stand())
    assert [each.kind for each in reply.expectations] == [MotionKind.MOVE, MotionKind.SWAY]


@pytest.mark.parametrize("end", ["skids to a stop", "screeches to a sudden halt", "slides to a standstill"])
def test_what_skids_to_a_stop_is_stopped_and_goes_no_farther(end):
    scene = stand(object_name="car", object_kind="vehicle")
    told = [each.kind for each in read_sentence(f"the car races ahead and {end}", scene).expectations]
    assert told == [MotionKind.MOVE, MotionKind.STILL]
    assert [e.kind for e in read_sentence(f"the car {end}", scene).expectations] == [MotionKind.MOVE]


@pytest.mark.parametrize(
    "hops", ["hops across the lawn", "leaps around", "bounces along", "skips over to the fence"]
)
def test_what_hops_about_hops_several_times_and_goes_on(hops):
    hop = read_sentence(f"the thing {hops}", stand()).expectations[0]
    assert hop.repeats > 2 and math.hypot(*hop.direction[:2]) > 0.5
    (spot, *_) = read_sentence("the thing jumps around on the spot", stand()).expectations
    assert spot.repeats > 2 and spot.direction[2] > 0.99


@pytest.mark.parametrize(
    "sentence",
    [
        "knock it over so it rolls",
        "it tips over and rolls to the right",
        "it falls over to the left and rolls",
    ],
)
def test_what_is_tall_falls_across_the_way_that_it_rolls(sentence):
    """It fell to the left and was then to roll to the left, along itself."""
    reply = compile_whole(sentence)
    tips = reply.force_field.constraints[0].vector
    rolls = next(each for each in reply.expectations if each.kind is MotionKind.MOVE)
    assert abs(dot(tips, rolls.direction)) > 0.9  # it turns over about that line


@pytest.mark.parametrize(
    ("sentence", "way"),
    [
        ("knock it onto its side, then it rolls to the left", (-1, 0, 0)),
        ("it tips over onto its side and rolls to the right", (1, 0, 0)),
        (
            "someone bumps into it so that it falls onto its side, then it rolls to the right and stops",
            (1, 0, 0),
        ),
    ],
)
def test_its_side_is_across_the_way_that_it_then_rolls(sentence, way):
    """Also of what is not tall; it rolls by as much as it goes, until friction stops it."""
    reply = compile_whole(sentence, extents=(0.8, 0.85, 0.8))
    led, (push, turn) = reply.force_field.constraints, reply.force_field.actions[-2:]
    tips = led[0].vector if led else reply.force_field.actions[0].vector
    assert abs(dot(tips, way)) > 0.9 and push.vector == pytest.approx(way)
    assert abs(dot(turn.vector, way)) < 0.1 and turn.magnitude > 1.4 * push.magnitude
    assert all(abs(dot(each.direction, way)) < 0.1 for each in reply.expectations[:1] if each.direction)


@pytest.mark.parametrize(
    ("sentence", "degrees"),
    [
        ("flip the statue over in the air and let it land", 180),
        ("the statue flips in mid-air", 360),
        ("turn the statue upside down in the air, then it drops to the floor", 180),
        ("the statue spins in the air and comes down again", 360),
        ("the statue does a somersault in midair", 360),
        ("the statue flips in midair and lands on its head", 180),
        ("the statue does a backflip and lands upside down", 540),
        ("the statue does a flip in the air and lands on its side", 270),
        ("the statue does a somersault and lands on its side", 450),
    ],
)
def test_what_flips_in_the_air_leaps_for_it_and_comes_down(sentence, degrees):
    """It hung in the air without weight, or turned over on its rim."""
    reply = compile_whole(sentence, extents=BROAD)
    leap, begin, stop = reply.force_field.actions
    assert leap.action_type is ActionType.IMPULSE and leap.vector == (0.0, 0.0, 1.0)
    assert begin.action_type is stop.action_type is ActionType.TORQUE
    push = begin.magnitude * begin.gain * (begin.active_time[1] - begin.active_time[0])
    turned = math.degrees(TURN) * 2 * push * (stop.active_time[0] - begin.active_time[0])
    frames = REFERENCE_TIME / ON_THE_GROUND.frame_dt
    assert turned / frames**2 == pytest.approx(degrees, rel=0.2)
    kinds = [each.kind for each in reply.expectations]
    assert kinds == [MotionKind.MOVE, MotionKind.FALL, MotionKind.ROTATE] and reply.world.gravity is None


@pytest.mark.parametrize(
    ("sentence", "axis", "degrees"),
    [
        ("the statue is thrown up, spins around and comes down", (0.0, 0.0, 1.0), 360),
        ("toss the statue into the air, it turns over and lands on its top", None, 180),
        ("the statue is flung up, spins and lands on its head", None, 180),
        ("it is thrown high up, tumbles twice and lands on its side", None, 810),
        ("the statue is tossed up, whirls around and drops back down", (0.0, 0.0, 1.0), 360),
    ],
)
def test_what_is_said_between_a_throw_and_the_landing_happens_aloft(sentence, axis, degrees):
    """It spun, or turned over, on the ground once it had come down."""
    reply = compile_whole(sentence)
    throw, begin, stop = reply.force_field.actions
    push = begin.magnitude * begin.gain * (begin.active_time[1] - begin.active_time[0])
    turned = math.degrees(TURN) * 2 * push * (stop.active_time[0] - begin.active_time[0])
    assert turned / (REFERENCE_TIME / ON_THE_GROUND.frame_dt) ** 2 == pytest.approx(degrees, rel=0.2)
    assert throw.active_time[1] == begin.active_time[0] and not reply.unsure
    assert begin.vector == axis if axis else abs(begin.vector[2]) < 0.1
    assert all(each.window[1] <= reply.expectations[1].window[1] for each in reply.expectations)


def test_what_it_does_after_a_flip_it_does_on_the_ground():
    reply = compile_whole("the statue flips over in the air, lands and slides to the right", extents=BROAD)
    assert reply.expectations[-1].window[0] >= reply.expectations[0].window[1]


@pytest.mark.parametrize(
    "sentence",
    ["it floats in the air and turns over", "hold it in the air and flip it", "it spins in mid-air"],
)
def test_what_is_held_or_floats_in_the_air_only_turns(sentence):
    reply = compile_whole(sentence, extents=BROAD)
    assert reply.world.gravity == "none" and [e.kind for e in reply.expectations] == [MotionKind.ROTATE]


@pytest.mark.parametrize(("extents", "stays"), [((1.0, 0.5, 0.2), True), ((1.0, 0.3, 0.6), False)])
def test_what_is_tall_and_thin_is_kept_as_it_was_turned_over(extents, stays):
    """A fish was let go on the fin of its back, and fell onto its side."""
    scene = dict(extents=extents, long_axis=(1.0, 0.0, 0.0))
    (turn,) = compile_whole("flip the statue upside down", **scene).force_field.constraints
    assert (turn.held_until is not None) is stays


@pytest.mark.parametrize(
    ("raised", "axis"),
    [
        ("lift the left side of the thing", RIGHT),
        ("lift its right end", LEFT),
        ("pull the left edge upwards", RIGHT),
        ("raise the rim on the right", LEFT),
        ("pinch the brim at one side and pull it up", LEFT),
    ],
)
def test_what_is_raised_at_one_side_until_it_tips_leans_to_the_other(raised, axis):
    """It leant to the left, whatever side was raised."""
    (tilt, *_) = read_sentence(f"{raised} until it tips, then let go", stand()).expectations
    assert tilt.kind is MotionKind.ROTATE and tilt.limb is None and tilt.part is None
    assert dot(tilt.direction or (), axis) > 0.9


def test_what_was_set_up_on_its_end_goes_on_past_its_balance_there():
    """A torque turned it back the way that it had come, and on and on."""
    plank = brief(world="ground", object_name="plank", extents=(1.0, 0.1, 0.3), long_axis=(1.0, 0.0, 0.0))
    reply = read_sentence("the plank stands up on its end and topples over", plank)
    stood = next(e for e in reply.expectations if e.amount is not None)
    (led,) = reply.force_field.constraints
    assert led.vector == pytest.approx(stood.direction) and led.region is None and led.held_until is None
    assert led.active_time[1] - led.active_time[0] < 15
    assert all(each.active_time[1] <= led.active_time[0] for each in reply.force_field.actions)


THIN = dict(object_name="bike", extents=(1.0, 0.55, 0.28), long_axis=(1.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("prompt", "sign"),
    [
        ("the bike is knocked over to the left", 1),
        ("the bike topples onto its right side", -1),
        ("somebody shoves the bike and it tips over to the right", -1),
    ],
)
def test_what_stands_thin_falls_onto_a_side_and_not_over_its_end(prompt, sign):
    """Its front is to the right, so that its left side is away from the viewer."""
    reply = compile_whole(prompt, **THIN)
    seen = [each for each in reply.expectations if each.kind is MotionKind.ROTATE]
    assert seen[0].direction == pytest.approx((-sign, 0.0, 0.0))


def test_what_is_broad_goes_over_its_end_as_told():
    reply = compile_whole("the statue topples over to the left", **THIN | dict(extents=(1.0, 0.5, 0.8)))
    seen = [each for each in reply.expectations if each.kind is MotionKind.ROTATE]
    assert seen[0].direction == pytest.approx(LEFT)
