"""The agents that a run may choose by name."""

from __future__ import annotations

from physagent_jax.agents.protocols import Agents
from physagent_jax.core.registry import Choice, Registry

_GRAMMAR = "physagent_jax.agents.grammar.semantic:GrammarSemanticAgent"
SEMANTIC = Registry(
    "`agents.semantic`", {"grammar": _GRAMMAR, "rules": _GRAMMAR}
)  # "rules" in older run specs
PLANNER = Registry("`agents.planner`", {"rules": "physagent_jax.agents.rules.planner:RulePlanner"})
EXECUTOR = Registry("`agents.executor`", {"rules": "physagent_jax.agents.rules.executor:RuleExecutor"})


def make_agents(semantic: Choice = "rules", planner: Choice = "rules", executor: Choice = "rules") -> Agents:
    """The agents of these names; the offline rules by default.

    Raises:
        UserError: There is no such agent, the package that it needs is missing, or it has no such options.
    """
    return Agents(SEMANTIC.make(semantic), PLANNER.make(planner), EXECUTOR.make(executor))
