"""Recovery of a known force: magnitude error in per cent, direction error in degrees.

The measures of "Seeing the Wind from a Falling Leaf" (NeurIPS 2025), per action instead of per point in space.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from physagent_jax.core.strict import Strict

_NOTHING = 1e-12


class ForceError(Strict):
    """Of one hidden action.

    Attributes:
        magnitude_percent: | |f| - |h| | / |h| of the found f and the hidden h; 100 where it was not found.
        direction_degrees: Angle between them; None where it was not found, or has no direction.
        window_percent: Frames in which only one of them acts, over those in which the hidden one does.
    """

    magnitude_percent: float
    direction_degrees: float | None
    window_percent: float


class Force(Strict):
    """An action as numbers.

    Attributes:
        kind: Only forces of one kind compare ("translation", ...).
        vector: Direction times magnitude, whose sign turns it round.
        window: First and last frame.
        axial: Whether the vector and its opposite are the same, but for the sign of the magnitude: a stretch.
        magnitude: M with its sign.
    """

    kind: str
    vector: tuple[float, float, float]
    window: tuple[float, float]
    axial: bool = False
    magnitude: float = 1.0


class RecoveryErrors(Strict):
    """Of a force field.

    Attributes:
        actions: Errors of each hidden action.
        magnitude_percent: Mean over them.
        direction_degrees: Mean over those that were found; None if none was.
        missing: Hidden actions that were not found.
        extra: Found actions that are none of them.
    """

    actions: tuple[ForceError, ...]
    magnitude_percent: float
    direction_degrees: float | None
    missing: int
    extra: int


def compare_forces(hidden: Sequence[Force], found: Sequence[Force]) -> RecoveryErrors:
    """Set the found forces against the hidden ones.

    Each hidden action, in order, is paired with the action of its kind, not yet taken, whose window overlaps most.

    Args:
        hidden: What made the motion; at least one.
        found: What a method gives.
    """
    left = list(found)
    errors, missing = [], 0
    for force in hidden:
        rivals = [other for other in left if other.kind == force.kind and _overlap(force, other) > 0]
        if not rivals:
            missing += 1
            errors.append(ForceError(magnitude_percent=100.0, direction_degrees=None, window_percent=100.0))
            continue
        match = max(rivals, key=lambda other: _overlap(force, other))
        left.remove(match)
        errors.append(_compare(force, match))
    angles = [error.direction_degrees for error in errors if error.direction_degrees is not None]
    return RecoveryErrors(
        actions=tuple(errors),
        magnitude_percent=float(np.mean([error.magnitude_percent for error in errors])),
        direction_degrees=float(np.mean(angles)) if angles else None,
        missing=missing,
        extra=len(left),
    )


def _compare(hidden: Force, found: Force) -> ForceError:
    h, f = np.asarray(hidden.vector, float), np.asarray(found.vector, float)
    sizes = np.linalg.norm(h), np.linalg.norm(f)
    angle = None
    if min(sizes) > _NOTHING:
        if hidden.axial and f @ h * hidden.magnitude * found.magnitude < 0:
            f = -f  # the same line
        angle = float(np.degrees(np.arctan2(np.linalg.norm(np.cross(h, f)), h @ f)))
    span = max(hidden.window[1] - hidden.window[0], _NOTHING)
    both, one = _overlap(hidden, found), found.window[1] - found.window[0]
    return ForceError(
        magnitude_percent=float(100.0 * abs(sizes[1] - sizes[0]) / max(sizes[0], _NOTHING)),
        direction_degrees=angle,
        window_percent=float(100.0 * (span + one - 2 * both) / span),
    )


def _overlap(a: Force, b: Force) -> float:
    """Frames in which both act."""
    return min(a.window[1], b.window[1]) - max(a.window[0], b.window[0])
