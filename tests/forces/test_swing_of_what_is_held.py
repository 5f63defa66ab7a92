"""Pushes to and fro of what is held, against an oscillator that SciPy integrates."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.scaling import make_closed_form_scaling
from physagent_jax.forces.schema import ForceField, Holding
from physagent_jax.forces.swinging import find_strokes

DT, FRAMES, RATIO, SWING = 0.04, 15, 0.1, 0.1


def spread(value):
    return tuple(map(tuple, (value * np.eye(3)).tolist()))


@pytest.mark.parametrize("phase", [0.85, 1.0, 1.3, 2.0])
def test_each_push_swings_an_oscillator_as_far_to_its_side(phase):
    """A push lasts so many half periods: those in time with it (1) would swing it farther each time."""
    frequency = phase * np.pi / (FRAMES * DT)
    way = 1 / frequency**2
    held = Holding(
        compliance=spread(way),
        square=spread(way**2),
        damping_ratio=RATIO,
        shift=SWING,
        least=1e-4,
        most=1e6,
    )
    scaling = make_closed_form_scaling(
        extent=1.0, youngs_modulus=2e5, density=300.0, duration=2.0, holding=held
    ).model_copy(update=dict(swing=SWING))
    pushes = [
        dict(
            action_type="translation",
            vector=[(-1) ** i, 0, 0],
            magnitude=1.0,
            active_time=[i * FRAMES, (i + 1) * FRAMES],
        )
        for i in range(5)
    ]
    field = ForceField.model_validate({"actions": pushes})
    values = ForceFieldParameters.of(field, 5 * FRAMES + 1).actions
    strokes = find_strokes(field, values, scaling, DT)
    state, peaks = np.zeros(2), []
    for index in range(5):
        push = (-1) ** index * float(strokes[index].k)

        def move(time, y, push=push):
            return [y[1], push - 2 * RATIO * frequency * y[1] - frequency**2 * y[0]]

        path = solve_ivp(move, (0, FRAMES * DT), state, max_step=DT / 4, rtol=1e-8).y
        peaks.append(((-1) ** index * path[0]).max())
        state = path[:, -1]
    assert np.array(peaks) == pytest.approx(SWING, rel=0.05)


@pytest.mark.parametrize("phase", [0.1, 0.3])
def test_quick_pushes_turn_an_oscillator_back(phase):
    """As long to either side each, they would drive a slow one ever farther to one side, without a way back."""
    frequency = phase * np.pi / (FRAMES * DT)
    held = Holding(
        compliance=spread(1 / frequency**2),
        square=spread(1 / frequency**4),
        damping_ratio=RATIO,
        shift=SWING,
        least=1e-4,
        most=1e6,
    )
    free = make_closed_form_scaling(extent=1.0, youngs_modulus=2e5, density=300.0, duration=2.0, holding=held)
    scaling = free.model_copy(update=dict(swing=SWING))
    windows = [(i * FRAMES, (i + 1) * FRAMES) for i in range(6)]
    actions = [
        dict(action_type="translation", vector=[(-1) ** i, 0, 0], magnitude=1.0, active_time=list(window))
        for i, window in enumerate(windows)
    ]
    field = ForceField.model_validate({"actions": actions})
    values = ForceFieldParameters.of(field, 6 * FRAMES + 1).actions
    strokes = find_strokes(field, values, scaling, DT)
    state, places, speeds = np.zeros(2), [0.0], []
    for index in range(6):
        push = (-1) ** index * float(strokes[index].k)

        def move(time, y, push=push):
            return [y[1], push - 2 * RATIO * frequency * y[1] - frequency**2 * y[0]]

        path = solve_ivp(move, (0, FRAMES * DT), state, max_step=DT / 4, rtol=1e-8).y
        places, speeds = [*places, *path[0]], [*speeds, *path[1]]
        state = path[:, -1]
    assert np.ptp(places) == pytest.approx(2 * SWING, rel=0.05)
    turns = np.flatnonzero(np.diff(np.sign(speeds)))
    assert np.abs(np.diff(np.array(places)[turns[:5]])).min() > 0.5 * SWING
