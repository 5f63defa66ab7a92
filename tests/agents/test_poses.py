"""Poses: the side that points down as something falls, what it ends up on, and matter that gives way."""

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from physagent_jax.agents.compiler import compile_intent
from physagent_jax.agents.grammar.semantic import read_intent
from physagent_jax.forces.calibration import DROP_HEIGHT, GRAVITY
from physagent_jax.forces.schema import ActionType, is_stop
from physagent_jax.motion.attitudes import find_attitude
from physagent_jax.motion.schema import MotionKind
from physagent_jax.scene.placement import find_tilt_rotation
from tests.agents.scenes import brief, read

LONG: dict[str, Any] = dict(extents=(1.0, 0.6, 0.4), long_axis=(1.0, 0.0, 0.0))
TALL: dict[str, Any] = dict(extents=(0.4, 1.0, 0.4), long_axis=(0.0, 0.0, 1.0))


def stand(name="thing", **changes):
    return brief(object_name=name, world="ground", frames_fixed=False, **changes)


@pytest.mark.parametrize(
    ("sentence", "shape", "down"),
    [
        ("drop the thing upside down", TALL, (0, 0, 1)),
        ("drop the thing upside down onto its leaves", TALL, (0, 0, 1)),
        ("drop the thing so that it lands on its head", TALL, (0, 0, 1)),
        ("the thing falls from the sky and lands on its roof", LONG, (0, 0, 1)),
        ("the thing plunges nose first onto the ground", LONG, (1, 0, 0)),
        ("the thing drops head first", TALL, (0, 0, 1)),
        ("the thing falls from 3 metres on its nose", LONG, (1, 0, 0)),
        ("the thing falls 2 metres and lands on its left side", TALL, (-1, 0, 0)),
        ("the thing falls from shoulder height onto its head", TALL, (0, 0, 1)),
        ("the thing falls from the sky face first", TALL, (0, -1, 0)),
        ("the thing falls off the table and lands on its back", TALL, (0, 1, 0)),
        ("the thing falls off the table and lands on its back", LONG, (0, 0, 1)),
        ("drop the thing on its left side", TALL, (-1, 0, 0)),
        ("the thing drops feet first", TALL, (0, 0, -1)),
    ],
)
def test_a_drop_begins_in_the_attitude_that_is_told(sentence, shape, down):
    reply = read(sentence, stand(**shape))
    assert reply.force_field.default_drop and not reply.force_field.actions
    assert [each.kind for each in reply.expectations] == [MotionKind.FALL]
    assert not reply.expectations[0].partial and not reply.unsure and not reply.unknown_parts
    assert reply.world.attitude is not None
    np.testing.assert_allclose(find_tilt_rotation(reply.world.attitude) @ down, (0, 0, -1), atol=1e-9)


def test_what_falls_as_it_stands_has_no_attitude():
    for sentence in (
        "drop the thing",
        "the thing falls from the sky and lands on its feet",
        "knock the thing over",
    ):
        assert read(sentence, stand(**TALL)).world.attitude in (None, (0.0, 0.0)), sentence


def test_what_stands_and_falls_on_a_side_tips_over():
    reply = read("the thing falls over and lies face down", stand(**TALL))
    assert reply.world.attitude is None and not reply.unsure
    assert reply.expectations[0].kind is MotionKind.ROTATE
    np.testing.assert_allclose(reply.expectations[0].direction or (), (1, 0, 0), atol=1e-9)


def test_what_lies_is_turned_over_onto_its_back():
    reply = read("flip the thing onto its back", stand(**LONG))
    (turn,) = reply.expectations
    assert turn.amount is not None and turn.amount.value == 180
    assert abs(np.dot(turn.direction or (), (1, 0, 0))) == pytest.approx(1)


@pytest.mark.parametrize("end", ["wheels", "feet", "leaves", "tyres"])
def test_what_it_ends_up_on_is_no_part_that_moves(end):
    reply = read(f"the thing rolls over sideways once and ends up on its {end}", stand(**LONG))
    (turn,) = reply.expectations
    assert not (reply.unknown_parts or reply.unsure or turn.partial)
    assert turn.amount is not None and turn.amount.value == 360
    assert abs(np.dot(turn.direction or (), (1, 0, 0))) == pytest.approx(1)


def test_an_end_is_raised_until_it_stands_on_the_other():
    reply = read("lift the front of the thing until it stands on its back end", stand(**LONG))
    (turn,) = reply.expectations
    assert turn.kind is MotionKind.ROTATE and turn.amount is not None and turn.amount.value == 80
    assert not turn.partial and turn.part is None


def test_a_flip_is_leapt():
    field = read("the thing does a backflip", stand(**TALL)).force_field
    assert [each.action_type for each in field.actions] == [ActionType.IMPULSE, *[ActionType.TORQUE] * 2]
    np.testing.assert_allclose(field.actions[1].vector, (-1, 0, 0), atol=1e-9)  # its top goes back
    np.testing.assert_allclose(field.actions[2].vector, (1, 0, 0), atol=1e-9)  # and is stopped


@pytest.mark.parametrize("words", ["is pushed hard, tips over and lies there", "is shoved and falls over"])
def test_what_is_long_falls_over_its_long_side_when_no_way_is_told(words):
    """A horse that was pushed was stood on its nose."""
    field = read(f"the thing {words}", stand(**LONG)).force_field
    (turn,) = [each for each in (*field.actions, *field.constraints)]
    np.testing.assert_allclose(np.abs(turn.vector), np.abs(stand(**LONG).long_axis), atol=1e-9)


def test_it_tumbles_the_way_that_it_is_thrown():
    reply = read("throw the thing forward so it tumbles head over heels once", stand(**LONG))
    turn = next(each for each in reply.expectations if each.kind is MotionKind.ROTATE)
    np.testing.assert_allclose(turn.direction or (), (1, 0, 0), atol=1e-9)
    assert not reply.unsure


@pytest.mark.parametrize("verb", ["sags", "slumps", "collapses", "buckles under its own weight"])
def test_what_gives_way_stays_where_it_stands_and_becomes_soft(verb):
    reply = read(f"the thing {verb}", stand(**TALL))
    assert [each.kind for each in reply.expectations] == [MotionKind.SQUEEZE]
    assert not (reply.force_field.default_drop or reply.force_field.actions or reply.unsure)
    assert reply.materials


def test_what_is_knocked_until_it_collapses_keeps_its_matter():
    reply = read("hit the thing so that it collapses", stand(**TALL))
    assert not reply.materials and MotionKind.ROTATE in [each.kind for each in reply.expectations]


def test_a_back_is_behind_a_person_and_on_top_of_what_lies():
    assert find_attitude("away", stand(**TALL)) == pytest.approx((-90.0, 0.0))
    assert find_attitude("away", stand(**LONG)) == find_attitude("up", stand(**LONG))


def test_the_front_is_told_by_the_names_of_parts():
    from physagent_jax.forces.part import Part
    from physagent_jax.forces.schema import CellsRegion

    cells: dict[str, Any] = dict(moved=CellsRegion(inside=((0.1, 0.5, 0.5),), outside=((0.9, 0.5, 0.5),)))
    cells["rest"] = cells["moved"]
    names = (("hood", (-1.0, 0.0, 0.0)), ("taillights", (1.0, 0.0, 0.1)))
    parts = tuple(
        Part(
            name=name,
            origin="file",
            joint=(0.5, 0.5, 0.5),
            arm=side,
            side=side,
            share=0.1,
            roles=("side",),
            **cells,
        )
        for name, side in names
    )
    turn = find_tilt_rotation(find_attitude("head", stand(parts=parts, **LONG)))
    np.testing.assert_allclose(turn @ (-1.0, 0.0, 0.0), (0, 0, -1), atol=1e-9)


def test_what_tips_onto_an_unknown_end_moves_as_a_whole():
    reply = read("the thing tips forward and falls on its beak", stand(**TALL))
    assert not reply.unknown_parts and not reply.unsure


@pytest.mark.parametrize(
    ("sentence", "kinds"),
    [
        ("lift the thing and shake it", ["move", "sway"]),
        ("the thing rattles and jumps up", ["sway", "move", "fall"]),
        ("the thing slides to the left and flips over", ["move", "rotate"]),
    ],
)
def test_what_would_hide_each_other_comes_one_after_the_other(sentence, kinds):
    motions = read(sentence, stand(**LONG)).expectations
    assert [each.kind.value for each in motions] == kinds
    assert motions[1].window[0] >= motions[0].window[1] - 0.5


@pytest.mark.parametrize(
    ("sentence", "count"),
    [
        ("the thing is dropped and bounces three times", 3),
        ("the thing falls from above and bounces on the floor", 2),
        ("the thing bounces on the floor", 2),
        ("the thing is dropped", 0),
        ("the thing is dropped and lands", 0),
    ],
)
def test_a_fall_that_bounces_is_one_fall_after_which_it_comes_up_again(sentence, count):
    scene = stand(**TALL)
    reply = read(sentence, scene)
    assert [each.kind for each in reply.expectations] == [MotionKind.FALL]
    leaps = reply.force_field.actions
    assert len(leaps) == count and all(each.vector == (0.0, 0.0, 1.0) for each in leaps)
    rises = [DROP_HEIGHT, *(each.magnitude * each.gain for each in leaps)]
    assert all(0.3 < after / before < 0.6 for before, after in pairwise(rises))
    flights = [
        math.sqrt(each * scene.size / GRAVITY) for each in (2 * rises[0], *(8 * each for each in rises[1:-1]))
    ]
    times = [0.0, *((each.active_time or (0,))[0] * scene.frame_dt for each in leaps)]
    for flight, (before, after) in zip(flights, pairwise(times)):  # it has just landed
        assert flight < after - before < flight + 3 * scene.frame_dt


def test_what_bends_down_to_the_ground_is_not_dropped():
    reply = read("the thing bends down until it touches the ground", stand(may_be_held=True, **TALL))
    assert not reply.force_field.default_drop and not reply.unsure
    (bend,) = reply.expectations
    assert bend.kind is MotionKind.MOVE and bend.direction == pytest.approx((-1, 0, 0))


def test_a_boat_that_rolls_from_side_to_side_rocks_about_its_line():
    (rock,) = read("the thing rolls from side to side", stand(**LONG)).expectations
    assert rock.kind is MotionKind.SWAY and rock.manner == "rock"


def test_parts_that_a_spin_flings_out_are_not_turned_alone():
    reply = read("spin the thing so fast that its leaves fly outwards", stand(**TALL))
    (turn,) = reply.expectations
    assert turn.kind is MotionKind.ROTATE and not turn.partial and not reply.unsure


def test_what_it_does_between_a_leap_and_its_landing_is_done_in_the_air():
    motions = read("the thing jumps up, spins around once in the air and lands", stand(**TALL)).expectations
    move, spin = (next(e for e in motions if e.kind.value == kind) for kind in ("move", "rotate"))
    assert spin.window[0] == move.window[0] and {e.kind.value for e in motions} == {"move", "rotate", "fall"}
    assert all(each.window[1] <= motions[1].window[1] for each in motions)  # nothing after it


def test_what_is_dropped_so_that_it_rolls_falls_first():
    reply = read("drop the thing on its side so that it rolls a little", stand(**TALL))
    assert reply.force_field.default_drop and reply.world.attitude is not None
    assert [each.kind.value for each in reply.expectations] == ["fall", "move", "rotate"]


def test_what_is_shaken_is_let_go_before_it_hops_away():
    scene = stand(**TALL)
    field = compile_intent(
        read_intent("the thing shakes itself and then hops away", scene), scene
    ).force_field
    (leap,) = field.actions
    shaken = [each for each in field.constraints if not is_stop(each)]
    held = max(each.held_until or each.active_time[1] for each in shaken)
    assert leap.active_time is not None and held <= leap.active_time[0] + 0.5


def test_a_couch_has_its_back_behind_and_a_thing_that_lies_on_top():
    for name, angle in (("couch", 90.0), ("thing", 180.0)):
        turn = read(f"the {name} tips over onto its back", stand(name, **LONG)).expectations[0]
        assert (turn.amount is None) == (angle == 90.0), name


def test_a_wheelie_is_done_and_ended():
    reply = read("the thing does a wheelie and then drops back down", stand(**LONG))
    (turn,) = reply.expectations
    assert turn.kind is MotionKind.ROTATE and turn.released and not reply.unsure


def test_what_is_to_fall_in_a_pose_later_is_turned_in_the_air():
    """By as much as brings that side down; else it falls as it is."""
    rise, turn, fall = read("it rises and then crashes down nose first", stand()).expectations
    assert turn.kind is MotionKind.ROTATE and turn.amount.value == pytest.approx(180.0)
    assert rise.window[1] <= turn.window[0] and turn.window[1] <= fall.window[0]
    assert not read("it crashes down nose first", stand()).unsure
    assert not read("it rises and then crashes down", stand()).unsure


@pytest.mark.parametrize(
    "sentence",
    [
        "let the thing fall so that it lands on one of its corners",
        "drop the thing on its edge",
        "the thing drops from a metre onto a corner",
        "the thing lands on an edge",
    ],
)
def test_what_lands_on_an_edge_falls_askew(sentence):
    reply = read(sentence, stand(**TALL))
    assert reply.world.attitude is not None and not reply.unsure and not reply.not_understood
    assert [each.kind for each in reply.expectations] == [MotionKind.FALL]


@pytest.mark.parametrize(
    ("sentence", "degrees"),
    [
        ("pick the thing up, then put it down upside down", 180.0),
        ("lift the thing and place it gently on its roof", 180.0),
        ("raise the thing, flip it over and lower it onto its head", 180.0),
        ("the thing is lifted and set back down the other way round", 180.0),
        ("lift the thing and lay it back down on its side", 90.0),
        ("pick the thing up and lower it onto the floor on its back", 90.0),
    ],
)
def test_what_is_set_down_otherwise_is_turned_in_the_air(sentence, degrees):
    reply = read(sentence, stand(**TALL))
    raised, turned, lowered = reply.expectations
    assert (raised.kind, turned.kind, lowered.kind) == (MotionKind.MOVE, MotionKind.ROTATE, MotionKind.MOVE)
    assert turned.amount is not None and turned.amount.value == degrees
    assert lowered.direction == (0.0, 0.0, -1.0) and lowered.amount is None and not reply.unsure


def test_what_was_turned_over_in_the_air_is_set_down_as_it_is():
    scene, ways = stand(**TALL), []
    for sentence in (
        "lift the thing, turn it upside down and set it back down",
        "lift the thing and set it down",
    ):
        reply = compile_intent(read_intent(sentence, scene), scene)
        first, *_, last = reply.force_field.constraints
        assert not any("turned back" in note for note in reply.notes)
        spans = [(hand.magnitude, hand.active_time or (0.0, 0.0)) for hand in (first, last)]
        up, down = (size * (end - begin) for size, (begin, end) in spans)
        ways.append(down / up)
    assert ways[0] < ways[1] == pytest.approx(1, rel=1e-2)  # its middle is elsewhere now: it drops the rest


def test_an_attitude_that_cannot_be_kept_is_not_dropped_silently():
    assert read("the thing flies upside down to the left", stand(**TALL)).not_understood == ("upside down",)
    turned = read("a kick knocks the thing upside down", stand(**TALL)).expectations
    assert [each.amount.value for each in turned if each.amount] == [180.0]


@pytest.mark.parametrize("way", ["left", "right", "away"])
def test_what_lies_flat_and_is_round_begins_on_its_edge_to_roll(way):
    reply = read(f"the thing rolls {way}", stand(extents=(1.0, 0.2, 1.0), box=(1.0, 0.9, 0.2)))
    turn = find_tilt_rotation(reply.world.attitude or (0.0, 0.0))
    going = getattr(stand(**TALL).directions, way)
    np.testing.assert_allclose(turn @ going, going, atol=1e-9)
    assert abs((turn @ (0.0, 0.0, 1.0))[2]) < 1e-9
    assert way == "away" or (turn @ (0.0, 0.0, 1.0)) @ stand(**TALL).directions.toward > 0.99


@pytest.mark.parametrize("box", [(1.0, 1.0, 0.8), (2.0, 1.0, 0.2)])
def test_what_is_no_disc_rolls_as_it_lies(box):
    assert read("the thing rolls left", stand(box=box)).world.attitude is None
