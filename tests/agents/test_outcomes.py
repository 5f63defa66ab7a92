"""Ends of actions, manners and amounts: the words of a sentence beside its first action."""

import pytest

from physagent_jax.agents.compiler.compilation import compile_intent
from physagent_jax.agents.llm.forms import SentenceForm, make_intent
from physagent_jax.motion import edits
from physagent_jax.motion.edits import Case
from physagent_jax.motion.kinds import choose_kinds
from physagent_jax.motion.matching import find_own_causes
from physagent_jax.motion.schema import Amount, MotionKind
from physagent_jax.motion.tolerances import expect_quantity, expect_strain
from tests.agents.scenes import brief, make_report, read
from tests.agents.tellings import ground, order

LEAST = 0.1  # of a length: the least change of shape that is seen without comparison


@pytest.mark.parametrize(
    ("sentence", "told"),
    [
        ("an earthquake shakes the robot until it topples", "sway left x6; rotate & fall"),
        ("the robot teeters, then crashes to the floor", "sway left x3; rotate & fall"),
        ("the robot wobbles and falls down", "sway left x3; rotate & fall"),
        ("roll the robot to the right until it tips over", "move right & rotate away; rotate & fall"),
        ("the robot swells until it bursts", "stretch; stretch"),
        ("the robot rises, spins and falls to the ground", "move up; rotate up; fall"),
        ("the robot rises, hovers, then drops", "move up; still; fall"),
        ("squash the robot and let it pop back up", "squeeze up"),
        ("the robot is made of jelly, squash it and let go so it wobbles back into shape", "squeeze up"),
        ("squash the jelly robot, let go and it jiggles", "squeeze up"),
        ("knock the robot over so that it lies on its back", "rotate left & fall"),
        ("push the robot until it tips over to the right", "rotate away & fall"),
        ("shove the robot so that it falls on its back", "rotate left & fall"),
        ("kick the robot so that it tips over to the right", "hit right & rotate away & fall"),
        ("drop the robot so that it lands on its side", "fall"),
        ("the robot tips forward and stays lying on its face", "rotate right & fall"),
        ("flip the robot over onto its roof", "rotate toward"),
        ("the robot falls over sideways", "rotate away & fall"),
        ("push the robot to the left until it topples", "rotate toward & fall"),
        ("toss the robot into the air so that it falls back down", "hit up; fall"),
    ],
)
def test_how_an_action_ends_comes_after_it(sentence, told):
    assert order(sentence) == told


def test_each_swing_over_the_foot_has_time_to_be_seen():
    reply = read("the robot teeters, then crashes to the floor", ground())
    first, end = reply.expectations[0].window
    assert (end - first) * ground().frame_dt / reply.expectations[0].repeats >= 0.6


@pytest.mark.parametrize(("sentence", "way"), [("inwards from both sides", (1, 0, 0)), ("inwards", None)])
def test_a_squeeze_from_both_sides_goes_along_one_line(sentence, way):
    (motion,) = read(f"squeeze the robot {sentence}", ground()).expectations
    assert motion.direction == way


@pytest.mark.parametrize(("height", "times"), [("twice its own height", 2), ("three times its height", 3)])
def test_what_rises_to_a_height_goes_so_many_of_its_own(height, times):
    reply = read(f"the robot rises to {height}", ground())
    amount = reply.expectations[0].amount
    assert reply.unsure == () and amount is not None and amount.value == times


@pytest.mark.parametrize("verb", ["stretch", "squash", "squeeze", "widen"])
def test_a_little_is_enough_to_be_seen(verb):
    (motion,) = read(f"{verb} the robot a little", ground()).expectations
    assert expect_strain(motion, motion.kind.value == "squeeze").low >= LEAST


def test_what_is_folded_lays_one_half_onto_the_other():
    reply = read("fold the robot in half", ground(may_be_held=True))
    (turn,) = reply.force_field.constraints
    assert turn.bend is not None and turn.vector[1] == pytest.approx(-1.0) and reply.anchor.kind == "rest"
    assert reply.expectations[0].direction == (-1, 0, 0)
    standing = read("fold the robot", ground(may_be_held=True, long_axis=(0, 0, 1)))
    assert standing.force_field.constraints[0].vector[0] == pytest.approx(1.0)  # its top comes forward


@pytest.mark.parametrize(
    ("manner", "kinds"),
    [("rock", {"enforce_particle_rotation"}), ("shake", {"enforce_particle_translation"}), ("bend", None)],
)
def test_a_manner_that_is_told_outweighs_the_verb(manner, kinds):
    """A language model may fill it in as well."""
    scene = ground(may_be_held=True)
    form = SentenceForm.model_validate(
        {"clauses": [{"words": "moves about", "motion": "sway", "manner": manner}]}
    )
    reply = compile_intent(make_intent(form), scene)
    assert reply.expectations[0].manner == form.clauses[0].manner == manner
    assert (reply.anchor.kind == "rest") == (manner == "bend")
    assert kinds is None or {each.constraint_type for each in reply.force_field.constraints} == kinds


def test_a_bend_that_springs_back_is_rescaled_with_its_swings():
    scene = brief(world="ground", may_be_held=True, frame_count=101)
    reply = read("bend the robot to the left, then let it spring back", scene)
    field, (motion,) = reply.force_field, reply.expectations
    causes = find_own_causes(motion, reply.expectations, field)
    assert len(causes) == len(field.constraints) > 2
    case = Case(field, motion, reply.expectations, scene, (), make_report([(0.0, 0.0, 0.0)] * 101))
    changed = edits.scale_magnitudes(case, causes, 1.3).force_field

    def span(each):
        assert each.active_time is not None
        return each.active_time

    def reach(each):
        return each.magnitude * each.gain * (span(each)[1] - span(each)[0])

    for before, after in zip(field.constraints, changed.constraints):
        assert reach(after) == pytest.approx(1.3 * reach(before), rel=0.05)
        assert span(after)[0] == span(before)[0]
    windows = [span(each) for each in changed.constraints]
    assert all(one[1] <= other[0] + 1e-6 for one, other in zip(windows, windows[1:]))


@pytest.mark.parametrize(
    "sentence", ["the boat rocks from side to side", "the boat rocks", "the boat capsizes"]
)
def test_what_lies_rocks_and_tips_over_about_its_own_line(sentence):
    turns = read(sentence, ground(may_be_held=True, long_axis=(1, 0, 0), object_name="boat")).force_field
    assert all(abs(each.vector[0]) == pytest.approx(1.0) for each in (*turns.constraints, *turns.actions))


def test_what_wobbles_before_it_falls_tilts_over_its_foot():
    reply = read("the robot wobbles, then falls over", ground(may_be_held=True))
    assert {each.constraint_type for each in reply.force_field.constraints} == {"enforce_particle_rotation"}
    assert not reply.force_field.actions and reply.force_field.constraints[-1].held_until is None


def test_what_lies_is_led_as_it_spins_about_its_own_line():
    """The ground holds it against a torque."""
    scene = ground(long_axis=(1, 0, 0))
    reply = read("spin the robot around its long axis", scene)
    field = choose_kinds(reply.force_field, reply.expectations, scene).force_field
    (turn,) = field.constraints
    assert not field.actions and abs(turn.vector[0]) == 1 and turn.region is None


def test_what_is_crumpled_is_pressed_from_one_side_after_another():
    reply = read("crumple a robot made of tin foil", ground())
    assert (reply.materials, reply.unsure, reply.not_understood) == (("tin foil",), (), ())
    field = choose_kinds(reply.force_field, reply.expectations, ground()).force_field
    assert {each.constraint_type for each in field.constraints} == {"moving_plate"} and not field.actions
    begins = [(each.active_time or (0.0,))[0] for each in field.constraints]
    assert begins == sorted(begins) and len(set(begins)) == 2 and len(begins) == 3


@pytest.mark.parametrize(("line", "held"), [((0, 0, 1), True), (None, True), ((1, 0, 0), False)])
def test_what_stands_is_twisted_against_its_foot(line, held):
    """Both ends of it would turn, and let go it would jump; what lies is wrung at both its ends."""
    scene = ground(may_be_held=True, long_axis=line)
    reply = read("twist the robot, then let it spring back", scene)
    assert (reply.anchor.kind == "rest") == held
    assert len(reply.expectations) == (1 if held else 2)
    assert all(each.released for each in reply.expectations)


@pytest.mark.parametrize(("sunk", "passes"), [(0.5, True), (0.9, True), (1.2, False), (0.2, False)])
def test_what_lies_or_is_in_pieces_has_sunk_by_more_than_it_fell(sunk, passes):
    """A glass that falls by 0.48 lengths and smashes was FAIL: its middle sank by 0.3 more."""
    fall = Amount(value=0.48, unit="lengths")
    assert (expect_quantity(fall, MotionKind.FALL, brief()).margin(sunk) >= 0) is passes
