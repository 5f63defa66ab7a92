"""Parts of the object that are pointed at, followed by themselves."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physagent_jax.perception.backends.flow import FlowTracker
from physagent_jax.perception.ends import DIRECTIONS, Ends, PartPrompt
from physagent_jax.perception.follow import follow
from tests.perception import scenes

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


@pytest.mark.parametrize(
    ("length", "degrees", "swings", "until"),
    [(0.25, 80, 0.5, 0.3), (0.15, 60, 2, 1.0), (0.25, 60, 0.5, 0.25)],
)
def test_a_small_part_that_turns_fast_is_not_lost(length, degrees, swings, until):
    """A tail that swings by a quarter of a right angle per frame, at a body that does not move."""
    body = scenes.blob(axes=(0.3, 0.2, 0.3), count=20_000).surface
    half, joint = 0.03, np.array([0.28, 0, 0])
    ends = (0.25, -half, -half), (0.3 + length, half, half)
    surface = np.concatenate([body, np.random.default_rng(0).uniform(*ends, (8000, 3))])
    tail = np.arange(len(surface)) >= len(body)

    def swing(points, phase):
        angle = np.radians(degrees) * np.sin(2 * np.pi * swings * min(phase / until, 1.0))
        turned = joint + Rotation.from_rotvec((0, angle, 0)).apply(points - joint)
        return np.where(tail[:, None], turned, points)

    shape = scenes.Shape(surface, scenes.texture(surface, 3), surface)
    clip = scenes.film(shape, swing, scenes.camera(size=160))
    prompt = PartPrompt(0, surface[tail][::20], surface[~tail][::40])
    tracker = FlowTracker().encode(clip.rgb, np.isfinite(clip.depth))
    path = follow(clip.rgb, clip.depth, clip.camera, tracker, (prompt,))
    seen = path.ends.describe(1.0)[-1].centroid
    assert all(place is not None for place in seen)
    truth = clip.particles[:, tail].mean(1) - clip.particles[0, tail].mean(0)
    np.testing.assert_allclose(np.array(seen)[:, 2], truth[:, 2], atol=0.045)
