"""Parts that come off: how a sentence says so, the way that they go, and that they do come off."""

import math
import warnings

import numpy as np
import pytest
import trimesh

import physagent_jax as pa
from physagent_jax.agents.context import AgentContext, Observation
from physagent_jax.agents.rules.planner import RulePlanner
from physagent_jax.forces.schema import ConstraintType
from physagent_jax.metrics import report_true_motion
from physagent_jax.motion.schema import MotionKind, Verdict
from tests.agents.scenes import Unseen, brief
from tests.agents.test_limbs import HEAD, LEFT_ARM, RIGHT_ARM, make_part, read

GROUND = dict(world="ground")


@pytest.mark.parametrize(
    "sentence",
    [
        "its head falls off",
        "the robot's head comes off",
        "the head snaps off",
        "knock its head off",
        "the head breaks off and drops to the ground",
        "the head falls off and rolls away",
        "its head falls off and bounces",
        "the head rolls off and lands next to the body",
        "the head falls off, bounces twice and rolls away",
        "the head comes off and flutters to the ground",
        "its head snaps in half",
        "the head breaks in two",
        "the head snaps off in the middle, and its tip falls to the floor",
        "the head comes off, and the robot sags on that side",
        "the head slips off and falls to the floor",
        "the head drops off the edge of the robot",
        "the head gets pulled off and falls on the ground beside the tail",
        "someone yanks off its head",
    ],
)
def test_a_part_comes_off_and_the_rest_stays(sentence):
    """It is led away from all that stays, as a piece of its own, and then let go."""
    reply = read(sentence, **GROUND)
    (lead,) = reply.force_field.constraints
    (expected,) = reply.expectations
    assert not reply.force_field.actions and not reply.unsure and not reply.materials
    assert lead.constraint_type is ConstraintType.PARTICLE_TRANSLATION and lead.held_until is None
    assert lead.region.inside == HEAD.moved.inside and lead.region.outside == HEAD.rest.inside
    assert lead.region.rigid and lead.active_time[1] < 20
    assert reply.anchor.kind == "rest" and reply.anchor.region.inside == HEAD.rest.inside
    assert (expected.kind, expected.limb, expected.manner) == (MotionKind.MOVE, 2, "detach")
    assert expected.direction[2] < 0


def test_a_piece_on_the_side_comes_off_outwards():
    """A push would press what has no joint of its own into the rest."""
    knob = make_part("handle", (-0.4, 0, 0), (-1, 0, 0)).model_copy(
        update=dict(seated=True, name="knob", roles=())
    )
    (lead,) = read("the knob comes off and falls down", HEAD, knob, **GROUND).force_field.constraints
    assert lead.vector[0] < -0.5


def test_what_pops_off_goes_up_first():
    """A viewer is asked whether it goes up, and not whether it lies on the ground in the end."""
    falls, pops = (read(f"the head {words}", **GROUND) for words in ("falls off", "pops off"))
    for reply, sign in ((falls, -1), (pops, 1)):
        assert sign * reply.expectations[0].direction[2] > 0.5
    lifted, dropped = (reply.force_field.constraints[0].vector[2] for reply in (pops, falls))
    assert lifted > dropped >= 0 and lifted > 0.5


@pytest.mark.parametrize(("word", "arm", "sign"), [("left", LEFT_ARM, -1), ("right", RIGHT_ARM, 1)])
def test_a_limb_goes_the_way_that_it_points(word, arm, sign):
    (lead,) = read(f"the {word} arm falls off", **GROUND).force_field.constraints
    assert sign * lead.vector[0] > 0.6 and lead.region.inside == arm.moved.inside


@pytest.mark.parametrize(
    "sentence",
    [
        "the head slips off its left arm",
        "a strong wind knocks the head off the left arm",
        "the head falls off the robot's right arm and rolls away",
    ],
)
def test_what_a_part_comes_off_is_no_part_that_moves(sentence):
    reply = read(sentence, **GROUND)
    assert [each.limb for each in reply.expectations] == [2] and not reply.unsure


@pytest.mark.parametrize(
    ("sentence", "way"),
    [
        ("the head falls off and lands to the left of the robot", (-1, 0, 0)),
        ("the head falls off and rolls away to the right", (1, 0, 0)),
        ("the head flies off in the wind and lands behind it", (0, 1, 0)),
        ("a gust of wind from the left blows the head off", (1, 0, 0)),
        ("the head pops off and lands on the right", (1, 0, 0)),
    ],
)
def test_a_part_goes_where_it_is_said_to_land(sentence, way):
    (lead,) = read(sentence, **GROUND).force_field.constraints
    assert np.dot(lead.vector, way) > 0.15


def test_a_wind_does_not_blow_a_part_straight_up():
    (motion,) = read("the wind blows its head off", **GROUND).expectations
    assert motion.direction[2] < 0


@pytest.mark.parametrize(("words", "sign"), [("", -1), (" to the right", 1), (" to the left", -1)])
def test_a_wheel_is_drawn_off_its_axle_and_rolls_on(words, sign):
    """Along the ground, to the nearer end of what it carries where no way is told."""
    told = dict(name="wheel", roles=(), origin="file", axle=(0.0, 1.0, 0.0))
    low = make_part("side", (0, 0, 0), (-0.6, -0.6, -1.1)).model_copy(update=told)
    wheel = low.model_copy(update=dict(joint=(0.26, 0.26, 0.25)))
    made = read(f"the wheel comes off and rolls away{words}", wheel, **GROUND).force_field.constraints
    assert [each.constraint_type for each in made] == [
        ConstraintType.PARTICLE_TRANSLATION,
        ConstraintType.PARTICLE_ROTATION,
    ]
    assert made[0].vector == pytest.approx((0, -1, 0)) and made[1].active_time[0] == made[0].active_time[1]
    assert made[1].vector == pytest.approx((0, sign, 0)) and made[1].pivot[2] == 0.0


def make_wheels():
    """Four wheels that bear an object, each about the world's y axis."""
    told = dict(name="wheel", roles=(), origin="file", axle=(0.0, 1.0, 0.0))
    sides = [(x, y, -1.1) for x in (-0.6, 0.6) for y in (-0.6, 0.6)]
    wheels = [make_part("side", (0, 0, 0), side).model_copy(update=told) for side in sides]
    places = [(0.5 + 0.4 * x, 0.5 + 0.4 * y, 0.25) for x, y, _ in sides]
    pieces = [each.moved.model_copy(update=dict(rigid=True)) for each in wheels]
    told = [dict(joint=place, moved=piece) for place, piece in zip(places, pieces)]
    return [each.model_copy(update=more) for each, more in zip(wheels, told)]


@pytest.mark.parametrize(
    "sentence", ["the wheels fall off and it drops to the ground", "all of its wheels come off"]
)
def test_what_loses_its_wheels_is_held_until_they_are_off_and_falls(sentence):
    reply = read(sentence, *make_wheels(), **GROUND)
    made = reply.force_field.constraints
    leads, (hold,) = made[:-1], made[-1:]
    assert reply.anchor.kind == "none" and not reply.unsure
    assert hold.held_until == max(each.active_time[1] for each in leads) < 25
    wheels = {each.region.inside for each in leads}
    assert len(wheels) == 4 and not wheels & {hold.region.inside}


def test_what_loses_one_wheel_of_four_stands_on_the_others():
    reply = read("the left wheel comes off", *make_wheels()[:1], LEFT_ARM, **GROUND)
    assert reply.anchor.kind == "rest"


def test_a_part_that_stands_on_the_ground_is_not_shot_along_it():
    """It leaves no faster than it goes aside in a fifth of a second."""
    legs = [make_part("leg", (0, 0, -0.2), (x, 0, -1.1)) for x in (-0.6, 0.6)]
    scene = brief(parts=tuple(legs), **GROUND)
    for lead in read("its legs come off", *legs, **GROUND).force_field.constraints:
        seconds = (lead.active_time[1] - lead.active_time[0]) * scene.frame_dt
        assert seconds > 0.05


def test_what_else_is_said_is_said_to_be_of_the_part():
    notes = read("the head falls off and rolls away", **GROUND).notes
    assert any("'rolls'" in note and "the part that comes off" in note for note in notes)


def test_without_gravity_it_goes_straight_on():
    reply = read("the left arm falls off", world="free")
    assert reply.expectations[0].direction == pytest.approx(reply.force_field.constraints[0].vector, abs=1e-6)


def test_what_has_no_part_that_could_come_off_falls_itself():
    reply = read("the robot falls off", **GROUND)
    assert [each.kind for each in reply.expectations] == [MotionKind.FALL]
    assert not reply.force_field.constraints


@pytest.mark.parametrize(
    ("goes", "verdict"),
    [(1.0, "SUCCESS"), (0.0, "FAIL"), (-1.0, "FAIL")],
)
def test_a_part_that_has_come_off_goes_its_own_way(goes, verdict):
    """It lies aside, in a piece of its own."""
    sentence = "the head falls off and rolls away"
    reply = read(sentence, HEAD, **GROUND)
    chance, level = np.random.default_rng(0), np.array(reply.force_field.constraints[0].vector) * (1, 1, 0)
    body = chance.uniform((-0.2, -0.2, -0.5), (0.2, 0.2, 0.3), (600, 3))
    head = chance.uniform((-0.2, -0.2, 0.3), (0.2, 0.2, 0.5), (200, 3))
    frames = []
    for t in np.clip((np.arange(50) - 5) / 20, 0, 1):
        way = 0.9 * goes * t * level / np.linalg.norm(level) - (0, 0, 0.8 * t * t * goes)
        frames.append(np.concatenate([body, head + way]))
    scene = brief(parts=(HEAD,), anchored="all but the part", **GROUND)
    context = AgentContext(sentence, scene, (), reply)
    report = report_true_motion(
        np.stack(frames),
        frame_dt=0.04,
        windows=RulePlanner().windows(context),
        parts={0: np.arange(800) >= 600},
    )
    report = report.model_copy(update=dict(pieces=tuple(1 + (k > 9) for k in range(50))))
    judged = RulePlanner().judge(context, Observation(reply.force_field, report, Unseen())).value
    assert judged.verdict is Verdict(verdict), judged.checks


def make_doll(path):
    """A ball on a thin neck on a box."""
    parts = [
        trimesh.creation.box((0.5, 0.3, 0.5)).apply_translation((0, 0, 0.25)),
        trimesh.creation.cylinder(0.06, 0.3).apply_translation((0, 0, 0.6)),
        trimesh.creation.icosphere(3, 0.2).apply_translation((0, 0, 0.85)),
    ]
    trimesh.util.concatenate(parts).export(path)
    return path


@pytest.mark.usefixtures("least_optimised")
def test_the_head_of_a_doll_lies_on_the_ground_beside_it(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        loaded = pa.load_object(make_doll(tmp_path / "doll.obj"), up="+z", max_particles=700, cells=32)
        scene = pa.build_scene(loaded, "the doll's head falls off", frame_count=40, width=48, height=48)
        x = pa.simulate_scene(scene).x
    height = np.ptp(x[0, :, 2])
    head = x[0, :, 2] > x[0, :, 2].min() + 0.68 * height
    shift = x[-1] - x[0]
    body = x[0, :, 2] < x[0, :, 2].min() + 0.3 * height
    assert np.abs(shift[body]).max() < 0.01 * height
    assert shift[head, 2].mean() < -0.4 * height
    assert np.linalg.norm(shift[head, :2].mean(0)) > 0.3 * height
    assert math.isclose(np.ptp(x[-1, head], axis=0).max(), np.ptp(x[0, head], axis=0).max(), rel_tol=0.4)


def test_what_has_come_off_does_not_keep_the_rest_from_giving_way():
    reply = read("its head falls off and the robot melts", **GROUND)
    assert [each.kind for each in reply.expectations] == [MotionKind.MOVE, MotionKind.SQUEEZE]
