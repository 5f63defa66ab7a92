"""The agents with the answer at hand: what perception and planner cost them is what is lost without it.

The motion report is that of the true particles, and the verdict is the task's judge's: its clauses, with their margins,
take the place of the planner's checks. The executor is the product's own and reads both as it always does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from baselines.agents import Sight
from baselines.evaluation import Evaluator
from baselines.tasks import Task
from physagent_jax.agents.context import AgentContext, KeyFrame, Observation
from physagent_jax.agents.protocols import Agents, PlannerAgent
from physagent_jax.agents.registry import make_agents
from physagent_jax.agents.trace import Reply
from physagent_jax.forces.schema import ForceField
from physagent_jax.metrics import report_true_motion
from physagent_jax.metrics.targets import Clause, Target
from physagent_jax.metrics.task_judge import ClauseJudgement, judge
from physagent_jax.motion.schema import Check, ExpectedMotion, Judgement, MotionKind, Verdict

_KINDS = {
    "direction": (MotionKind.MOVE, MotionKind.FALL),
    "distance": (MotionKind.MOVE, MotionKind.FALL, MotionKind.SWAY),
    "path": (MotionKind.MOVE, MotionKind.FALL),
    "oscillation": (MotionKind.SWAY,),
    "turn": (MotionKind.ROTATE,),
    "stretch": (MotionKind.STRETCH, MotionKind.SQUEEZE),
    "rest": (MotionKind.STILL,),
}
_ASPECTS = {"direction": "direction", "order": "order", "rest": "stillness", "integrity": "integrity"}
_LARGEST_GAIN = 10.0  # as the planner's own


class NoPictures:
    """Implements `agents.context.KeyFrames` where nothing is rendered."""

    def pick(self, most: int = 6) -> tuple[KeyFrame, ...]:
        """None."""
        del most
        return ()


class TrueSight(PlannerAgent, Sight):
    """Looks at true particles, and judges by the task's own target."""

    def __init__(self, task: Task):
        self._task, self._x = task, np.zeros((0, 0, 3))
        self._agents = make_agents()

    def make_agents(self) -> Agents:
        """The product's agents with this planner."""
        return Agents(self._agents.semantic, self, self._agents.executor)

    def windows(self, context: AgentContext) -> Sequence[tuple[int, int]]:
        """Those of the product's planner."""
        return self._agents.planner.windows(context)

    def look(
        self, evaluator: Evaluator, field: ForceField, note: str, windows: Sequence[tuple[int, int]]
    ) -> Observation | None:
        """As `Sight.look`, for the price of a simulation."""
        x = evaluator.watch(field, note)
        if x is None:
            return None
        self._x = x
        camera = self._task.build(field).camera
        report = report_true_motion(x, frame_dt=self._task.frame_dt, camera=camera, windows=windows)
        return Observation(field, report, NoPictures())

    def judge(self, context: AgentContext, seen: Observation) -> Reply[Judgement]:
        """The clauses of the target as checks of the expectations that they are about."""
        del seen
        checks = []
        for clause in self._task.target.clauses:
            index = find_expectation(clause, context.expectations)
            alone = judge(Target(clauses=(clause,)), self._x, self._task.mass, self._task.frame_dt)
            checks += [make_check(clause, found, index) for found in alone.clauses]
        success = all(check.passed for check in checks)
        mean = sum(check.score for check in checks) / len(checks)
        judgement = Judgement(
            verdict=Verdict.SUCCESS if success else Verdict.FAIL,
            score=mean if success else min(mean, 0.99),
            checks=tuple(checks),
            suggestion="; ".join(check.question for check in checks if not check.passed),
        )
        return Reply(judgement)


def find_expectation(clause: Clause, expectations: Sequence[ExpectedMotion]) -> int:
    """The expectation that a clause is most likely about: by its kind, then by direction and window; 0 if none."""
    wanted = _KINDS.get(clause.kind, ())
    if getattr(clause, "target", None) == 0.0:
        wanted = ()  # what nobody asked for comes with whatever happens then
    direction = next(
        (value for name in ("along", "axis", "toward") if (value := getattr(clause, name, None)) is not None),
        None,
    )

    def rate(item: tuple[int, ExpectedMotion]) -> tuple[bool, float]:
        expectation = item[1]
        first = max(clause.window[0], expectation.window[0])
        last = min(clause.window[1], expectation.window[1])
        overlap = max(0.0, last - first) / (clause.window[1] - clause.window[0])
        along = 0.0
        if direction is not None and expectation.direction is not None and wanted:
            along = abs(float(np.dot(direction, expectation.direction)))
        return expectation.kind in wanted, along + overlap

    return max(enumerate(expectations), key=rate)[0] if expectations else 0


def make_check(clause: Clause, found: ClauseJudgement, index: int) -> Check:
    """A number of a clause as the planner would say it, with the factor on the cause that would mend it."""
    unasked = found.wanted == 0.0 and clause.kind not in _ASPECTS
    aspect = "collateral" if unasked and clause.kind != "path" else _ASPECTS.get(clause.kind, "amount")
    gain = None
    if found.margin < 0 and aspect in ("amount", "collateral", "integrity") and clause.kind != "path":
        least = 0.1 * found.tolerance
        seen = found.seen if abs(found.seen) > least else math.copysign(least, found.seen or 1.0)
        gain = (found.wanted or found.tolerance) / (abs(seen) if unasked else seen)
        gain = min(max(gain, -_LARGEST_GAIN), _LARGEST_GAIN)
    return Check(
        expectation=index,
        question=found.name,
        expected=f"{found.wanted:.3g} +- {found.tolerance:.3g} {found.unit}",
        observed=f"{found.seen:.3g} {found.unit}",
        passed=found.margin >= 0,
        aspect=aspect,  # pyright: ignore[reportArgumentType]
        score=min(1.0, 1.0 / (1.0 - found.margin)) if found.margin < 0 else 1.0,
        margin=found.margin,
        gain=gain,
    )
