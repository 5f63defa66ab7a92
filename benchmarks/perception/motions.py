"""Motions that are known exactly: affine maps about the object's centre, in the viewer's directions."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

RIGHT, AWAY, UP = np.eye(3)
"""The viewer's directions: the camera looks along +y, z is up."""
LOOK = np.array([0.0, np.cos(np.radians(12.0)), -np.sin(np.radians(12.0))])
"""The viewing direction of `scenes.make_camera`."""


@dataclasses.dataclass(frozen=True)
class Motion:
    """x -> R S (x - c) + c + L d.

    Attributes:
        shift: d at phase s in [0, 1] [body lengths], shape (3,).
        turn: Rotation vector at phase s [deg], shape (3,).
        factors: Stretch along right, away and up at phase s, shape (3,).
        frequency: Frequency of a swing [1 / clip]; None if it does not swing.
        in_plane: Whether all turning is in the picture plane.
    """

    shift: Callable[[float], np.ndarray] = lambda s: np.zeros(3)
    turn: Callable[[float], np.ndarray] = lambda s: np.zeros(3)
    factors: Callable[[float], np.ndarray] = lambda s: np.ones(3)
    frequency: float | None = None
    in_plane: bool = True

    def matrix(self, s: float) -> np.ndarray:
        """R S at phase s, shape (3, 3)."""
        return Rotation.from_rotvec(np.radians(self.turn(s))).as_matrix() @ np.diag(self.factors(s))


def _ease(s: float) -> float:
    """From 0 to 1 without a jump in speed."""
    return s * s * (3 - 2 * s)


def _make_shift(vector) -> Motion:
    return Motion(shift=lambda s: _ease(s) * np.asarray(vector, float))


def _make_turn(axis, degrees: float) -> Motion:
    return Motion(
        turn=lambda s: _ease(s) * degrees * np.asarray(axis, float),
        in_plane=bool(abs(np.dot(axis, LOOK)) > 0.99),
    )


def _make_stretch(*factors) -> Motion:
    return Motion(factors=lambda s: 1 + _ease(s) * (np.asarray(factors, float) - 1))


def _make_swing(vector, periods: float) -> Motion:
    return Motion(
        shift=lambda s: np.sin(2 * np.pi * periods * s) * np.asarray(vector, float), frequency=periods
    )


def _combine(first: Motion, second: Motion) -> Motion:
    return Motion(
        shift=lambda s: first.shift(s) + second.shift(s),
        turn=lambda s: first.turn(s) + second.turn(s),
        factors=lambda s: first.factors(s) * second.factors(s),
        frequency=first.frequency or second.frequency,
        in_plane=first.in_plane and second.in_plane,
    )


MOTIONS: dict[str, Motion] = {
    "nothing": Motion(),
    "right 0.5": _make_shift((0.5, 0, 0)),
    "left 0.15": _make_shift((-0.15, 0, 0)),
    "up 0.4": _make_shift((0, 0, 0.4)),
    "towards 0.4": _make_shift((0, -0.4, 0)),
    "away 0.5": _make_shift((0, 0.5, 0)),
    "right, up and away": _make_shift((0.3, 0.3, 0.2)),
    "in the plane 15": _make_turn(LOOK, 15),
    "in the plane 45": _make_turn(-LOOK, 45),
    "in the plane 90": _make_turn(LOOK, 90),
    "about the vertical 15": _make_turn(UP, 15),
    "about the vertical 45": _make_turn(-UP, 45),
    "about the vertical 90": _make_turn(UP, 90),
    "tipped away 30": _make_turn(-RIGHT, 30),
    "tipped towards 60": _make_turn(RIGHT, 60),
    "stretched up 1.35": _make_stretch(1, 1, 1.35),
    "stretched across 1.25": _make_stretch(1.25, 1, 1),
    "squeezed down 0.65": _make_stretch(1, 1, 0.65),
    "squeezed across 0.75": _make_stretch(0.75, 1, 1),
    "sways across": _make_swing((0.25, 0, 0), 2.0),
    "bobs": _make_swing((0, 0, 0.15), 3.0),
    "right, turned 45 about the vertical": _combine(_make_shift((0.4, 0, 0)), _make_turn(UP, 45)),
    "down, tipped 30 and turned 20": _combine(
        _make_shift((0, 0, -0.35)), _combine(_make_turn(-RIGHT, 30), _make_turn(LOOK, 20))
    ),
    "left and squeezed down 0.75": _combine(_make_shift((-0.35, 0, 0)), _make_stretch(1.1, 1.1, 0.75)),
}
