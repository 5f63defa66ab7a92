"""Starts by superposed responses, on a body of which the motion under every force field is known in closed form."""

from types import SimpleNamespace

import numpy as np
import pytest

from baselines.evaluation import Evaluator
from baselines.methods import make_method
from baselines.protocol import Budget
from baselines.responses import (
    BLOW_LENGTH,
    END_SKILLS,
    SKILLS,
    WRING,
    list_changes,
    list_places,
    make_end,
    measure_responses,
)
from baselines.starts import share
from baselines.structures import WEAKER, find_starts, list_structures, pick, weaken
from baselines.tasks import START
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import Action, ActionType, ForceField, HalfSpaceRegion
from physagent_jax.metrics.targets import Distance, Stretch, Target, Turn
from physagent_jax.metrics.task_judge import compute_residuals, judge

pytestmark = pytest.mark.usefixtures("module_least_optimised")  # a program for each target, of 30 particles

FRAMES = 13
WHOLE = 1 + 3 * len(SKILLS)  # simulations: a fall, and each skill along each axis
REST = np.random.default_rng(0).uniform(0.0, 1.0, (30, 3)).astype(np.float32)
MASS = np.ones(30)


class Body:
    """Floats; pushes accelerate it, blows set it off, stretches are followed at once; the fall is a push downwards."""

    def __init__(self, target):
        self.target = target

    def simulate(self, force_field):
        t = np.arange(FRAMES)[:, None, None] / (FRAMES - 1)
        x = np.repeat(REST[None], FRAMES, axis=0).astype(np.float64)
        if force_field.default_drop:
            x += t**2 * np.array([0.0, 0.0, -2.0])
        for action in force_field.actions:
            first, last = (frame / (FRAMES - 1) for frame in action.active_time or (0, FRAMES - 1))
            push, v = action.magnitude * np.asarray(action.vector), np.asarray(action.vector)
            inside = np.clip(t - first, 0.0, last - first)
            if action.action_type == "impulse":
                x += np.maximum(t - first, 0.0) * push
            elif action.action_type == "translation":
                x += (0.5 * inside**2 + inside * np.maximum(t - last, 0.0)) * push
            elif action.action_type == "scale":
                acts = (t > first) & (t <= last)
                x += 0.15 * action.magnitude * acts * ((REST - 0.5) @ v)[None, :, None] * v
            else:
                x += 0.5 * inside**2 * np.cross(push, REST - 0.5)[None]
        return SimpleNamespace(x=x)

    def compute_residuals(self, rollout):
        return np.asarray(compute_residuals(self.target, rollout.x, MASS, 0.04))


def make_evaluator(*clauses, budget=60.0, start=START, smooth=False):
    target = Target(clauses=clauses)
    task = SimpleNamespace(
        spec=SimpleNamespace(name="body", expert=None, smooth=smooth),
        target=target,
        start=start,
        frame_count=FRAMES,
        frame_dt=0.04,
        mass=MASS,
    )
    evaluator = Evaluator(task, Budget(budget), simulation=Body(target))  # type: ignore[arg-type]
    return evaluator, lambda field: judge(target, Body(target).simulate(field).x, MASS, 0.04)


def go(way, window, target, along=(1, 0, 0)):
    return Distance(window=window, along=along, target=way * target, tolerance=target / 4)


def test_there_and_back_takes_two_actions_at_the_times_of_the_target():
    evaluator, see = make_evaluator(go(1, (0, 6), 0.4), go(-1, (6, 12), 0.4), go(1, (0, 2), 0.12))
    fields = find_starts(evaluator, 3)
    assert see(fields[0]).success and evaluator.spent == WHOLE + len(fields)  # each is scored
    assert [action.active_time[0] for action in fields[0].actions] == [0, 6]
    assert {action.action_type for action in fields[0].actions} == {ActionType.IMPULSE}
    assert len({field.model_dump_json() for field in fields}) == 3


def test_one_action_is_preferred_where_one_is_enough():
    evaluator, see = make_evaluator(Stretch(window=(0, 12), along=(0, 1, 0), target=0.15, tolerance=0.05))
    field = find_starts(evaluator, 1)[0]
    (action,) = field.actions
    assert action.action_type is ActionType.SCALE and abs(action.vector[1]) == 1 and see(field).success


def test_what_falls_is_what_actions_are_added_to():
    down = Distance(window=(0, 12), along=(0, 0, -1), target=2.0, tolerance=0.2)
    evaluator, see = make_evaluator(down, go(1, (0, 12), 0.8))
    field = find_starts(evaluator, 1)[0]
    assert field.default_drop and len(field.actions) == 1 and see(field).success


def test_ends_are_those_that_the_target_speaks_of():
    top = Distance(window=(0, 12), part=(0, 0, 1), along=(1, 0, 0), target=0.4, tolerance=0.1)
    evaluator, _ = make_evaluator(top, budget=70)
    regions = {slot.region for structure in list_structures(evaluator) for _, slot in structure}
    assert regions == {None, make_end((0.0, 0.0, 1.0))}
    region = make_end((0.0, 0.0, 1.0))
    assert isinstance(region, HalfSpaceRegion)
    assert region.point == pytest.approx((0.5, 0.5, 2 / 3))
    find_starts(evaluator, 1)
    assert evaluator.spent == WHOLE + 3 * len(END_SKILLS) + 1  # and the start
    poor, _ = make_evaluator(top, budget=40)
    find_starts(poor, 1)
    assert poor.spent == WHOLE + 1  # an end is too dear: 40 % of the budget are 16


def test_ends_are_turned_against_each_other_where_that_is_asked_for():
    """Both by one vector, one each way, held to the end: three simulations more, and not one for each end alone."""
    twist = Turn(window=(0, 12), part=(0, 0, 1), against=(0, 0, -1), axis=(0, 0, 1), target=40, tolerance=10)
    evaluator, _ = make_evaluator(twist, budget=50)
    responses = measure_responses(evaluator)
    ends = make_end((0.0, 0.0, 1.0)), make_end((0.0, 0.0, -1.0))
    assert (WRING, ends) in responses.steps and evaluator.spent == WHOLE + 3
    fields = [each.force_field for each in evaluator.evaluations if each.force_field.constraints]
    assert len(fields) == 3
    for field in fields:
        one, other = field.constraints
        assert (one.region, other.region) == ends and one.held_until == other.held_until == FRAMES - 1
        np.testing.assert_allclose(one.vector, -np.asarray(other.vector))


def test_an_end_is_stretched_only_where_its_length_is_spoken_of():
    top, left = (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0)
    taller = Stretch(window=(0, 12), part=top, along=(0, 0, 1), target=0.15, tolerance=0.05)
    evaluator, _ = make_evaluator(taller, Distance(window=(0, 12), part=left, target=0.4, tolerance=0.1))
    scaled = {slot.region: ActionType.SCALE in skills for slot, skills in list_places(evaluator)}
    assert scaled == {None: True, make_end(top): True, make_end(left): False}


def test_changes_are_apart_and_blows_short():
    evaluator, _ = make_evaluator(go(1, (0, 2), 0.1), go(1, (4, 12), 0.1), go(1, (0, 5), 0.1))
    assert list_changes(evaluator) == [4]
    for structure in list_structures(evaluator):
        for skill, slot in structure:
            assert slot.first < slot.last
            assert skill is not ActionType.IMPULSE or slot.last - slot.first <= BLOW_LENGTH


def test_a_local_method_begins_with_them_and_needs_their_types_too():
    evaluator, see = make_evaluator(go(1, (0, 6), 0.4), go(-1, (6, 12), 0.4), budget=30)
    result = make_method(
        "levenberg_marquardt", dict(types="responses", numbers="responses", starts=2)
    ).finish(evaluator)
    assert see(result.incumbent_at()).success
    with pytest.raises(UserError, match="types=responses"):
        make_method("adam", dict(numbers="responses"))


def test_the_task_s_own_windows_and_regions_are_tried_with_all_skills():
    region = make_end((1.0, 0.0, 0.0))
    action = Action(action_type="scale", vector=(1, 0, 0), active_time=(3, 9), region=region)  # type: ignore[arg-type]
    evaluator, _ = make_evaluator(go(1, (0, 12), 0.3), start=ForceField(actions=(action,)))
    mine = [s for s in list_structures(evaluator) if len(s) == 1 and s[0][1].first == 3]
    assert {skill for ((skill, _),) in mine} == {name for name in ActionType if name.skill.superposes}
    assert all(s[0][1].region == region for s in mine)


class Brittle(Body):
    """Flies apart under what is stronger than 0.6."""

    def simulate(self, force_field):
        rollout = super().simulate(force_field)
        strongest = max((abs(action.magnitude) for action in force_field.actions), default=0.0)
        rollout.x[1:] += 50.0 * (strongest > 0.6)
        return rollout


@pytest.mark.parametrize(
    "given, kept, paid", [(1.6, 1.6 * WEAKER**3, 3), (0.8, 0.8 * WEAKER, 2), (0.5, 0.5, 1)]
)
def test_what_tears_is_made_weaker_until_it_does_better_than_nothing(given, kept, paid):
    target = Target(clauses=(go(1, (0, 12), 0.3),))
    task = SimpleNamespace(target=target, frame_count=FRAMES, frame_dt=0.04, mass=MASS)
    evaluator = Evaluator(task, Budget(20), simulation=Brittle(target))  # type: ignore[arg-type]
    push = Action(action_type=ActionType.TRANSLATION, vector=(1, 0, 0), magnitude=-given)
    idle = evaluator.score(ForceField()).loss
    found = weaken(evaluator, ForceField(actions=(push.model_copy(update=dict(magnitude=given)),)), idle)
    assert found.actions[0].magnitude == pytest.approx(kept) and evaluator.spent == 1 + paid
    wrong = weaken(evaluator, ForceField(actions=(push,)), idle)
    assert wrong.actions[0].magnitude < 0 and abs(wrong.actions[0].magnitude) >= 0.4


def test_half_of_the_starts_at_most_have_as_many_actions_where_others_have_more():
    push = Action(action_type=ActionType.TRANSLATION, vector=(1, 0, 0), magnitude=0.4)
    one = [ForceField(actions=(push.model_copy(update=dict(magnitude=m)),)) for m in (0.5, 0.6, 0.7, 0.8)]
    two = ForceField(actions=(push, push))
    assert pick([*one, two], 4) == [*one[:3], two]
    assert pick([*one, two], 1) == one[:1] and pick(one, 3) == one[:3]


def test_a_start_that_was_scored_is_not_paid_for_again():
    evaluator, _ = make_evaluator(go(1, (0, 12), 0.3))
    push = Action(action_type=ActionType.TRANSLATION, vector=(1, 0, 0), magnitude=0.4)
    starts = [ForceField(actions=(push,)), ForceField(default_drop=True, actions=(push,))]
    evaluator.score(starts[0])
    share(evaluator, starts, lambda *_: iter([1.0]), lambda _: 1.0)
    assert evaluator.spent == 2
