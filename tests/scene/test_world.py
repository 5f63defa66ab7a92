"""Gravity, ground and obstacles around an object."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from physagent_jax.agents.schema import SemanticReply
from physagent_jax.forces.calibration import (
    DROP_HEIGHT,
    FRICTION,
    GRAVITY,
    MOST_DROP,
    REFERENCE_TIME,
    SWEEP,
    TRAVEL,
)
from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.schema import ObstacleRequest, WorldRequest
from physagent_jax.run.brief import make_brief
from physagent_jax.run.resolve import resolve, resolve_world
from physagent_jax.run.spec import RunSpec
from physagent_jax.scene import config as c
from physagent_jax.scene.body import make_body
from physagent_jax.scene.fuse import estimate_sweep, fuse
from physagent_jax.scene.world import GROUND, find_ground_height, rolls


def resolved(path, **parts):
    overrides = dict(max_particles=800, **parts.pop("overrides", {}))
    return resolve(
        RunSpec.model_validate(dict(object={"path": str(path)}, prompt="x", overrides=overrides, **parts))
    )


@pytest.fixture(scope="module")
def body(robot_path):
    template = resolved(robot_path).template
    return make_body(template.source, template.preset.filling, template.preset.domain, ".")


def fused(path, body, field=None, said=None, **parts):
    run = resolved(path, **parts)
    reply = SemanticReply(force_field=ForceField(), world=said or WorldRequest())
    return fuse(run.with_reply(reply), body, field or ForceField())


def planes(config):
    return [each for each in config.boundaries if isinstance(each, c.HalfSpace)]


def test_on_the_ground_gravity_acts_and_the_feet_touch(robot_path, body):
    config = fused(robot_path, body, world="ground")
    (ground,) = planes(config)
    feet = body.particles.x[:, 2].min()
    assert config.always_gravity and config.gravity == (0.0, 0.0, -GRAVITY)
    assert feet - 1e-4 <= ground.point[2] <= feet + 0.02 and ground.friction == FRICTION
    assert fused(robot_path, body, world="ground", friction=0.1).boundaries[-1].friction == 0.1


def test_what_drops_is_lifted_and_what_hangs_is_clear_of_the_ground(robot_path, body):
    standing = planes(fused(robot_path, body, world="ground"))[0].point[2]
    dropped = planes(fused(robot_path, body, ForceField(default_drop=True), world="ground"))[0].point[2]
    hung = planes(fused(robot_path, body, world="ground", anchor={"kind": "top"}))[0].point[2]
    assert standing - dropped == pytest.approx(DROP_HEIGHT * body.extent, abs=2e-4)
    assert hung == dropped


def test_what_is_dropped_can_be_kept_upright_once_it_is_thrown_up_again(robot_path, body):
    levers = [
        fused(robot_path, body, ForceField(default_drop=drop), world="ground").scaling.opposition
        for drop in (False, True)
    ]
    assert levers[0].lever == levers[1].lever > 0 and levers[1].friction == 0


def test_a_sentence_tells_how_high_it_falls_from():
    told = resolve_world(GROUND, WorldRequest(drop_height=1.2))
    assert (resolve_world(GROUND, WorldRequest()).drop_height, told.drop_height) == (DROP_HEIGHT, 1.2)


def test_what_falls_from_a_told_height_has_its_ground_so_far_below(body):
    world, free = dataclasses.replace(GROUND, drop_height=0.8), c.Anchor(kind="none")
    standing, falling = (find_ground_height(world, body, free, drop=drop) for drop in (False, True))
    assert standing - falling == pytest.approx(0.8 * body.extent, abs=2e-4)


@pytest.mark.parametrize("height", [0.8, MOST_DROP])
def test_what_drops_from_a_told_height_has_so_much_room_below(robot_path, body, height):
    standing = planes(fused(robot_path, body, world="ground"))[0].point[2]
    said = WorldRequest(drop_height=height)
    config = fused(robot_path, body, ForceField(default_drop=True), world="ground", said=said)
    assert standing - planes(config)[0].point[2] == pytest.approx(height * body.extent, abs=2e-4)
    assert planes(fused(robot_path, body, world="ground", said=said))[0].point[2] == standing


def test_the_free_world_has_neither_until_something_drops(robot_path, body):
    config = fused(robot_path, body, world="free")
    assert not config.always_gravity and not planes(config)
    (ground,) = planes(fused(robot_path, body, ForceField(default_drop=True), world="free"))
    assert ground.friction == 0 and ground.point[2] == pytest.approx(
        body.low[2] - 0.5 * body.extent, abs=1e-4
    )


@pytest.mark.parametrize("kind", ["ground", "free"])
def test_the_sentence_goes_before_the_world(robot_path, body, kind):
    up = fused(robot_path, body, world=kind, said=WorldRequest(gravity="up"))
    assert up.always_gravity and up.gravity[2] == GRAVITY and not planes(up)
    none = fused(robot_path, body, world=kind, said=WorldRequest(gravity="none"))
    assert not none.always_gravity and not planes(none)
    down = fused(robot_path, body, world=kind, said=WorldRequest(gravity="down"))
    assert down.always_gravity and len(planes(down)) == 1
    bare = fused(robot_path, body, world=kind, said=WorldRequest(gravity="down", ground=False))
    assert bare.always_gravity and not planes(bare)


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.6, 0.8, 0.0), (0.0, 0.0, 1.0)])
def test_obstacles_stand_where_the_sentence_has_them(robot_path, body, direction):
    away, x = np.asarray(direction), body.particles.x
    request = ObstacleRequest(kind="wall", direction=direction, distance=0.4)
    wall = fused(robot_path, body, world="free", said=WorldRequest(obstacles=(request,))).boundaries[-1]
    gap = np.asarray(wall.point) @ away - (x @ away).max()
    assert gap == pytest.approx(0.4 * body.extent, abs=1e-3)
    np.testing.assert_allclose(wall.normal, -away, atol=1e-6)
    block = fused(
        robot_path,
        body,
        world="ground",
        said=WorldRequest(obstacles=(request.model_copy(update=dict(kind="block")),)),
    ).boundaries[-1]
    assert isinstance(block, c.Box)
    corners = np.asarray(block.point) + np.asarray(block.half_size) * (
        np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T
    )
    assert (corners @ away).min() - (x @ away).max() == pytest.approx(0.4 * body.extent, abs=2e-3)
    if not direction[2]:
        assert corners[:, 2].min() == pytest.approx(x[:, 2].min(), abs=0.02)


def test_the_camera_has_room_for_what_a_wall_throws_back(robot_path, body):
    throw = ForceField.model_validate(
        {
            "actions": [
                {"action_type": "impulse", "vector": [1, 0, 0], "magnitude": 1.6, "active_time": [0, 1]}
            ]
        }
    )
    wall = WorldRequest(obstacles=(ObstacleRequest(direction=(1.0, 0.0, 0.0), distance=0.4),))
    low, high = body.low[0], body.high[0]
    spans = {}
    for name, said in (("free", None), ("wall", wall)):
        x = estimate_sweep(fused(robot_path, body, throw, world="free", said=said), body)[:, 0]
        spans[name] = ((low - x.min()) / body.extent, (x.max() - high) / body.extent)
    room = spans["free"][0]  # around what does not move that way at all
    assert spans["free"][1] > room + 0.5
    assert spans["wall"] == pytest.approx((room + SWEEP, room + 0.4), abs=2e-3)


def test_the_clip_is_as_long_as_the_sentence_needs_unless_the_user_says(robot_path):
    reply = SemanticReply(force_field=ForceField(), frame_count=120)
    run = resolved(robot_path)
    assert run.with_reply(reply).preset.timing.frame_count == 120
    assert not run.frames_fixed and not make_brief(run.template).frames_fixed
    fixed = resolved(robot_path, overrides=dict(frame_count=20))
    assert fixed.with_reply(reply).preset.timing.frame_count == 20
    brief = make_brief(fixed.template, frames_fixed=fixed.frames_fixed)
    assert brief.frames_fixed and brief.size == fixed.template.source.extent
    assert make_brief(resolved(robot_path, world="ground").template).world == "ground"
    assert make_brief(resolved(robot_path, world="free").template).world == "free"


def test_a_long_clip_does_not_make_a_push_slower(robot_path, body):
    field = ForceField()
    template = resolved(robot_path, world="free").template
    for frame_count, duration in ((26, 1.0), (51, 2.0), (201, REFERENCE_TIME)):
        timing = template.preset.timing.model_copy(update=dict(frame_count=frame_count))
        preset = dataclasses.replace(template.preset, timing=timing)
        scaling = fuse(dataclasses.replace(template, preset=preset), body, field).scaling
        assert scaling.translation == pytest.approx(2 * TRAVEL * body.extent / duration**2)


@pytest.mark.parametrize(
    ("shape", "expected"),
    [("ball", True), ("cube", False), ("table", False), ("half a ball on its face", False)],
)
def test_what_is_round_below_rolls(shape, expected):
    x = np.random.default_rng(0).uniform(-1, 1, (40_000, 3))
    ball, half = (x**2).sum(1) < 1, (x**2).sum(1) < 1
    half &= x[:, 2] > 0
    legs = (x[:, 2] > 0.7) | (np.abs(x[:, :2]) > 0.8).all(1)
    x = x[{"ball": ball, "cube": slice(None), "table": legs, "half a ball on its face": half}[shape]]
    particles = SimpleNamespace(x=x, volume=np.ones(len(x)))
    assert rolls(SimpleNamespace(particles=particles, extent=2.0)) is expected
