"""Parts that a capture left loose: found, and joined to the rest.

A capture has no matter where nothing was seen: a hand may float beside its arm. Without gravity it stays behind as soon
as the rest moves, with gravity it falls off. Pieces near the rest are joined to it by particles across the gap, as wide
as where the two face each other; what is farther away is left, and reported.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.spatial import KDTree

from physagent_jax.mpm.pieces import label_pieces as label_pieces
from physagent_jax.scene.filling import Particles

NEAR = 0.2  # [L]: farther pieces are not joined
FACING = 1.5  # cells beyond the least distance that count as facing the rest
SPACING = 0.5  # cells between particles of a joint
FEWEST = 3  # particles, below which a piece is dust
MOST_PIECES = 256


@dataclasses.dataclass(frozen=True)
class LoosePiece:
    """A piece that nothing joins to the rest.

    Attributes:
        share: Share of the particles.
        distance: From the rest [L].
    """

    share: float
    distance: float


def join_pieces(particles: Particles, dx: float) -> tuple[Particles, tuple[LoosePiece, ...]]:
    """The particles with joints between pieces, largest pieces first, and what stays loose.

    Args:
        particles: At rest.
        dx: The simulation's grid spacing [m].
    """
    x = np.asarray(particles.x, np.float64)
    labels = label_pieces(x, dx)
    if not labels.any():
        return particles, ()
    extent = np.ptp(x, axis=0).max()
    joints, loose = [], []
    sizes = np.bincount(labels)[: MOST_PIECES + 1]
    waiting = np.flatnonzero(np.isin(labels, np.flatnonzero(sizes[1:] >= FEWEST) + 1))
    distance, nearest = np.full(len(x), np.inf), np.zeros(len(x), int)  # what of the rest lies nearest
    new = np.flatnonzero(labels == 0)
    while len(waiting):
        if len(new):
            found, index = map(np.asarray, KDTree(x[new]).query(x[waiting]))
            closer = found < distance[waiting]
            distance[waiting[closer]], nearest[waiting[closer]] = found[closer], new[index[closer]]
        least = distance[waiting].min()
        piece = int(np.min(labels[waiting[distance[waiting] == least]]))
        mine = np.flatnonzero(labels == piece)
        waiting = waiting[labels[waiting] != piece]
        if least > NEAR * extent:
            loose.append(LoosePiece(len(mine) / len(x), float(least / extent)))
            new = mine[:0]
            continue
        facing = mine[distance[mine] <= least + FACING * dx]
        joints.append(_bridge(x[facing], x[nearest[facing]], SPACING * dx))
        new = mine
    if not joints:
        return particles, tuple(loose)
    added = _thin_out(np.concatenate(joints), x, SPACING * dx)
    joined = Particles(
        np.concatenate([particles.x, added.astype(np.float32)]),
        np.concatenate([particles.volume, np.full(len(added), np.median(particles.volume), np.float32)]),
        np.concatenate([particles.gaussian_index, np.full(len(added), -1, np.int32)]),
        None if particles.enclosed is None else np.pad(particles.enclosed, (0, len(added))),
    )
    return joined, tuple(loose)


def explain_loose(pieces: tuple[LoosePiece, ...]) -> str | None:
    """Explain loose pieces to the user."""
    seen = [piece for piece in pieces if piece.share >= 1e-3]
    if not seen:
        return None
    words = ", ".join(f"{piece.share:.1%} at {piece.distance:.2f} L" for piece in seen[:4])
    return (
        f"{len(seen)} piece(s) of the object are joined to the rest by nothing ({words}): they fall or stay behind; "
        "`source.crop` removes them"
    )


def _bridge(one: np.ndarray, other: np.ndarray, spacing: float) -> np.ndarray:
    """Points on the lines between pairs of points, shape (m, 3)."""
    count = max(2, int(np.ceil(np.linalg.norm(one - other, axis=1).max() / spacing)) + 1)
    share = np.linspace(0, 1, count)[1:-1] if count > 2 else np.array([0.5])
    return (one[:, None] + share[:, None] * (other - one)[:, None]).reshape(-1, 3)


def _thin_out(points: np.ndarray, x: np.ndarray, spacing: float) -> np.ndarray:
    """One of ``points`` per cell of ``spacing`` [m] in which nothing of ``x`` lies."""
    low = np.minimum(points.min(0), x.min(0))
    cells = np.floor((np.concatenate([x, points]) - low) / spacing).astype(np.int64)
    keys = np.ravel_multi_index(cells.T, cells.max(0) + 1)
    first = np.sort(np.unique(keys[len(x) :], return_index=True)[1])
    kept = first[~np.isin(keys[len(x) :][first], keys[: len(x)])]
    return points[kept if len(kept) else first]
