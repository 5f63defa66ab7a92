"""Files of tasks: written so that people can read them, each target with its hash; paths for recovery tasks."""

from __future__ import annotations

import json
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel

from baselines.tasks import Task, TaskSpec
from physagent_jax.core.files import write_text
from physagent_jax.forces.schema import ForceField
from physagent_jax.metrics.clips import Clip
from physagent_jax.metrics.targets import Path as StoredPath
from physagent_jax.metrics.targets import Target, hash_target

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
_SIGNIFICANT = 9  # digits of numbers in files
_WIDTH = 110


def stamp(fields: dict[str, Any]) -> TaskSpec:
    """A task from its fields, with the hash of its target."""
    target = Target.model_validate(fields["target"])
    return TaskSpec.model_validate({**fields, "target_hash": hash_target(target)})


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
    write_text(path, format_json([_dump(spec) for spec in specs]) + "\n")


def write_witnesses(path: Path, witnesses: dict[str, ForceField]) -> None:
    """Write the force fields that make tasks successes."""
    write_text(path, format_json({name: _dump(field) for name, field in witnesses.items()}) + "\n")


def _dump(value: Any) -> Any:
    """As plain values: kinds first, then what is not at its default, and tolerances always."""
    if isinstance(value, tuple):
        return [_dump(each) for each in value]
    if isinstance(value, StrEnum):
        return value.value
    if isinstance(value, float):
        return float(f"{value:.{_SIGNIFICANT}g}")  # a unit vector that is read again is written as it was
    if not isinstance(value, BaseModel):
        return value
    names = sorted(type(value).model_fields, key=lambda name: name != "kind")
    return {
        name: _dump(getattr(value, name))
        for name in names
        if name in ("kind", "tolerance") or getattr(value, name) != type(value).model_fields[name].default
    }


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
