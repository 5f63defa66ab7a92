"""The leaderboard: one line of JSON per fit, which names the force field, so that anyone can check it or add their own.

A line needs nothing of this code but the tasks: who has another method writes its force fields, and `verify` simulates
and judges them like ours.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pydantic import Field, ValidationError

from benchmarks.harness import Row
from physagent_jax.core.errors import UserError
from physagent_jax.core.files import write_text
from physagent_jax.core.reading import format_validation_error
from physagent_jax.core.strict import Strict
from physagent_jax.forces.schema import ForceField

PARTS = ("methods", "suite", "ablation", "iterations", "models", "distillation", "neighbourhood")


class Entry(Strict):
    """A fit.

    Attributes:
        method: As in the tables.
        task, split: Which task, of which split.
        seed: Seed of all that was random.
        oracle: Whether the target was looked at.
        budget, spent: Forward-equivalents that were given and used.
        seconds: Wall time; None = not told.
        success: What the judge said.
        error: Largest miss [tolerances]; None = it could not be simulated.
        force_field: What was found.
        task_hash: Hash of the task that it was judged by.
        revision: Revision of the code that simulated it.
    """

    method: str
    task: str
    split: str
    seed: int = 0
    oracle: bool
    budget: float = Field(gt=0)
    spent: float = Field(ge=0)
    seconds: float | None = None
    success: bool
    error: float | None
    force_field: ForceField
    task_hash: str
    revision: str

    @property
    def key(self) -> tuple:
        """Two fits with the same are the same fit, made again."""
        return self.method, self.task, self.seed, self.budget

    @property
    def job(self) -> str:
        """Name of its check."""
        return f"{self.task} / {self.method} / {self.seed} / {self.budget:g}"


def list_entries(result: dict[str, Any]) -> list[Entry]:
    """A line for each row of a result; none for a fit that was refused, or whose whole task was not hashed yet."""
    entries = []
    for part in PARTS:
        section = result.get(part, {"rows": []})
        for row in section["rows"]:
            if row["marks"] and "task_hash" in row:
                entries.append(_make_entry(row, section["runs"][row["run"]]))
    return entries


def _make_entry(row: Row, run: dict[str, Any]) -> Entry:
    last = row["marks"][-1]
    return Entry(
        method=row["label"],
        task=row["task"],
        split=row["split"],
        seed=row["seed"],
        oracle=row["oracle"],
        budget=last["mark"],
        spent=row["spent"],
        seconds=row["seconds"],
        success=last["success"],
        error=last["error"] if last["error"] < float("inf") else None,
        force_field=last["force_field"],
        task_hash=row["task_hash"],
        revision=str(run["git_revision"]),
    )


def read(path: Path) -> list[Entry]:
    """The lines of a leaderboard; none where there is no file.

    Raises:
        UserError: A line is not an entry.
    """
    entries = []
    lines = path.read_text().splitlines() if path.is_file() else []
    for number, line in enumerate(lines, 1):
        try:
            entries.append(Entry.model_validate_json(line))
        except ValidationError as error:
            raise format_validation_error(error, f"{path}:{number}", Entry) from None
    return entries


def merge(path: Path, result: dict[str, Any]) -> None:
    """Write the result's fits to a leaderboard: what is there already and not made again stays.

    Raises:
        UserError: A line that is there is not an entry.
    """
    kept = {entry.key: entry for entry in (*read(path), *list_entries(result))}
    lines = [
        entry.model_dump(mode="json", exclude_none=True) | {"error": entry.error} for entry in kept.values()
    ]
    lines.sort(key=lambda line: (line["task"], line["method"], line["seed"], line["budget"]))
    write_text(path, "".join(json.dumps(line) + "\n" for line in lines))


def as_row(entry: Entry) -> Row:
    """As `verify` takes it."""
    if entry.error is None and entry.success:
        raise UserError(f"{entry.job} is called a success and has no error", do="Give its error")
    field = entry.force_field.model_dump(mode="json")
    error = float("inf") if entry.error is None else entry.error
    mark = {"mark": entry.budget, "success": entry.success, "error": error, "force_field": field}
    return {"job": entry.job, "task": entry.task, "task_hash": entry.task_hash, "marks": [mark]}
