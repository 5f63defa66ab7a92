"""Turns through views in which nothing can be followed."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physagent_jax.perception.bridging import bridge
from physagent_jax.perception.fit import Affine


def make_chains(*steps, begins=(0, 14), lost=3):
    """Poses of chains that turn about the vertical by so many degrees a frame, with a gap before each."""
    poses, chain = [None] * 26, np.full(26, -1)
    for number, (begin, end, step) in enumerate(zip(begins, (*begins[1:], 26 + lost), steps)):
        for t in range(begin, end - lost):
            turn = Rotation.from_rotvec([0, 0, np.radians(step * (t - begin))]).as_matrix()
            poses[t], chain[t] = Affine(turn, np.zeros(3), turn), number
    return poses, chain


def measure(found, t):
    return (
        None
        if found.rotations[t] is None
        else np.degrees(Rotation.from_matrix(found.rotations[t]).magnitude())
    )


def test_what_turns_alike_before_and_after_has_turned_on():
    found = bridge(*make_chains(6.0, 7.0))
    assert measure(found, 10) == pytest.approx(60)
    assert found.rotations[12] is None
    assert measure(found, 14) == pytest.approx(60 + 4 * 6.5)
    assert measure(found, 25) == pytest.approx(60 + 4 * 6.5 + 11 * 7)
    assert np.degrees(found.guessed) == pytest.approx(26)


@pytest.mark.parametrize("steps", [(6.0, -6.0), (6.0, 0.0), (0.0, 0.0), (6.0, 20.0), (40.0, 40.0)])
def test_what_turns_otherwise_afterwards_or_too_far_is_not_known(steps):
    found = bridge(*make_chains(*steps))
    assert measure(found, 10) is not None
    assert found.rotations[14] is None and found.guessed == 0


def test_the_last_points_before_a_gap_may_be_followed_wrongly():
    poses, chain = make_chains(6.0, 6.0)
    poses[10] = poses[9]
    assert measure(bridge(poses, chain), 20) == pytest.approx(120)
