"""Methods against simulators with a closed form, through the evaluator that they are given in earnest."""

import dataclasses

import numpy as np
import pytest

from baselines.methods import METHODS, make_method
from baselines.methods.bo_leap import predict
from baselines.methods.lbfgs import find_direction
from baselines.methods.smoothed_adam import combine
from baselines.starts import KINDS, choose_templates, enumerate_types
from physagent_jax.core.errors import UserError
from physagent_jax.forces.parameters import ActionParameters, ForceFieldParameters
from physagent_jax.forces.schema import ForceField
from physagent_jax.forces.skills import list_skills
from tests.baselines.analytic import Linear, make_evaluator, pushes
from tests.baselines.tiny import act

A = np.array([[3.0, 1.0, 0.0], [0.0, 2.0, 0.5], [1.0, 0.0, 4.0], [0.2, 0.3, 1.0]])
WANTED = np.array([-0.7, 0.4, 0.6])  # |M| is 1.005
LOCAL = ("levenberg_marquardt", "lbfgs", "adam", "smoothed_adam")
ORACLES = (*LOCAL, "cma", "catcma", "random", "bo_leap")


def linear(kinds=None, offset=0.0):
    """Least squares whose least value is at `WANTED`, with a residual that nothing removes if ``offset``."""
    null = np.linalg.svd(A.T)[2][-1]
    return Linear(A, A @ WANTED + offset * null, kinds)


def fit(name, evaluator, **options):
    for package in {"cma": ["cmaes"], "catcma": ["cmaes"], "bo_leap": ["cmaes", "sklearn"]}.get(name, []):
        pytest.importorskip(package, reason="extra `baselines`")
    return make_method(name, options).finish(evaluator)


def find(result) -> np.ndarray:
    action = result.incumbent_at().actions[0]
    return action.magnitude * np.asarray(action.vector)


def test_levenberg_marquardt_finds_the_closed_form_of_linear_least_squares():
    evaluator = make_evaluator(linear(offset=0.4), budget=60)
    result = fit("levenberg_marquardt", evaluator)
    exact = np.linalg.lstsq(A, linear(offset=0.4).b, rcond=None)[0]
    np.testing.assert_allclose(find(result), exact, atol=2e-3)
    assert result.find_incumbent().objective == pytest.approx(0.08, rel=1e-4)
    assert result.spent < 40  # it knows when it has converged


@pytest.mark.parametrize(
    "name, budget", [("lbfgs", 100), ("adam", 600), ("smoothed_adam", 2000), ("cma", 600)]
)
def test_the_least_value_of_a_quadratic_is_found(name, budget):
    options = dict(types="task") if name == "cma" else {}
    result = fit(name, make_evaluator(linear(), budget=budget), **options)
    np.testing.assert_allclose(find(result), WANTED, atol=0.02)


def test_levenberg_marquardt_stays_in_the_library_s_range():
    """The least value lies outside: the best force field inside is the nearest in the metric of the residuals."""
    simulation = Linear(np.eye(3), np.array([0.0, 3.0, 0.0]))
    result = fit("levenberg_marquardt", make_evaluator(simulation, budget=80))
    np.testing.assert_allclose(find(result), [0.0, 1.6, 0.0], atol=0.02)


def test_lbfgs_direction_is_newton_s_on_a_quadratic_that_it_knows():
    H = A.T @ A
    pairs = [(e, H @ e) for e in np.linalg.eigh(H)[1].T]
    gradient = np.array([1.0, -2.0, 0.5])
    np.testing.assert_allclose(find_direction(gradient, pairs), -np.linalg.solve(H, gradient), rtol=1e-8)


def test_smoothed_gradient_takes_the_estimate_that_varies_less():
    noise = np.random.default_rng(0).normal(size=(200, 2))
    noise = np.concatenate([noise, -noise])
    true = np.array([1.0, -2.0])
    losses = 0.1 * noise @ true
    rough = np.tile(true, (400, 1)) + 1e3 * np.random.default_rng(1).normal(size=(400, 2))
    smooth = np.tile(true, (400, 1))
    np.testing.assert_allclose(combine(smooth, losses, noise, 0.1), true, atol=1e-6)
    np.testing.assert_allclose(combine(rough, losses, noise, 0.1), true, atol=0.5)


@pytest.mark.parametrize("name", [*LOCAL, "cma"])
def test_all_types_are_tried_and_the_right_one_is_polished(name):
    simulation = linear(kinds=("torque",))
    budget = 3000 if name == "smoothed_adam" else 600
    result = fit(name, make_evaluator(simulation, budget=budget), types="enumerated", starts=2)
    assert result.incumbent_at().actions[0].action_type == "torque"
    np.testing.assert_allclose(find(result), WANTED, atol=0.1)


@pytest.mark.parametrize("name, spread", [("catcma", 0.2), ("random", 0.6), ("bo_leap", 0.1)])
def test_the_type_is_found(name, spread):
    result = fit(name, make_evaluator(linear(kinds=("impulse",)), budget=600))
    assert result.incumbent_at().actions[0].action_type == "impulse"
    assert np.linalg.norm(find(result) - WANTED) < spread


@pytest.mark.parametrize("name", ORACLES)
@pytest.mark.parametrize("budget", [3, 17])
def test_a_budget_is_exceeded_by_one_evaluation_at_most_and_the_record_is_kept(name, budget):
    result = fit(name, make_evaluator(linear(offset=1.0), budget=budget), **_all_types(name))
    before = [0.0, *(each.spent for each in result.evaluations)][-2]
    assert result.evaluations and before < budget
    assert result.spent < budget + 4.3
    assert all(np.diff([each.spent for each in result.evaluations]) >= 0)


@pytest.mark.parametrize("name", ORACLES)
def test_the_same_seed_gives_the_same_result(name):
    runs = [
        fit(name, make_evaluator(linear(offset=1.0), budget=60, seed=seed), **_all_types(name))
        for seed in (1, 1, 2)
    ]
    tried = [[each.force_field for each in run.evaluations] for run in runs]
    assert tried[0] == tried[1]
    assert tried[0] != tried[2]


@pytest.mark.parametrize("name", ORACLES)
def test_the_incumbent_never_gets_worse(name):
    result = fit(name, make_evaluator(linear(offset=1.0), budget=80), **_all_types(name))
    at = [result.find_incumbent(spent) for spent in np.arange(0, 90, 2.5)]
    values = [each.objective for each in at if each is not None]
    assert len(values) > 20 and all(np.diff(values) <= 0)
    assert result.incumbent_at(0.0) == result.start


def test_failures_are_survived():
    class Torn(Linear):
        def simulate(self, force_field):
            self.calls += 1
            if force_field.actions[0].vector[0] > 0.1:
                raise UserError("it tears")
            return force_field

    for name in LOCAL:
        start = act("translation", (-0.1, 0.6, 0.8), 1.0)
        simulation = Torn(np.eye(3), np.array([-0.1, 1.0, 0.0]))
        result = fit(name, make_evaluator(simulation, start, budget=400))
        assert np.isfinite(result.find_incumbent().objective)
        np.testing.assert_allclose(find(result), [-0.1, 1.0, 0.0], atol=0.1)


@pytest.mark.parametrize("damping", [0.0, -1.0, float("nan")])
def test_damping_that_shortens_no_step_is_refused(damping):
    with pytest.raises(UserError, match="damping"):
        make_method("levenberg_marquardt", dict(damping=damping))


def test_a_step_over_a_cliff_is_at_least_halved_until_it_stays_on_this_side():
    """The least value lies beyond it: what is found is the edge, in a few trials each time."""

    class Cliff(Linear):
        def replay(self, rollout, parameters):
            r = super().replay(rollout, parameters)
            return r + 40.0 * (pushes(parameters)[0] > 1.0)

    simulation = Cliff(np.diag([3.0, 1.0, 1.0]), np.array([4.5, 0.0, 0.0]))
    evaluator = make_evaluator(simulation, act("translation", (1.0, 0.0, 0.0), 0.5), budget=40)
    result = fit("levenberg_marquardt", evaluator, hops=0)
    assert 0.95 < find(result)[0] <= 1.0
    here, steps = 0.5, []
    for each in result.evaluations:
        there = pushes(ForceFieldParameters.of(each.force_field, 11))[0]
        if each.note == "trial" and there > 1.0:
            steps.append(there - here)
            assert len(steps) < 2 or steps[-1] <= 0.51 * steps[-2]
        elif each.note == "trial":
            here, steps = there, []


def test_a_task_without_actions_is_tried_as_it_is():
    start = ForceField(default_drop=True)
    simulation = Linear(np.zeros((2, 0)), np.array([1.0, 1.0]))
    for name in ("levenberg_marquardt", "lbfgs", "adam"):
        result = fit(name, make_evaluator(simulation, start))
        assert [each.force_field for each in result.evaluations] == [start]


def test_every_combination_of_kinds_is_there_once():
    one = enumerate_types(act("translation", (1, 0, 0)))
    assert len(one) == len(KINDS) and len(set(one)) == len(one)
    windows = {a.action_type: a.active_time for each in one for a in each.actions}
    assert windows == {s.name: (0, 2) if s.is_sudden else None for s in list_skills("actions")}
    assert windows["impulse"] == (0, 2) and windows["translation"] is None
    action = act("translation", (1, 0, 0)).actions[0]
    same = enumerate_types(ForceField(actions=(action, action)))
    assert len(same) == len(KINDS) * (len(KINDS) + 1) / 2
    later = action.model_copy(update=dict(active_time=(3, 5)))
    assert len(enumerate_types(ForceField(actions=(action, later)))) == len(KINDS) ** 2


def test_a_fall_is_among_the_types_only_where_it_helps():
    """A fall misses by 1 and rest by 2, or the other way round: the one that misses less is what actions add to."""

    @dataclasses.dataclass
    class Falling(Linear):
        helps: bool = True

        def compute_residuals(self, rollout):
            return np.full(4, 1.0 if rollout.default_drop == self.helps else 2.0)

    for helps in (True, False):
        evaluator = make_evaluator(Falling(A, A @ WANTED, helps=helps))
        templates = choose_templates(evaluator, "enumerated")
        assert evaluator.spent == 2 and {each.default_drop for each in templates} == {helps}
        assert len(templates) == len(KINDS) + helps


def test_surrogate_goes_through_what_is_known_and_knows_where_it_does_not():
    pytest.importorskip("sklearn", reason="extra `baselines`")
    x = np.linspace(-1, 1, 9)[:, None]
    mean, deviation = predict(x, np.sin(3 * x[:, 0]), np.array([[0.25], [0.1], [20.0]]))
    np.testing.assert_allclose(mean[:2], np.sin([0.75, 0.3]), atol=0.05)
    assert abs(mean[2]) < 0.05 and deviation[2] > 5 * deviation[0]


@pytest.mark.parametrize("name", ["levenberg_marquardt", "random", "catcma"])
def test_more_actions_follow_one_another(name):
    wide = Linear(np.eye(6), np.array([0.8, 0, 0, 0, 0, -0.9]), ("translation", "torque"))
    result = fit(
        name,
        make_evaluator(wide, budget=120),
        actions=2,
        **({"types": "enumerated"} if "marq" in name else {}),
    )
    assert {len(each.force_field.actions) for each in result.evaluations} <= {0, 2}
    first, second = (action.active_time for action in result.incumbent_at().actions)
    assert first == (0, 5) and second == (5, 10)
    if name == "levenberg_marquardt":
        assert result.find_incumbent().objective < 1e-3


def test_drawn_windows_lie_in_the_clip():
    result = fit("random", make_evaluator(linear(offset=1.0)), windows=True)
    windows = np.array([a.active_time for each in result.evaluations for a in each.force_field.actions])
    assert windows.min() >= 0 and windows.max() <= 10 and np.diff(windows).min() >= 1 - 1e-9
    assert np.ptp(windows[:, 0]) > 5


def test_a_start_near_the_expert_is_where_a_search_begins():
    expert = act("impulse", (0, 0, 1), 0.9, (0, 2))
    evaluator = make_evaluator(linear(kinds=("impulse",)), expert=expert)
    result = fit("levenberg_marquardt", evaluator, types="expert", numbers="expert")
    assert result.evaluations[0].force_field == expert
    np.testing.assert_allclose(find(result), WANTED, atol=0.01)
    with pytest.raises(UserError, match="published"):
        fit("levenberg_marquardt", make_evaluator(linear()), types="expert")


def test_unknown_names_and_options_are_refused():
    with pytest.raises(UserError, match="adam"):
        make_method("adm")
    for name, options in (
        ("adam", dict(learning_rate=0)),
        ("adam", dict(starts=0)),
        ("smoothed_adam", dict(samples=3)),
        ("hybrid", dict(part=0)),
        ("rules", dict(rounds=0)),
        ("adam", dict(colour="red")),
    ):
        with pytest.raises(UserError):
            make_method(name, options)
    assert all(make_method(name).name == name for name in METHODS.entries)


def _all_types(name):
    return dict(types="enumerated", starts=2) if name in LOCAL or name == "cma" else {}


def test_what_no_number_changes_ends_at_once():
    for name in ("levenberg_marquardt", "lbfgs"):
        result = fit(name, make_evaluator(Linear(np.zeros((2, 3)), np.ones(2))))
        assert result.spent < 40 and result.find_incumbent().objective == 1.0


@pytest.mark.parametrize("name", ["levenberg_marquardt", "lbfgs"])
def test_a_search_that_is_stuck_at_a_kink_begins_again_beside_it(name):
    """A flat r beyond a kink leaves no way down; a step aside finds one."""

    class Ledge(Linear):
        def replay(self, rollout, parameters):
            u = pushes(parameters)
            return self.A @ u - self.b if u[0] < 0.25 else np.full(4, 9.0)

        def differentiate(self, rollout, parameters):
            if pushes(parameters)[0] < 0.25:
                return super().differentiate(rollout, parameters)
            zero = [ActionParameters(np.zeros(3), np.zeros(()), np.zeros(2))]
            return np.full(4, 9.0), ForceFieldParameters(tuple(zero))

    start = act("translation", (0.3, 0.6, 0.74), 1.0)
    found = {}
    for hops in (0, 20):
        result = fit(name, make_evaluator(Ledge(A, A @ WANTED), start, budget=200), hops=hops)
        found[hops] = result.find_incumbent().objective
    assert found[0] == pytest.approx(162.0) and found[20] < 1e-3
