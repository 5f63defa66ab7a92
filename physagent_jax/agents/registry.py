"""The agents that a run may choose by name."""

from __future__ import annotations

from physagent_jax.agents.protocols import Agents
from physagent_jax.core.registry import Choice, Registry

SEMANTIC = Registry("`agents.semantic`", {"rules": "physagent_jax.agents.rules.semantic:RuleSemanticAgent"})
PLANNER = Registry("`agents.planner`", {"rules": "physagent_jax.agents.rules.planner:RulePlanner"})
EXECUTOR = Registry("`agents.executor`", {"rules": "physagent_jax.agents.rules.executor:RuleExecutor"})


def make_agents(semantic: Choice = "rules", planner: Choice = "rules", executor: Choice = "rules") -> Agents:
    """The agents of these names; the offline rules by default.

    Raises:
        UserError: There is no such agent, the package that it needs is missing, or it has no such options.
    """
    return Agents(SEMANTIC.make(semantic), PLANNER.make(planner), EXECUTOR.make(executor))
