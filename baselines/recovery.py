"""The recovery of a hidden force field, and the numbers of it that the motion identifies."""

from __future__ import annotations

import dataclasses

import numpy as np

from baselines.tasks import Task
from physagent_jax.forces.calibration import MAGNITUDE_MAX
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.schema import Action, ForceField, VelocityConstraint
from physagent_jax.forces.skills import get_skill
from physagent_jax.metrics.identifiability import Identifiability, find_identifiability
from physagent_jax.metrics.recovery import Force, RecoveryErrors, compare_forces
from physagent_jax.metrics.task_judge import compute_residuals

STEP = 0.02  # of M v, of central differences: some hundred times what single precision rounds off


def compare_fields(hidden: ForceField, found: ForceField, frame_count: int) -> RecoveryErrors:
    """Errors of a found force field's actions and velocity constraints.

    Args:
        hidden: What made the motion.
        found: What a method gives.
        frame_count: Frames of the clip, for windows that are the whole of it.
    """
    return compare_forces(*(_list_forces(field, frame_count) for field in (hidden, found)))


def _list_forces(field: ForceField, frame_count: int) -> list[Force]:
    return [_read_force(entry, frame_count) for entry in (*field.actions, *field.constraints)]


def _read_force(entry: Action | VelocityConstraint, frame_count: int) -> Force:
    skill = get_skill(entry)
    x, y, z = (entry.magnitude * c for c in entry.vector)
    return Force(
        kind=skill.name,
        vector=(x, y, z),
        window=entry.active_time or (0.0, float(frame_count - 1)),
        axial=skill.is_two_sided,
        magnitude=entry.magnitude,
    )


def measure_identifiability(task: Task, force_field: ForceField) -> Identifiability:
    """J^T J of the task's residuals by the actions' M v, at a force field, by central differences.

    Each number is scaled by the library's greatest magnitude, so that a direction is identified where a change of the
    force by that much moves the residuals by a tolerance at least. Windows are left out: recovery tasks give them.

    Args:
        task: Whose residuals.
        force_field: Where; for a recovery task the hidden one.
    """
    names, columns = [], []
    for index, action in enumerate(force_field.actions):
        for axis in range(3):
            step = STEP * np.eye(3)[axis]
            above, below = (_find_residuals(task, force_field, index, sign * step) for sign in (1, -1))
            columns.append((above - below) / (2 * STEP))
            names.append(f"actions[{index}] {action.action_type} {'xyz'[axis]}")
    return find_identifiability(np.stack(columns, 1), names, np.full(len(names), MAGNITUDE_MAX))


def _find_residuals(task: Task, field: ForceField, index: int, change: np.ndarray) -> np.ndarray:
    """Residuals with ``change`` added to M v of an action."""
    parameters = ForceFieldParameters.of(field, task.frame_count)
    values = parameters.actions[index]
    vector = values.vector + change * np.sign(values.magnitude) / abs(values.magnitude)
    changed = (
        *parameters.actions[:index],
        dataclasses.replace(
            values,
            vector=vector / np.linalg.norm(vector),
            magnitude=values.magnitude * np.linalg.norm(vector),
        ),
        *parameters.actions[index + 1 :],
    )
    near = dataclasses.replace(parameters, actions=changed).to_force_field(field, task.frame_count)
    return np.asarray(compute_residuals(task.target, task.simulate(near), task.mass, task.frame_dt))
