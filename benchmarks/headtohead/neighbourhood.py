"""Starts near a solution, from which a local method should solve its task.

A method that misses from the neighbourhood of a force field which is a success is broken; one that misses from afar, as
in the comparison of all methods, may only have been too far away. The neighbourhood is around the task's witness: each
|M| of it `STRONGER` or weaker, each direction turned by `TURNED` about an axis drawn at random, types, windows and
regions as they are.
"""

from __future__ import annotations

import dataclasses
import hashlib
from typing import Literal

import numpy as np

from baselines.tasks import Task
from benchmarks.headtohead.entrants import LOCAL, Entrant
from physagent_jax.forces.calibration import MAGNITUDE_MAX, MAGNITUDE_MIN
from physagent_jax.forces.schema import ForceField

Begin = Literal["near", "begin"]
"""Near the witness, or at the first force field that the task itself gives (recovery)."""

STRONGER = 0.3
"""Part of |M| that is added or taken away, whichever the library allows; by chance where both are."""

TURNED = 20.0
"""[degrees]."""


def list_entrants(begin: Begin) -> tuple[Entrant, ...]:
    """The local methods that begin there."""
    return tuple(Entrant(f"{name}, {begin}", name, dict(types="task", numbers="task")) for name in LOCAL)


def list_begins(task_gives_one: bool) -> tuple[Begin, ...]:
    """From where a task's searches begin."""
    return ("near", "begin") if task_gives_one else ("near",)


def move(task: Task, witness: ForceField, seed: int) -> Task:
    """The task, begun in the neighbourhood of ``witness``; the same for the same name and seed."""
    digest = hashlib.sha256(f"{task.spec.name} {seed}".encode()).digest()
    begin = perturb(witness, np.random.default_rng(list(digest)))
    return dataclasses.replace(task, spec=task.spec.model_copy(update=dict(begin=begin)))


def perturb(field: ForceField, rng: np.random.Generator) -> ForceField:
    """Every action and constraint with another magnitude and direction."""
    return field.model_copy(
        update=dict(
            actions=tuple(_perturb_one(item, rng) for item in field.actions),
            constraints=tuple(_perturb_one(item, rng) for item in field.constraints),
        )
    )


def _perturb_one(item, rng: np.random.Generator):
    sizes = [item.magnitude * factor for factor in (1 + STRONGER, 1 - STRONGER)]
    allowed = [size for size in sizes if MAGNITUDE_MIN <= abs(size) <= MAGNITUDE_MAX]
    along, drawn = np.asarray(item.vector), rng.normal(size=3)
    across = drawn - (drawn @ along) * along
    across /= np.linalg.norm(across)
    angle = np.radians(TURNED)
    x, y, z = (np.cos(angle) * along + np.sin(angle) * across).tolist()
    return item.model_copy(update=dict(vector=(x, y, z), magnitude=float(rng.choice(allowed))))
