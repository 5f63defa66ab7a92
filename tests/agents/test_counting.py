"""The confidence of counts and times, against noise that is known."""

import math
import random

import pytest

from physagent_jax.core.turning import find_turning_points
from physagent_jax.motion.judging.counting import (
    estimate_crossing,
    estimate_jitter,
    find_count_confidence,
)


def swing(noise=0.0, amplitude=0.2, frames=60, periods=3, seed=0):
    draw = random.Random(seed).gauss
    return [amplitude * math.sin(2 * math.pi * periods * t / frames) + draw(0, noise) for t in range(frames)]


@pytest.mark.parametrize("noise", [0.001, 0.02])
def test_jitter_is_the_noise_and_not_the_swing(noise):
    found = [estimate_jitter(swing(noise, seed=seed)) for seed in range(20)]
    assert sum(found) / 20 == pytest.approx(noise, rel=0.2)
    assert estimate_jitter(swing()) < 0.005 * 0.2


def sureness(path, wanted=(5, 7)):
    threshold = 0.35 * (max(path) - min(path))
    return find_count_confidence(
        lambda limit: len(find_turning_points(path, limit)),
        lambda seen: wanted[0] <= seen <= wanted[1],
        threshold,
        max(path) - min(path),
        math.sqrt(2) * estimate_jitter(path),
    )


def test_a_count_is_as_sure_as_its_swings_stand_out():
    clear, noisy, drowned = (sureness(swing(noise)) for noise in (0.002, 0.03, 0.15))
    assert clear > 0.99 > noisy > drowned > 0.5


def test_a_swing_that_hardly_counts_is_unsure():
    """The third one is just above the threshold: with a little noise it might not be."""
    heights = [0, 1, 0, 1, 0.64, 1, 0]
    path = [a + (b - a) * k / 6 for a, b in zip(heights, heights[1:]) for k in range(6)]
    noise = 0.03
    unsure = find_count_confidence(
        lambda limit: len(find_turning_points(path, limit)), lambda seen: seen == 5, 0.35, 1.0, noise
    )
    sure = find_count_confidence(
        lambda limit: len(find_turning_points(path, limit)), lambda seen: 3 <= seen <= 5, 0.35, 1.0, noise
    )
    assert unsure < 0.8 and sure > 0.99


def test_a_crossing_is_as_sure_as_it_is_steep():
    steep, flat = ([(t, slope * t) for t in range(20)] for slope in (0.1, 0.01))
    assert estimate_crossing(steep, 10, 0.0) == pytest.approx(1 / math.sqrt(12))
    assert estimate_crossing(steep, 10, 0.1) == pytest.approx(math.hypot(1.0, 1 / math.sqrt(12)))
    assert estimate_crossing(flat, 10, 0.1) == pytest.approx(10, rel=0.01)
