"""Turns through views in which nothing can be followed: a thin thing seen from its edge, for some frames.

Points are followed in chains, and poses of different chains cannot be compared (`follow`). What turned before a gap
and turns alike after it has turned on in between: a body that spins does not stop for a few frames.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.spatial.transform import Rotation

from physagent_jax.perception.fit import Affine

SPAN = 8
"""Frames before and after a gap that tell how fast it turns."""
FEWEST = 3
"""Steps from frame to frame that tell it at least."""
LEAST = np.radians(1.0)
"""Turn from frame to frame below which it is not known to turn [rad]."""
MOST = np.radians(100.0)
"""Turn in a gap beyond which nobody can say how far it went [rad]."""
UNLIKE = 0.4
"""Difference of two turns, over the larger, from which on they are not alike."""


@dataclasses.dataclass(frozen=True)
class Bridged:
    """Rotations from frame 0, across gaps where those can be bridged.

    Attributes:
        rotations: Per frame, shape (3, 3) each; None where not known.
        guessed: Sum of the turns in the gaps [rad].
    """

    rotations: list[np.ndarray | None]
    guessed: float = 0.0


def bridge(poses: list[Affine | None], chain: np.ndarray) -> Bridged:
    """Put the chains' rotations one after the other.

    Args:
        poses: Map from a chain's first frame per frame, None where unknown.
        chain: Chain of each frame, shape (T,).
    """
    rotations: list[np.ndarray | None] = [None] * len(poses)
    guessed, before = 0.0, np.zeros(0, int)
    for number in dict.fromkeys(chain[chain >= 0].tolist()):
        frames = np.array([t for t in np.flatnonzero(chain == number) if poses[t] is not None], int)
        own = {t: _get_rotation(poses, t) for t in frames}
        start = np.eye(3)
        if len(before):
            if (found := _cross(rotations, before, own, frames)) is None:
                continue
            start, turn, frames = found
            guessed += turn
        elif not len(frames) or frames[0] != 0:
            break  # nothing is known of frame 0, with which all are compared
        for t in frames:
            rotations[t] = start @ own[t]
        before = frames
    return Bridged(rotations, guessed)


def _get_rotation(poses: list[Affine | None], t: int) -> np.ndarray:
    pose = poses[t]
    assert pose is not None
    return pose.rotation


def _cross(
    rotations: list[np.ndarray | None], before: np.ndarray, own: dict[int, np.ndarray], after: np.ndarray
) -> tuple[np.ndarray, float, np.ndarray] | None:
    """The rotation that a later chain begins with, the turn in the gap [rad], and its frames that can be relied on.

    None if it does not turn alike on both sides of the gap, or may have turned too far in between. Frames at the gap
    whose turn differs from that of the others are taken for lost: there the last points are followed wrongly.
    """
    known = {t: r for t in before if (r := rotations[t]) is not None}
    first = _find_steady(known, before[::-1][:SPAN])
    second = _find_steady(own, after[:SPAN])
    if first is None or second is None:
        return None
    (last, one), (begin, other) = first, second
    size = max(np.linalg.norm(one), np.linalg.norm(other))
    speed = 0.5 * (one + other)
    turn = float(np.linalg.norm(speed)) * (begin - last)
    if size < LEAST or np.linalg.norm(one - other) > UNLIKE * size or turn > MOST:
        return None
    gap = Rotation.from_rotvec(speed * (begin - last)).as_matrix()
    return gap @ known[last] @ own[begin].T, turn, after[after >= begin]


def _find_steady(rotations: dict[int, np.ndarray], frames: np.ndarray) -> tuple[int, np.ndarray] | None:
    """The frame nearest to the gap that turns as those beside it do, and their turn per frame [rad], shape (3,).

    Args:
        rotations: Rotation per frame.
        frames: Frames, the nearest to the gap first.
    """
    pairs = [(a, b) for a, b in zip(frames, frames[1:])]
    if len(pairs) < FEWEST:
        return None
    steps = np.array(
        [
            Rotation.from_matrix(rotations[max(p)] @ rotations[min(p)].T).as_rotvec() / abs(p[0] - p[1])
            for p in pairs
        ]
    )
    usual = np.median(steps, axis=0)
    alike = np.linalg.norm(steps - usual, axis=1) <= UNLIKE * np.linalg.norm(usual)
    if alike.sum() < FEWEST:
        return None
    return int(pairs[int(np.argmax(alike))][0]), steps[alike].mean(0)
