"""Going to pieces: it is whole until it lands, or until the sentence says that it breaks."""

import math

import pytest

from physagent_jax.agents.compiler import compile_intent
from physagent_jax.agents.grammar.semantic import read_intent
from physagent_jax.forces.calibration import DROP_HEIGHT, GRAVITY
from physagent_jax.run.rigidity import keeps_shape
from tests.agents.scenes import brief

PLAIN = dict(world="ground", frames_fixed=False, parts=())
GROUND = brief(**PLAIN)


def read(prompt, scene=GROUND):
    return compile_intent(read_intent(prompt, scene), scene)


def list_bursts(reply):
    return [each for each in reply.force_field.constraints if each.constraint_type == "shatter"]


@pytest.mark.parametrize(
    "prompt",
    [
        "the robot falls and shatters on the floor",
        "drop the robot so it breaks into pieces",
        "make the robot out of glass and drop it so it smashes into pieces",
        "the robot shatters",
        "the robot smashes to bits on the floor",
    ],
)
def test_what_falls_bursts_as_it_lands(prompt):
    """It was of brittle matter from the first frame on, which the landing pressed into a heap."""
    reply = read(prompt)
    (burst,) = list_bursts(reply)
    height = reply.world.drop_height or DROP_HEIGHT
    landing = math.sqrt(2 * height * GROUND.size / GRAVITY) / GROUND.frame_dt
    assert burst.active_time[0] == pytest.approx(landing, abs=0.01)
    assert reply.materials in ((), ("glass",)) and keeps_shape(reply) and not reply.unsure


@pytest.mark.parametrize(
    "prompt",
    [
        "the robot jumps up and down twice, then spins and finally breaks into pieces",
        "the robot spins and then shatters",
        "the robot slides to the left, then spins and then crumbles into pieces",
    ],
)
def test_what_breaks_late_is_whole_until_then(prompt):
    reply = read(prompt)
    (burst,) = list_bursts(reply)
    at = burst.active_time[0]
    spins = [each for each in reply.expectations if each.kind.value == "rotate"]
    assert at >= max(each.window[1] for each in spins) and not reply.materials
    for each in reply.force_field.constraints:
        assert each is burst or max(each.active_time[1], each.held_until or 0) <= at
    assert all(each.active_time[1] <= at + 1e-3 for each in reply.force_field.actions)


def test_what_leaps_bursts_where_it_comes_down():
    reply = read("the robot jumps up in the air and shatters when it lands")
    (burst,), (leap,) = list_bursts(reply), reply.force_field.actions
    flight = math.sqrt(8 * leap.magnitude * leap.gain * GROUND.size / GRAVITY) / GROUND.frame_dt
    assert burst.active_time[0] == pytest.approx(leap.active_time[1] + flight, abs=0.01)


@pytest.mark.parametrize(
    "prompt",
    [
        "the robot cracks",
        "the robot splits in two",
        "its head breaks off",
        "the robot crumbles to dust",
        "squeeze the robot until it breaks",
        "drop the robot",
    ],
)
def test_what_is_cracked_parted_or_crushed_does_not_burst(prompt):
    assert not list_bursts(read(prompt))


def test_what_is_tough_bursts_more_gently_unless_it_is_said_to_be_of_glass():
    food = brief(**PLAIN, object_kind="food")
    (cake,), (glass,) = (
        list_bursts(read(f"the {what}robot falls and shatters", food)) for what in ("", "glass ")
    )
    assert cake.magnitude < glass.magnitude
