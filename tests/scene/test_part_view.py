"""The camera that sees a part move: across the line of sight, before nothing else, with left still on the left."""

import numpy as np
import pytest

from physagent_jax.scene.camera import find_viewer_directions
from physagent_jax.scene.config import CameraConfig
from physagent_jax.scene.part_view import PartMotion, turn_to_parts

BODY = ((0, 0, 0.3), (0.25, 0.25, 0.3))
PARTS = {"head": ((0, 0, 0.75), (0.12, 0.12, 0.15)), "tail": ((0, 0.5, 0.3), (0.04, 0.25, 0.04))}


def fill(box, count):
    centre, half = map(np.array, box)
    return centre + half * np.random.default_rng(0).uniform(-1, 1, (count, 3))


def look(part, way, *, joint, turns=False, azimuth=0.0):
    """The azimuth from which a part of a box is looked at, whose camera stood in front [degrees]."""
    own, body = fill(PARTS[part], 600), fill(BODY, 3000)
    mask = np.arange(len(own) + len(body)) < len(own)
    motion = PartMotion(mask, np.array(joint, float), np.array(way, float), turns)
    camera = CameraConfig(azimuth_degrees=azimuth)
    return turn_to_parts(camera, np.concatenate([own, body]), [motion]).azimuth_degrees - azimuth


@pytest.mark.parametrize("azimuth", [0.0, 130.0])
def test_a_nod_towards_the_viewer_is_seen_from_aside(azimuth):
    toward = find_viewer_directions(CameraConfig(azimuth_degrees=azimuth))["toward"]
    assert 45 <= abs(look("head", toward, joint=(0, 0, 0.6), azimuth=azimuth)) < 90


def test_a_tilt_to_the_side_is_seen_from_where_the_camera_stands():
    assert look("head", (1, 0, 0), joint=(0, 0, 0.6)) == 0


def test_what_is_behind_the_rest_is_seen_from_aside():
    """A tail at the back that goes up, or that wags: the body hides it from the front."""
    assert abs(look("tail", (0, 0, 1), joint=(0, 0.25, 0.3))) >= 30
    assert abs(look("tail", (1, 0, 0), joint=(0, 0.25, 0.3))) >= 30
    assert abs(look("tail", (1, 0, 0), joint=(0, 0.25, 0.3), turns=True)) >= 30


@pytest.mark.parametrize("way", [(0.6, -0.8, 0), (-0.6, -0.8, 0)])
def test_left_and_right_stay_what_they_are(way):
    turned = CameraConfig(azimuth_degrees=look("head", way, joint=(0, 0, 0.6)))
    assert way[0] * np.dot(way, find_viewer_directions(turned)["right"]) > 0.5


def test_a_camera_stays_where_nothing_moves():
    assert turn_to_parts(CameraConfig(), fill(BODY, 100), []) == CameraConfig()
