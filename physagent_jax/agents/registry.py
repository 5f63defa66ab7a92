"""The agents that a run may choose by name."""

from __future__ import annotations

from physagent_jax.core.registry import Registry

SEMANTIC = Registry("`agents.semantic`", {"rules": "physagent_jax.agents.rules.semantic:RuleSemanticAgent"})
PLANNER = Registry("`agents.planner`", {"rules": "physagent_jax.agents.rules.planner:RulePlanner"})
EXECUTOR = Registry("`agents.executor`", {"rules": "physagent_jax.agents.rules.executor:RuleExecutor"})
