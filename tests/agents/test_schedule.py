"""The length of each push of a sway, against an oscillator's response."""

import math

import numpy as np
import pytest

from physagent_jax.core.turning import find_turning_points
from physagent_jax.motion.windows import divide, divide_swings

FRAME_DT, LAST = 0.04, 49.0
DRAG = 1.2  # [1/s]


def swing(pushes, frequency):
    """Place per frame of a mass on a spring with drag, from rest, under pushes of 1 to and fro: piecewise exact."""
    decay, beat = DRAG / 2, math.sqrt(frequency**2 - DRAG**2 / 4)
    times = np.arange(int(LAST) + 1) * FRAME_DT
    path, place, speed = np.zeros(len(times)), 0.0, 0.0
    for index, (first, last) in enumerate(pushes):
        rest = (-1) ** index / frequency**2  # where this push would hold it

        def state(t, begin=first * FRAME_DT, rest=rest, offset=place - rest, speed=speed):
            s = np.asarray(t) - begin
            b = (speed + decay * offset) / beat
            fade, c, n = np.exp(-decay * s), np.cos(beat * s), np.sin(beat * s)
            here = rest + fade * (offset * c + b * n)
            return here, fade * ((b * beat - decay * offset) * c - (offset * beat + decay * b) * n)

        inside = (times >= first * FRAME_DT) & (times <= last * FRAME_DT)
        path[inside] = state(times[inside])[0]
        place, speed = (float(value) for value in state(last * FRAME_DT))
    return path


def count_turns(path):
    """With the planner's hysteresis."""
    return len(find_turning_points(list(path), 0.35 * (path.max() - path.min())))


@pytest.mark.parametrize("frequency", [3.0, 5.0])
def test_what_is_shaken_faster_than_it_swings_turns_as_often_as_it_is_pushed(frequency):
    """Four times is seven turns; by whole pushes from the start, the first swing dwarfs the others."""
    window = (0.0, LAST)
    assert count_turns(swing(divide_swings(window, 4, True), frequency)) == 7
    assert count_turns(swing(divide(window, [1.0] * 8), frequency)) <= 3


@pytest.mark.parametrize("held", [True, False])
def test_pushes_follow_each_other_through_the_window(held):
    for count in (1, 2, 4, 6):
        pushes = divide_swings((2.0, 50.0), count, held)
        assert pushes[0][0] == 2.0 and pushes[-1][1] == pytest.approx(50.0)
        assert all(a[1] == b[0] for a, b in zip(pushes, pushes[1:]))
        assert len(pushes) == 2 * count + (not held or count >= 4)
