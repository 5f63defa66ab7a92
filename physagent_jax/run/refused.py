"""Sentences that a model has read for a run that was refused then: `refused.json`, beside the run in that folder.

A run that is refused before it has simulated anything does not take the folder, but its reading is paid for. The same
run goes on from it, under other limits for instance; runs that ask for something else leave it alone.
"""

from __future__ import annotations

from pathlib import Path

from physagent_jax.agents.schema import SemanticReply
from physagent_jax.agents.trace import Trace
from physagent_jax.core.files import write_text
from physagent_jax.core.reading import read_model
from physagent_jax.core.strict import Strict
from physagent_jax.run.manifest import AgentCost

REFUSED = "refused.json"


class RefusedReading(Strict):
    """One of them.

    Attributes:
        inputs: Which run it is (`Manifest.inputs`).
        prompt: The sentence.
        error: Why the run was refused.
        reply, trace: The semantic agent's, and how it came about.
        agents: What agents have cost the run, this call included.
    """

    inputs: dict[str, str]
    prompt: str
    error: str
    reply: SemanticReply
    trace: Trace
    agents: tuple[AgentCost, ...]


class RefusedReadings(Strict):
    """The readings of refused sentences, in the order of the refusals."""

    readings: tuple[RefusedReading, ...] = ()


def read_refused(folder: Path) -> tuple[RefusedReading, ...]:
    """Those in the run folder ``folder``.

    Raises:
        UserError: The file is not valid.
    """
    path = folder / REFUSED
    return read_model(path, RefusedReadings).readings if path.is_file() else ()


def replace_refused(folder: Path, inputs: dict[str, str], reading: RefusedReading | None) -> None:
    """Put ``reading`` in the place of that of the run with ``inputs``; None takes it away."""
    earlier = read_refused(folder)
    kept = [each for each in earlier if each.inputs != inputs] + ([reading] if reading else [])
    if kept:
        write_text(folder / REFUSED, RefusedReadings(readings=tuple(kept)).model_dump_json(indent=2) + "\n")
    elif earlier:
        (folder / REFUSED).unlink()
