"""The residuals that methods minimise: their derivative, at rest too, and their agreement with the judge."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.metrics.targets import Target
from physagent_jax.metrics.task_judge import compute_residuals, judge

pytestmark = pytest.mark.usefixtures(
    "least_optimised"
)  # derivatives of small scenes: to compile takes longest

FRAMES, DT = 13, 0.04
LAST = FRAMES - 1
REST = np.random.default_rng(5).uniform((-0.4, -0.25, -0.5), (0.4, 0.25, 0.5), (90, 3)) + 1.5
MASS = np.random.default_rng(6).uniform(0.5, 1.5, 90)
TIME = np.linspace(0.0, 1.0, FRAMES)
X, Y, Z = np.eye(3).tolist()
WHOLE = {"window": (0, LAST)}

EVERY = [
    {"kind": "direction", "toward": X, "tolerance": 5.0, **WHOLE},
    {"kind": "distance", "along": X, "target": 0.9, "tolerance": 0.1, **WHOLE},
    {"kind": "distance", "part": Z, "target": 0.9, "tolerance": 0.1, "when": "peak", **WHOLE},
    {"kind": "turn", "axis": Z, "target": 200, "tolerance": 20, **WHOLE},
    {"kind": "turn", "axis": X, "part": Z, "against": [0, 0, -1], "target": 60, "tolerance": 20, **WHOLE},
    {"kind": "stretch", "along": Z, "target": 1.5, "tolerance": 0.1, **WHOLE},
    {"kind": "stretch", "part": X, "target": 1.2, "tolerance": 0.1, **WHOLE},
    {"kind": "oscillation", "along": X, "target": 0.9, "tolerance": 0.1, "frequency": 9.0,
     "frequency_tolerance": 1.0, **WHOLE},
    {"kind": "order", "first": {"along": X}, "second": {"along": Z}, "target": 12, "tolerance": 1, **WHOLE},
    {"kind": "rest", "tolerance": 0.02, **WHOLE},
    {"kind": "integrity", "limit": 1.0, "tolerance": 0.01, **WHOLE},
    {"kind": "path", "places": [{"centres": [[0.0, 0.0, 0.0]] * FRAMES}], **WHOLE},
]  # fmt: skip
"""One clause of every kind and of every way to ask, none of which is met where derivatives are taken."""


def ask(*clauses):
    return Target.model_validate({"clauses": clauses})


def move(numbers):
    """A clip by nine numbers: a push, a stretch and a twist that grow, and a swing."""
    t, arm = jnp.asarray(TIME)[:, None, None], jnp.asarray(REST - REST.mean(0))
    push, stretch, twist = numbers[:3], numbers[3:6], numbers[6:9]
    angle = t * (twist[2] + twist[0] * arm[None, :, 2:]) * 2.0
    grown = arm * (1 + t * stretch) + 0.3 * t * twist[1] * arm[:, 1:2] ** 2 * jnp.asarray(X)
    x, y, z = (grown[..., k : k + 1] for k in range(3))
    turned = jnp.concatenate(
        [x * jnp.cos(angle) - y * jnp.sin(angle), x * jnp.sin(angle) + y * jnp.cos(angle), z], axis=-1
    )
    return turned + t**2 * push + 0.1 * jnp.sin(7 * t) * push[::-1] + REST.mean(0)


def find_residuals(numbers, target):
    return compute_residuals(target, move(numbers), MASS, DT)


AT = np.array([0.31, -0.12, 0.23, 0.15, -0.08, 0.21, 0.4, 0.3, 0.37])
ALL = ask(*EVERY)
find_all = jax.jit(lambda numbers: find_residuals(numbers, ALL))
find_all_slopes = jax.jit(jax.jacrev(lambda numbers: find_residuals(numbers, ALL)))


def list_kinds():
    """The clause of each residual."""
    counts = {"oscillation": 2, "path": 3 * FRAMES}
    return [clause["kind"] for clause in EVERY for _ in range(counts.get(clause["kind"], 1))]


def test_derivatives_agree_with_central_differences(x64):
    derivative, kinds = np.asarray(find_all_slopes(AT)), np.array(list_kinds())
    assert len(kinds) == len(derivative)
    assert np.abs(find_all(AT))[kinds != "path"].min() > 0  # nothing is met, so that nothing is zero
    assert np.abs(derivative).max(1)[kinds != "path"].min() > 1e-3
    h = 1e-5
    for k, step in enumerate(h * np.eye(len(AT))):
        difference = (find_all(AT + step) - find_all(AT - step)) / (2 * h)
        np.testing.assert_allclose(derivative[:, k], difference, rtol=2e-6, atol=2e-6)


def test_derivatives_are_finite_at_rest_and_point_to_what_is_asked(x64):
    still = np.zeros(len(AT))
    derivative, residuals = np.asarray(find_all_slopes(still)), np.asarray(find_all(still))
    assert np.isfinite(derivative).all() and np.isfinite(residuals).all()
    downhill = -(derivative.T @ residuals)
    assert downhill[0] > 0 and downhill[5] > 0 and downhill[8] > 0  # along X, longer along Z, about Z


def test_residuals_are_zero_where_the_judge_sees_room_and_only_there():
    """At margins of 0.6 there is nothing left to do; at 0.4, and outside, there is."""
    seen = judge(ask(*EVERY[:-1]), move(AT), MASS, DT)
    kinds = [clause for clause in EVERY[:-1] for _ in range(2 if clause["kind"] == "oscillation" else 1)]
    for clause, number in zip(kinds, seen.clauses):
        if clause["kind"] in ("oscillation", "direction"):
            continue
        for margin in (0.6, 0.4, -0.5):
            easier = clause | {"tolerance": abs(number.seen - number.wanted) / (1 - margin)}
            if (wanted := easier.get("target")) and easier["tolerance"] > abs(wanted) / 3:
                easier["target"] = number.seen + (1 - margin) * 0.2 * abs(number.seen)
                easier["tolerance"] = 0.2 * abs(number.seen)
            judged = judge(ask(easier), move(AT), MASS, DT)
            assert judged.clauses[0].margin == pytest.approx(margin, abs=1e-3)
            assert judged.success == (margin > 0)
            residual = float(find_residuals(AT, ask(easier))[0])
            assert abs(residual) == pytest.approx(max(0.5 - margin, 0.0), abs=1e-3)


def test_gauss_newton_meets_all_clauses_in_a_few_steps(x64):
    wanted = ask(
        {"kind": "distance", "along": X, "target": 0.5, "tolerance": 0.1, **WHOLE},
        {"kind": "turn", "axis": Z, "target": 60, "tolerance": 10, **WHOLE},
        {"kind": "stretch", "along": Z, "target": -0.2, "tolerance": 0.05, **WHOLE},
        {"kind": "direction", "toward": X, "tolerance": 20, **WHOLE},
    )
    find = jax.jit(lambda numbers: find_residuals(numbers, wanted))
    slope = jax.jit(jax.jacrev(lambda numbers: find_residuals(numbers, wanted)))
    at = np.zeros(len(AT))
    assert not judge(wanted, move(at), MASS, DT).success
    for _ in range(12):
        at = at - np.linalg.lstsq(slope(at), find(at), rcond=1e-6)[0]
    seen = judge(wanted, move(at), MASS, DT)
    assert seen.success and seen.error <= 0.5 + 1e-3
    assert 0.5 * float(find(at) @ find(at)) < 1e-5


def test_the_norm_of_a_paths_residuals_is_its_root_mean_square_distance():
    way = np.outer(TIME, [0.03, 0.04, 0.0])
    path = ask({"kind": "path", "places": [{"centres": way.tolist()}], "tolerance": 0.05, **WHOLE})
    still = np.tile(REST, (FRAMES, 1, 1))
    expected = np.sqrt(np.mean((0.05 * TIME) ** 2)) / 0.05
    assert np.linalg.norm(compute_residuals(path, still, MASS, DT)) == pytest.approx(expected, rel=1e-4)
