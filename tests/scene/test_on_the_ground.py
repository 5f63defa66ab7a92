"""Pushes, blows and spins over the ground go as far as M says, and friction ends them."""

import numpy as np
import pytest
import trimesh

from physagent_jax.forces.calibration import FRICTION, GRAVITY
from physagent_jax.forces.schema import ForceField
from physagent_jax.simulation.simulate import simulate_frames
from tests.scene.test_equilibrium import scene_of

FRAMES = 51  # two seconds


@pytest.fixture(scope="module")
def block(tmp_path_factory):
    path = tmp_path_factory.mktemp("block") / "block.obj"
    trimesh.creation.box((1.0, 0.7, 0.6)).export(path)
    return path


def simulate(path, *, youngs_modulus, frames=FRAMES, cells=48, particles=2500, actions=()):
    scene, _ = scene_of(
        path,
        frames=frames,
        cells=cells,
        particles=particles,
        field=ForceField.model_validate(dict(actions=actions)),
        material={"youngs_modulus": youngs_modulus, "density": 500.0},
    )
    rest = np.asarray(scene.state.x)
    return rest, [np.asarray(frame.state.x) for frame in simulate_frames(scene)]


def push(magnitude, kind="translation", vector=(-1.0, 0.0, 0.0), **parts):
    return [dict(action_type=kind, vector=vector, magnitude=magnitude, **parts)]


@pytest.mark.parametrize("youngs_modulus", [3e4, 3e5])
def test_a_push_moves_what_is_soft_and_what_is_stiff_as_far_as_it_says(block, youngs_modulus):
    rest, frames = simulate(block, youngs_modulus=youngs_modulus, actions=push(0.6))
    path = np.array([x.mean(0) - rest.mean(0) for x in frames])
    assert path[-1, 0] == pytest.approx(-0.6, rel=0.15)
    assert np.abs(path[:, 1:]).max() < 0.03
    assert np.all(np.diff(path[5:, 0]) < 0)  # on its way all the time


def test_friction_stops_it_when_the_push_ends(block):
    rest, frames = simulate(block, youngs_modulus=1e5, actions=push(1.0, active_time=(0, 25)))
    way = np.array([x[:, 0].mean() - rest[:, 0].mean() for x in frames])
    speed = way[25] - way[24]  # [m per frame]
    stopping = (speed / 0.04) ** 2 / (2 * FRICTION * GRAVITY)
    assert way[25] == pytest.approx(-0.25, rel=0.2)
    assert way[-1] == pytest.approx(way[25] - stopping, abs=0.03)
    assert abs(way[-1] - way[-11]) < 0.02  # it rocks a little on its foot, but stays


def test_a_spin_turns_as_far_as_it_says(block):
    rest, frames = simulate(block, youngs_modulus=1e5, actions=push(1.0, "torque", (0.0, 0.0, 1.0)))
    flat = rest[:, :2] - rest[:, :2].mean(0)
    last = frames[-1][:, :2] - frames[-1][:, :2].mean(0)
    covariance = flat.T @ last
    turned = np.degrees(np.arctan2(covariance[0, 1] - covariance[1, 0], np.trace(covariance)))
    assert turned == pytest.approx(90, rel=0.2)
