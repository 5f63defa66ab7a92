"""Pictures from cameras that are placed after the simulation."""

import dataclasses

import numpy as np
import pytest

import physagent_jax as pa
from physagent_jax.scene.camera import make_reference_camera, shows_points
from physagent_jax.simulation.views import reframe
from tests.conftest import ROBOT


@pytest.fixture(scope="module")
def recording():
    loaded = pa.load_object(ROBOT, max_particles=1200, cells=48)
    scene = pa.build_scene(loaded, "push the robot hard to the left", frame_count=8, width=64, height=64)
    return pa.simulate_scene(scene)


def move_camera(recording, distance):
    """The recording as if its camera had been placed so near, or so far."""
    config = recording.scene.config
    camera = config.camera.model_copy(update=dict(distance=distance))
    config = config.model_copy(update=dict(camera=camera))
    placed = make_reference_camera(camera, config.rendering, config.domain)
    return dataclasses.replace(
        recording, scene=dataclasses.replace(recording.scene, config=config, camera=placed)
    )


def test_what_its_camera_shows_stays(recording):
    far = move_camera(recording, 3 * recording.scene.config.camera.distance)
    assert reframe(far) is far


def test_what_left_the_picture_is_drawn_again_from_where_it_is_seen(recording):
    near = move_camera(recording, 0.3 * recording.scene.config.camera.distance)
    framed = reframe(near)
    config = framed.scene.config
    points = recording.gaussians.reshape(-1, 3).astype(float)
    assert (
        np.mean([shows_points(each[None], config.camera, config.rendering) for each in points[::97]]) > 0.98
    )
    assert config.camera.azimuth_degrees == near.scene.config.camera.azimuth_degrees
    assert framed.rgb.shape == near.rgb.shape and framed.depth.shape == near.depth.shape
    ground = (framed.depth > 0).any((1, 2))
    assert (
        ground.all() and not (framed.depth[:, [0, -1]] > 0).any()
    )  # nothing touches the upper and lower edge
    np.testing.assert_array_equal(framed.rgb, pa.render_recording(framed))
