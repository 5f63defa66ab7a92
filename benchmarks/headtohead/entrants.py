"""Entrants of each table: methods with their options, by the label of their row."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from baselines.methods import make_method
from baselines.protocol import Method


@dataclasses.dataclass(frozen=True)
class Entrant:
    """A row of a table.

    Attributes:
        label: Label of the row.
        method: Name in the registry.
        options: Options of the method.
        question: What the row is there for, in a few words.
    """

    label: str
    method: str
    options: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    question: str = ""

    def make(self) -> Method:
        """The method."""
        return make_method(self.method, self.options)


LOCAL = ("levenberg_marquardt", "lbfgs", "adam")
"""Methods that descend from a start."""

ENUMERATED = dict(types="enumerated", numbers="random")
RESPONSES = dict(types="responses", numbers="responses", starts=4)
_AGENT = dict(types="agent", numbers="agent")

METHODS = (
    Entrant("expert", "expert", question="the forces of published scenes"),
    Entrant("physsplat_f", "physsplat_f", question="one guess, no skills, no feedback"),
    Entrant("random", "random", question="chance"),
    Entrant("physagent", "physagent", question="ours: sees pictures and the sentence"),
    Entrant("catcma", "catcma", question="evolution over types and numbers"),
    Entrant("cma", "cma", question="evolution, each type"),
    Entrant("adam, all types", "adam", ENUMERATED, "gradients, each type"),
    Entrant("lbfgs, all types", "lbfgs", ENUMERATED, "gradients, each type"),
    Entrant("levenberg_marquardt, all types", "levenberg_marquardt", ENUMERATED, "least squares, each type"),
    Entrant(
        "smoothed_adam, all types", "smoothed_adam", ENUMERATED, "gradients of a blurred loss, each type"
    ),
    Entrant("adam, responses", "adam", RESPONSES, "gradients, types by superposition"),
    Entrant("lbfgs, responses", "lbfgs", RESPONSES, "gradients, types by superposition"),
    Entrant(
        "levenberg_marquardt, responses", "levenberg_marquardt", RESPONSES, "least squares, by superposition"
    ),
    Entrant("hybrid", "hybrid", question="agents choose, least squares polishes"),
)
"""Table 1: oracles, which read the true distance to the target, among those that see pictures only."""

MATERIALS = tuple(each for each in METHODS if each.label in ("physagent", "hybrid"))
"""With other materials: of the rest, what they found with the own one is tried."""

ABLATION = (
    Entrant(
        "privileged", "physagent", dict(privileged=True), "true particles and the judge in place of pictures"
    ),
    Entrant("without skills", "physsplat_f", dict(feedback=True), "pushes of strength 1, with feedback"),
    Entrant("without refinement", "physsplat_f", dict(skills=True), "the first guess"),
    Entrant("types: agent, numbers: least squares", "levenberg_marquardt", _AGENT, "the agent's types"),
    Entrant("types: agent, numbers: adam", "adam", _AGENT, "the agent's types"),
    Entrant(
        "types: task, numbers: least squares",
        "levenberg_marquardt",
        dict(numbers="random"),
        "the task's own kind",
    ),
)
"""For table 2: what skills and feedback are worth, and who should choose types, who numbers."""

ABLATION_ROWS: Mapping[str, tuple[str, str]] = {
    "full": ("methods", "physagent"),
    "privileged": ("ablation", "privileged"),
    "without skills": ("ablation", "without skills"),
    "without refinement": ("ablation", "without refinement"),
    "types: agent, numbers: agent": ("ablation", "without refinement"),
    "types: agent, numbers: least squares": ("ablation", "types: agent, numbers: least squares"),
    "types: agent, numbers: adam": ("ablation", "types: agent, numbers: adam"),
    "types: all, numbers: least squares": ("methods", "levenberg_marquardt, all types"),
    "types: all, numbers: adam": ("methods", "adam, all types"),
    "types: task, numbers: least squares": ("ablation", "types: task, numbers: least squares"),
}
"""Table 2: per row the part and the label of the fits that it is made of, as some are those of table 1."""


def list_distillers(prior: str, weights: str) -> tuple[Entrant, ...]:
    """The methods of score distillation, led by a prior; their rows say whose word they follow."""
    led = dict(prior=prior, weights=weights)
    return (
        Entrant(f"dreamphysics_f ({prior} prior)", "dreamphysics_f", led, "the published schedule"),
        Entrant(
            f"dreamphysics_f, whole clip, Adam ({prior} prior)",
            "dreamphysics_f",
            led | dict(schedule="adam"),
            "without its limits",
        ),
        Entrant(f"omniphysgs_f ({prior} prior)", "omniphysgs_f", led, "skills chosen too"),
    )


def list_guided(clip: Path) -> tuple[Entrant, ...]:
    """The methods that the CLIP model of a folder leads; their rows name it."""
    question = "CLIP similarity by its gradient"
    return (Entrant(f"clip_guided ({clip.resolve().name})", "clip_guided", dict(clip=str(clip)), question),)


ITERATIONS = (Entrant("physagent", "physagent", dict(rounds=6), "rounds after the first guess"),)
"""Table 3: success after 0 to 5 rewrites."""
