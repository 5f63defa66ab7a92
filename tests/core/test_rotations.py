"""Rotations against scipy's polar decomposition and against angles that are known."""

import numpy as np
import pytest
import scipy.linalg
from scipy.spatial.transform import Rotation

from physagent_jax.core.rotations import find_rotation, polar, unwrap


@pytest.mark.parametrize("seed", range(5))
def test_the_polar_decomposition_is_that_of_scipy(seed):
    matrix = np.random.default_rng(seed).normal(size=(3, 3))
    matrix *= np.sign(np.linalg.det(matrix))
    rotation, stretch = polar(matrix)
    expected = scipy.linalg.polar(matrix)
    np.testing.assert_allclose(rotation, expected[0], atol=1e-12)
    np.testing.assert_allclose(stretch, expected[1], atol=1e-12)
    np.testing.assert_array_equal(find_rotation(matrix), rotation)


def test_a_mirrored_matrix_still_gives_a_rotation():
    matrix = np.diag([3.0, 2.0, -1.0])
    rotation, stretch = polar(matrix)
    assert np.linalg.det(rotation) == pytest.approx(1)
    np.testing.assert_allclose(rotation @ stretch, matrix, atol=1e-12)


def test_an_angle_grows_beyond_half_a_turn_across_frames_without_a_rotation():
    angles = [0.0, 100.0, None, 200.0, 300.0, 400.0]
    turns = [None if a is None else Rotation.from_rotvec([0, 0, np.radians(a)]).as_matrix() for a in angles]
    found = unwrap(turns)
    assert found[2] is None
    degrees = [np.degrees(v[2]) for v in found if v is not None]
    np.testing.assert_allclose(degrees, [0, 100, 200, 300, 400], atol=1e-9)
    assert unwrap([None, None]) == [None, None]


def test_a_small_lean_does_not_change_the_axis_of_whole_turns():
    lean = Rotation.from_euler("x", 6, degrees=True)
    turns = [(Rotation.from_rotvec([0, 0, np.radians(a)]), a) for a in range(0, 721, 10)]
    found = unwrap([(turn * lean if a > 180 else turn).as_matrix() for turn, a in turns])
    degrees = np.degrees(np.array(found))
    np.testing.assert_allclose(degrees[:, 2], [a for _, a in turns], atol=2)
    assert np.linalg.norm(degrees[-1, :2]) < np.tan(np.radians(6)) * 720


def test_what_falls_over_after_a_whole_turn_leans_by_its_own_vector():
    spin = [Rotation.from_rotvec([0, 0, np.radians(a)]) for a in range(0, 361, 20)]
    fall = [Rotation.from_rotvec([np.radians(a), 0, 0]) for a in range(10, 91, 10)]
    found = unwrap([each.as_matrix() for each in (*spin, *fall)])
    np.testing.assert_allclose(np.degrees(found[-1]), [90, 0, 0], atol=1e-6)
