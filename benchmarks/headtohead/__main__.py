"""`python -m benchmarks.headtohead [--json OUT] [--markdown MD] [--data DIR] [--quick]`: methods against each other.

Every method gets the same budget on the same tasks and the same simulator, counted in forward-equivalents; what it is
to be judged by is read from the particles and never shown to it (oracles apart, which are named so). `methods` is the
comparison, `ablation` takes the agents apart, `iterations` counts their rewrites, `models` asks language models in
their place, `materials` gives objects other materials, `neighbourhood` checks that local methods are not broken.
`gradients` times what a gradient is charged for. `clipsim` is how alike their pictures and the sentence are to a CLIP
model. `fidelity` asks whether a body could have moved so. `verify` simulates the force fields of the file again and
judges them anew.
"""

from __future__ import annotations

import dataclasses
import json
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Literal

import tyro

import physagent_jax as pa
from baselines.methods import make_method
from baselines.plot import plot
from baselines.tasks import TaskSpec, load_tasks, split_available
from benchmarks import harness
from benchmarks.chat_models import Asked
from benchmarks.harness import RAW, Job
from benchmarks.headtohead import leaderboard
from benchmarks.headtohead.comparison import choose_split
from benchmarks.headtohead.entrants import (
    ABLATION,
    ITERATIONS,
    MATERIALS,
    METHODS,
    Entrant,
    list_distillers,
    list_guided,
    list_model_agents,
)
from benchmarks.headtohead.jobs import (
    USUAL,
    list_checks,
    list_fits,
    list_gradients,
    list_materials,
    list_neighbours,
    list_ratings,
    list_similarities,
)
from benchmarks.headtohead.markdown import PAGE
from physagent_jax.core.errors import UserError
from physagent_jax.core.names import explain_unknown_name
from physagent_jax.metrics.clip_similarity import load_clip

MARKS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
ROUNDS = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
TASKS = Path(__file__).resolve().parents[1] / "tasks"


@dataclasses.dataclass(frozen=True)
class Command(harness.Command):
    """Compare the methods, or write the tables of an earlier run."""

    json: Path = RAW / "head-to-head.json"
    """File of the raw rows; those of other parts are kept."""
    parts: tuple[
        Literal[
            "methods",
            "ablation",
            "iterations",
            "models",
            "distillation",
            "materials",
            "neighbourhood",
            "gradients",
            "clipsim",
            "fidelity",
            "verify",
        ],
        ...,
    ] = (
        "methods",
        "ablation",
        "iterations",
    )
    """Parts to measure."""
    methods: tuple[str, ...] = ()
    """Only these of `methods`, by the labels of the tables; module:Class or file.py:Class is one of your own."""
    tasks: Path = TASKS
    """Folder of the tasks."""
    data: Path | None = None
    """Folder of captured objects; tasks on those are left out without it."""
    split: Literal["development", "test", "both"] = "both"
    """Split of the tasks."""
    families: tuple[str, ...] = ()
    """Only these; none = all."""
    smooth: bool = False
    """Only tasks in which nothing comes to touch the ground."""
    every: int = 1
    """Only every so-many-th task of a family."""
    budget: float = USUAL
    """Forward-equivalents of each fit: the last mark. Fits with another budget are kept beside these."""
    seeds: int = 1
    """Seeds of what is random; the rest is done once."""
    workers: int = 1
    """Fits side by side, each on its share of the cores: for what is counted, not for seconds to quote."""
    settings: tuple[str, ...] = ("softer", "stiffer")
    """For `materials`: as `--material` of `baselines.run`."""
    prior: Literal["wan", "modelscope", "cogvideox", "toy"] = "toy"
    """Prior of the methods of score distillation."""
    weights: str = "runs/toy_prior/prior"
    """Weights of the prior."""
    models: tuple[str, ...] = ()
    """For `models`: chat models, NAME=PLACE each: a GGUF file, a cassette, or URL#MODEL of a server."""
    cassettes: Path = Path("runs/headtohead")
    """Folder where the models' answers are kept; a run that is stopped asks nothing twice."""
    clip: Path | None = None
    """Folder of a CLIP model, for `clipsim`, and for `clip_guided` among the methods, which needs one."""
    leaderboard: Path | None = None
    """File of JSON lines, one per fit: those of this result are added; `verify` then checks all of its lines."""
    plots: Path | None = None
    """Also draw success against budget here."""


def main() -> int:
    """Run the command line."""
    command = tyro.cli(Command)
    if command.plots is not None and not harness.can_plot():
        return 2
    pa.enable_compile_cache()
    try:
        specs, left_out = list_tasks(command)
        entrants = choose_entrants(command.methods, command.clip)
        models = list_model_agents([Asked(text, command.cassettes) for text in command.models])
    except UserError as error:
        print(f"headtohead: {error}", file=sys.stderr)
        return 2
    budget = command.budget
    marks = (*(mark for mark in MARKS if mark < budget), budget)
    fits = partial(list_fits, specs, seeds=command.seeds, data=command.data)
    parts: dict[str, Callable[[], list[Job]]] = {
        "methods": lambda: fits(entrants, marks, budget),
        "ablation": lambda: fits(ABLATION, marks, budget),
        "iterations": lambda: fits(ITERATIONS, ROUNDS, ROUNDS[-1]),
        "models": lambda: fits(models, ROUNDS, ROUNDS[-1]),
        "distillation": lambda: fits(list_distillers(command.prior, command.weights), marks, budget),
        "materials": lambda: list_materials(
            specs, MATERIALS, command.settings, command.json, marks, budget, command.data
        ),
        "neighbourhood": lambda: list_neighbours(specs, command.tasks, marks, budget, command.data),
        "gradients": lambda: list_gradients(specs, command.tasks, command.data),
        "clipsim": lambda: list_similarities(specs, command.json, find_clip(command.clip), command.data),
        "fidelity": lambda: list_ratings(specs, command.tasks, command.json, command.data),
        "verify": lambda: list_checks(specs, command.json, command.leaderboard, command.data),
    }
    about = {"left_out": left_out, "budget": budget}
    try:
        code = harness.main(command, parts, PAGE, about, command.workers, pa.enable_compile_cache)
    except UserError as error:
        print(f"headtohead: {error}", file=sys.stderr)
        return 2
    if command.leaderboard is not None and command.json.is_file():
        leaderboard.merge(command.leaderboard, json.loads(command.json.read_text()))
    if command.plots is not None:
        rows = json.loads(command.json.read_text())["methods"]["rows"]
        plot(choose_split(rows), command.plots / "headtohead-success.svg")
    return code


def find_clip(folder: Path | None) -> Path:
    """The folder of the CLIP model, which can be read.

    Raises:
        UserError: It is not given, or cannot.
    """
    if folder is None:
        raise UserError("`clipsim` needs a CLIP model", do="Give its folder with --clip")
    load_clip(folder)
    return folder


def choose_entrants(names: Sequence[str], clip: Path | None) -> tuple[Entrant, ...]:
    """The methods of these labels, or of one's own; all of the comparison without any.

    Raises:
        UserError: There is no such method.
    """
    if not names:
        return (*METHODS, *find_guided(clip))
    known = {entrant.label: entrant for entrant in METHODS}
    chosen = []
    for name in names:
        if ":" in name:
            chosen.append(Entrant(make_method(name).name, name, question="one's own"))
        elif name in known:
            chosen.append(known[name])
        else:
            raise explain_unknown_name("method", name, known)
    return tuple(chosen)


def find_guided(folder: Path | None) -> tuple[Entrant, ...]:
    """The methods that CLIP leads, if there is a model; else a line says that they are left out.

    Raises:
        UserError: The model cannot be read.
    """
    if folder is not None:
        return list_guided(find_clip(folder))
    harness.say("`clip_guided` is left out: it needs a CLIP model. Give its folder with --clip.")
    return ()


def list_tasks(command: Command) -> tuple[tuple[TaskSpec, ...], list[str]]:
    """The tasks that are asked for and can be made, and the names of those that cannot.

    Raises:
        UserError: There are none, or a family is unknown.
    """
    split = None if command.split == "both" else command.split
    specs = load_tasks(command.tasks, split=split, families=command.families or None)
    specs, left_out = split_available(
        [spec for spec in specs if spec.smooth or not command.smooth], command.data
    )
    counts: dict[str, int] = {}
    chosen = []
    every = 4 if command.quick else command.every
    for spec in specs:
        place = counts[spec.family] = counts.get(spec.family, -1) + 1
        if place % every == 0:
            chosen.append(spec)
    return tuple(chosen), list(left_out)


if __name__ == "__main__":
    sys.exit(main())
