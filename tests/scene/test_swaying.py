"""Objects that stand and sway: the foot stays, the top goes to either side, and ends where it was."""

import itertools

import numpy as np
import pytest
import trimesh

from physagent_jax.forces.calibration import TURN, find_reference_time
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.matching import agrees, find_causes
from physagent_jax.motion.schema import DirectionTable, MotionKind, SceneBrief
from physagent_jax.motion.swaying import FOOT, sway
from physagent_jax.simulation.simulate import simulate_frames
from tests.agents.scenes import brief, read
from tests.scene.test_equilibrium import scene_of

STANDING = dict(world="ground", may_be_held=True)
UP, LAST = (0, 0, 1), 24


@pytest.mark.parametrize("sentence", ["the robot sways", "the robot wobbles", "bend the robot"])
def test_what_sways_where_it_stands_keeps_its_foot(sentence):
    reply = read(sentence, brief(**STANDING))
    assert reply.anchor.kind == "rest" and reply.anchor.region == FOOT
    assert not reply.force_field.actions and reply.force_field.constraints


@pytest.mark.parametrize("sentence", ["bend the robot to the left", "the robot sways"])
def test_what_bends_is_brought_about_by_its_turns(sentence):
    """Another force beside them would only fight them."""
    reply = read(sentence, brief(**STANDING))
    for motion in reply.expectations:
        causes = find_causes(motion, reply.force_field)
        assert [each.item for each in causes] == list(reply.force_field.constraints)
        assert all(agrees(each, motion) for each in causes)


def test_what_rocks_tilts_over_its_foot_as_a_whole():
    """To one side and back, to the other and back; nothing of it bends."""
    reply = read("the robot rocks to and fro", brief(**STANDING))
    turns = reply.force_field.constraints
    assert reply.anchor.kind is None and not reply.force_field.actions and len(turns) == 8
    assert all(each.region is None and each.bend is None and each.pivot is None for each in turns)
    angles = [each.vector[1] * each.magnitude * (each.active_time[1] - each.active_time[0]) for each in turns]
    size = abs(angles[0])
    assert np.cumsum(angles) / angles[0] == pytest.approx([1, 0, -1, 0] * 2, abs=0.01) and size > 0


@pytest.mark.parametrize(("verb", "held"), [("rocks", False), ("sways", True)])
def test_what_goes_gently_to_either_side_is_seen_to(verb, held):
    """A few degrees were not; what is not gentle goes farther."""
    scene, angles = brief(**STANDING), []
    for manner in (" gently", ""):
        first = read(f"the robot {verb}{manner} from side to side", scene).force_field.constraints[0]
        seconds = (first.active_time[1] - first.active_time[0]) * scene.frame_dt
        rate = np.degrees(TURN) * first.magnitude * first.gain / find_reference_time(held, scene.seconds)
        angles.append(rate * seconds)
    assert angles[0] > 9 and angles[1] > 1.3 * angles[0]


@pytest.mark.parametrize("held", [{}, {"anchored": "plants are rooted"}])
@pytest.mark.parametrize(
    ("sentence", "angle", "back"),
    [
        ("bend the robot to the left", 45.0, False),
        ("bend the robot far to the left", 58.5, False),
        ("bend the robot a little to the left", 22.5, False),
        ("bend the robot to the left by 60 degrees", 60.0, False),
        ("bend the robot to the left, then let it spring back", 45.0, True),
    ],
)
def test_what_stands_is_bent_over_its_foot_and_springs_back_if_it_is_let_go(sentence, angle, back, held):
    scene = brief(**STANDING | held, frames_fixed=False)
    reply = read(sentence, scene)
    turn, *swings = reply.force_field.constraints
    rate = np.degrees(TURN / find_reference_time(True, 0)) * scene.frame_dt
    turned = [
        -rate * each.vector[1] * each.magnitude * each.gain * np.subtract(*each.active_time[::-1])
        for each in (turn, *swings)
    ]
    last = (reply.frame_count or scene.frame_count) - 1
    assert turned[0] == pytest.approx(angle, rel=0.01) and bool(swings) == back
    assert sum(turned) == pytest.approx(0 if back else angle, abs=0.01 * angle)
    assert (swings or [turn])[-1].held_until == last
    assert turn.bend.rest == FOOT and turn.bend.depth >= 0.5
    (motion,) = (each for each in reply.expectations if each.kind is MotionKind.MOVE)
    assert motion.direction == (-1, 0, 0) and motion.released == back
    swung = [(a.active_time[1], b.active_time[0]) for a, b in itertools.pairwise(swings)]
    assert all(a == b for a, b in swung) and (not back or turn.held_until == swings[0].active_time[0])


@pytest.mark.parametrize(
    ("sentence", "way"),
    [("bend the robot", UP), ("bend the robot upwards", UP), ("bend the robot away from us", (0, 1, 0))],
)
def test_what_lies_bends_about_its_middle(sentence, way):
    """Both ends go there, as one end would not over the other as its foot."""
    reply = read(sentence, brief(**STANDING, long_axis=(1.0, 0.0, 0.0)))
    one, two = reply.force_field.constraints
    assert reply.anchor.kind is None and not reply.force_field.actions
    for turn, side in ((one, 1.0), (two, -1.0)):
        assert np.cross(turn.vector, (side, 0, 0)) * np.sign(turn.magnitude) == pytest.approx(way)
        assert turn.bend.rest != turn.region and turn.region.inside[0][0] == 0.5 + 0.25 * side
    (motion,) = reply.expectations
    assert motion.direction == pytest.approx(way) and motion.part is not None


@pytest.mark.parametrize("sentence", ["shake the robot", "the robot trembles"])
def test_what_is_rooted_shakes_quickly_and_ends_where_it_began(sentence):
    """A train of pushes swings what is limp at its own pace."""
    reply = read(sentence, brief(**STANDING, anchored="plants are rooted"))
    turns = reply.force_field.constraints
    ways = [
        each.vector[1] * each.magnitude * np.subtract(*each.active_time[::-1]) * each.gain for each in turns
    ]
    assert not reply.force_field.actions and len(turns) == 9 and abs(sum(ways)) < 0.01 * max(ways)


@pytest.mark.parametrize("sentence", ["shake the robot", "the robot sways"])
def test_what_was_shaken_is_kept_upright_at_the_end(sentence):
    """Let go with the speed of its last stroke, a soft pole was flung over."""
    scene = brief(**STANDING, anchored="its feet are held")
    last = read(sentence, scene).force_field.constraints[-1]
    assert last.held_until == scene.last and last.active_time[1] < scene.last


def test_jelly_jiggles_by_its_own_stiffness():
    """It is held at its base and pushed: a prescribed turn would hide that it is soft."""
    reply = read("the robot jiggles", brief(**STANDING, object_kind="jelly"))
    assert reply.anchor.kind == "base" and reply.force_field.actions and not reply.force_field.constraints


@pytest.mark.parametrize(
    "sentence", ["shake the robot up and down", "the robot rocks up and down four times"]
)
def test_what_is_rooted_and_shaken_upwards_is_pushed(sentence):
    reply = read(sentence, brief(**STANDING, anchored="plants are rooted"))
    assert reply.force_field.actions and not reply.force_field.constraints


def test_what_is_shaken_is_led_as_a_whole():
    reply = read("shake the robot", brief(**STANDING))
    led = reply.force_field.constraints
    assert reply.anchor.kind is None and led and not reply.force_field.actions
    assert all(each.region is None and each.bend is None for each in led)


@pytest.mark.parametrize("sentence", ["the robot bobs up and down", "the robot is tossed to and fro"])
def test_what_goes_to_and_fro_goes_as_a_whole(sentence):
    reply = read(sentence, brief(**STANDING))
    assert reply.anchor.kind is None and reply.force_field.actions and not reply.force_field.constraints


@pytest.mark.parametrize("changes", [dict(world="free"), dict(may_be_held=False)])
def test_what_floats_or_may_not_be_held_is_pushed_to_and_fro(changes):
    reply = read("the robot sways", brief(**STANDING | changes))
    assert reply.anchor.kind is None and not reply.force_field.constraints


@pytest.mark.parametrize("youngs_modulus", [2e4, 5e5])
def test_soft_and_stiff_things_sway_alike(tmp_path, youngs_modulus, least_optimised):
    path = tmp_path / "thing.obj"
    trimesh.creation.box((0.3, 0.3, 1.0)).export(path)
    table = DirectionTable(
        right=(1, 0, 0), left=(-1, 0, 0), up=(0, 0, 1), down=(0, 0, -1), toward=(0, -1, 0), away=(0, 1, 0)
    )
    about = SceneBrief(
        object_name="bar", frame_count=LAST + 1, frame_dt=0.04, world="ground", directions=table
    )
    turns = sway(about, (1.0, 0.0, 0.0), 1.0, 1, (0.0, float(LAST)))
    scene, _ = scene_of(
        path,
        frames=LAST + 1,
        cells=32,
        particles=1500,
        field=ForceField(constraints=tuple(turns)),
        anchor={"kind": "base"},
        material={"youngs_modulus": youngs_modulus, "density": 300.0},
    )
    rest = np.asarray(scene.state.x)
    way = np.stack([np.asarray(frame.state.x) - rest for frame in simulate_frames(scene)])
    height = rest[:, 2] - rest[:, 2].min()
    foot, top = (way[:, chosen, 0].mean(1) for chosen in (height < 0.08, height > 0.92))
    assert np.abs(foot).max() < 0.02
    assert 0.12 < top.max() < 0.3 and -0.3 < top.min() < -0.12
    assert top.argmax() < top.argmin()
    assert abs(top[-1]) < 0.05
