"""Entrants of each table: methods with their options, by the label of their row, and old labels of stored rows."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from baselines.methods import make_method
from baselines.protocol import Method
from benchmarks.chat_models import Asked


@dataclasses.dataclass(frozen=True)
class Entrant:
    """A row of a table.

    Attributes:
        label: Label of the row.
        method: Name in the registry.
        options: Options of the method.
        question: Reason for the row, in a few words.
        published_as: Method of a paper in whose place it stands, and what it is not; "" = its own name says it.
        published_steps: Steps of that method's public code; 0 = not told.
    """

    label: str
    method: str
    options: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    question: str = ""
    published_as: str = ""
    published_steps: int = 0

    def make(self) -> Method:
        """The method."""
        return make_method(self.method, self.options)


LOCAL = ("levenberg_marquardt", "lbfgs", "adam")
"""Methods that descend from a start."""

ENUMERATED = dict(types="enumerated", numbers="random")
RESPONSES = dict(types="responses", numbers="responses", starts=4)
STAGES = dict(stages=2, inner=5)
_AGENT = dict(types="agent", numbers="agent")

METHODS = (
    Entrant(
        "expert",
        "expert",
        question="the forces of published scenes",
        published_as="PhysGaussian-g, OmniPhysGS-g: two of their force fields",
    ),
    Entrant(
        "direction_only",
        "direction_only",
        question="one guess, no skills, no feedback",
        published_as="PhysSplat-f: no code is public",
    ),
    Entrant("random", "random", question="chance"),
    Entrant(
        "rules",
        "rules",
        question="ours: sees pictures and the sentence",
        published_as="PhysAgent: there agents are a language model",
    ),
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

MATERIALS = tuple(each for each in METHODS if each.label in ("rules", "hybrid"))
"""With other materials: of the rest, what they found with the own one is tried."""

ABLATION = (
    Entrant(
        "privileged", "rules", dict(privileged=True), "true particles and the judge in place of pictures"
    ),
    Entrant(
        "direction_only, feedback",
        "direction_only",
        dict(feedback=True),
        "pushes of strength 1, with feedback",
    ),
    Entrant("without refinement", "rules", dict(rounds=1), "the first guess"),
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
    "full": ("methods", "rules"),
    "privileged": ("ablation", "privileged"),
    "direction_only, feedback": ("ablation", "direction_only, feedback"),
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
    dream, omni = "DreamPhysics-f: its steps, another derivative", "OmniPhysGS-f: its choice, for skills"
    return (
        Entrant(f"sds_last_substep ({prior} prior)", "sds_last_substep", led, "steps of the code", dream, 50),
        Entrant(f"sds_whole_clip ({prior} prior)", "sds_whole_clip", led, "without its limits", "", 50),
        Entrant(f"sds_choice ({prior} prior)", "sds_choice", led | STAGES, "skills chosen too", omni, 1500),
    )


def list_guided(clip: Path) -> tuple[Entrant, ...]:
    """The methods that the CLIP model of a folder leads; their rows name it."""
    question = "CLIP similarity by its gradient"
    return (Entrant(f"clip_guided ({clip.resolve().name})", "clip_guided", dict(clip=str(clip)), question),)


ITERATIONS = (Entrant("rules", "rules", dict(rounds=6), "rounds after the first guess"),)
"""Table 3: success after 0 to 5 rewrites."""


def list_model_agents(models: Sequence[Asked]) -> tuple[Entrant, ...]:
    """The agents of each model, with and without the skill library's words and hard rules, beside the rules."""
    published = "PhysAgent, with a smaller model that sees no pictures"
    entrants = [*ITERATIONS]
    for each in models:
        asked = dict(model=each.place, record=each.record)
        told = "reads and rewrites; rules judge"
        entrants += [
            Entrant(f"agents ({each.name})", "chat_agents", asked, told, published),
            Entrant(f"agents ({each.name}), without skills", "chat_agents", asked | dict(skills=False), told),
        ]
    return tuple(entrants)


RENAMED: Mapping[str, str] = {
    "physagent": "rules",
    "physsplat_f": "direction_only",
    "without skills": "direction_only, feedback",
    "dreamphysics_f": "sds_last_substep",
    "dreamphysics_f (toy prior)": "sds_last_substep (toy prior)",
    "dreamphysics_f, whole clip, Adam (toy prior)": "sds_whole_clip (toy prior)",
    "omniphysgs_f": "sds_choice",
    "omniphysgs_f (toy prior)": "sds_choice (toy prior)",
}
"""Labels and methods of rows that history has, by the names of today. It goes when these rows are measured again."""

_SPLIT: Mapping[str, Mapping[str, Any]] = {
    "without refinement": dict(method="rules", options=dict(rounds=1)),
    "sds_whole_clip (toy prior)": dict(method="sds_whole_clip", options=dict(prior="toy")),
    "sds_choice (toy prior)": dict(method="sds_choice", options=dict(prior="toy", **STAGES)),
}
"""The same, of what was an option of another method, or an option left at its default."""


def rename(result: Mapping[str, Any]) -> dict[str, Any]:
    """Rows that history has, by the names of today: of jobs, labels and methods."""
    return {
        part: {**section, "rows": [_rename_row(row) for row in section["rows"]]}
        for part, section in result.items()
    }


def _rename_row(row: Mapping[str, Any]) -> dict[str, Any]:
    named = {key: RENAMED.get(row[key], row[key]) for key in ("label", "method") if key in row}
    job = " / ".join(RENAMED.get(word, word) for word in row["job"].split(" / "))
    split = _SPLIT.get(named.get("label", ""), {}) if "method" in row else {}
    return {**row, **named, "job": job, **split}
