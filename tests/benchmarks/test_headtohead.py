"""The harness of the head-to-head: what a mark says, what is verified, and the page."""

from pathlib import Path

import numpy as np
import pytest

from baselines.protocol import Evaluation, FitResult
from benchmarks.headtohead.__main__ import verify
from benchmarks.headtohead.entrants import ABLATION, ITERATIONS, METHODS
from benchmarks.headtohead.markdown import document
from benchmarks.headtohead.measuring import judge_marks
from physagent_jax.forces.schema import Action, ActionType, ForceField
from physagent_jax.metrics.task_judge import ClauseJudgement, TaskJudgement


def push(magnitude):
    return ForceField(
        actions=(Action(action_type=ActionType.TRANSLATION, vector=(1, 0, 0), magnitude=magnitude),)
    )


class Spec:
    """As much of a task's definition as is looked at."""

    target_hash = "abc"


class World:
    """A task that M = 1 solves; everything beyond M = 1.5 cannot be simulated."""

    frame_dt, spec = 0.04, Spec()

    def __init__(self):
        self.simulated = 0

    def simulate(self, field):
        self.simulated += 1
        return np.full((2, 1, 3), field.actions[0].magnitude)

    def build(self, field):
        from types import SimpleNamespace

        return SimpleNamespace(model=SimpleNamespace(forces=(), constraints=(), mass=np.ones(1)))

    def judge(self, x):
        error = abs(float(x[0, 0, 0]) - 1.0) / 0.1
        clause = ClauseJudgement("distance", 0.0, 0.0, 1.0, "lengths", 1.0 - error)
        return TaskJudgement(error <= 1, error, (clause,))


def fitted(*tried):
    made = tuple(Evaluation(push(m), spent, spent, objective) for m, spent, objective in tried)
    return FitResult("x", "t", 0, push(0.4), made, False, made[-1].spent if made else 0.0, 1.0)


def test_a_mark_is_judged_by_what_the_method_itself_held_for_best():
    """Not by the best that it ever tried; before anything is tried, by the task's start; each field once."""
    task = World()
    result = fitted((1.0, 2.0, 5.0), (0.7, 4.0, 1.0), (0.6, 6.0, 3.0))
    rows = judge_marks(result, task, (1.0, 3.0, 10.0, 30.0))
    assert [row["success"] for row in rows] == [False, True, False, False]
    assert rows[0]["error"] == pytest.approx(6.0) and rows[2]["error"] == pytest.approx(3.0)
    assert task.simulated == 3


def test_a_stored_field_is_verified_against_target_and_simulation():
    task = World()
    (mark,) = judge_marks(fitted((1.0, 1.0, 0.0)), task, (10.0,))
    row = {"job": "j", "target_hash": "abc", "marks": [mark]}
    assert verify(row, task)[0]["good"]
    assert not verify(row | {"target_hash": "abd"}, task)[0]["good"]
    assert not verify(row | {"marks": [mark | {"error": 0.5}]}, task)[0]["good"]
    assert not verify(row | {"marks": [mark | {"success": False}]}, task)[0]["good"]


def test_every_entrant_can_be_made_and_oracles_are_named():
    for entrants in (METHODS, ABLATION, ITERATIONS):
        assert len({entrant.label for entrant in entrants}) == len(entrants)
    oracles = {entrant.label: entrant.make().oracle for entrant in METHODS}
    assert not oracles["physagent"] and not oracles["physsplat_f"] and oracles["adam, all types"]


def test_the_page_has_success_cost_and_pairs():
    def make_row(label, oracle, success):
        marks = [
            {"mark": 1.0, "success": False, "error": 4.0},
            {"mark": 10.0, "success": success, "error": 0.5},
        ]
        row = {"run": 0, "label": label, "task": "drop-a", "family": "drop", "seed": 0, "oracle": oracle}
        return row | {"marks": marks, "spent": 9.0, "seconds": 2.0, "memory_gb": None, "evaluations": 9}

    run = {
        "quick": True,
        "seconds": 3.0,
        "command": "c",
        "machine": "m",
        "load_average": [0.1],
        "git_revision": "r",
    }
    rows = [make_row("physagent", False, True), make_row("adam", True, False)]
    page = document(
        {"methods": {"runs": [run], "complete": True, "rows": rows}}, Path("a.json"), Path("b.md")
    )
    assert "| adam (oracle) | 0% of 1 | 0 % (0–0) |" in page
    assert "| physagent | 0 % (0–0) | 100 % (100–100) |" in page
    assert "Not measured yet: ablation, iterations, verify" in page and "Against physagent" in page
