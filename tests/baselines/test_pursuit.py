"""Further actions explain the remainder, and the worst clause counts more: on bodies with a closed form."""

from functools import partial

import numpy as np
import pytest

from baselines.evaluation import Evaluator
from baselines.methods import make_method
from baselines.misses import GOOD, Score, sharpen
from baselines.pursuit import describe, extend, grow, try_more
from baselines.responses import measure_responses
from baselines.structures import Ranking
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import Action, ActionType, ForceField
from physagent_jax.metrics.targets import Distance, Stretch
from physagent_jax.metrics.task_judge import ROOM
from tests.baselines import analytic
from tests.baselines.test_responses import FRAMES, Body, go, make_evaluator
from tests.baselines.tiny import act

pytestmark = pytest.mark.usefixtures("module_least_optimised")  # a program for each target, of 30 particles

PUSH = Action(action_type=ActionType.TRANSLATION, vector=(1, 0, 0), magnitude=0.8)


@pytest.fixture(scope="module")
def begun():
    """A push that does half of what is asked for, and its paths."""
    wider = Stretch(window=(0, 12), along=(0, 1, 0), target=0.15, tolerance=0.05)
    evaluator, see = make_evaluator(go(1, (0, 12), 0.4), wider)
    ranking, field = Ranking(evaluator), ForceField(actions=(PUSH,))
    return evaluator, see, ranking, field, evaluator.watch(field)


def test_what_explains_the_rest_is_added_and_costs_nothing(begun):
    evaluator, see, ranking, field, x = begun
    spent = evaluator.spent
    found = extend(evaluator, ranking, field, x)
    assert evaluator.spent == spent
    first, second = found[0].actions
    assert first.action_type is ActionType.TRANSLATION and second.action_type is ActionType.SCALE
    assert abs(second.vector[1]) == 1 and not see(field).success and see(found[0]).success


def test_additions_are_of_different_kinds_and_none_is_simulated_twice_or_kept_that_tears(begun):
    evaluator, _, ranking, field, x = begun
    found = extend(evaluator, ranking, field, x)
    assert len({describe(each) for each in found}) == len(found)
    spent, good = evaluator.spent, found[0]
    tears = field.model_copy(update=dict(actions=(PUSH.model_copy(update=dict(magnitude=1.6)),) * 3))
    loss = evaluator.score(good).loss + 0.1
    assert try_more(evaluator, [tears, good], loss) == [good] and evaluator.spent == spent + 2
    assert try_more(evaluator, [tears, good], loss) == [good] and evaluator.spent == spent + 2


def test_where_nothing_is_left_nothing_is_added(begun):
    evaluator, _, ranking, field, x = begun
    solved = extend(evaluator, ranking, field, x)[0]
    assert extend(evaluator, ranking, solved, evaluator.watch(solved)) == []


def test_the_best_start_grows_before_anything_descends(begun):
    evaluator, see, ranking, field, _ = begun
    idle = ForceField(actions=(PUSH.model_copy(update=dict(vector=(0, 0, -1), magnitude=0.4)),))
    grown = grow(evaluator, ranking, [idle, field], GOOD)
    assert see(grown[0]).success and len(grown[0].actions) == 2 and grown[-2:] == [field, idle]


class Replayed(Body):
    """Can be differentiated by differences."""

    def simulate(self, force_field):
        rollout = super().simulate(force_field)
        rollout.field = force_field
        return rollout

    def replay(self, rollout, parameters):
        return self.compute_residuals(self.simulate(parameters.to_force_field(rollout.field, FRAMES)))


def test_four_blows_are_found_one_after_the_other():
    """No combination that is tried at first has four; the third and the fourth explain what two or three leave."""
    ways = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0))
    windows = ((0, 3), (3, 6), (6, 9), (9, 12))
    clauses = [go(1, window, 0.25, along) for window, along in zip(windows, ways)]
    others = ((0, 1, 0), (0, 0, 1), (-1, 0, 0), (0, 1, 0))
    clauses += [
        Distance(window=window, along=along, when="peak", target=0.0, tolerance=0.1)
        for window, along in zip(windows, others)
    ]
    evaluator, see = make_evaluator(*clauses, budget=150)
    evaluator = Evaluator(evaluator.task, evaluator.budget, simulation=Replayed(evaluator.task.target))  # type: ignore[arg-type]
    options = dict(types="responses", numbers="responses", starts=2, hops=0)
    result = make_method("levenberg_marquardt", options).finish(evaluator)
    assert see(result.incumbent_at()).success and len(result.incumbent_at().actions) >= 4
    notes = [each.note for each in result.evaluations]
    assert notes.index("an action more") < min(notes.index("trial") if "trial" in notes else len(notes), 40)


class Weak(Body):
    """Fails under pushes of more than half of the clip, and under every blow along x."""

    def simulate(self, force_field):
        for action in force_field.actions:
            first, last = action.active_time or (0, 12)
            if action.action_type == "translation" and last - first > 6:
                raise UserError("it flew apart")
            if action.action_type == "impulse" and action.vector[0] > 0.9:
                raise UserError("it flew apart")
        return super().simulate(force_field)


def test_a_response_that_fails_is_that_of_a_shorter_time_again_and_again():
    """Push add up in time, so the response is the whole one; it is charged, and what it is for is on the record."""
    (evaluator, _), (other, _) = (make_evaluator(go(1, (0, 12), 0.4)) for _ in range(2))
    other = Evaluator(other.task, other.budget, simulation=Weak(other.task.target))  # type: ignore[arg-type]
    whole, found = measure_responses(evaluator), measure_responses(other)
    push = ActionType.TRANSLATION, (None, None)
    np.testing.assert_allclose(found.steps[push], whole.steps[push], atol=1e-4)
    assert np.abs(found.steps[push]).max() > 0.2 and other.spent == evaluator.spent + 3
    assert sum("shorter time" in each.note for each in other.evaluations) == 3
    blow = found.steps[ActionType.IMPULSE, (None, None)]
    assert not blow[0].any() and blow[1].any()


class Deaf(Replayed):
    """Fails under everything but what is not weak."""

    def simulate(self, force_field):
        if min((abs(action.magnitude) for action in force_field.actions), default=1.0) < 0.41:
            raise UserError("it flew apart")
        return super().simulate(force_field)


def test_where_nothing_answers_a_search_begins_beside_the_task_s_own():
    options = dict(types="responses", numbers="responses", starts=2)
    result = make_method("levenberg_marquardt", options).finish(make_deaf())
    assert not measure_responses(make_deaf()).steps
    assert result.find_incumbent().objective <= GOOD


def make_deaf():
    """An evaluator that has spent nothing."""
    evaluator, _ = make_evaluator(go(1, (0, 12), 0.4))
    return Evaluator(evaluator.task, evaluator.budget, simulation=Deaf(evaluator.task.target))  # type: ignore[arg-type]


def test_a_fall_that_helps_hardly_is_not_taken_for_what_is_asked_for():
    down = partial(Distance, window=(0, 12), along=(0, 0, -1))
    for clauses, fall in (
        ([go(1, (0, 12), 0.8), down(target=40.0, tolerance=13.0)], False),
        ([down(target=2.0, tolerance=0.5)], True),
    ):
        evaluator, _ = make_evaluator(*clauses)
        assert measure_responses(evaluator).drop is fall


def test_what_sinks_evenly_is_found_beside_a_fall_that_is_nearer_than_nothing():
    """The fall is late at first and goes too far; a blow down does better without it, and both are looked at.

    Not above the ground, where superposition from rest would pass through it.
    """
    sink = partial(Distance, along=(0, 0, -1))
    clauses = (
        sink(window=(0, 6), target=0.75, tolerance=0.2),
        sink(window=(0, 12), target=1.5, tolerance=0.3),
    )
    for smooth in (False, True):
        evaluator, see = make_evaluator(*clauses, smooth=smooth)
        found = measure_responses(evaluator)
        assert found.drop and (found.rest is not None) is smooth
        ranking = Ranking(evaluator)
        falls = {field.default_drop for field in ranking.fields}
        assert falls == ({True, False} if smooth else {True})
        assert not see(ForceField(default_drop=True)).success
    best = ranking.take(4)  # of the smooth one
    assert any(not field.default_drop and see(field).success for field in best)


def test_the_worst_counts_more_and_what_the_judge_is_content_with_does_not_get_worse():
    r = np.array([-0.25, 0.5, 2.0])
    np.testing.assert_allclose(sharpen(r, 3), [-0.0625, 0.5, 32.0])
    assert sharpen(r, 1) is r
    for power in (1, 3):
        assert Score.of(r, power).find_objective(power) == pytest.approx(0.5 * r @ r)
    content = np.full(6, 0.9 * ROOM)
    assert Score.of(content).loss > GOOD == pytest.approx(Score.of(content, 3).find_objective(3))


def test_within_sharpened_a_search_makes_the_greatest_miss_small():
    """r = (u, u, u - 3): squares are least at u = 1 with a miss of 2; sixth powers where 2 u^5 = (3 - u)^5."""
    A, b = np.zeros((3, 3)), np.array([0.0, 0.0, 2.4])
    A[:, 0] = 1.0
    start, best = act("translation", (1.0, 0.0, 0.0), 0.6), 2.4 / (1 + 2**0.2)
    method = make_method("levenberg_marquardt", dict(hops=0))
    found = []
    for power in (1, 3):
        evaluator = analytic.make_evaluator(analytic.Linear(A, b), start)
        with evaluator.sharpened(power):
            for _ in method.descend(evaluator, start, 100.0):
                pass
        field = evaluator.evaluations[-1].force_field
        found.append(field.actions[0].magnitude * field.actions[0].vector[0])
    assert found == pytest.approx([0.8, best], abs=0.02)
