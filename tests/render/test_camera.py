"""Cameras that show nothing are refused, where they are made."""

import math

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.render import look_at

USUAL = dict(eye=(0.0, -3.0, 0.5), target=(0.0, 0.0, 0.0), up=(0.0, 0.0, 1.0), fov_degrees=40.0)


@pytest.mark.parametrize(
    ("changes", "fragment"),
    [
        (dict(eye=(math.nan, 0.0, 0.0)), "`eye`"),
        (dict(target=(0.0, math.inf, 0.0)), "`target`"),
        (dict(eye=(1e30, 0.0, 0.0)), "`eye`"),
        (dict(up=(0.0, 0.0, 0.0)), "`up`"),
        (dict(up=(0.0, 3.0, -0.5)), "`up`"),
        (dict(eye=(0.0, 0.0, 0.0)), "coincide"),
        (dict(fov_degrees=0.0), "fov_degrees"),
        (dict(fov_degrees=180.0), "fov_degrees"),
        (dict(fov_degrees=math.nan), "fov_degrees"),
    ],
)
def test_cameras_without_a_picture(changes, fragment):
    with pytest.raises(UserError, match=fragment):
        look_at(**{**USUAL, **changes}, width=32, height=32)


def test_the_length_of_up_means_nothing():
    """Unit or not: an axis of a nanometre is an axis."""
    cameras = [look_at(**{**USUAL, "up": (0.0, 0.0, z)}, width=32, height=32) for z in (1.0, 1e-9, 1e9)]
    for camera in cameras[1:]:
        np.testing.assert_allclose(camera.viewmat, cameras[0].viewmat, atol=1e-12)
