"""Motions taken apart and added up, against rotations and displacements in closed form."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from baselines.superposition import Base

REST = np.random.default_rng(3).uniform(0.0, 1.0, (40, 3))
MASS = np.random.default_rng(4).uniform(0.5, 1.5, 40)
CENTRE = MASS @ REST / MASS.sum()
TIMES = np.linspace(0.0, 1.0, 5)
STILL = np.repeat(REST[None], 5, axis=0)


def turn(axis, angle):
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    turned = [Rotation.from_rotvec(angle * t * axis).apply(REST - CENTRE) + CENTRE for t in TIMES]
    return np.stack(turned)


@pytest.mark.parametrize("axis", [(0, 0, 1), (0.6, 0, 0.8)])
def test_three_times_a_turn_is_a_turn_by_three_times_the_angle(axis):
    """Added as displacements, the body would be 12 % longer at 0.5 rad and half as long again at 1.2."""
    base = Base.of(STILL, MASS)
    added = base.compare(turn(axis, 0.4), MASS)
    np.testing.assert_allclose(base.add(3.0 * added), turn(axis, 1.2), atol=2e-5)


def test_what_is_taken_apart_is_put_together_again_on_any_motion():
    """A shear, a push and more than half a turn, with nothing added; and the way from rest to another motion."""
    shear = TIMES[:, None, None] * 0.3 * (STILL[..., :1] * np.array([0.0, 1.0, 0.0]))
    x = turn((0, 1, 0), 4.0) + shear + TIMES[:, None, None] ** 2 * np.array([0.5, 0.0, -0.2])
    base = Base.of(x, MASS)
    np.testing.assert_allclose(base.add(np.zeros((5, 42, 3), np.float32)), x, atol=2e-5)
    other = turn((0, 0, 1), 1.0) + shear
    still = Base.of(STILL, MASS)
    np.testing.assert_allclose(still.add(still.compare(other, MASS)), other, atol=2e-5)


def test_a_stretch_and_a_turn_by_themselves_make_the_stretched_body_turned():
    stretch = 1.0 + 0.2 * TIMES[:, None, None] * np.array([1.0, 0.0, 0.0])
    stretched = (STILL - CENTRE) * stretch + CENTRE
    base = Base.of(STILL, MASS)
    both = base.add(base.compare(stretched, MASS) + base.compare(turn((0, 0, 1), 1.0), MASS))
    wanted = [
        Rotation.from_rotvec([0, 0, t]).apply(frame - CENTRE) + CENTRE for t, frame in zip(TIMES, stretched)
    ]
    np.testing.assert_allclose(
        both, wanted, atol=2e-2
    )  # the turned body's best affine map has the turn alone
    np.testing.assert_allclose(base.add(base.compare(stretched, MASS)), stretched, atol=2e-5)
