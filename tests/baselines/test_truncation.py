"""Derivatives that go back only so far, against the closed form of a body that is pushed as a whole.

Under an acceleration k u that acts on all of it, N semi-implicit steps move a body by k u dt^2 N (N + 1) / 2. With the
state before the last M steps given, what is left of the derivative is that of M steps.
"""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import physagent_jax as pa
from baselines.simulation import Simulation
from baselines.truncation import WHOLE, Truncation, replay_truncated
from physagent_jax.core.errors import UserError


@pytest.fixture(scope="module")
def pushed(tiny):
    """A rollout of the start, and its numbers on the device."""
    rollout = Simulation(tiny).simulate(tiny.start)
    parameters = pa.ForceFieldParameters.of(tiny.start, tiny.frame_count)
    return rollout, jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float32), parameters)


def replay(rollout, parameters, truncation):
    """Positions."""
    model = rollout.scene.with_parameters(parameters).model
    return replay_truncated(model, rollout.scene.state, rollout.schedule, truncation)[0]


def differentiate(pushed, truncation, frame):
    """Mean derivative of a frame's positions by the strength of the push, and all positions."""
    rollout, parameters = pushed

    def play(p):
        return replay(rollout, p, truncation)

    played = play(parameters)

    def along(p):
        x = play(p)
        return (x[frame] @ jnp.asarray(parameters.actions[0].vector)).mean()

    return float(jax.grad(along)(parameters).actions[0].magnitude), np.asarray(played)


@pytest.mark.parametrize("truncation", [WHOLE, Truncation(first=3), Truncation(substeps=1)], ids=str)
def test_values_are_those_of_the_whole_simulation(pushed, truncation):
    rollout, parameters = pushed
    played = replay(rollout, parameters, truncation)
    assert np.abs(np.asarray(played) - rollout.x).max() < 2e-6


def test_what_is_left_of_a_derivative_is_that_of_the_steps_that_are_left(pushed):
    steps = [frame.substeps for frame in pushed[0].schedule.frames]
    assert len(set(frame.dt for frame in pushed[0].schedule.frames)) == 1
    frame = 5
    all_steps, since = sum(steps[:frame]), sum(steps[3:frame])
    whole, _ = differentiate(pushed, WHOLE, frame)
    assert whole > 0
    cut, _ = differentiate(pushed, Truncation(first=3), frame)
    assert cut / whole == pytest.approx(since * (since + 1) / (all_steps * (all_steps + 1)), rel=1e-3)
    for last in (1, 2):
        end, _ = differentiate(pushed, Truncation(substeps=last), frame)
        assert end / whole == pytest.approx(last * (last + 1) / (all_steps * (all_steps + 1)), rel=1e-3)
    assert differentiate(pushed, Truncation(first=5), frame)[0] == 0
    assert differentiate(pushed, Truncation(first=5, substeps=1), frame)[0] == 0


def test_costs_and_refusals(pushed):
    assert WHOLE.count_cost(9, 4.0) == 4.0
    assert Truncation(first=4).count_cost(9, 4.0) == 0.5 + 0.5 * 4.0
    assert Truncation(substeps=1).count_cost(9, 4.0) == 1.0
    with pytest.raises(UserError, match="at least one substep"):
        Truncation(substeps=0)
    rollout, parameters = pushed
    with pytest.raises(UserError, match="nothing of the clip"):
        replay(rollout, parameters, Truncation(first=7))
