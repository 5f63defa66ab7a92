"""Hash of a whole task: its words, its scene, its target and force fields, and the object that it is about."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from enum import StrEnum
from typing import Any

from pydantic import BaseModel

from baselines.objects import DENSITY, OBJECTS, TaskObject

NAME = "task_hash"
_SIGNIFICANT = 9  # digits of numbers in files
_NO_HASHES = ("file", "data", "captured")  # of an object: its file is known by its digest


def hash_task(spec: BaseModel) -> str:
    """SHA-256 of all that a task's file says of it but this hash, and of its object with the file's digest."""
    fields = {name: value for name, value in to_plain(spec).items() if name != NAME}
    about = describe_object(OBJECTS[fields["object"]])
    text = json.dumps([fields, about], sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


def describe_object(thing: TaskObject) -> dict[str, Any]:
    """The constants of an object that change its motion."""
    fields = dataclasses.asdict(thing) | {"density": DENSITY}
    return {name: value for name, value in fields.items() if name not in _NO_HASHES}


def to_plain(value: Any) -> Any:
    """A model as files of tasks have it: kinds first, then what is not at its default, and tolerances always."""
    if isinstance(value, tuple):
        return [to_plain(each) for each in value]
    if isinstance(value, StrEnum):
        return value.value
    if isinstance(value, float):
        return float(f"{value:.{_SIGNIFICANT}g}")  # a unit vector that is read again is written as it was
    if not isinstance(value, BaseModel):
        return value
    names = sorted(type(value).model_fields, key=lambda name: name != "kind")
    return {
        name: to_plain(getattr(value, name))
        for name in names
        if name in ("kind", "tolerance") or getattr(value, name) != type(value).model_fields[name].default
    }
