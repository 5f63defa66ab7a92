"""The agents with the answer at hand: the judge's clauses as the planner's checks."""

from types import SimpleNamespace

import pytest

from baselines.methods import make_method
from baselines.privileged import TrueSight, find_expectation, make_check
from baselines.protocol import Budget
from physagent_jax.metrics.targets import Distance, Integrity, Stretch, Turn
from physagent_jax.metrics.task_judge import ClauseJudgement
from physagent_jax.motion.schema import ExpectedMotion, MotionKind, Verdict
from tests.baselines.tiny import act, play

LEFT = ExpectedMotion(kind=MotionKind.MOVE, direction=(-1, 0, 0), window=(0, 12))
UP = ExpectedMotion(kind=MotionKind.MOVE, direction=(0, 0, 1), window=(12, 24))
SPIN = ExpectedMotion(kind=MotionKind.ROTATE, direction=(0, 0, 1), window=(0, 24))


def move(along, window, target=0.5):
    return Distance(window=window, along=along, target=target, tolerance=0.1)


def test_a_clause_belongs_to_the_motion_of_its_kind_and_way_and_time():
    expected = (LEFT, UP, SPIN)
    assert find_expectation(move((-1, 0, 0), (0, 12)), expected) == 0
    assert find_expectation(move((0, 0, 1), (0, 24)), expected) == 1
    assert find_expectation(Turn(window=(0, 24), axis=(0, 0, 1), target=45, tolerance=10), expected) == 2
    assert find_expectation(move((-1, 0, 0), (13, 24), target=0.0), expected) == 1  # unasked: by time alone
    assert find_expectation(Stretch(window=(0, 9), target=0.2, tolerance=0.05), ()) == 0


def test_a_miss_says_by_which_factor_to_change_the_cause():
    def check(clause, seen, wanted, tolerance=0.1):
        margin = 1 - abs(seen - wanted) / tolerance
        return make_check(clause, ClauseJudgement("d", seen, wanted, tolerance, "", margin), 1)

    asked, unasked = move((1, 0, 0), (0, 9)), move((0, 1, 0), (0, 9), target=0.0)
    low = check(asked, 0.25, 0.5)
    assert low.passed is False and low.aspect == "amount" and low.gain == pytest.approx(2.0)
    assert check(asked, -0.5, 0.5).gain == pytest.approx(-1.0)
    assert check(asked, 0.0, 0.5).gain == 10.0
    assert check(asked, 0.45, 0.5).passed and check(asked, 0.45, 0.5).gain is None
    beside = check(unasked, -0.4, 0.0)
    assert beside.aspect == "collateral" and beside.gain == pytest.approx(0.25)
    assert check(Integrity(window=(0, 9)), 0.05, 0.0, 0.01).aspect == "integrity"


def test_the_verdict_is_the_judge_s_and_no_picture_is_looked_at(tiny):
    context = SimpleNamespace(expectations=(LEFT,))
    sight = TrueSight(tiny)

    class Door:
        def watch(self, field, note):
            return play(tiny.build, field)

    verdicts = []
    for field in (tiny.spec.hidden, act("translation", (0.3, 0.5, 0.1), 0.8)):
        seen = sight.look(Door(), field, "", [(0, 7)])  # type: ignore[arg-type]
        assert seen is not None and not seen.key_frames.pick()
        verdicts.append(sight.judge(context, seen).value.verdict)  # type: ignore[arg-type]
    assert verdicts == [Verdict.SUCCESS, Verdict.FAIL]
    result = make_method("rules", dict(privileged=True, rounds=2)).fit(tiny, Budget(2))
    assert result.oracle and result.evaluations[0].objective <= 0 and result.spent <= 2
