"""The jobs of each part: which method does which task, from where, and which force fields are checked again."""

from __future__ import annotations

import dataclasses
import json
import math
import tempfile
from collections.abc import Sequence
from functools import cache, partial
from pathlib import Path

from baselines.fits import read_budget
from baselines.materials import OWN
from baselines.measuring import judge_field
from baselines.recordings import rate
from baselines.simulation import Simulation
from baselines.tasks import Task, TaskSpec, load_witnesses, make_task
from benchmarks import harness
from benchmarks.harness import Job, Row
from benchmarks.headtohead import leaderboard
from benchmarks.headtohead.entrants import Entrant
from benchmarks.headtohead.measuring import measure, measure_gradient
from benchmarks.headtohead.neighbourhood import list_begins, list_entrants, move
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField
from physagent_jax.metrics.clip_similarity import PictureEncoder, load_clip, measure_clip_similarity
from physagent_jax.metrics.targets import hash_target

USUAL = 30.0  # forward-equivalents; fits with others say so in their names
WITNESS = "witness"
NOTHING = "nothing is done"
SHOWN = ("methods", "ablation", "iterations", "models", "distillation", "materials")
"""Parts whose clips are compared with their sentences."""
ROUNDED = ("iterations", "models")
"""Parts that are judged after each round."""
_TOLERANCE = 4e-6  # of an error, at least of 1: it is in single precision, and its sums depend on the threads
_KEPT = tempfile.TemporaryDirectory()


def list_fits(
    specs: Sequence[TaskSpec],
    entrants: Sequence[Entrant],
    marks: Sequence[float],
    budget: float,
    seeds: int,
    data: Path | None,
) -> list[Job]:
    """Every entrant on every task, those that draw anything with every seed; each budget is a fit of its own."""
    jobs = []
    for spec in specs:
        for entrant in entrants:
            for seed in range(seeds if entrant.make().stochastic else 1):
                work = partial(fit, entrant, spec, data, marks, seed, budget)
                jobs.append(Job(_name_fit(spec.name, entrant.label, seed, budget), work, spec.name))
    return jobs


def fit(
    entrant: Entrant, spec: TaskSpec, data: Path | None, marks: Sequence[float], seed: int, budget: float
) -> list[Row]:
    """`measure` of a task that is made first."""
    return measure(entrant, _make(spec, data), marks, seed, budget)


def list_neighbours(
    specs: Sequence[TaskSpec], tasks: Path, marks: Sequence[float], budget: float, data: Path | None
) -> list[Job]:
    """Local methods, once each: near the witness, and where the task says."""
    witnesses, jobs = load_witnesses(tasks), []
    for spec in specs:
        for begin in list_begins(spec.begin is not None):
            for entrant in list_entrants(begin):
                witness = witnesses[spec.name] if begin == "near" else None
                work = partial(fit_from, witness, entrant, spec, data, marks, budget)
                name = f"{spec.name} / {entrant.label}{_name_budget(budget)}"
                jobs.append(Job(name, work, spec.name))
    return jobs


def fit_from(
    witness: ForceField | None,
    entrant: Entrant,
    spec: TaskSpec,
    data: Path | None,
    marks: Sequence[float],
    budget: float,
) -> list[Row]:
    """`measure`, begun beside ``witness`` if there is one."""
    task = _make(spec, data)
    if witness is not None:
        task = move(task, witness, seed=0)
    return measure(entrant, task, marks, 0, budget)


def list_gradients(specs: Sequence[TaskSpec], tasks: Path, data: Path | None, repeats: int = 5) -> list[Job]:
    """`measure_gradient` at the witness of every task that has numbers: a fall alone has no gradient."""
    witnesses = load_witnesses(tasks)
    return [
        Job(spec.name, partial(time_gradient, witness, spec, data, repeats), spec.name)
        for spec in specs
        if (witness := witnesses[spec.name]).actions or witness.constraints
    ]


def time_gradient(witness: ForceField, spec: TaskSpec, data: Path | None, repeats: int) -> list[Row]:
    """`measure_gradient` of a task that is made first."""
    return measure_gradient(_make(spec, data), witness, repeats)


def list_materials(
    specs: Sequence[TaskSpec],
    entrants: Sequence[Entrant],
    settings: Sequence[str],
    result: Path,
    marks: Sequence[float],
    budget: float,
    data: Path | None,
) -> list[Job]:
    """With each material: the entrants' fits, and what the fits of the comparison found with the own one."""
    known, jobs = {spec.name: spec for spec in specs}, []
    content = json.loads(result.read_text()) if result.is_file() else {}
    found = [
        row
        for row in content.get("methods", {}).get("rows", [])
        if row["task"] in known and row["job"] == _name_fit(row["task"], row["label"], 0, budget)
    ]
    for spec in specs:
        for setting in settings:
            for entrant in entrants:
                work = partial(fit_material, setting, entrant, spec, data, marks, budget)
                name = f"{spec.name} / {entrant.label} / {setting}{_name_budget(budget)}"
                jobs.append(Job(name, work, spec.name))
            for row in (row for row in found if row["task"] == spec.name):
                work = partial(transfer, setting, row, spec, data)
                jobs.append(Job(f"{row['job']} / brought to {setting}", work, spec.name))
    return jobs


def fit_material(
    setting: str,
    entrant: Entrant,
    spec: TaskSpec,
    data: Path | None,
    marks: Sequence[float],
    budget: float,
) -> list[Row]:
    """`measure` of a task with another material."""
    rows = measure(entrant, _make(spec, data, setting), marks, 0, budget)
    return [row | {"material": setting, "brought": False} for row in rows]


def transfer(setting: str, row: Row, spec: TaskSpec, data: Path | None) -> list[Row]:
    """Row of a force field, found with the own material and judged with another; a refusal stays one."""
    marks = []
    for last in row["marks"][-1:]:
        judged = judge_field(ForceField.model_validate(last["force_field"]), _make(spec, data, setting))
        marks = [{"mark": last["mark"], "success": judged["success"], "error": judged["error"]}]
    told = {name: row[name] for name in ("label", "task", "family", "split", "seed", "oracle")}
    return [told | {"material": setting, "brought": True, "marks": marks}]


def list_checks(specs: Sequence[TaskSpec], result: Path, board: Path | None, data: Path | None) -> list[Job]:
    """The last force field of every row of a result, or of every line of a leaderboard, once more."""
    known = {spec.name: spec for spec in specs}
    if board is not None and board.is_file():
        rows = [leaderboard.as_row(entry) for entry in leaderboard.read(board)]
    else:
        content = json.loads(result.read_text()) if result.is_file() else {}
        rows = [row for part in leaderboard.PARTS for row in content.get(part, {}).get("rows", [])]
    return [
        Job(row["job"], partial(check, row, known[row["task"]], data), row["task"])
        for row in rows
        if row["task"] in known and row["marks"]
    ]


def list_similarities(specs: Sequence[TaskSpec], result: Path, clip: Path, data: Path | None) -> list[Job]:
    """CLIPsim of the force fields of every part, and of a clip in which nothing is done.

    Of a fit it is the last; of the part that counts rewrites, that of every round; brought materials have no clips.
    Each is also compared with another sentence about the same object: what the two have in common tells nothing.
    """
    known = {spec.name: spec for spec in specs}
    content = json.loads(result.read_text()) if result.is_file() else {}
    others = {spec.name: find_other_sentence(spec, specs) for spec in specs}
    jobs, named = [], {}
    for part in SHOWN:
        for row in content.get(part, {}).get("rows", []):
            if row["task"] not in known or not row["marks"] or row.get("brought"):
                continue
            named[row["task"]] = known[row["task"]]
            for mark in row["marks"] if part in ROUNDED else row["marks"][-1:]:
                shown = {**row, "part": part, "marks": [mark], "label": _name_clip(part, row, mark)}
                name = f"{part} / {row['job']}" + (f" / {mark['mark']:g}" if part in ROUNDED else "")
                work = partial(measure_similarity, shown, known[row["task"]], clip, data, others[row["task"]])
                jobs.append(Job(name, work, row["task"]))
    for name, spec in named.items():
        still = {"part": "methods", "label": NOTHING, "task": name, "oracle": False, "seed": 0, "marks": []}
        jobs.append(
            Job(f"{name} / nothing", partial(measure_similarity, still, spec, clip, data, others[name]), name)
        )
    return jobs


def _name_clip(part: str, row: Row, mark: Row) -> str:
    """Label of a row, with its round or its material."""
    if part in ROUNDED:
        return f"{row['label']}, {mark['mark']:g} rounds"
    return f"{row['label']}, {row['material']}" if part == "materials" else row["label"]


def find_other_sentence(spec: TaskSpec, specs: Sequence[TaskSpec]) -> str | None:
    """A sentence about the same object that asks for another kind of motion; None if there is none.

    It is the next after the task's own, in a circle.
    """
    place = specs.index(spec)
    rest = [*specs[place + 1 :], *specs[:place]]
    return next((s.sentence for s in rest if s.object == spec.object and s.family != spec.family), None)


def measure_similarity(
    row: Row, spec: TaskSpec, clip: Path, data: Path | None, other: str | None = None
) -> list[Row]:
    """CLIPsim of a stored force field with its task's sentence and with another, in the pictures that methods see."""
    last = row["marks"][-1] if row["marks"] else None
    field = ForceField() if last is None else ForceField.model_validate(last["force_field"])
    told = {name: row[name] for name in ("part", "label", "task", "oracle", "seed")} | {
        "family": spec.family,
        "split": spec.split,
    }
    try:
        pictures, _ = Simulation(_make(spec, data, row.get("material", OWN))).play(field)
    except UserError as error:  # what cannot be simulated has no pictures
        return [told | {"refused": str(error)[:200]}]
    model = _load_clip(clip)
    found = measure_clip_similarity(pictures.rgb, spec.sentence, model)
    apart = None if other is None else measure_clip_similarity(pictures.rgb, other, model).mean
    return [told | {"mark": last and last["mark"], **dataclasses.asdict(found), "shuffled": apart}]


def list_ratings(specs: Sequence[TaskSpec], tasks: Path, result: Path, data: Path | None) -> list[Job]:
    """Physical fidelity of the clips of all witnesses, and of every method's last force field of one run."""
    witnesses, known = load_witnesses(tasks), {spec.name: spec for spec in specs}
    content = json.loads(result.read_text()) if result.is_file() else {}
    rows = [
        row for row in content.get("methods", {}).get("rows", []) if row["task"] in known and row["marks"]
    ]
    last: dict[tuple[str, str], Row] = {}
    for row in sorted(rows, key=read_budget):
        if row["seed"] == 0:
            last[row["label"], row["task"]] = row
    fields = {(WITNESS, spec.name): witnesses[spec.name].model_dump() for spec in specs}
    fields |= {key: row["marks"][-1]["force_field"] for key, row in last.items()}
    return [
        Job(f"{name} / {label}", partial(measure_fidelity, label, field, spec, data), name)
        for name, spec in known.items()  # a task's programs are compiled once
        for (label, task), field in fields.items()
        if task == name
    ]


def measure_fidelity(label: str, field: dict, spec: TaskSpec, data: Path | None) -> list[Row]:
    """Terms of the clip of a force field; a row without terms where it cannot be simulated."""
    told = {"label": label, "task": spec.name, "family": spec.family, "split": spec.split}
    task, force_field = _make(spec, data), ForceField.model_validate(field)
    try:
        found = rate(task, force_field, task.simulate(force_field))
    except UserError as error:
        return [told | {"refused": str(error)[:200]}]
    harness.say(f"{spec.name:32s} {label:36s} {found.score:.2f} {' '.join(found.faults)}")
    return [told | {"terms": dataclasses.asdict(found), "score": found.score, "faults": found.faults}]


def check(row: Row, spec: TaskSpec, data: Path | None) -> list[Row]:
    """`verify` of a task that is made first."""
    return verify(row, _make(spec, data))


def verify(row: Row, task: Task) -> list[Row]:
    """Return whether a stored force field is still judged as its row says, by the task that it was made for.

    Rows that were measured before whole tasks were hashed have the hash of their target alone.
    """
    stored = row["marks"][-1]
    again = judge_field(ForceField.model_validate(stored["force_field"]), task)
    if "task_hash" in row:
        same_task = row["task_hash"] == task.spec.task_hash
    else:
        same_task = row["target_hash"] == hash_target(task.spec.target)
    near = math.isclose(again["error"], stored["error"], rel_tol=_TOLERANCE, abs_tol=_TOLERANCE)
    good = same_task and again["success"] == stored["success"] and near
    if not good:
        harness.say(f"{row['job']}: error {stored['error']:.6g} then, {again['error']:.6g} now")
    return [{"good": good, "stored": stored["error"], "again": again["error"], "same_task": same_task}]


def _name_fit(task: str, label: str, seed: int, budget: float) -> str:
    return f"{task} / {label} / {seed}{_name_budget(budget)}"


def _name_budget(budget: float) -> str:
    return "" if budget == USUAL else f" / {budget:g}"


@cache
def _load_clip(folder: Path) -> PictureEncoder:
    return load_clip(folder)


@cache
def _make(spec: TaskSpec, data: Path | None, material: str = OWN) -> Task:
    return make_task(spec, Path(_KEPT.name), data, material)
