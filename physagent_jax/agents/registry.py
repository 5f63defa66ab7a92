"""The agents that a run may choose by name."""

from __future__ import annotations

from typing import TYPE_CHECKING

from physagent_jax.agents.protocols import Agents
from physagent_jax.core.errors import UserError
from physagent_jax.core.registry import Choice, Registry

if TYPE_CHECKING:
    from physagent_jax.chat.base import ChatModel

SEMANTIC = Registry(
    "`agents.semantic`",
    {
        "grammar": "physagent_jax.agents.grammar.semantic:GrammarSemanticAgent",
        "rules": "physagent_jax.agents.grammar.semantic:GrammarSemanticAgent",  # as run specs called it before
        "model": "physagent_jax.agents.llm.semantic:ModelSemanticAgent",
        "both": "physagent_jax.agents.llm.semantic:BothReaders",
    },
)
PLANNER = Registry(
    "`agents.planner`",
    {
        "rules": "physagent_jax.agents.rules.planner:RulePlanner",
        "chat": "physagent_jax.agents.llm.planner:ModelPlanner",
        "both": "physagent_jax.agents.llm.planner:BothPlanners",
    },
)
EXECUTOR = Registry(
    "`agents.executor`",
    {
        "rules": "physagent_jax.agents.rules.executor:RuleExecutor",
        "chat": "physagent_jax.agents.llm.executor:ModelExecutor",
    },
)
ASK_A_MODEL = frozenset({"model", "chat", "both"})
"""Names of the agents that ask a chat model."""


def make_agents(
    semantic: Choice = "grammar",
    planner: Choice = "rules",
    executor: Choice = "rules",
    *,
    model: ChatModel | None = None,
) -> Agents:
    """The agents of these names, with their options; those that ask no model by default.

    Raises:
        UserError: There is no such agent, it has no such options, or it asks a model and there is none.
    """
    chosen = zip((SEMANTIC, PLANNER, EXECUTOR), (semantic, planner, executor))
    return Agents(*(_make(registry, choice, model) for registry, choice in chosen))


def _make(registry: Registry, choice: Choice, model: ChatModel | None):
    name, options = (choice, {}) if isinstance(choice, str) else choice
    if name not in ASK_A_MODEL:
        return registry.make(choice)
    if model is None:
        raise UserError(
            f"{registry.what} {registry.check(name)!r} asks a language model, and none is named",
            do="Name one in `agents.model`, or choose an agent that asks none",
        )
    return registry.make((name, {**options, "model": model}))
