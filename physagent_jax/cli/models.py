"""`physagent models`: each model, its licence, where its files are looked for, and the command that brings it."""

from __future__ import annotations

import dataclasses
import json
from typing import TYPE_CHECKING, Annotated

import tyro

if TYPE_CHECKING:
    from physagent_jax.run.models import ModelState

_TITLES = {
    "segmenter": "--segmenter: finds the object",
    "depth": "--depth: says how far away it is",
    "tracker": "--tracker: follows its points",
    "clip": "CLIPsim: compares pictures with a sentence",
    "chat": "--llm: language models",
    "judge": "physagent score --judge: scores of finished runs by others",
}


@dataclasses.dataclass(frozen=True)
class Models:
    """List the models that a run may use: what for, licences, sizes, files, and how to get what is missing.

    Nothing is downloaded and nothing heavy is imported.
    """

    json_line: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print JSON instead of sentences."""

    def __call__(self) -> int:
        """Run the command; return the exit code."""
        from physagent_jax.run.models import list_states

        states = list_states()
        if self.json_line:
            print(json.dumps([_describe_as_json(each) for each in states], indent=2))
        else:
            print("\n".join(_describe(states)))
        return 0


def _describe_as_json(state: ModelState) -> dict:
    card = state.card
    return {
        "role": card.role,
        "name": card.name,
        "what": card.what,
        "code_licence": card.code,
        "weights_licence": card.weights,
        "size": card.size,
        "lacking_packages": list(state.lacking),
        "place": state.place,
        "found": state.found,
        "ready": state.ready,
        "get": state.get,
    }


def _describe(states: list[ModelState]) -> list[str]:
    lines: list[str] = []
    for role, title in _TITLES.items():
        lines += ["", title] if lines else [title]
        for each in (state for state in states if state.card.role == role):
            lines += _describe_one(each)
    return lines


def _describe_one(state: ModelState) -> list[str]:
    card = state.card
    mark = "ready" if state.ready else "not ready"
    lines = [f"  {card.name} ({mark}): {card.what}"]
    if card.packages or card.hub or card.file or card.given:
        lines.append(f"    licence: code {card.code}; weights {card.weights}")
    if state.place:
        there = {True: "found", False: "not found", None: "named when it is used"}[state.found]
        lines.append(f"    files: {card.size}; {there}: {state.place}")
    if state.lacking:
        lines.append(f"    lacks: {', '.join(state.lacking)}")
    if state.get:
        lines.append(f"    get: {state.get}")
    return lines
