"""The path of a free body that a force field acts on: "unopposed it goes so far"."""

from __future__ import annotations

import numpy as np

from physagent_jax.forces.binding import FreeEntry
from physagent_jax.forces.parameters import ForceFieldParameters
from physagent_jax.forces.schema import ForceField, SkillScaling
from physagent_jax.forces.skills import get_skill
from physagent_jax.forces.swinging import find_strokes


def compute_free_path(
    field: ForceField, scaling: SkillScaling, *, frame_dt: float, frame_count: int
) -> np.ndarray:
    """Displacement of a free body that the field's pushes and blows of either kind act on, and nothing else does.

    Velocities are those at the ends of the frames, so that the path runs a little ahead of the exact one.

    Args:
        field: The force field; regions are left out of account, and so are stretches, turns, and what moves an end.
        scaling: What M = 1 means.
        frame_dt: Seconds per frame [s].
        frame_count: Frames of the clip.

    Returns:
        Displacements at the frames [m], shape (frame_count, 3).
    """
    gained = np.zeros((frame_count - 1, 3))  # change of velocity in each interval [m/s]
    begin = np.arange(frame_count - 1)
    numbers = ForceFieldParameters.of(field, frame_count)
    strokes = find_strokes(field, numbers.actions, scaling, frame_dt)
    for group in ("actions", "constraints"):
        for index, (entry, values) in enumerate(zip(getattr(field, group), getattr(numbers, group))):
            stroke = strokes.get(index) if group == "actions" else None
            free = FreeEntry(values, entry.region is None, scaling, frame_dt, begin, stroke)
            gained = get_skill(entry).accelerate(gained, free)
    steps = np.cumsum(gained, axis=0) * frame_dt
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
