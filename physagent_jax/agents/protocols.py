"""The three agents of the loop as protocols; offline rules and language models implement them alike.

Each is called with one `AgentContext` and returns its answer with a `Trace`. An agent that keeps nothing between calls
lets a stopped run resume anywhere. One that finds no answer raises `AgentError` with the trace until then: the run
keeps that and ends, and the same command asks again.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Protocol

from physagent_jax.agents.context import AgentContext, Observation, Round
from physagent_jax.agents.schema import Rewrite, SemanticReply
from physagent_jax.agents.trace import Reply
from physagent_jax.motion.schema import Judgement


class Agent(Protocol):
    """The base of all roles; agents derive from their role's protocol and so inherit the defaults."""

    @property
    def name(self) -> str:
        """The implementation's name, with its model if it asks one: another name is another run."""
        return type(self).__name__


class SemanticAgent(Agent, Protocol):
    """Compiles a sentence into a force field (paper, section 3.2)."""

    def compile(self, context: AgentContext) -> Reply[SemanticReply]:
        """Read ``context.prompt`` for the scene in ``context.brief``.

        Raises:
            UserError: The prompt is empty or nothing in it can be understood.
            AgentError: There is no answer.
        """
        ...


class PlannerAgent(Agent, Protocol):
    """Judges the seen motion against the sentence (paper, appendix B.2, phase 1)."""

    def windows(self, context: AgentContext) -> Sequence[tuple[int, int]]:
        """Frames (first, last), inclusive, that the motion report should tell apart; none by default.

        The report always holds the whole clip and its quarters.
        """
        return ()

    def watches_ending(self, context: AgentContext) -> bool:
        """Return whether the frames after the planned ones are to be looked at too; not by default."""
        return False

    def judge(self, context: AgentContext, seen: Observation) -> Reply[Judgement]:
        """Compare what was ``seen`` with what ``context.prompt`` asked for.

        Raises:
            AgentError: There is no answer.
        """
        ...


class ExecutorAgent(Agent, Protocol):
    """Rewrites the force field under the hard rules (paper, appendix B.2, phase 2)."""

    def rewrite(self, context: AgentContext, failed: Round) -> Reply[Rewrite]:
        """Mend the force field of the round that has just ``failed``.

        The same force field again means that there is nothing left to try.

        Raises:
            AgentError: There is no answer.
        """
        ...


@dataclasses.dataclass(frozen=True)
class Agents:
    """The three agents of a run."""

    semantic: SemanticAgent
    planner: PlannerAgent
    executor: ExecutorAgent

    @property
    def names(self) -> dict[str, str]:
        """The implementation in each role: part of what a run is, because replies of different agents do not mix."""
        return {role.name: getattr(self, role.name).name for role in dataclasses.fields(self)}
