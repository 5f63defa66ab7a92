"""The time that a run still takes, against hand-made clocks."""

import pytest

from physagent_jax.run.forecast import BRIEF, CLOSING, FIRST, PATIENCE, Forecast, find_most_substeps
from physagent_jax.scene.cost import Cost


class Clock:
    def __init__(self):
        self.time = 100.0

    def __call__(self) -> float:
        return self.time


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def forecast(clock):
    """Three rounds of 20 s of simulation, after which pictures take 5 s."""
    return Forecast(Cost(1000.0, 25.0, 1e9, ("", ""), watching=5.0), 3, clock)


def test_before_the_first_frame_the_estimated_cost_counts_down(forecast, clock):
    clip, run = forecast.find_left()
    assert clip == 25.0 and run == pytest.approx(3 * 25.0 + CLOSING)
    clock.time += 8.0
    assert forecast.find_left() == (pytest.approx(17.0), pytest.approx(67.0 + CLOSING))


def test_frames_tell_the_pace_of_a_slower_machine(forecast, clock):
    forecast.count_frame(1, 11)
    clock.time += 8.0
    forecast.count_frame(3, 11)  # 4 s a frame: 32 s are left
    assert forecast.find_left()[0] == pytest.approx(32.0 + 5.0)
    clock.time += 2.0
    assert forecast.find_left()[0] == pytest.approx(30.0 + 5.0)


def test_frames_taken_over_from_the_round_before_are_no_measure(forecast, clock):
    forecast.count_frame(6, 11)
    clock.time += 3.0
    forecast.count_frame(9, 11)
    assert forecast.find_left()[0] == pytest.approx(2.0 + 5.0)


def test_later_rounds_take_what_the_first_took(forecast, clock):
    forecast.count_frame(0, 10)
    clock.time += 40.0
    forecast.count_frame(10, 10)
    forecast.end_simulation()
    clock.time += 6.0
    forecast.show_clip()
    assert forecast.find_left()[0] == 0
    clock.time += 3.0
    forecast.end_round()
    forecast.begin_round(1)
    assert forecast.find_left() == (pytest.approx(46.0), pytest.approx(2 * 49.0 + CLOSING))


def test_nothing_is_ever_less_than_over(forecast, clock):
    clock.time += 1000.0
    assert forecast.find_left()[0] == 5.0  # the pictures are still to come
    forecast.end_simulation()
    clock.time += 1000.0
    assert forecast.find_left()[0] == 0


def test_a_further_round_takes_no_more_steps_than_are_worth_waiting_for():
    """A while if it is quick, else some times what it takes at rest."""
    quick, slow = (Cost(steps, steps * 0.01 + 5.0, 1e9, ("", ""), watching=5.0) for steps in (100.0, 5000.0))
    assert find_most_substeps(quick) == pytest.approx(BRIEF / 0.01)
    assert find_most_substeps(slow) == pytest.approx(PATIENCE * 5000.0)


def test_the_first_round_may_take_longer_and_not_for_ever(forecast):
    """Without it there is no clip; a user who says so waits longer."""
    cost = Cost(1000.0, 25.0, 1e9, ("", ""), watching=5.0)
    further = find_most_substeps(cost)
    assert forecast.most_substeps == pytest.approx(FIRST * further)
    assert Forecast(cost, 3, patience=2.0).most_substeps == pytest.approx(2 * FIRST * further)
    forecast.begin_round(1)
    assert forecast.most_substeps == pytest.approx(further)


def test_what_is_idle_takes_few_steps_and_is_forecast_so(forecast, clock):
    forecast.begin_round(0, 100.0)
    assert forecast.find_left()[0] == pytest.approx(2.0 + 5.0)
