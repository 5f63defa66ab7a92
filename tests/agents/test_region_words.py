"""Words for regions of an object without limbs: each acts on the particles of its own place, and on no others."""

import numpy as np
import pytest

from physagent_jax.agents.compiler import compile_intent
from physagent_jax.agents.grammar.semantic import read_intent
from physagent_jax.forces.regions import make_region_mask
from tests.agents.scenes import brief

GRID = np.stack(np.meshgrid(*[np.linspace(0, 1, 21)] * 3, indexing="ij"), -1).reshape(-1, 3)
TABLE = brief().directions


@pytest.mark.parametrize(
    ("sentence", "way", "share"),
    [
        ("push the top half to the left", "up", 0.5),
        ("pull the upper half up", "up", 0.5),
        ("push the left half up", "left", 0.5),
        ("push the upper part to the right", "up", 0.5),
        ("push the bottom half to the right", "down", 0.5),
        ("push the front up", "toward", 0.5),
        ("pull the back up", "away", 0.5),
        ("pull the tip down", "up", 0.25),
        ("push the rim to the left", "up", 0.25),
        ("push the neck to the left", "up", 0.35),
        ("push the base to the left", "down", 0.3),
        ("pull the left end down", "left", 0.25),
        ("lift the right side", "right", 0.5),
        ("push down on one end of the robot", "right", 0.25),
        ("pull one side of it up", "right", 0.4),
    ],
)
def test_a_region_lies_where_its_word_says(sentence, way, share):
    about = brief()
    reply = compile_intent(read_intent(sentence, about), about)
    regions = {each.region for each in reply.force_field.actions}
    regions |= {each.region for each in reply.force_field.constraints}
    (region,) = regions
    assert region is not None and not reply.unsure
    mask = make_region_mask(region, GRID)
    along = (GRID - 0.5) @ np.asarray(getattr(TABLE, way))
    assert along[mask].min() >= along[~mask].max() - 1e-9  # all that lies beyond a plane across the way
    assert 0.04 < mask.mean() <= share + 0.05


@pytest.mark.parametrize(
    ("sentence", "part"),
    [
        ("lift one end of the robot", True),
        ("lift the robot by one end", True),
        ("raise a corner of the robot", True),
        ("push the robot to one side", False),
        ("push the robot to one side of the room", False),
        ("push the robot from one end of the table to the left", False),
    ],
)
def test_an_end_of_it_is_a_part_and_a_way_there_is_none(sentence, part):
    about = brief()
    reply = compile_intent(read_intent(sentence, about), about)
    assert all((each.part is not None) == part for each in reply.expectations) and reply.expectations


def test_the_middle_is_between_the_ends():
    about = brief()
    reply = compile_intent(read_intent("push the middle to the left", about), about)
    mask = make_region_mask(reply.force_field.actions[0].region, GRID)
    height = GRID[:, 2]
    assert 0.3 < height[mask].min() and height[mask].max() < 0.7 and mask.mean() > 0.25
