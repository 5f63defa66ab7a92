"""Objects that stand and sway: the foot stays, the top goes to either side, and ends where it was."""

import numpy as np
import pytest
import trimesh

from physagent_jax.forces.schema import ForceField
from physagent_jax.motion.schema import DirectionTable, SceneBrief
from physagent_jax.motion.swaying import FOOT, sway
from physagent_jax.simulation.simulate import simulate_frames
from tests.agents.scenes import brief, read
from tests.scene.test_equilibrium import scene_of

STANDING = dict(world="ground", may_be_held=True)
LAST = 24


@pytest.mark.parametrize("sentence", ["the robot sways", "the robot wobbles", "the robot rocks to and fro"])
def test_what_sways_where_it_stands_keeps_its_foot(sentence):
    reply = read(sentence, brief(**STANDING))
    assert reply.anchor.kind == "rest" and reply.anchor.region == FOOT
    assert not reply.force_field.actions and reply.force_field.constraints


@pytest.mark.parametrize(
    "sentence", ["shake the robot", "the robot bobs up and down", "the robot is tossed to and fro"]
)
def test_what_is_shaken_goes_as_a_whole(sentence):
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
