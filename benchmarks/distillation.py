"""`python -m benchmarks.distillation --weights DIR [--json OUT] [--markdown MD]`: does distillation lead to the target?

At force fields of every task, gradients of a score prior by all |M| v are drawn, through the whole clip and through the
last substep before each picture alone (the published truncation), with and without the still clip's gradient taken off,
and their cosine with the gradient of the task's own loss is taken. A method never sees any of it.
"""

from __future__ import annotations

import dataclasses
import json
import sys
import tempfile
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
import tyro

import physagent_jax as pa
from baselines.scores import PRIORS, open_prior
from baselines.scores.compare import compare_with_truth
from baselines.scores.protocol import ScorePrior
from baselines.starts import draw_numbers
from baselines.tasks import Task, TaskSpec, load_tasks, make_task, split_available
from baselines.truncation import WHOLE, Truncation
from benchmarks import harness
from benchmarks.harness import RAW, Job, Page, Row, import_pyplot, number, provenance, table
from physagent_jax.core.errors import UserError

TASKS = Path(__file__).resolve().parent / "tasks"
SETTINGS: dict[str, tuple[dict[str, Any], Truncation]] = {
    "whole clip": ({}, WHOLE),
    "whole clip, still subtracted": ({"motion": True}, WHOLE),
    "last substep": ({}, Truncation(substeps=1)),
}
"""Changes of the prior's settings, and how far gradients go back."""
COLUMNS = {
    "family": lambda rows: rows[0]["family"],
    "places": lambda rows: str(len(rows)),
    "mean": lambda rows: number(float(np.mean([row["cosine"] for row in rows]))),
    "range over places": lambda rows: (
        f"{number(min(r['cosine'] for r in rows))} to {number(max(r['cosine'] for r in rows))}"
    ),
    "places with a positive mean": lambda rows: f"{100 * np.mean([row['cosine'] > 0 for row in rows]):.0f}%",
    "downhill": lambda rows: f"{100 * np.mean([row['downhill'] for row in rows]):.0f}%",
    "signal to noise": lambda rows: number(float(np.median([row["signal_to_noise"] for row in rows]))),
}
_KEPT = tempfile.TemporaryDirectory()


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Compare gradients of score distillation with the true ones, or write the tables of an earlier run."""

    json: Path = RAW / "distillation.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[Literal["cosines"], ...] = ("cosines",)
    """Parts to measure; there is one."""
    prior: Literal["wan", "modelscope", "cogvideox", "toy"] = "toy"
    """Prior that gives the gradients."""
    weights: str = "runs/toy_prior/prior"
    """Weights of the prior."""
    tasks: Path = TASKS
    """Folder of the tasks."""
    data: Path | None = None
    """Folder of captured objects; tasks on those are left out without it."""
    every: int = 2
    """Only every so-many-th task of a family."""
    places: int = 2
    """Force fields per task: the task's start, then drawn ones."""
    draws: int = 16
    """Gradients per force field and setting."""
    plots: Path | None = None
    """Also draw the cosines here."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    if command.plots is not None and not harness.can_plot():
        return 2
    pa.enable_compile_cache()
    try:
        specs, left_out = split_available(load_tasks(command.tasks), command.data)
        if command.parts and command.prior in PRIORS:
            open_prior(command.prior, command.weights)  # a wrong folder is told before anything is simulated
    except UserError as error:
        print(f"distillation: {error}", file=sys.stderr)
        return 2
    families: dict[str, list[TaskSpec]] = {}
    for spec in specs:
        families.setdefault(spec.family, []).append(spec)
    every = 8 if command.quick else command.every
    chosen = [spec for members in families.values() for spec in members[::every]]
    jobs = [Job(spec.name, partial(_compare, command, spec)) for spec in chosen]
    facts = {"left_out": list(left_out), "prior": command.prior}
    code = harness.main(command, {"cosines": lambda: jobs}, PAGE, facts)
    if command.plots is not None:
        plot(json.loads(command.json.read_text()), command.plots)
    return code


def write_tables(result: harness.Result) -> harness.Tables:
    """The tables of docs/distillation.md."""
    rows = result["cosines"]["rows"] if "cosines" in result else []
    told = [row for row in rows if "cosine" in row]
    text = ""
    for prior in dict.fromkeys(row["prior"] for row in told):
        for setting in SETTINGS:
            mine = [row for row in told if (row["prior"], row["setting"]) == (prior, setting)]
            groups = [
                [row for row in mine if row["family"] == f] for f in dict.fromkeys(r["family"] for r in mine)
            ]
            shown = [[show(group) for show in COLUMNS.values()] for group in groups if group]
            shown += [["all", *(show(mine) for show in list(COLUMNS.values())[1:])]] if mine else []
            text += f"\n## {prior.capitalize()}: {setting}\n" + table(tuple(COLUMNS), shown)
    if refused := [row for row in rows if "refused" in row]:
        text += f"\n{len(refused)} of {len(rows)} comparisons could not be made:\n\n"
        text += "".join(f"- {row['task']}, {row['setting']}: {row['refused']}\n" for row in refused)
    return {"cosines": text, "runs": provenance(result, ("cosines",))}


PAGE = Page(
    "distillation",
    "python -m benchmarks.distillation --weights DIR",
    write_tables,
    (
        "baselines",
        "benchmarks/tasks",
        *(f"physagent_jax/{part}" for part in ("forces", "kernels", "mpm", "render", "simulation")),
    ),
)


def compare(
    task: Task, opened: Callable[[dict[str, Any]], ScorePrior], *, places: int, draws: int, seed: int = 0
) -> list[Row]:
    """A row for each force field and setting; what cannot be compared says why.

    Args:
        task: Whose target is the truth.
        opened: The prior with these changes of its settings.
        places: Force fields: the task's start, then drawn ones.
        draws: Gradients of each.
        seed: Seed of the drawn force fields and of the noise.
    """
    rng, rows = np.random.default_rng(seed), []
    fields = [task.start, *(draw_numbers(rng, task.start) for _ in range(places - 1))]
    for place, field in enumerate(fields):
        for name, (changes, truncation) in SETTINGS.items():
            row: Row = {
                "task": task.spec.name,
                "family": task.spec.family,
                "place": place,
                "setting": name,
                "force_field": field.model_dump(mode="json", exclude_none=True),
            }
            try:
                found = compare_with_truth(
                    task, field, opened(changes), draws=draws, seed=seed, truncation=truncation
                )
            except UserError as error:
                rows.append(row | {"refused": " ".join(str(error).split())[:200]})
                continue
            row |= {
                "prior": found.prior,
                "toy": found.toy,
                "cosine": found.cosine,
                "cosines": [round(float(each), 4) for each in found.cosines],
                "downhill": found.share_downhill,
                "signal_to_noise": found.signal_to_noise,
                "unknowns": len(found.true_gradient),
            }
            rows.append(row)
            harness.say(f"{task.spec.name:32s} {place} {name:30s} cosine {found.cosine:6.3f}")
    return rows


def plot(result: dict[str, Any], folder: Path) -> None:
    """Write ``distillation.png``: the cosine of each mean gradient, by family and setting.

    Raises:
        UserError: matplotlib is not installed.
    """
    plt = import_pyplot()

    rows = [row for row in result["cosines"]["rows"] if "cosine" in row]
    families = list(dict.fromkeys(row["family"] for row in rows))
    figure, axis = plt.subplots(figsize=(8, 4))
    for index, name in enumerate(SETTINGS):
        mine = [row for row in rows if row["setting"] == name]
        across = [families.index(row["family"]) + 0.25 * (index - 1) for row in mine]
        color = plt.get_cmap("tab10")(index)
        for x, row in zip(across, mine):
            axis.plot(
                np.full(len(row["cosines"]), x), row["cosines"], ".", color=color, alpha=0.15, markersize=3
            )
        axis.plot(across, [row["cosine"] for row in mine], "_", color=color, markersize=12, label=name)
    axis.axhline(0, color="black", linewidth=0.8)
    axis.set(ylabel="cosine with the gradient of the true loss", ylim=(-1.05, 1.05))
    axis.set_xticks(range(len(families)), families)
    prior = rows[0]["prior"] if rows else ""
    axis.set_title(f"{prior}. Dots: single draws; bars: their mean at each force field.", fontsize=9)
    axis.legend(fontsize=8)
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "distillation.png", dpi=110, bbox_inches="tight")
    plt.close(figure)


def _compare(command: Command, spec: TaskSpec) -> list[Row]:
    places, draws = (1, 2) if command.quick else (command.places, command.draws)
    task = _make(spec, command.data)

    def open_changed(changes: dict[str, Any]) -> ScorePrior:
        return _open(command.prior, command.weights, tuple(changes.items()))

    return compare(task, open_changed, places=places, draws=draws)


@cache
def _open(prior: str, weights: str, changes: tuple[tuple[str, Any], ...]) -> ScorePrior:
    return open_prior(prior, weights, settings=dict(changes))


@cache
def _make(spec: TaskSpec, data: Path | None) -> Task:
    return make_task(spec, Path(_KEPT.name), data)


if __name__ == "__main__":
    sys.exit(main())
