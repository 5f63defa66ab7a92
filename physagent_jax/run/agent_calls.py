"""Calls of agents, and what they cost."""

from __future__ import annotations

import time
from collections.abc import Iterable

from physagent_jax.agents.protocols import Agents
from physagent_jax.agents.trace import AgentError, Reply, Trace
from physagent_jax.run.manifest import AgentCost


class AgentCalls:
    """Asks agents, and adds up calls, tokens and seconds.

    Attributes:
        costs: By the agent's role; what earlier processes of the run have spent is in it.
    """

    def __init__(self, agents: Agents, earlier: Iterable[AgentCost] = ()):
        self._agents = agents
        self.costs = {cost.agent: cost for cost in earlier}

    def ask(self, role: str, method: str, *arguments) -> Reply:
        """Call ``method`` of the agent in ``role``.

        Raises:
            AgentError: It has no answer; that call is charged like any other.
        """
        agent, begun = getattr(self._agents, role), time.perf_counter()
        try:
            reply = getattr(agent, method)(*arguments)
        except AgentError as error:
            self._charge(role, error.trace, time.perf_counter() - begun, failed=True)
            what = f"the {role} ({agent.name}) gave no answer: {error.what}"
            raise AgentError(what, trace=error.trace, got=error.got, do=error.do) from error
        self._charge(role, reply.trace, time.perf_counter() - begun)
        return reply

    def _charge(self, role: str, trace: Trace, seconds: float, *, failed: bool = False) -> None:
        cost = self.costs.get(role) or AgentCost(agent=role, implementation=getattr(self._agents, role).name)
        self.costs[role] = cost.model_copy(
            update=dict(
                calls=cost.calls + 1,
                failed_calls=cost.failed_calls + failed,
                input_tokens=cost.input_tokens + trace.input_tokens,
                output_tokens=cost.output_tokens + trace.output_tokens,
                seconds=round(cost.seconds + seconds, 4),
                latency_seconds=round(cost.latency_seconds + trace.latency_seconds, 4),
            )
        )
