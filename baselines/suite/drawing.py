"""A task of the suite by seed and number: drawn until it is one, and tried on clips that the judge must refuse."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from baselines.suite.templates import CELLS, DRAFTS, Cell, Unfit
from baselines.task_files import stamp
from baselines.tasks import FAMILIES, Split, Task, TaskSpec, make_task
from physagent_jax.core.errors import UserError
from physagent_jax.forces.schema import ForceField
from physagent_jax.metrics.clips import Clip
from physagent_jax.metrics.task_judge import judge

MATERIALS = {"own": "the ", "softer": "the soft ", "stiffer": "the stiff "}
"""The words before an object, by what it is made of."""

_TRIES = 40
_CLEAR = 0.7  # [tolerances] by which the drawn force field may miss its own task


@dataclasses.dataclass(frozen=True)
class Drawn:
    """A task that was drawn.

    Attributes:
        spec: The task.
        witness: The force field that it was made of, with which it is a success. No method sees it.
        tries: Draws that it took.
    """

    spec: TaskSpec
    witness: ForceField
    tries: int


def commit_seed(seed: int) -> str:
    """SHA-256 that is published before methods are frozen, and tells the seed from any other afterwards."""
    return hashlib.sha256(f"physagent suite {seed}".encode()).hexdigest()


def list_cells(split: Split | None) -> dict[str, list[Cell]]:
    """The cells of a split by family."""

    def is_in(cell: Cell) -> bool:
        odd = hashlib.sha256(cell.name.encode()).digest()[-1] % 2
        return split is None or odd == (split == "test")

    return {family: [c for c in CELLS if c.family == family and is_in(c)] for family in FAMILIES}


def draw_task(seed: int, number: int, folder: Path, split: Split | None = None) -> Drawn:
    """The task of a number, whatever others are drawn.

    Families follow each other, so that they are balanced; all else is drawn. A draw is no task where its motion is too
    small or too large to be asked for, where its force field misses it, or where the judge takes a wrong clip for it.

    Args:
        seed: Seed of the suite.
        number: From 0.
        folder: Where files of objects go that are made.
        split: Only cells of this split; None = of both.

    Raises:
        UserError: There is none in `_TRIES` draws, which is a fault of a template.
    """
    family = FAMILIES[number % len(FAMILIES)]
    cells = list_cells(split)[family]
    for attempt in range(_TRIES):
        rng = np.random.default_rng([seed, number, attempt])
        cell = cells[int(rng.integers(len(cells)))]
        try:
            spec, field = _draw(rng, cell, number, folder)
        except Unfit:
            continue
        return Drawn(spec, field, attempt + 1)
    raise UserError(f"no task of the family {family} was drawn", got=f"seed {seed}, number {number}")


def _draw(rng: np.random.Generator, cell: Cell, number: int, folder: Path) -> tuple[TaskSpec, ForceField]:
    material = str(rng.choice(list(MATERIALS)))
    draft = DRAFTS[cell.family](rng, cell.variant, MATERIALS[material] + cell.object)
    fields = dict(
        name=f"{cell.name}--{number:04d}",
        sentence="(not yet known)",
        family=cell.family,
        object=cell.object,
        scene=dict(draft.scene),
        target=dict(clauses=[dict(kind="rest", window=(0, 1))]),
        begin=draft.begin,
        hidden=draft.hidden,
        material=material,
    )
    task = make_task(stamp(fields), folder)
    try:
        x = task.simulate(draft.field)
    except UserError as error:  # it cannot be simulated
        raise Unfit from error
    sentences, clauses = draft.ask(task, Clip(x, task.mass, task.frame_dt))
    if cell.family != "recovery":
        clauses.append({"kind": "integrity", "window": (0, task.frame_count - 1), "tolerance": 0.01})
    told = fields | dict(sentence=str(rng.choice(sentences)), target=dict(clauses=clauses))
    spec = stamp(told)
    if not _is_told_apart(dataclasses.replace(task, spec=spec), x):
        raise Unfit
    return spec, draft.field


def _is_told_apart(task: Task, x: np.ndarray) -> bool:
    """Return whether the clip is clearly a success, and standing still, half, twice and mirrored are none."""

    def is_right(clip: np.ndarray) -> bool:
        return judge(task.target, clip, task.mass, task.frame_dt).success

    rest, moved = x[:1], x - x[:1]
    falls = moved * np.array([1.0, 1.0, 0.0])  # a fall is the same in its mirror image
    wrong = [np.broadcast_to(rest, x.shape), rest + 0.5 * moved, rest + 2 * moved, x - 2 * falls]
    return task.judge(x).error < _CLEAR and not any(map(is_right, wrong))


def hash_suite(specs: Sequence[TaskSpec]) -> str:
    """SHA-256 over the hashes of all tasks, which cover their words, targets, scenes and objects."""
    text = json.dumps(sorted((spec.name, spec.task_hash) for spec in specs))
    return hashlib.sha256(text.encode()).hexdigest()
