"""Whole motions of everyday words: steps, leaps one after another, gentle pushes, hinges, and nouns for the object."""

import pytest

from physagent_jax.agents.compiler import compile_intent
from physagent_jax.agents.grammar.semantic import read_intent
from physagent_jax.core.errors import UserError
from physagent_jax.forces.calibration import PRESCRIBED_TRAVEL
from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import ActionType, CellsRegion
from physagent_jax.motion.hinges import find_hinge
from physagent_jax.motion.limbs import find_front
from physagent_jax.motion.schema import MotionKind
from physagent_jax.motion.vectors import dot
from physagent_jax.scene.priors import list_nouns
from tests.agents.scenes import brief, read
from tests.agents.tellings import ground

LEFT, UP = (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
CHESS = brief(object_name="knight", object_kind="object", object_nouns=list_nouns("object"), world="ground")


def compile_sentence(prompt, scene):
    return compile_intent(read_intent(prompt, scene), scene)


@pytest.mark.parametrize(
    "prompt", ["knock the chess piece over", "the gizmo wobbles", "the old thing tips over"]
)
def test_an_unknown_noun_is_the_only_object_there_is(prompt):
    assert not read(prompt, CHESS).unsure


@pytest.mark.parametrize(
    "prompt",
    [
        "the knight flops onto its belly",
        "shove the knight off balance",
        "throw the knight off balance",
        "it flops down",
    ],
)
def test_everyday_words_for_falling_over_are_known(prompt):
    reply = read(prompt, CHESS)
    assert not reply.unsure and [each.kind for each in reply.expectations] == [
        MotionKind.ROTATE,
        MotionKind.FALL,
    ]


def test_what_shakes_a_little_can_be_seen_to():
    """It went by four hundredths of its length."""
    reply = read("the knight shakes a little", CHESS)
    first = reply.force_field.constraints[0]
    frames = first.active_time[1] - first.active_time[0]
    reach = (
        first.magnitude * first.gain * frames * PRESCRIBED_TRAVEL * CHESS.frame_dt / CHESS.reference_seconds
    )
    assert 0.05 < reach < 0.07


@pytest.mark.parametrize("arms", [0, 2])
def test_what_has_arms_looks_along_no_back_however_many_pieces_its_legs_have(arms):
    roles = ["head", *["leg"] * 4, *["arm"] * arms]
    box = CellsRegion(inside=((0.5, 0.5, 0.2),), outside=((0.5, 0.5, 0.8),))
    parts = [
        Part(
            moved=box,
            rest=box,
            joint=(0.5, 0.5, 0.5),
            arm=(0, 0, 1),
            side=(1, 0, 0),
            share=0.1,
            roles=(role,),
        )
        for role in roles
    ]
    assert (find_front(parts) is None) == bool(arms)


@pytest.mark.parametrize(
    "prompt", ["the gizmo zorps to the left", "make the gizmo zorp to the left", "zorp the gizmo"]
)
def test_an_unknown_verb_is_no_part_of_the_name(prompt):
    with pytest.raises(UserError):
        read(prompt, CHESS)


@pytest.mark.parametrize(("prompt", "count"), [("the robot walks to the left", 5), ("it gallops left", 6)])
def test_steps_are_equal_and_go_up_and_down(prompt, count):
    reply = read(prompt, ground())
    (motion,), steps = reply.expectations, reply.force_field.constraints
    assert motion.kind is MotionKind.MOVE and motion.direction == LEFT and motion.leaves_place
    assert len(steps) == 2 * count and not reply.force_field.actions
    assert len({round(step.magnitude * step.gain, 3) for step in steps}) == 1
    rises = [dot(step.vector, UP) > 0 for step in steps]
    assert rises == [True, False] * count
    assert all(step.region is None and dot(step.vector, LEFT) > 0 for step in steps)


def test_what_has_wheels_takes_no_steps():
    reply = read("the car runs to the left", ground(object_name="car", object_kind="vehicle"))
    assert not reply.force_field.constraints and reply.force_field.actions[0].vector == LEFT


def test_forward_is_where_what_walks_looks():
    side = brief(world="ground", long_axis=(1.0, 0.0, 0.0))
    (walks,), (pushed,) = (read(text, side).expectations for text in ("it walks forward", "push it forward"))
    assert walks.direction in (LEFT, (1.0, 0.0, 0.0)) and pushed.direction == side.directions.toward


@pytest.mark.parametrize("names", [("left arm", "right arm"), ("right arm", "left arm")])
def test_a_figure_with_a_left_and_a_right_arm_walks_where_it_looks(names):
    """Its own left is on the viewer's right where it looks at the viewer, and on their left where it looks away."""
    for way in (1.0, -1.0):
        sides = {"left arm": (way, 0.0, 0.0), "right arm": (-way, 0.0, 0.0)}
        box = CellsRegion(inside=((0.5, 0.5, 0.2),), outside=((0.5, 0.5, 0.8),))
        told = dict(moved=box, rest=box, joint=(0.5, 0.5, 0.5), share=0.1, origin="file")
        parts = tuple(Part(name=name, arm=sides[name], side=sides[name], **told) for name in names)
        scene = brief(world="ground", parts=parts)
        (walks,) = read("it walks forward", scene).expectations
        assert walks.direction == pytest.approx(tuple(way * c for c in scene.directions.toward))


def test_what_is_longest_across_its_wings_rocks_from_wing_to_wing():
    box = CellsRegion(inside=((0.5, 0.5, 0.2),), outside=((0.5, 0.5, 0.8),))
    told = dict(moved=box, rest=box, joint=(0.5, 0.5, 0.5), share=0.1, origin="shape", roles=("wing",))
    sides = ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0))
    wings = tuple(Part(arm=side, side=side, **told) for side in sides)
    for parts, way in ((wings, 0), ((), 1)):
        scene = brief(world="ground", parts=parts, long_axis=(1.0, 0.0, 0.0))
        (rocks,) = read("it rocks from side to side", scene).expectations
        assert abs(rocks.direction[way]) > 0.9


def test_every_one_of_several_leaps_is_a_rise():
    """Each is strengthened with the others, so that they stay alike."""
    rise, fall = read("the robot hops three times", ground()).expectations
    field = read("the robot hops three times", ground()).force_field
    times = [each.active_time or (-1.0, 1e9) for each in field.actions]
    assert all(rise.window[0] <= first < rise.window[1] for first, _ in times)
    assert len({each.magnitude for each in field.actions}) == 1
    assert fall.window[0] > max(end for _, end in times)


def test_whoever_sits_on_it_presses_it():
    sofa = ground(object_name="sofa")
    assert read("someone sits down on the sofa", sofa).expectations[0].kind is MotionKind.SQUEEZE
    assert read("the sofa sits there", sofa).expectations[0].kind is MotionKind.STILL


@pytest.mark.parametrize(("word", "far"), [("gently", 0.3), ("hard", 2.0)])
def test_a_gentle_push_goes_no_farther_than_it_promises(word, far):
    (push,) = read(f"push the robot {word} to the left", ground()).force_field.actions
    free = read(f"push the robot {word} to the left", brief(world="free")).force_field.actions[0]
    assert push.action_type is ActionType.TRANSLATION and push.magnitude * push.gain <= far
    assert free.gain == 1.0


def test_an_earthquake_shakes_faster_than_a_hand():
    quake, shaken = (
        len(read(text, ground()).force_field.constraints)
        for text in ("the robot shakes in an earthquake", "shake the robot")
    )
    assert quake > shaken


def test_what_is_put_back_says_so():
    back = read("lift the robot and put it back down", ground()).expectations[-1]
    lowered = read("lift the robot and lower it", ground()).expectations[-1]
    assert back.put_back and not lowered.put_back
    over, counted = (
        read(text, ground()).expectations[-1] for text in ("it rolls over", "it rolls over twice")
    )
    assert over.may_stop_short and not counted.may_stop_short


def make_piece(name, inside, outside):
    where, there = (
        CellsRegion(inside=a, outside=b, rigid=True) for a, b in ((inside, outside), (outside, inside))
    )
    side = (0.0, 0.0, 1.0) if name == "screen" else (0.0, 0.0, -1.0)
    return Part(
        name=name,
        origin="file",
        seated=True,
        moved=where,
        rest=there,
        joint=(0.5, 1.0, 0.5),
        arm=UP,
        side=side,
        share=0.5,
    )


def make_book(upper, lower):
    """Two pieces of a thing that is as wide as it is deep and high."""
    parts = (make_piece("base", lower, upper), make_piece("screen", upper, lower))
    return brief(object_name="laptop", world="ground", may_be_held=True, extents=(1.0, 1.0, 1.0), parts=parts)


ROW = [x / 8 for x in range(9)]
SCREEN = tuple((x, 1.0, 0.05 + 0.95 * z) for x in ROW for z in ROW)
BASE = tuple((x, 0.95 * y, 0.0) for x in ROW for y in ROW)


def test_a_screen_closes_about_its_lower_edge():
    laptop = make_book(SCREEN, BASE)
    hinge = find_hinge(laptop.parts[1], laptop)
    assert hinge is not None and hinge.joint[1] == pytest.approx(1.0) and hinge.joint[2] < 0.2
    assert abs(hinge.axis[0]) > 0.99 and 80 < hinge.angle < 105
    for prompt in ("close the laptop", "close the screen", "shut the laptop"):
        reply = compile_sentence(prompt, laptop)
        ((turn,), (motion,)) = reply.force_field.constraints, reply.expectations
        assert motion.kind is MotionKind.ROTATE and motion.limb == 1 and not reply.unsure
        assert turn.pivot == pytest.approx(hinge.joint) and turn.vector[0] > 0.99  # its top comes towards us
        assert reply.anchor.kind == "rest"
    opened = compile_sentence("open the screen", laptop).force_field.constraints[0]
    assert opened.vector[0] < -0.99


def test_what_sits_on_the_rest_all_around_has_no_hinge():
    ring = tuple(
        (0.5 + 0.5 * x, 0.5 + 0.5 * y, z) for z in (0.9, 1.0) for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1))
    )
    below = tuple((x, y, 0.8) for x, y, z in ring if z == 0.9) + ((0.5, 0.5, 0.0),)
    pot = make_book(ring, below)
    assert find_hinge(pot.parts[1], pot) is None
    assert compile_sentence("open the screen", pot).expectations[0].kind is MotionKind.MOVE


def test_back_and_forth_is_not_the_back():
    back = make_piece("back", SCREEN, BASE)
    chair = brief(object_name="chair", world="ground", parts=(back,))
    reply = read("rock the chair back and forth", chair)
    assert reply.expectations[0].limb is None and not reply.unsure


@pytest.mark.parametrize(
    ("prompt", "kinds"),
    [
        ("the knight wobbles when it lands", "fall sway"),
        ("the knight falls and wobbles when it lands", "fall sway"),
        ("the knight is thrown up and wobbles when it lands", "move fall sway"),
    ],
)
def test_what_goes_on_at_the_landing_comes_after_the_fall(prompt, kinds):
    reply = read(prompt, CHESS.model_copy(update=dict(may_be_held=True)))
    assert [e.kind for e in reply.expectations] == kinds.split() and reply.anchor.kind is None
    starts = [e.window[0] for e in reply.expectations]
    assert starts == sorted(starts) and starts[-1] > 0


def test_what_slides_and_then_topples_has_room_to_fall():
    """A whole push took it to the wall of the space that is simulated, which it then leant on."""
    alone, before = (
        read(text, CHESS).force_field.actions[0].magnitude
        for text in ("the knight slides to the right", "the knight slides to the right and then topples over")
    )
    assert before < 0.7 * alone


@pytest.mark.parametrize(
    "prompt", ["the knight waddles forward like a sleepy penguin", "yank the knight up like a carrot"]
)
def test_a_likeness_of_a_telling_verb_is_no_doubt(prompt):
    assert not read(prompt, CHESS).unsure
    assert read("the knight moves like a sleepy penguin", CHESS).unsure


@pytest.mark.parametrize(
    ("prompt", "falls"),
    [("drop the robot twice", 2), ("bang the robot down on the table three times", 3), ("slam it down", 1)],
)
def test_what_is_dropped_again_is_lifted_between(prompt, falls):
    """A plate pressed what was banged on the table, and a second fall was not understood."""
    reply = read(prompt, brief(world="ground"))
    kinds = [MotionKind.FALL, *[MotionKind.MOVE, MotionKind.FALL] * (falls - 1)]
    assert not reply.unsure and [each.kind for each in reply.expectations] == kinds
    assert [each.means for each in reply.expectations] == [kind is MotionKind.MOVE for kind in kinds]


@pytest.mark.parametrize(
    ("prompt", "kinds"),
    [
        ("the robot makes a deep bow", [MotionKind.ROTATE]),
        ("it bends at the waist", [MotionKind.ROTATE]),
        ("strech it upwards", [MotionKind.STRETCH]),
        ("the robot rears up and slams back down", [MotionKind.ROTATE]),
        ("it tilts up onto its back wheels", [MotionKind.ROTATE]),
        ("lift the robot by its wooden handle", [MotionKind.MOVE]),
        ("tilt it by one handle", [MotionKind.ROTATE]),
        ("shove it backwards, away from us, with great force", [MotionKind.MOVE]),
        ("lift it, sorry, I meant drop it", [MotionKind.FALL]),
        ("it pitches up and down in the waves", [MotionKind.SWAY]),
        ("it goes limp like a rag doll", [MotionKind.SQUEEZE]),
        ("it marches on the spot", [MotionKind.SWAY]),
        ("turn it into jelly and drop it", [MotionKind.FALL]),
        ("rip the robot out of the ground", [MotionKind.MOVE]),
        ("smash the robot into the ground", [MotionKind.FALL]),
    ],
)
def test_whole_sentences_of_one_motion_are_understood(prompt, kinds):
    reply = read(prompt, brief(world="ground"))
    assert not reply.unsure and [each.kind for each in reply.expectations] == kinds


def test_what_springs_back_has_not_become_something_that_sags():
    assert not read("it sags, then springs back", brief(world="ground")).materials
    assert read("it sags", brief(world="ground")).materials == ("yielding",)


def test_what_goes_along_is_pushed_to_and_fro_and_not_led():
    """Led to and fro it stayed where it was."""
    scene = brief(world="ground", may_be_held=True)
    field = read("it slides to the left, wobbling as it goes", scene).force_field
    assert not field.constraints and len(field.actions) > 3


def test_the_front_that_a_wave_lifts_is_the_objects():
    (lift,) = read("a wave lifts the front of the robot up", brief(world="ground")).expectations
    assert lift.kind is MotionKind.MOVE and lift.direction == UP and lift.part is not None


@pytest.mark.parametrize(
    "sentence", ["somebody pushes it and it rolls backward", "a nudge sends it rolling backward"]
)
def test_what_is_pushed_goes_the_way_that_it_then_rolls(sentence):
    """No way is told of the push itself."""
    car = brief(object_name="van", object_kind="vehicle", world="ground")
    ways = {each.direction for each in read(sentence, car).expectations}
    assert ways == {read("it rolls backward", car).expectations[0].direction}


@pytest.mark.parametrize(
    ("prompt", "way"),
    [
        ("the robot turns left and then walks forward", (-1.0, 0.0, 0.0)),
        ("the robot turns around and walks away", (0.0, 1.0, 0.0)),
        ("the robot does a 180 and walks forward", (0.0, 1.0, 0.0)),
        ("the robot turns right, then left, and walks forward", (0.0, -1.0, 0.0)),
        ("the robot turns left and then moves up", UP),
    ],
)
def test_what_has_turned_goes_the_way_that_it_faces_by_then(prompt, way):
    """It went where it had faced before, sideways or backwards."""
    seen = read(prompt, brief(world="ground")).expectations
    going = seen[-1]
    assert going.kind is MotionKind.MOVE and going.window[0] >= seen[-2].window[1]
    assert going.direction == pytest.approx(way, abs=1e-6)


@pytest.mark.parametrize(
    ("prompt", "angle"),
    [
        ("the robot does a 180", 180.0),
        ("the robot makes a complete turn and falls over", 360.0),
        ("the robot spins 270 and stops", 270.0),
        ("the robot does a u-turn", 180.0),
    ],
)
def test_bare_numbers_and_whole_turns_are_angles(prompt, angle):
    reply = read(prompt, brief(world="ground"))
    turn = reply.expectations[0]
    assert turn.kind is MotionKind.ROTATE and turn.amount is not None and turn.amount.value == angle
    assert turn.direction == UP and not reply.unsure


@pytest.mark.parametrize(
    "prompt", ["shake the robot and throw it away", "the robot wobbles and is tossed up"]
)
def test_what_is_shaken_is_thrown_after_that(prompt):
    sway, throw = read(prompt, brief(world="ground")).expectations[:2]
    assert sway.kind is MotionKind.SWAY and throw.sudden and throw.window[0] >= sway.window[1]


def test_a_wave_may_be_what_acts():
    assert not read("a big wave lifts the robot up and drops it", brief(world="ground")).unsure


def test_what_rolls_down_to_a_side_rolls_along_the_ground():
    move, _ = read("the robot rolls down to the left", brief(world="ground")).expectations
    assert move.direction == LEFT


def test_an_end_that_is_no_part_does_not_come_off_unnoticed():
    """It was pushed down, and that was called a success."""
    assert read("the top of the robot breaks off", brief(world="ground")).unsure
    assert not read("the top of the robot slips off to the right", brief(world="ground")).unsure
