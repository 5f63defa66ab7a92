"""Pushes to and fro swing a free object as far as M says, however short they are, and leave it where it was."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.forces import calibration
from physagent_jax.forces.free_path import compute_free_path
from physagent_jax.forces.parameters import ActionParameters
from physagent_jax.forces.scaling import make_closed_form_scaling
from physagent_jax.forces.schema import Action, ActionType, ForceField
from physagent_jax.forces.swinging import find_strokes

LEFT, RIGHT, UP = (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
FRAMES, DT, L = 121, 0.02, 1.3


def push(way, first, last, magnitude=1.0, kind=ActionType.TRANSLATION):
    return Action(action_type=kind, vector=way, magnitude=magnitude, active_time=(first, last))


def train(half, count, magnitude=1.0):
    edges = [0, *(half // 2 + half * i for i in range(2 * count)), 2 * count * half]
    spans = zip(edges, edges[1:])
    return tuple(push(RIGHT if i % 2 else LEFT, *span, magnitude) for i, span in enumerate(spans))


def scaled(damping_rate=0.0):
    return make_closed_form_scaling(
        extent=L, youngs_modulus=1e5, density=300, duration=2.0, damping_rate=damping_rate
    )


def strokes_of(actions, scaling):
    values = [ActionParameters.of(action, FRAMES) for action in actions]
    return find_strokes(ForceField(actions=actions), values, scaling, DT)


def integrate(actions, scaling, steps=200):
    """The path of a point mass under the strokes' own k."""
    strokes, x, v, path = strokes_of(actions, scaling), 0.0, 0.0, [0.0]
    for index, action in enumerate(actions):
        first, last = action.active_time
        a = strokes[index].k * action.magnitude * action.vector[0]
        assert strokes[index].speed * action.vector[0] == pytest.approx(v, abs=0.03 * L)
        for _ in range(steps):
            dt = (last - first) * DT / steps
            v += (a - scaling.damping_rate * v) * dt
            x += v * dt
            path.append(x)
    return np.array(path)


@pytest.mark.parametrize("magnitude", [0.4, 1.6])
@pytest.mark.parametrize(("half", "count"), [(4, 8), (12, 4), (40, 1)])
def test_a_train_goes_as_far_as_it_says_and_comes_back(half, count, magnitude):
    path = integrate(train(half, count, magnitude), scaled())
    assert np.ptp(path) / 2 == pytest.approx(magnitude * calibration.SWING * L, rel=0.02)
    assert abs(path[-1]) < 0.02 * L


def test_what_else_acts_meanwhile_does_not_matter():
    actions = train(12, 4)
    lifted = (push(UP, 0, 96), *actions)
    assert {i + 1: s.k for i, s in strokes_of(actions, scaled()).items()} == {
        i: s.k for i, s in strokes_of(lifted, scaled()).items()
    }


@pytest.mark.parametrize("damping", [0.5, 2.5])
def test_damping_is_made_up_for(damping):
    path = integrate(train(12, 4), scaled(damping))
    settled = path[len(path) // 2 : -300]  # what drifts at first is slow to settle
    assert np.ptp(settled) / 2 == pytest.approx(calibration.SWING * L, rel=0.1)


def test_the_camera_s_path_knows_it():
    field = ForceField(actions=train(12, 4))
    path = compute_free_path(field, scaled(), frame_dt=DT, frame_count=FRAMES)
    assert np.ptp(path[:, 0]) / 2 == pytest.approx(calibration.SWING * L, rel=0.1)


@pytest.mark.parametrize(
    "actions",
    [
        (push(LEFT, 0, 20), push(RIGHT, 20, 40)),  # a push and its brake
        (push(LEFT, 0, 20), push(RIGHT, 20, 40), push(LEFT, 40, 60)),  # gives more than it takes back
        (push(LEFT, 0, 10), push(LEFT, 10, 30), push(LEFT, 30, 40)),
    ],
)
def test_other_pushes_keep_their_k_but_know_their_speed(actions):
    scaling = scaled()
    strokes = strokes_of(actions, scaling)
    assert [s.k for s in strokes.values()] == [scaling.translation] * len(actions)
    gained = scaling.translation * DT * (actions[0].active_time[1] - actions[0].active_time[0])
    sign = 1 if actions[0].vector == actions[1].vector else -1
    assert strokes[1].speed == pytest.approx(sign * gained)


@pytest.mark.parametrize(
    "actions",
    [
        (push(LEFT, 0, 10), push(UP, 10, 30), push(RIGHT, 30, 40)),
        (push(LEFT, 0, 10), push(RIGHT, 20, 40), push(LEFT, 50, 60)),
        tuple(push(*span, kind=ActionType.IMPULSE) for span in [(LEFT, 0, 1), (RIGHT, 1, 2), (LEFT, 2, 3)]),
    ],
)
def test_what_does_not_follow_is_a_push_like_any_other(actions):
    assert strokes_of(actions, scaled()) == {}


def test_traced_numbers_give_the_same_with_derivatives():
    actions, scaling = train(12, 4), scaled(0.5)
    field, values = (
        ForceField(actions=actions),
        [ActionParameters.of(action, FRAMES) for action in actions],
    )

    def add_up(first):
        moved = [*values[:2], dataclasses.replace(values[2], window=values[2].window + first), *values[3:]]
        strokes = find_strokes(field, moved, scaling, DT)
        return strokes[3].k * 1.0 + strokes[3].speed

    known = find_strokes(field, values, scaling, DT)[3]
    shift = jnp.zeros(2)
    assert float(jax.jit(add_up)(shift)) == pytest.approx(float(known.k + known.speed), rel=1e-5)
    assert np.isfinite(jax.grad(add_up)(shift)).all()
