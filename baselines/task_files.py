"""Files of tasks: written so that people can read them, each with its hash; paths for recovery tasks."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from baselines.task_hashes import hash_task, to_plain
from baselines.tasks import Task, TaskSpec
from physagent_jax.core.files import write_text
from physagent_jax.forces.schema import ForceField
from physagent_jax.metrics.clips import Clip
from physagent_jax.metrics.targets import Path as StoredPath
from physagent_jax.metrics.targets import Target

ENDS = (
    (1.0, 0.0, 0.0),
    (-1.0, 0.0, 0.0),
    (0.0, 1.0, 0.0),
    (0.0, -1.0, 0.0),
    (0.0, 0.0, 1.0),
    (0.0, 0.0, -1.0),
)
"""Beside the whole, what a recovery task's target follows: it then says how the object turns and deforms too."""
_DIGITS = 4  # of stored paths [body lengths]
_WIDTH = 110


def stamp(fields: dict[str, Any]) -> TaskSpec:
    """A task from its fields, with its hash."""
    spec = TaskSpec.model_validate({**fields, "task_hash": ""})
    return spec.model_copy(update={"task_hash": hash_task(spec)})


def record_target(task: Task, hidden: ForceField, tolerance: float) -> Target:
    """The target of a recovery task: what the whole and its six ends do under ``hidden``.

    Args:
        task: Any task on the same scene.
        hidden: The force field that is to be recovered.
        tolerance: [body lengths].
    """
    clip = Clip(task.simulate(hidden), task.mass, task.frame_dt)
    places = []
    for part in (None, *ENDS):
        centre = np.asarray(clip.centre(part), np.float64)
        places.append({"part": part, "centres": np.round(centre - centre[0], _DIGITS) + 0.0})
    window = (0, task.frame_count - 1)
    path = {"kind": "path", "window": window, "places": places, "tolerance": tolerance}
    return Target(clauses=(StoredPath.model_validate(path),))


def write_tasks(path: Path, specs: Sequence[TaskSpec]) -> None:
    """Write a family's file; what a task leaves at its default is left out."""
    write_text(path, format_json([to_plain(spec) for spec in specs]) + "\n")


def write_witnesses(path: Path, witnesses: dict[str, ForceField]) -> None:
    """Write the force fields that make tasks successes."""
    write_text(path, format_json({name: to_plain(field) for name, field in witnesses.items()}) + "\n")


def format_json(value: Any, indent: int = 0) -> str:
    """JSON in which what fits stands on one line."""
    flat = json.dumps(value, ensure_ascii=False)
    if len(flat) + indent <= _WIDTH or not isinstance(value, dict | list):
        return flat
    pad = " " * (indent + 2)
    if isinstance(value, dict):
        inner = [f"{json.dumps(key)}: {format_json(each, indent + 2)}" for key, each in value.items()]
    elif all(isinstance(each, list) for each in value):
        return _fill([json.dumps(each) for each in value], indent)
    else:
        inner = [format_json(each, indent + 2) for each in value]
    begin, end = "{}" if isinstance(value, dict) else "[]"
    return begin + "\n" + ",\n".join(pad + line for line in inner) + "\n" + " " * indent + end


def _fill(items: list[str], indent: int) -> str:
    """Vectors, as many on a line as fit."""
    pad, lines = " " * (indent + 2), [""]
    for item in items:
        if lines[-1] and len(pad) + len(lines[-1]) + len(item) > _WIDTH:
            lines.append("")
        lines[-1] += (", " if lines[-1] else "") + item
    return "[\n" + ",\n".join(pad + line for line in lines) + "\n" + " " * indent + "]"
