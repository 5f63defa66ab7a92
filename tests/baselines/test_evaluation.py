"""The evaluator charges what is done, tells the truth to oracles only, and its derivatives are those of differences."""

import dataclasses

import numpy as np
import pytest

from baselines.evaluation import GRADIENT_COST, Evaluator, are_near
from baselines.parametrisation import Parametrisation
from baselines.protocol import Budget, BudgetSpent
from physagent_jax.core.errors import UserError
from physagent_jax.forces.parameters import ActionParameters, ForceFieldParameters
from physagent_jax.metrics.task_judge import ROOM
from tests.baselines.analytic import Linear, make_evaluator, pushes
from tests.baselines.tiny import act

PUSH = act("translation", (0.6, -0.8, 0.0), 0.9)


def make(task, spend=100.0, **options):
    return Evaluator(task, Budget(spend), **options)


def test_the_hidden_force_field_has_no_loss_and_another_has_one(tiny):
    evaluator = make(tiny)
    assert evaluator.score(tiny.spec.hidden).loss < 1e-6
    assert evaluator.score(tiny.start).loss > 0.1
    assert evaluator.spent == 2 and [each.spent for each in evaluator.evaluations] == [1, 2]


def find_central_differences(evaluator, unknowns, u, h):
    residuals = [
        [evaluator.score(unknowns.decode(u + s * h * axis)).residuals for s in (1, -1)] for axis in np.eye(3)
    ]
    return np.stack([(up - down) / (2 * h) for up, down in residuals], axis=1)


@pytest.mark.parametrize("kind", ["translation", pytest.param("torque", marks=pytest.mark.slow)])
def test_gradient_and_jacobian_agree_with_central_differences(tiny, kind):
    field = act(kind, (0.6, -0.64, 0.48), 0.9)
    unknowns = Parametrisation(field, tiny.frame_count)
    evaluator, u = make(tiny), unknowns.encode(field)
    score, slope = evaluator.gradient(field)
    gradient = unknowns.pull_back(field, slope)
    central = find_central_differences(evaluator, unknowns, u, 0.05)
    wanted = central.T @ score.residuals
    np.testing.assert_allclose(gradient, wanted, atol=0.02 * np.abs(wanted).max())
    same, jacobian = evaluator.jacobian(field)
    np.testing.assert_allclose(same.residuals, score.residuals, atol=1e-4)
    np.testing.assert_allclose(jacobian, central, atol=0.03 * np.abs(central).max())
    with evaluator.sharpened(2):  # r |r| / ROOM, of which the derivative is 2 |r| / ROOM
        _, sharper = evaluator.gradient(field)
    r = score.residuals
    wanted = central.T @ (2 * abs(r) / ROOM * r * abs(r) / ROOM)
    given = unknowns.pull_back(field, sharper)
    np.testing.assert_allclose(given, wanted, atol=0.03 * np.abs(wanted).max())
    recorded = [each.objective for each in evaluator.evaluations if each.force_field == field]
    np.testing.assert_allclose(recorded, score.loss, rtol=1e-3)


@pytest.mark.slow
def test_a_stretch_that_turns_takes_particles_to_the_other_side(tiny):
    """Differences see them and reverse mode does not; with 200 particles they come in lumps."""
    field = act("scale", (0.6, -0.64, 0.48), -0.9)
    unknowns = Parametrisation(field, tiny.frame_count)
    evaluator, u = make(tiny), unknowns.encode(field)
    score, slope = evaluator.gradient(field)
    wanted = find_central_differences(evaluator, unknowns, u, 0.15).T @ score.residuals
    np.testing.assert_allclose(unknowns.pull_back(field, slope), wanted, atol=0.25 * np.linalg.norm(wanted))
    _, jacobian = evaluator.jacobian(field)
    np.testing.assert_allclose(jacobian.T @ score.residuals, wanted, atol=0.4 * np.linalg.norm(wanted))


@pytest.mark.slow
def test_derivatives_by_windows_agree_with_differences(tiny):
    field = act("translation", (0, 1, 0), 1.0, (1.4, 4.6))
    unknowns = Parametrisation(field, tiny.frame_count, windows=True)
    evaluator, u = make(tiny), unknowns.encode(field)
    _, slope = evaluator.gradient(field)
    h = 0.2 / (tiny.frame_count - 1)  # stays within the window's frames
    for axis in (3, 4):
        step = h * np.eye(5)[axis]
        up, down = (evaluator.score(unknowns.decode(u + s * step)).loss for s in (1, -1))
        np.testing.assert_allclose(unknowns.pull_back(field, slope)[axis], (up - down) / (2 * h), rtol=0.1)


def test_everything_is_charged(tiny):
    evaluator = make(tiny)
    evaluator.gradient(PUSH)
    assert evaluator.spent == pytest.approx(1 + GRADIENT_COST)
    evaluator.gradient(act("translation", (0.6, -0.8, 0.0), 1.0))  # its steps serve
    assert evaluator.spent == pytest.approx(1 + 2 * GRADIENT_COST)
    evaluator.gradient(act("translation", (-0.6, 0.8, 0.0), 1.0))  # these do not
    assert evaluator.spent == pytest.approx(2 + 3 * GRADIENT_COST)
    before = evaluator.spent
    evaluator.jacobian(tiny.start)
    assert evaluator.spent == pytest.approx(before + 1 + 3)
    before = evaluator.spent
    assert evaluator.play(PUSH) is not None
    assert evaluator.spent == before + 1
    assert all(np.diff([each.spent for each in evaluator.evaluations]) > 0)


def test_the_evaluation_that_spends_the_budget_is_the_last(tiny):
    evaluator = make(tiny, 2.0)
    evaluator.score(PUSH)
    evaluator.gradient(PUSH)
    with pytest.raises(BudgetSpent):
        evaluator.score(PUSH)
    assert evaluator.spent == pytest.approx(1 + GRADIENT_COST) and len(evaluator.evaluations) == 2
    late = Evaluator(tiny, Budget(10, seconds=1e-9))
    with pytest.raises(BudgetSpent):
        late.score(PUSH)


def test_a_force_field_that_cannot_be_simulated_is_charged_and_is_no_solution(tiny):
    def refuse(field):
        if field != tiny.start:
            raise UserError("it tears")
        return tiny.build(field)

    evaluator = make(dataclasses.replace(tiny, build=refuse))
    assert evaluator.score(PUSH).failed and evaluator.play(PUSH) is None
    score, gradient = evaluator.gradient(PUSH)
    assert score.failed and not np.any(gradient.actions[0].vector)
    assert evaluator.spent == 3 and all(each.objective == np.inf for each in evaluator.evaluations)


def test_who_is_no_oracle_is_told_nothing_true(tiny):
    evaluator = make(tiny, oracle=False)
    for ask in (evaluator.score, evaluator.gradient, evaluator.jacobian):
        with pytest.raises(UserError, match="oracle"):
            ask(PUSH)
    pictures = evaluator.play(PUSH)
    assert {field.name for field in dataclasses.fields(pictures)} == {"rgb", "depth", "camera", "frame_dt"}
    assert pictures.rgb.shape == (tiny.frame_count, 48, 64, 3)


def test_a_gradient_by_pixels_agrees_with_differences_of_the_pictures(tiny):
    """Of a smooth function of the colours. Pictures are rounded to 8 bits, so the step is large; what crosses the least
    alpha that is drawn has no derivative, so it is right to a seventh.
    """
    evaluator, field = make(tiny, oracle=False), act("translation", (1, 0, 0), 0.8)
    unknowns = Parametrisation(field, tiny.frame_count)
    u = unknowns.encode(field)
    rows, columns = np.mgrid[:48, :64] / 48.0
    weight = np.stack([np.cos(2 * columns), np.sin(3 * rows), columns * rows], -1)
    pixels = np.zeros((tiny.frame_count, 48, 64, 3))
    pixels[-1] = weight

    def value(u):
        return float((evaluator.play(unknowns.decode(u)).rgb[-1] / 255.0 * weight).sum())

    evaluator.play(field)
    gradient = unknowns.pull_back(field, evaluator.pull_back(field, pixels)[0])
    h = 0.1
    differences = [(value(u + h * axis) - value(u - h * axis)) / (2 * h) for axis in np.eye(3)]
    np.testing.assert_allclose(gradient, differences, atol=0.15 * np.abs(differences).max())


def test_steps_serve_force_fields_that_differ_by_little_numbers_only():
    field = act("scale", (1, 0, 0), 1.0, (0, 3))
    assert are_near(field, act("scale", (1, 0.1, 0), 1.1, (0, 3)))
    for other in (
        act("scale", (1, 0, 0), -1.0, (0, 3)),
        act("scale", (1, 0, 0), 1.0, (0, 4)),
        act("torque", (1, 0, 0), 1.0, (0, 3)),
        act("scale", (1, 0, 0), 1.4, (0, 3)),
    ):
        assert not are_near(field, other)


def test_unknowns_come_back_and_are_kept_in_the_library_s_range():
    field = act("scale", (0.6, 0.8, 0), -1.2, (2, 5))
    unknowns = Parametrisation(field, 8, windows=True)
    u = unknowns.encode(field)
    np.testing.assert_allclose(u, [0.72, 0.96, 0, 2 / 7, 3 / 7])
    assert unknowns.decode(u).actions[0].magnitude == pytest.approx(-1.2)
    wide = unknowns.decode(np.array([30.0, 40, 0, 0.9, 0.9]))
    assert wide.actions[0].magnitude == pytest.approx(-1.6)
    np.testing.assert_allclose(wide.actions[0].active_time, [6, 7], atol=0.31)
    assert abs(unknowns.decode(np.zeros(5)).actions[0].magnitude) == pytest.approx(0.4)


@pytest.mark.parametrize("windows", [False, True])
def test_unknowns_without_directions_are_strengths(windows):
    """And derivatives by them those along the vectors."""
    field = act("scale", (0.6, 0.8, 0), -1.2, (2, 5))
    unknowns = Parametrisation(field, 8, windows, directions=False)
    u = unknowns.encode(field)
    np.testing.assert_allclose(u, [1.2, 2 / 7, 3 / 7][: unknowns.size])
    (same,) = unknowns.decode(u).actions
    assert same.vector == field.actions[0].vector and same.magnitude == pytest.approx(-1.2)
    np.testing.assert_allclose(same.active_time, [2, 5])
    u[0] = 9.0
    wide = unknowns.decode(u).actions[0]
    assert wide.magnitude == -1.6 and wide.vector == field.actions[0].vector
    slope = ActionParameters(np.array([5.0, 7.0, 9.0]), np.asarray(2.0), np.array([1.0, 3.0]))
    by_unknowns = unknowns.pull_back(field, ForceFieldParameters((slope,)))
    np.testing.assert_allclose(by_unknowns, [-2.0, 28.0, 21.0][: unknowns.size])


def test_gradients_by_unknowns_do_not_go_by_vectors_of_other_lengths():
    """L = g.(M v): whatever the simulator does with vectors that are no unit vectors."""
    g, field = np.array([0.3, -1.0, 2.0]), act("translation", (0.6, 0, 0.8), 1.2)
    unknowns, v = Parametrisation(field, 8), np.array([0.6, 0, 0.8])
    for wrong in (0.0, -7.0):
        slope = ActionParameters(1.2 * g + wrong * v, np.asarray(g @ v), np.zeros(2))
        np.testing.assert_allclose(unknowns.pull_back(field, ForceFieldParameters((slope,))), g)


def test_a_scale_s_derivatives_are_those_of_a_closed_form():
    """r = A (M v) has the Jacobian A whatever the kind; at a direction of symmetry, an even r has none across it."""
    A = np.array([[3.0, 1.0, 0.0], [0.0, 2.0, 0.5], [1.0, 0.0, 4.0]])
    field = act("scale", (0.6, -0.64, 0.48), 0.9)
    _, jacobian = make_evaluator(Linear(A, np.ones(3))).jacobian(field)
    np.testing.assert_allclose(jacobian, A, atol=0.02)

    evaluator = make_evaluator(Linear(A, np.ones(3)))
    _, by_strength = evaluator.jacobian(field, Parametrisation(field, 11, directions=False))
    np.testing.assert_allclose(by_strength, A @ np.asarray(field.actions[0].vector)[:, None], atol=1e-6)
    assert evaluator.spent == 1 + 1

    class Even(Linear):
        def replay(self, rollout, parameters):
            return np.array([pushes(parameters)[0], 0.0]) - self.b

    evaluator = make_evaluator(Even(A[:2], np.array([1.0, 0.0])))
    score, jacobian = evaluator.jacobian(act("scale", (1, 0, 0), 0.4))
    np.testing.assert_allclose(jacobian, [[1, 0, 0], [0, 0, 0]], atol=1e-9)
    assert evaluator.spent == 1 + 5
