"""Messages through the door. What comes out is JSON and plain arrays: to read it runs no code of the sender."""

from __future__ import annotations

import dataclasses
import io
import json
from collections.abc import Mapping
from multiprocessing.connection import Connection
from typing import Any

import numpy as np
from pydantic import BaseModel

from baselines.protocol import Evaluation
from physagent_jax.core.errors import UserError

MOST = 1 << 30
"""Bytes of a message that are read."""


@dataclasses.dataclass(frozen=True)
class Scene:
    """A task as its method is told of it.

    Attributes:
        spec: Fields of the task's `TaskSpec` but those that tell the answer.
        start: The first force field of a method that needs one.
        frame_count: Frames of the clip.
        frame_dt: Time between them [s].
        mass: Mass of the model's particles [kg], shape (n,).
        brief: The scene as agents are told of it.
    """

    spec: Mapping[str, Any]
    start: Any
    frame_count: int
    frame_dt: float
    mass: np.ndarray
    brief: Any


@dataclasses.dataclass(frozen=True)
class Reply:
    """An answer of the evaluator.

    Attributes:
        kind: "value", "spent" (of the budget nothing is left), "refused" or "pictures" (rate these first).
        value: What was asked for; for "refused" the message.
        spent: Forward-equivalents so far.
        first: Place of the first of the evaluations that may be new.
        evaluations: All from there on.
    """

    kind: str
    value: Any
    spent: float
    first: int
    evaluations: tuple[Evaluation, ...]


def send(connection: Connection, header: Mapping[str, Any], arrays: Mapping[str, Any] | None = None) -> None:
    """Send a message outwards: JSON fields, in which models are dumped, and arrays."""

    def dump(value: Any) -> Any:
        if isinstance(value, BaseModel):
            return value.model_dump(mode="json")
        if dataclasses.is_dataclass(value) and not isinstance(value, type):
            return {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
        if isinstance(value, np.generic | np.ndarray):
            return value.tolist()
        raise TypeError(f"{type(value).__name__} cannot be sent through the door")

    file = io.BytesIO()
    text = json.dumps(header, default=dump).encode()
    np.savez(file, **{**(arrays or {}), "header": np.frombuffer(text, np.uint8)})
    connection.send_bytes(file.getvalue())


def receive(connection: Connection) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """The fields and arrays of a message from inside.

    Raises:
        EOFError: The process has ended.
        UserError: The message is none.
    """
    content = connection.recv_bytes(MOST)
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        header = json.loads(arrays.pop("header").tobytes())
        if not isinstance(header, dict):
            raise ValueError("no object")
    except (ValueError, KeyError, OSError) as error:
        raise UserError("a method's process has sent what is no message", got=error) from None
    return header, arrays
