"""The agents that a run names, with the chat model that they share, open for as long as they are needed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from physagent_jax.agents.protocols import Agents
from physagent_jax.agents.registry import make_agents
from physagent_jax.chat.registry import make_model
from physagent_jax.core.errors import UserError
from physagent_jax.run.spec import RunSpec


@contextmanager
def open_agents(
    spec: RunSpec, base_dir: str | Path = ".", *, record: str | Path | None = None
) -> Iterator[Agents]:
    """The agents that ``spec`` names; their model is closed afterwards.

    Args:
        spec: The run.
        base_dir: Folder that relative paths of the spec start from.
        record: Cassette that keeps what the model is asked and answers, for `replay`; None = there is none.

    Raises:
        UserError: One of them needs what is not installed, does not take its options, or asks a model and none is
            named; or there is nothing to record.
    """
    choice = spec.agents.located(base_dir)
    model = None
    if choice.model is not None:
        model = make_model((choice.model.name, choice.model.options), record=record)
    elif record is not None:
        raise UserError("there is nothing to record", do="Name a model, or leave `--record` out")
    try:
        roles = {role: getattr(choice, role) for role in ("semantic", "planner", "executor")}
        yield make_agents(**{role: (each.name, each.options) for role, each in roles.items()}, model=model)
    finally:
        if model is not None:
            model.close()
