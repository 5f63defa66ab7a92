"""Rounds that begin alike: which frames are provably shared, and that taking them over changes nothing."""

import importlib

import jax
import numpy as np
import pytest

from physagent_jax.agents.protocols import ExecutorAgent
from physagent_jax.agents.schema import Rewrite
from physagent_jax.agents.trace import Reply
from physagent_jax.forces.schema import (
    Action,
    ForceField,
    HalfSpaceRegion,
    SkillScaling,
    VelocityConstraint,
)
from physagent_jax.report.html import write_report
from physagent_jax.run.manifest import Manifest
from physagent_jax.run.resolve import resolve
from physagent_jax.scene import config as c
from physagent_jax.scene.body import make_body
from physagent_jax.scene.compile import compile_scene
from physagent_jax.scene.fuse import fuse
from physagent_jax.scene.materials import LIBRARY
from physagent_jax.simulation import simulate as driver
from physagent_jax.simulation.shared_frames import find_last_shared_frame, find_restart_frames, is_clock_right
from physagent_jax.simulation.simulate import find_shared_restart, simulate_scene
from tests.run.specs import made, small, with_rules
from tests.run.test_loop import ScriptedPlanner

UP = HalfSpaceRegion(point=(0.5, 0.5, 0.5), normal=(0, 0, 1))


def act(kind, first=None, last=None, magnitude=1.0, vector=(-1.0, 0.0, 0.0), **more):
    window = None if first is None else (first, last)
    return Action(action_type=kind, vector=vector, magnitude=magnitude, active_time=window, **more)


def hold(kind, first, last, magnitude=1.0):
    return VelocityConstraint(
        constraint_type=kind, vector=(0, 0, 1), magnitude=magnitude, active_time=(first, last)
    )


def field(*items, drop=False):
    actions = tuple(item for item in items if isinstance(item, Action))
    constraints = tuple(item for item in items if isinstance(item, VelocityConstraint))
    return ForceField(default_drop=drop, actions=actions, constraints=constraints)


def scene(*items, drop=False, **parts):
    return c.SceneConfig(source=c.Source(path="any.ply"), force_field=field(*items, drop=drop), **parts)


PUSH = act("translation", 0, 10)
ENFORCE, BLOW = "enforce_particle_translation", "particle_impulse"


@pytest.mark.parametrize(
    ("one", "other", "frame"),
    [
        ([PUSH], [PUSH], 49),
        ([act("translation")], [act("translation", 0, 49)], 49),  # None = the whole clip
        ([PUSH, act("impulse", 20, 21)], [PUSH, act("impulse", 20, 21, 1.5)], 19),
        ([PUSH], [PUSH, act("torque", 20, 30)], 19),
        ([PUSH], [PUSH, act("torque", 20.9, 30)], 19),
        ([PUSH, act("torque", 20, 30)], [PUSH, act("torque", 20, 30, region=UP)], 19),
        ([PUSH, act("torque", 20, 30)], [PUSH, act("torque", 24, 30)], 19),
        ([PUSH], [PUSH, hold(ENFORCE, 30, 40)], 29),
        ([PUSH, hold(ENFORCE, 30, 40)], [PUSH, hold(ENFORCE, 30, 45)], 39),
        ([PUSH], [act("translation", 0, 30)], 9),  # a push does not know when it will end
        ([act("torque", 5, 10)], [act("torque", 5, 30)], 9),
        ([act("translation", 0, 60)], [act("translation", 0, 80)], 49),  # both outlast the clip
        # A stretch grows with its window, and an impulse is spread over it.
        ([act("scale", 12, 20)], [act("scale", 12, 30)], 11),
        ([act("impulse", 12, 20)], [act("impulse", 12, 30)], 11),
        ([hold(BLOW, 12, 20)], [hold(BLOW, 12, 30)], 11),
        ([act("scale", 0, 60)], [act("scale", 0, 80)], 0),
        # What acts from the start leaves nothing to share but the rest pose.
        ([PUSH], [act("translation", 0, 10, 1.2)], 0),
        ([PUSH], [act("translation", 0, 10, vector=(0, 0, 1))], 0),
        ([PUSH], [], 0),
        ([PUSH], [act("translation", 1, 10)], 0),
        # Sums of three terms depend on their order.
        ([PUSH, act("torque", 0, 10)], [act("torque", 0, 10), PUSH], 0),
        ([PUSH, act("torque", 8, 10)], [act("torque", 8, 10), PUSH], 7),
    ],
)
def test_frames_shared_by_force_fields(one, other, frame):
    assert find_last_shared_frame(scene(*one), scene(*other)) == frame
    assert find_last_shared_frame(scene(*other), scene(*one)) == frame


SCALING = SkillScaling(translation=1, scale=1, impulse=1, torque=1, velocity=1)
LATE = c.Uniform(acceleration=(1, 0, 0), envelope={"kind": "constant", "start": 1.9})


@pytest.mark.parametrize(
    "parts",
    [
        dict(source=c.Source(path="other.ply")),
        dict(source=c.Source(path="any.ply", sha256="0" * 64)),
        dict(filling=c.Filling(seed=1)),
        dict(material=c.Material(youngs_modulus=3e5)),
        dict(domain=c.Domain(cells=64)),
        dict(timing=c.Timing(safety=0.5)),
        dict(timing=c.Timing(frame_count=51)),
        dict(transfer=c.Transfer(damping_rate=1.0)),
        dict(gravity=(0, 0, -1.6)),
        dict(boundaries=()),
        dict(constraints=(c.ParticleTranslation(point=(1, 1, 1), half_size=(1, 1, 1), velocity=(0, 0, 0)),)),
        dict(anchor=c.Anchor(kind="base")),
        dict(forces=(LATE,)),
        dict(scaling=SCALING),
        dict(ledger=True),
        dict(camera=c.CameraConfig(azimuth_degrees=30)),
        dict(rendering=c.Rendering(width=64)),
        dict(force_field=field(PUSH, drop=True)),
    ],
)
def test_nothing_is_shared_if_anything_else_differs(parts):
    one = scene(PUSH)
    assert find_last_shared_frame(one, one.model_copy(update=parts)) is None


def test_later_rounds_start_where_something_begins_ends_or_is_cut_short():
    config = scene(act("impulse", 5, 6), act("torque", 10, 30), act("scale", 30, 49))
    assert find_restart_frames(config) == (4, 5, 9, 17, 25, 29)
    assert find_restart_frames(scene(act("scale"))) == ()


def test_a_clock_that_ran_away_is_noticed():
    assert is_clock_right(0.4001, 10, 0.04) and not is_clock_right(0.42, 10, 0.04)


# --- played -------------------------------------------------------------------------------------------

FRAMES = 14
COARSE = dict(cells=48)  # half of the preset's, which takes twice as long
LEFT, RISE = act("translation", 0, 5, 1.4), (0.0, 0.0, 1.0)


def template_and_body(robot_path):
    spec = small(robot_path, "push it", frames=FRAMES, resolution=64)
    template = resolve(
        spec.model_copy(update=dict(overrides=spec.overrides.model_copy(update=COARSE)))
    ).template
    preset = template.preset
    return template, make_body(template.source, preset.filling, preset.domain, ".")


@pytest.fixture(scope="module")
def robot(robot_path):
    return template_and_body(robot_path)


def compiled(robot, *items, material=None, ledger=False):
    """With a ledger, each program takes four times as long to compile."""
    template, body = robot
    config = fuse(template, body, field(*items))
    camera = fuse(template, body, field(LEFT)).camera  # the loop keeps its first one too
    changes = dict(camera=camera, material=material or config.material, ledger=ledger)
    config = config.model_copy(update=changes)
    return compile_scene(config, body)


@pytest.fixture(scope="module")
def weaker(robot):
    """The first round of those whose blow becomes stronger, with a ledger."""
    return simulate_scene(compiled(robot, *BEFORE, ledger=True))


def assert_equal(resumed, full, exactly=False):
    """Everything that was recorded, to 1e-6 of its largest value."""
    tolerance = 0 if exactly else 1e-6
    for name in ("depth", "x", "F", "gaussians"):
        one, other = getattr(resumed, name), getattr(full, name)
        assert np.abs(one - other).max() <= tolerance * np.abs(other).max(), name
    assert np.abs(resumed.rgb.astype(int) - full.rgb).max() <= (0 if exactly else 1)
    records = [r.record.model_dump() for r in (resumed, full)]
    same(*records, tolerance)


def same(one, other, tolerance, name="record"):
    """Equal structures; series of numbers agree to ``tolerance`` of their largest."""
    assert type(one) is type(other), name
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for key in one:
            same(one[key], other[key], tolerance, f"{name}.{key}")
    elif isinstance(one, tuple) and one:
        one, other = np.asarray(one, float), np.asarray(other, float)
        assert one.shape == other.shape, name
        assert np.abs(one - other).max() <= tolerance * max(np.abs(other).max(), 1e-12), name
    else:
        assert one == other, name


WEAKER = act("impulse", 8, 9, 0.8, RISE)
BEFORE = LEFT, WEAKER
LATER = {
    "stronger blow": (WEAKER, act("impulse", 8, 9, 1.6, RISE)),
    "other program": (act("torque", 8, 12, 1.0, RISE), hold(ENFORCE, 8, 12)),
}


@pytest.mark.parametrize("case", LATER)
def test_a_resumed_rollout_equals_one_from_the_start(case, robot, weaker):
    ledger = LATER[case][0] is WEAKER  # the ledger's sums go on too
    before, after = (compiled(robot, LEFT, item, ledger=ledger) for item in LATER[case])
    first = weaker if ledger else simulate_scene(before)
    resumed, full = simulate_scene(after, restart_cache=first.restart_cache), simulate_scene(after)
    assert (resumed.reused_frames, full.reused_frames) == (8, 0)
    assert_equal(resumed, full)
    assert np.abs(full.x[-1] - first.x[-1]).max() > 0.01  # the two rounds do differ


def test_plastic_memory_and_a_grown_window_are_taken_over(robot):
    """Sand remembers, and a push over half a body length makes the window grow; a longer push shares its beginning."""
    sand = LIBRARY["dry_sand"].material.model_copy(update=dict(youngs_modulus=1e5))
    short, long = (compiled(robot, act("translation", 0, end, 1.6), material=sand) for end in (9, 13))
    first = simulate_scene(short)
    assert first.restart_cache.restarts[8].grid.shape != short.model.grid.shape
    resumed = simulate_scene(long, restart_cache=first.restart_cache)
    assert resumed.reused_frames == 9
    assert_equal(resumed, simulate_scene(long), exactly=True)  # the same program runs


def test_a_round_of_fewer_parts_goes_on_from_one_of_more(robot):
    push, turn = act("translation", 2, 8), act("torque", 3, 8)
    more = simulate_scene(compiled(robot, act("impulse", 9, 10), push, turn))
    fewer = compiled(robot, push, turn)
    assert max(more.restart_cache.restarts[8].acting.forces) >= len(fewer.model.forces)
    resumed = simulate_scene(fewer, restart_cache=more.restart_cache)
    assert resumed.reused_frames == 9
    assert_equal(resumed, simulate_scene(fewer))


def test_shared_frames_are_neither_simulated_nor_rendered_again(robot, monkeypatch):
    before, after = (compiled(robot, LEFT, item, ledger=True) for item in LATER["stronger blow"])
    calls = []
    frame = importlib.import_module("physagent_jax.mpm.frame")
    renderer = importlib.import_module("physagent_jax.render.renderer")
    for module, name in ((frame, "advance"), (renderer, "render")):
        counted(monkeypatch, calls, module, name)
    first = simulate_scene(before)
    assert (calls.count("advance"), calls.count("render")) == (FRAMES - 1, FRAMES)
    calls.clear()
    seen = []
    second = simulate_scene(
        after, progress=lambda done, total: seen.append(done), restart_cache=first.restart_cache
    )
    assert (calls.count("advance"), calls.count("render")) == (FRAMES - 8, FRAMES - 8)
    assert seen == list(range(8, FRAMES + 1))
    assert all(
        one is other for one, other in zip(first.restart_cache.outputs[:8], second.restart_cache.outputs)
    )  # no copies


def counted(monkeypatch, calls, module, name):
    function = getattr(module, name)

    def wrapped(*arguments, **options):
        calls.append(name)
        return function(*arguments, **options)

    monkeypatch.setattr(module, name, wrapped)


def test_only_states_that_memory_allows_are_kept(robot, weaker, monkeypatch):
    both, kept = compiled(robot, *BEFORE, ledger=True), weaker.restart_cache
    assert list(kept.restarts) == [4, 7, 8] and len(kept.outputs) == 9
    size = kept.outputs[0].nbytes * 8 + 2 * sum(
        leaf.nbytes for leaf in jax.tree.leaves(kept.restarts[4].state)
    )
    monkeypatch.setattr(driver, "RESTART_BYTES", size)
    assert list(simulate_scene(both).restart_cache.restarts) == [4, 7]
    monkeypatch.setattr(driver, "RESTART_BYTES", 0)
    empty = simulate_scene(both).restart_cache
    assert not empty.restarts and not empty.outputs
    assert simulate_scene(both, restart_cache=empty).reused_frames == 0


def test_another_body_shares_nothing(robot, weaker, robot_path):
    own = template_and_body(robot_path)
    one, other = (compiled(each, *BEFORE, ledger=True) for each in (robot, own))
    cache = weaker.restart_cache
    assert find_shared_restart(one, cache).index == 8
    assert find_shared_restart(other, cache) is None


# --- in the loop --------------------------------------------------------------------------------------


class LaterAndLater(ExecutorAgent):
    """Answers with an ever stronger blow at the end; may be told to stop the run instead."""

    def __init__(self, interrupt=False):
        self.interrupt = interrupt

    def rewrite(self, context, failed):
        if self.interrupt and context.rounds:
            raise KeyboardInterrupt
        blow = act("impulse", 8, 9, 0.5 + 0.2 * len(context.rounds), RISE)
        return Reply(Rewrite(force_field=field(LEFT, blow), changes=("scripted",)))


def run_loop(robot_path, out, scores, interrupt=False):
    spec = small(robot_path, "push the robot to the left", frames=FRAMES, resolution=64)
    return made(spec, out, with_rules(ScriptedPlanner(scores), LaterAndLater(interrupt)))


def reused(folder):
    manifest = Manifest.model_validate_json((folder / "manifest.json").read_bytes())
    return [manifest.reused_frames.get(f"iterations/{index}", 0) for index in range(manifest.iterations)]


def test_the_loop_takes_over_what_rounds_share_and_says_so(robot_path, tmp_path):
    store = run_loop(robot_path, tmp_path / "run", [0.1, 0.2, 0.3])
    assert reused(store.path) == [0, 0, 8]  # the sentence's own push lasts longer than the executor's
    page = write_report(store.path).read_text()
    assert page.count("frames 0 to 7 of the round before") == 2  # in the round's card and among the facts


def test_a_run_taken_up_again_plays_its_next_round_from_the_start(robot_path, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        run_loop(robot_path, tmp_path / "run", [0.1, 0.2], interrupt=True)
    store = run_loop(robot_path, tmp_path / "run", [0.3])
    assert store.manifest.complete and reused(store.path) == [0, 0, 0]
