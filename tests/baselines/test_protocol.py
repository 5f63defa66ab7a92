"""The force field that counts at a stopping point of a fit."""

import math

import pytest

from baselines.protocol import Evaluation, FitResult
from physagent_jax.forces.schema import Action, ActionType, ForceField


def push(magnitude):
    return ForceField(
        actions=(Action(action_type=ActionType.TRANSLATION, vector=(1, 0, 0), magnitude=magnitude),)
    )


def fitted(*objectives):
    made = tuple(
        Evaluation(push(0.5 + 0.1 * i), float(i + 1), 0.0, each) for i, each in enumerate(objectives)
    )
    return FitResult("m", "t", 0, push(0.4), made, False, float(len(made)), 0.0)


@pytest.mark.parametrize(
    ("objectives", "index"),
    [
        ((3.0, 1.0, 2.0), 1),
        ((1.0, 1.0), 0),
        ((None, None), 1),
        ((None, math.inf), 0),
        ((math.inf, None), 1),
        ((math.inf, 5.0, None), 1),
        ((math.inf, math.inf), 1),
    ],
)
def test_the_incumbent_is_the_best_of_what_could_be_simulated(objectives, index):
    """By the method's own objective; the latest where it has none; a failure only where there is nothing else."""
    result = fitted(*objectives)
    assert result.find_incumbent() == result.evaluations[index]


def test_before_anything_is_tried_there_is_the_start():
    result = fitted(1.0)
    assert result.find_incumbent(0.5) is None and result.incumbent_at(0.5) == push(0.4)
