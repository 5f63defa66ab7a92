"""The agents that are asked in the benchmark, each with an answer that is right for it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

from pydantic import BaseModel

from physagent_jax.agents.llm.base import ChatMessage, ChatModel
from physagent_jax.agents.llm.structured import ask
from physagent_jax.agents.schema import Judgement, Rewrite, SemanticReply
from physagent_jax.agents.trace import Reply

FIELD = {
    "actions": [
        {
            "action_type": "translation",
            "vector": [-1.0, 0.0, 0.0],
            "magnitude": 1.0,
            "active_time": [0.0, 20.0],
        }
    ]
}


@dataclasses.dataclass(frozen=True)
class Role:
    """An agent that asks a model.

    Attributes:
        name: Name of the agent.
        right: A right answer of the model.
        ask: The call of the agent.
    """

    name: str
    right: dict[str, Any]
    ask: Callable[[ChatModel], Reply[Any]]


def _ask_for(schema: type[BaseModel], task: str) -> Callable[[ChatModel], Reply[Any]]:
    messages = ChatMessage("system", task), ChatMessage("user", "a strong wind pushes the robot to the left")
    return lambda model: ask(model, messages, schema)


ROLES = (
    Role("semantic", {"force_field": FIELD}, _ask_for(SemanticReply, "Compile the sentence.")),
    Role(
        "planner", {"verdict": "FAIL", "suggestion": "Push harder."}, _ask_for(Judgement, "Judge the motion.")
    ),
    Role(
        "executor",
        {"force_field": FIELD, "changes": ["The push is harder."]},
        _ask_for(Rewrite, "Rewrite the force field."),
    ),
)
