"""Landings: a jump ends on its feet, until something else begins."""

import pytest

from physagent_jax.forces.calibration import DROP_HEIGHT, GRAVITY, MAGNITUDE_MIN
from physagent_jax.forces.schema import ActionType, is_stop
from physagent_jax.motion.matching import Cause
from physagent_jax.motion.wishes import replace_items
from tests.agents.scenes import brief, read


def list_landings(sentence, **more):
    reply = read(sentence, brief(world="ground", **more))
    landings = [each for each in reply.force_field.constraints if is_stop(each)]
    blows = [each for each in reply.force_field.actions if each.action_type is ActionType.IMPULSE]
    return blows, landings


def test_each_jump_ends_in_a_stop_before_the_next_begins():
    blows, landings = list_landings("the robot jumps twice")
    assert len(blows) == len(landings) == 2
    assert (
        blows[0].active_time[1]
        < landings[0].active_time[0]
        < landings[0].held_until
        <= blows[1].active_time[0]
    )


@pytest.mark.parametrize("share", [0.5, 1.0])
def test_it_comes_down_when_a_body_in_free_flight_does(share):
    """It rises by M lengths against its weight: 2 sqrt(2 h / g)."""
    blows, (landing,) = list_landings(f"the robot jumps up by {share} body lengths")
    rise = blows[0].magnitude * brief().size
    aloft = 2 * (2 * rise / 9.8) ** 0.5 / brief().frame_dt
    assert landing.active_time[0] - blows[0].active_time[1] == pytest.approx(aloft, abs=1.0)


def test_a_small_hop_is_far_lower_than_a_leap():
    rises = []
    for sentence in ("the robot does a small hop", "the robot jumps up"):
        (blow,), (landing,) = list_landings(sentence)
        rise = blow.magnitude * blow.gain
        aloft = 2 * (2 * rise * brief().size / 9.8) ** 0.5 / brief().frame_dt
        assert landing.active_time[0] - blow.active_time[1] == pytest.approx(aloft, abs=1.0)
        rises.append(rise)
    assert rises[0] <= 0.3 * rises[1]


@pytest.mark.parametrize(
    "sentence",
    ["the robot jumps and lands on its back", "throw the robot into the air"],
)
def test_what_falls_over_or_is_thrown_is_not_stopped(sentence):
    assert not list_landings(sentence)[1]


def test_what_flips_all_round_stands_where_it_comes_down_to_the_end():
    """It toppled: its feet come down a little askew."""
    _, landings = list_landings("the robot does a backflip")
    assert [each.held_until for each in landings] == [brief().last]


def test_the_stop_is_said_and_goes_with_the_jump_that_it_was_made_for():
    """A higher jump comes down later: at the old time it would hang in the air."""
    reply = read("the robot jumps twice", brief(world="ground"))
    assert any("stopped where it comes down" in note for note in reply.notes)
    field = reply.force_field
    causes = [Cause("actions", index, item) for index, item in enumerate(field.actions)]
    higher = [each.model_copy(update={"magnitude": 1.2}) for each in field.actions]
    assert field.constraints and not replace_items(field, causes, higher).constraints


@pytest.mark.parametrize(
    "sentence",
    [
        "the robot jumps twice, the second time much higher",
        "the robot hops twice on the spot, and the second hop is way higher than the first",
        "it jumps, then jumps higher",
    ],
)
def test_the_second_of_two_jumps_is_higher_where_that_is_said(sentence):
    blows, _ = list_landings(sentence)
    assert len(blows) == 2 and blows[1].magnitude > 1.3 * blows[0].magnitude
    assert not read(sentence, brief(world="ground")).unsure


def test_jumps_each_higher_than_the_one_before_are_a_doubt_and_no_stretch():
    reply = read("it hops three times, each higher than the one before", brief(world="ground"))
    assert {each.action_type for each in reply.force_field.actions} == {ActionType.IMPULSE}
    assert any("How much 'higher' each time" in doubt for doubt in reply.unsure)


@pytest.mark.parametrize(
    "sentence",
    [
        "the jelly robot is dropped and wobbles when it lands",
        "drop the jelly robot so it squashes on impact and then jiggles back into shape",
        "the robot is made of jelly, it drops, gets squished as it hits the floor and springs back",
    ],
)
def test_what_is_soft_stands_and_wobbles_where_it_lands(sentence):
    """It bounced, tipped over and lay on its side. It is down after sqrt(2 h / g)."""
    blows, (landing,) = list_landings(sentence)
    down = (2 * DROP_HEIGHT * brief().size / GRAVITY) ** 0.5 / brief().frame_dt
    assert not blows and landing.active_time[0] == pytest.approx(down, abs=1.0)
    assert landing.held_until == brief().last and landing.magnitude > MAGNITUDE_MIN


@pytest.mark.parametrize(
    "sentence",
    [
        "the robot is dropped and wobbles when it lands",
        "the jelly robot is dropped onto its side",
        "the jelly robot is dropped and bounces twice",
        "the jelly robot is dropped, then squash it",
    ],
)
def test_what_is_hard_or_is_not_to_stand_is_left_to_itself(sentence):
    assert not list_landings(sentence)[1]


def test_hops_in_a_row_go_as_far_as_a_thrown_body_that_lands_before_the_next():
    """Four hops over a floor went four tenths of a length in all: 4 M cos sin is the range of each [body lengths]."""
    blows, _ = list_landings("the robot hops across the floor")
    ranges = [
        4 * each.magnitude * each.gain * each.vector[2] * (1 - each.vector[2] ** 2) ** 0.5 for each in blows
    ]
    assert len(blows) == 4 and min(ranges) > 0.2 and sum(ranges) < 2.0


@pytest.mark.parametrize(("times", "count"), [("once", 1), ("twice", 2)])
def test_what_is_soft_and_bounces_wobbles_where_it_comes_down_at_last(times, count):
    """Its own spring adds leaps that nobody asked for; it is stopped once it has made those that are told."""
    told = f"the jelly is dropped, bounces {times} and then wobbles until it settles"
    scene = dict(object_name="jelly", object_kind="jelly", frame_count=100)
    blows, (landing,) = list_landings(told, **scene)
    assert len(blows) == count
    rise = blows[-1].magnitude * blows[-1].gain * brief().size
    aloft = 2 * (2 * rise / GRAVITY) ** 0.5 / brief().frame_dt
    assert landing.active_time[0] - blows[-1].active_time[0] == pytest.approx(aloft, abs=1.5)
    assert landing.held_until == pytest.approx(99, abs=1.0), "a rest is nothing to get up for"
    assert not list_landings(f"the jelly is dropped and bounces {times}", **scene)[1]
