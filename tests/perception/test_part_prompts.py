"""Parts of the object that are pointed at, followed by themselves."""

import numpy as np
from scipy.spatial.transform import Rotation

from physagent_jax.perception.ends import DIRECTIONS, Ends, PartPrompt

ARM, BODY = np.array([[0.5, 0, 0.1], [0.7, 0, 0.1]]), np.array([[0.1, 0, 0], [0, 0, 0.4], [0, 0, -0.4]])


def make_surface():
    """A body of 300 points and an arm of 60 that sticks out at its right."""
    chance = np.random.default_rng(0)
    body = chance.uniform((-0.2, -0.1, -0.5), (0.2, 0.1, 0.5), (300, 3))
    arm = chance.uniform((0.45, -0.05, 0.05), (0.75, 0.05, 0.15), (60, 3))
    return np.concatenate([body, arm]), np.arange(360) >= 300


def test_a_part_that_is_pointed_at_is_followed_by_itself():
    surface, on_arm = make_surface()
    ends = Ends.split(surface, 2, (PartPrompt(4, ARM, BODY),))
    ends.start_link(0, surface)
    turn, joint = Rotation.from_rotvec((0, -0.5, 0)), np.array([0.2, 0, 0.1])
    after = np.where(on_arm[:, None], joint + turn.apply(surface - joint), surface)
    ends.fit(1, surface, after, np.ones(360), np.ones(360, bool))
    *six, part = ends.describe(2.0)
    assert len(six) == len(DIRECTIONS) and all(end.limb is None for end in six)
    assert part.limb == 4 and part.direction[0] > 0.9
    moved = (after - surface)[on_arm].mean(0) / 2.0
    np.testing.assert_allclose(part.centroid[1], moved, atol=5e-3)
    np.testing.assert_allclose(part.rotation[1], (0, np.degrees(-0.5), 0), atol=1.0)


def test_a_part_that_nobody_sees_is_left_out():
    surface, on_arm = make_surface()
    ends = Ends.split(surface[~on_arm], 2, (PartPrompt(4, ARM, BODY),))
    assert len(ends.describe(1.0)) == len(DIRECTIONS)


def test_ends_are_those_of_the_rest():
    """A part of most of the surface is not its own other end: a shade beside the slim pole that bears it."""
    chance = np.random.default_rng(0)
    shade = chance.uniform((-0.2, -0.2, 0.3), (0.2, 0.2, 0.6), (300, 3))
    pole = chance.uniform((-0.02, -0.02, -0.6), (0.02, 0.02, 0.3), (60, 3))
    surface, on_shade = np.concatenate([shade, pole]), np.arange(360) < 300
    ends = Ends.split(surface, 2, (PartPrompt(1, shade[::9], pole),))
    ends.start_link(0, surface)
    turn, joint = Rotation.from_rotvec((0, 0.6, 0)), np.array([0.0, 0, 0.3])
    after = np.where(on_shade[:, None], joint + turn.apply(surface - joint), surface)
    ends.fit(1, surface, after, np.ones(360), np.ones(360, bool))
    *six, part = ends.describe(1.0)
    assert np.linalg.norm(part.centroid[1]) > 0.05
    for end in six:
        assert end.centroid[1] is None or np.linalg.norm(end.centroid[1]) < 0.02
