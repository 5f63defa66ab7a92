"""Particles whose stress moves nothing: all that share nodes with them are led for the whole clip.

What a skill leads, or an anchor holds, goes where that says, whatever its stress. Where a limb bends beside its joint,
its matter is strained by several times its length, and such a strain would shorten the substeps of the whole object.
"""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from physagent_jax.forces.schema import ConstraintType, VelocityConstraint
from physagent_jax.mpm import PrescribedMotion
from physagent_jax.mpm.protocols import Constraint
from physagent_jax.scene import config as c

SOFT = 1e-3
"""Factor on the stiffness of what is idle: steps may be thirty times as long."""
_LEVEL = 0.5  # component along the vertical below which an axis is level
REACH = 3  # cells over which two particles share nodes
ELASTIC = (c.MaterialModel.NEO_HOOKEAN, c.MaterialModel.FIXED_COROTATED, c.MaterialModel.HENCKY)
"""Models whose deformation does not depend on the stress; others flow by it, which is seen."""


def find_idle(
    config: c.SceneConfig, grips: tuple[Constraint, ...], held: np.ndarray, rest: np.ndarray
) -> np.ndarray:
    """Particles whose stress moves nothing, shape (n,).

    None are where the clip goes on after its planned frames (`simulation.ending`): what was led is then let go.

    Args:
        config: The scene.
        grips: Constraints that its force field makes.
        held: Particles that are held for ever, shape (n,).
        rest: Rest positions [m], shape (n, 3).
    """
    models = {config.material.model, *(region.material.model for region in config.material_regions)}
    if not is_led_to_end(config) or not models.issubset(ELASTIC):
        return np.zeros(len(rest), bool)
    led = held | _find_led(grips, len(rest), config.timing.duration)
    cells = np.floor((rest - rest.min(0)) / config.domain.dx).astype(np.int64)
    free = np.zeros(cells.max(0) + 1, bool)
    free[tuple(cells[~led].T)] = True
    beside = np.asarray(ndimage.binary_dilation(free, np.ones((3, 3, 3)), iterations=REACH), bool)
    return led & ~beside[tuple(cells.T)]


def is_led_to_end(config: c.SceneConfig) -> bool:
    """Return whether a constraint acts until the planned frames end, and the clip is to end there.

    It holds something, leads a part of what is held, or rocks the whole: letting it go would undo what was asked, or
    let what is rocked fall over.
    """
    last, held = config.timing.frame_count - 1, config.anchor.kind != "none"
    return any(
        (each.held_until or 0) >= last
        or (
            (each.active_time is None or each.active_time[1] >= last)
            and (_rocks(each) if each.region is None else held)
        )
        for each in config.force_field.constraints
    )


def _rocks(constraint: VelocityConstraint) -> bool:
    """Return whether it turns the whole about a level axis."""
    return (
        constraint.constraint_type is ConstraintType.PARTICLE_ROTATION and abs(constraint.vector[2]) < _LEVEL
    )


def _find_led(grips: tuple[Constraint, ...], count: int, duration: float) -> np.ndarray:
    """Particles that some motion prescribes at any time until ``duration`` [s], shape (n,)."""
    motions = [each for each in grips if isinstance(each, PrescribedMotion)]
    spans = [(float(np.min(each.start)), float(np.max(each.end))) for each in motions]
    edges = sorted({0.0, duration, *(time for span in spans for time in span if 0 < time < duration)})
    led = np.ones(count, bool)
    for begin, end in zip(edges, edges[1:]):
        now = np.zeros(count + 1, bool)  # the last stands for no particle
        for each, (first, last) in zip(motions, spans):
            if first <= 0.5 * (begin + end) < last:
                now[np.asarray(each.particles)] = True
        led &= now[:-1]
    return led
