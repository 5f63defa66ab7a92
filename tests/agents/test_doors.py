"""Doors and lids that are closed: the edge that is their hinge, and how far they open."""

import itertools
import math

import numpy as np
import pytest

from physagent_jax.agents.compiler import compile_intent
from physagent_jax.agents.grammar.semantic import read_intent
from physagent_jax.forces.part import Part
from physagent_jax.forces.schema import CellsRegion
from physagent_jax.motion.hinges import find_hinge, stand_up
from physagent_jax.motion.schema import MotionKind
from tests.agents.scenes import brief

STEPS = np.linspace(0.0, 1.0, 6)
RIGHT, UP, TOWARD = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)


def fill(low, high):
    """Places on an even lattice in a box, bounding-box fractions."""
    low, high = np.asarray(low), np.asarray(high)
    return tuple(tuple((low + (high - low) * each).tolist()) for each in itertools.product(STEPS, repeat=3))


def make_piece(name, inside, outside, share=0.3):
    middle = np.mean(inside, axis=0) - 0.5
    return Part(
        name=name,
        origin="file",
        seated=True,
        moved=CellsRegion(inside=inside, outside=outside, rigid=True),
        rest=CellsRegion(inside=outside, outside=inside, rigid=True),
        joint=tuple(np.mean(inside, axis=0).tolist()),
        arm=UP,
        side=tuple((middle / np.linalg.norm(middle)).tolist()),
        share=share,
    )


def make_thing(*pieces):
    return brief(object_name="thing", world="ground", may_be_held=True, extents=(1.0, 1.0, 1.0), parts=pieces)


def make_chest(depth=0.8):
    """A lid on a box, which fills the object from side to side and is less deep."""
    lid, box = fill((0, 0, 0.62), (1, depth, 1)), fill((0, 0, 0), (1, depth, 0.58))
    return make_thing(make_piece("chest lid", lid, box), make_piece("chest", box, lid, 0.7))


def find_start(axis, arm):
    """The way in which a place begins to go when its arm turns about an axis."""
    return np.cross(axis, arm)


def test_a_lid_opens_about_its_long_edge_at_the_back():
    chest = make_chest()
    hinge = find_hinge(chest.parts[0], chest)
    assert hinge is not None and hinge.joint[1] > 0.7 and 0.55 < hinge.joint[2] < 0.7
    assert find_start(-np.array(hinge.axis), TOWARD)[2] > 0.99  # its front goes up
    assert find_hinge(chest.parts[1], chest) is None  # nothing turns the box


def test_a_lid_that_is_told_to_open_turns_and_is_not_lifted():
    reply = compile_intent(read_intent("The lid of the chest slowly opens", make_chest()), make_chest())
    ((turn,), (motion,)) = reply.force_field.constraints, reply.expectations
    assert motion.kind is MotionKind.ROTATE and motion.amount is not None
    assert 40 < motion.amount.value < 100 and turn.pivot[1] > 0.7


def test_a_slight_opening_is_less_wide():
    wide, slight = (
        compile_intent(read_intent(text, make_chest()), make_chest()).expectations[0].amount.value
        for text in ("open the lid", "open the lid slightly")
    )
    assert slight < 0.6 * wide


def test_a_lid_off_the_middle_opens_about_the_edge_there():
    hood, car = fill((0, 0, 0.7), (0.3, 1, 0.75)), fill((0, 0, 0), (1, 1, 0.66))
    thing = make_thing(make_piece("hood", hood, car))
    hinge = find_hinge(thing.parts[0], thing)
    assert hinge is not None and hinge.joint[0] == pytest.approx(0.3, abs=0.03)


def make_wall(name="door", low=(0.3, 0, 0), high=(0.7, 0.08, 0.8)):
    """A piece at the front of a block."""
    door, block = fill(low, high), fill((0, 0.12, 0), (1, 1, 1))
    return make_thing(make_piece(name, door, block, 0.1))


def test_a_door_opens_towards_us_about_an_upright_edge():
    wall = make_wall()
    hinge = find_hinge(wall.parts[0], wall)
    assert hinge is not None and abs(hinge.axis[2]) > 0.99
    assert hinge.joint[0] == pytest.approx(0.3, abs=0.05)
    assert find_start(-np.array(hinge.axis), RIGHT) @ np.array(TOWARD) > 0.99


def test_a_door_at_one_side_has_its_hinge_there():
    wall = make_wall(low=(0.6, 0, 0), high=(1, 0.08, 0.8))
    assert find_hinge(wall.parts[0], wall).joint[0] > 0.95


@pytest.mark.parametrize(("name", "height"), [("oven door", 0.0), ("garage door", 0.8)])
def test_some_doors_open_downwards_or_upwards(name, height):
    wall = make_wall(name)
    hinge = find_hinge(wall.parts[0], wall)
    assert hinge.joint[2] == pytest.approx(height, abs=0.05) and abs(hinge.axis[0]) > 0.99


def test_two_doors_have_their_hinges_away_from_each_other():
    block = fill((0, 0.12, 0), (1, 1, 1))
    left, right = fill((0.1, 0, 0), (0.48, 0.08, 0.8)), fill((0.52, 0, 0), (0.9, 0.08, 0.8))
    thing = make_thing(make_piece("left gate", left, block, 0.1), make_piece("right gate", right, block, 0.1))
    one, other = (find_hinge(part, thing) for part in thing.parts)
    assert one.joint[0] < 0.15 and other.joint[0] > 0.85
    assert one.axis[2] * other.axis[2] < 0


def test_both_doors_open_each_about_its_own_hinge():
    block = fill((0, 0.12, 0), (1, 1, 1))
    left, right = fill((0.1, 0, 0), (0.48, 0.08, 0.8)), fill((0.52, 0, 0), (0.9, 0.08, 0.8))
    thing = make_thing(make_piece("left gate", left, block, 0.1), make_piece("right gate", right, block, 0.1))
    reply = compile_intent(read_intent("both gates open", thing), thing)
    one, other = reply.force_field.constraints
    assert one.vector[2] * other.vector[2] < -0.9 and one.magnitude == other.magnitude
    assert {each.amount.value for each in reply.expectations} == {100.0}


def test_a_drawer_has_no_hinge():
    assert find_hinge(make_wall("drawer").parts[0], make_wall()) is None


@pytest.mark.parametrize("verb", ["swings open", "opens", "creaks open"])
def test_words_that_go_with_open_tell_the_same_motion(verb):
    reply = compile_intent(read_intent(f"the door {verb}", make_wall()), make_wall())
    (motion,) = reply.expectations
    assert motion.kind is MotionKind.ROTATE and motion.repeats == 1


def test_what_opens_may_stop_half_way_and_what_closes_may_not():
    """No number tells how far: a lid that stands half open is open, and one that is half shut is not shut."""
    asked = ("open the lid", "close the lid")
    told = [compile_intent(read_intent(text, make_chest()), make_chest()).expectations for text in asked]
    assert [[each.may_stop_short for each in motions] for motions in told] == [[True], [False]]


def test_what_opens_and_closes_on_a_hinge_does_so_in_steps():
    asked = ("open and close the lid", "the lid opens and closes twice")
    told = [compile_intent(read_intent(text, make_chest()), make_chest()).expectations for text in asked]
    assert [[each.direction[0] for each in motions] for motions in told] == [[-1, 1], [-1, 1, -1, 1]]
    assert all(each.amount.value == told[0][0].amount.value for motions in told for each in motions)


@pytest.mark.parametrize("words", ["whips back and forth", "rocks to and fro", "wobbles left and right"])
def test_what_goes_to_and_fro_on_a_hinge_is_no_two_steps(words):
    told = compile_intent(read_intent(f"the lid {words}", make_chest()), make_chest()).expectations
    assert [each.kind for each in told] == ["sway"]


def test_what_is_broad_and_low_does_not_turn_about_its_side():
    """A stem's foot touches the melon at its side as well: it was turned about the upright."""
    foot = CellsRegion(
        inside=tuple((x, y, 0.97) for x in (0.4, 0.5, 0.6) for y in (0.4, 0.5, 0.6)),
        outside=((0.34, 0.5, 0.97), (0.5, 0.5, 0.5)),
    )
    told = dict(moved=foot, rest=foot, joint=(0.5, 0.5, 0.97), side=(0.0, 0.0, 1.0), share=0.01)
    stem = Part(name="stem", seated=True, arm=(0.0, 0.0, 0.2), **told)
    arm = stand_up(stem, brief(box=(1.0, 1.0, 1.0))).arm
    assert arm[2] > 0.9 * math.hypot(*arm)
