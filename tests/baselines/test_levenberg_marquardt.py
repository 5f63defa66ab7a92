"""Steps of Levenberg-Marquardt at the library's edge, and its Jacobians, against answers from elsewhere."""

import numpy as np
import pytest
from scipy.optimize import minimize

from baselines.methods import make_method
from baselines.methods.levenberg_marquardt import restrict, update
from baselines.parametrisation import Parametrisation
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import ForceField
from tests.baselines.analytic import FRAMES, Linear, make_evaluator
from tests.baselines.tiny import act


def push_twice(first, second) -> ForceField:
    return ForceField(actions=(*act("translation", *first).actions, *act("translation", *second).actions))


def test_at_the_edge_of_the_range_the_rest_goes_where_a_solver_for_constraints_does():
    """Two pushes that answer to the same residuals; the first would have to be four times as strong as it can be."""
    rng = np.random.default_rng(0)
    A = np.concatenate([np.eye(6), 0.7 * rng.normal(size=(4, 6))])
    b = A @ np.array([0.0, 6.4, 0.0, 0.5, -0.3, 0.4])
    start = push_twice(((0.0, 1.0, 0.0), 1.5), ((0.6, 0.0, 0.8), 0.5))
    result = make_method("levenberg_marquardt", dict(hops=0)).finish(
        make_evaluator(Linear(A, b), start, budget=80)
    )

    def give_room(u):
        sizes = np.linalg.norm(u.reshape(-1, 3), axis=1)
        return np.concatenate([sizes - MAGNITUDE_MIN, MAGNITUDE_MAX - sizes])

    limits = {"type": "ineq", "fun": give_room}
    inside = Parametrisation(start, FRAMES).encode(start)
    exact = minimize(
        lambda u: 0.5 * np.sum((A @ u - b) ** 2), inside, method="SLSQP", constraints=limits, tol=1e-12
    )
    assert exact.success and np.linalg.norm(exact.x[:3]) == pytest.approx(MAGNITUDE_MAX)
    found = Parametrisation(start, FRAMES).encode(result.incumbent_at())
    np.testing.assert_allclose(found, exact.x, atol=0.02)
    assert result.find_incumbent().objective == pytest.approx(exact.fun, rel=1e-3)


def test_a_linear_response_is_differentiated_once():
    """Six unknowns: a simulation, six differences, and then a simulation per step."""
    A = np.random.default_rng(1).normal(size=(9, 6))
    wanted = np.array([0.5, 0.5, 0.0, 0.0, -0.6, 0.5])
    start = push_twice(((0.0, 1.0, 0.0), 0.5), ((0.0, 0.0, 1.0), 0.5))
    result = make_method("levenberg_marquardt", dict(hops=0)).finish(
        make_evaluator(Linear(A, A @ wanted), start, budget=100)
    )
    assert result.find_incumbent().objective < 1e-6
    assert result.spent < 1 + 6 + 8


def test_an_updated_jacobian_gives_the_change_that_was_seen_and_keeps_what_was_not():
    rng = np.random.default_rng(2)
    J, step, change = rng.normal(size=(5, 4)), rng.normal(size=4), rng.normal(size=5)
    updated = update(J, step, change)
    np.testing.assert_allclose(updated @ step, change)
    across = np.linalg.svd(step[None])[2][1:]
    np.testing.assert_allclose(updated @ across.T, J @ across.T, atol=1e-12)


def test_what_leads_out_of_the_range_is_blocked_and_what_leads_in_is_not():
    """A push at full strength for the whole clip, and a weakest one that has begun later."""
    start = push_twice(((0.0, 0.6, 0.8), MAGNITUDE_MAX), ((1.0, 0.0, 0.0), MAGNITUDE_MIN))
    late = start.actions[1].model_copy(update=dict(active_time=(2.0, 5.0)))
    unknowns = Parametrisation(
        start.model_copy(update=dict(actions=(start.actions[0], late))), FRAMES, windows=True
    )
    u = unknowns.encode(unknowns.template)
    out = np.array([0.0, 0.6, 0.8, -1.0, 2.0, -1.0, 0.3, 0.0, -1.0, -1.0])
    blocked = unknowns.list_blocked(u, out)
    np.testing.assert_allclose(blocked @ blocked.T, np.eye(len(blocked)), atol=1e-12)
    free = out - blocked.T @ (blocked @ out)
    np.testing.assert_allclose(free, [0, 0, 0, 0, 0, 0, 0.3, 0.0, -1.0, -1.0], atol=1e-12)
    assert len(unknowns.list_blocked(u, -out * (np.arange(10) < 3))) == 0
    normal, slope = restrict(np.eye(10), -out, unknowns, u)
    np.testing.assert_allclose(-slope, free, atol=1e-12)
    np.testing.assert_allclose(normal @ blocked.T, 0, atol=1e-12)
