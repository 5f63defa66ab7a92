"""The three agents of the loop as protocols; offline rules and language models implement them alike."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Protocol

from physagent_jax.agents.schema import ExpectedMotion, Judgement, Rewrite, SceneBrief, SemanticReply
from physagent_jax.forces.schema import ForceField
from physagent_jax.perception.schema import MotionReport


class SemanticAgent(Protocol):
    """Compiles a sentence into a force field (paper, section 3.2)."""

    def compile(self, prompt: str, brief: SceneBrief) -> SemanticReply:
        """Reads ``prompt`` for the scene in ``brief``.

        Raises:
            UserError: The prompt is empty or nothing in it can be understood.
        """
        ...


class PlannerAgent(Protocol):
    """Judges the seen motion against the sentence (paper, appendix B.2, phase 1)."""

    def judge(
        self,
        prompt: str,
        expectations: Sequence[ExpectedMotion],
        report: MotionReport,
        force_field: ForceField,
        brief: SceneBrief,
    ) -> Judgement:
        """Compares ``report`` with what ``prompt`` asked for."""
        ...


class ExecutorAgent(Protocol):
    """Rewrites the force field under the hard rules (paper, appendix B.2, phase 2)."""

    def rewrite(
        self,
        prompt: str,
        expectations: Sequence[ExpectedMotion],
        force_field: ForceField,
        report: MotionReport,
        judgement: Judgement,
        brief: SceneBrief,
        history: Sequence[tuple[ForceField, Judgement]] = (),
    ) -> Rewrite:
        """Returns the next force field; ``history`` holds the earlier attempts, oldest first."""
        ...


@dataclasses.dataclass(frozen=True)
class Agents:
    """The three agents of a loop."""

    semantic: SemanticAgent
    planner: PlannerAgent
    executor: ExecutorAgent
