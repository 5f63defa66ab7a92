"""Point tracks by GMFlow: a learned search of the whole picture, which finds what has moved or turned far."""

from __future__ import annotations

import hashlib
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import jax
import numpy as np
from flax import nnx  # pyright: ignore[reportMissingImports]

from physagent_jax.core.errors import UserError
from physagent_jax.perception.backends import flow
from physagent_jax.perception.gmflow.checkpoint import make_network, read_tensors
from physagent_jax.perception.protocols import Tracks

_SIDE = 192
"""Side of the square in which pictures are compared [px]."""

_TRIES, _ENOUGH = 3, 0.7
"""A frame in which fewer points are found than this share is searched again, with the motion that was found."""

_ROOM = 0.15
"""Background kept on each side of the object [its longest side]."""


class GmflowTracker(flow.FlowTracker):
    """GMFlow (Xu et al. 2022) from the first frame to each other, corrected at full resolution.

    Each frame is first turned, stretched and moved back as the object was in the frame before, and so that the masks'
    middles meet; the network finds what is left of the motion. That may be 45 degrees or half the object from frame to
    frame, and what turns on and on stays comparable with the first frame, so that nothing drifts. The network is right
    to a pixel; the correction of `FlowTracker` makes that a few hundredths.

    Args:
        weights: A checkpoint of GMFlow: `.safetensors`, or a file of `torch.save`.
        round_trip: Largest forward-backward error of the network's flow [its pixels: the object has about 150].

    Raises:
        UserError: There are no weights, they are of another network, or ``round_trip`` is no length.
    """

    def __init__(self, weights: str, round_trip: float = 3.0):
        if isinstance(round_trip, bool) or not isinstance(round_trip, (int, float)) or not round_trip > 0:
            raise UserError("`round_trip` of the tracker gmflow must be above 0", got=repr(round_trip)[:80])
        super().__init__(round_trip=round_trip)
        if not isinstance(weights, str):
            raise UserError(
                "`weights` of the tracker gmflow must be the path of a file", got=repr(weights)[:80]
            )
        tensors = read_tensors(Path(weights))
        self._graph, self._weights = nnx.split(make_network(tensors))
        digest = hashlib.sha256()
        for name in sorted(tensors):
            digest.update(name.encode() + np.ascontiguousarray(tensors[name]).tobytes())
        self._name = f"{type(self).__name__} {digest.hexdigest()[:12]}"

    @property
    def name(self) -> str:
        """The class and the weights: others are another run."""
        return self._name

    def follow(self, frames: np.ndarray, queries: np.ndarray, masks: np.ndarray) -> Tracks:
        """As `FlowTracker.follow`. A point that was not corrected has a confidence below 1, by its way back."""
        tracks = np.repeat(np.asarray(queries, np.float64)[None], len(frames), axis=0)
        sure = np.zeros(tracks.shape[:2])
        sure[0] = 1.0
        window, expected = _frame(masks[0]), np.eye(2, 3)
        shown, first = _look_through(frames[0], window), cv2.cvtColor(frames[0], cv2.COLOR_RGB2GRAY)
        for t in range(1, len(frames)):
            if not (masks[0].any() and masks[t].any()):
                break
            current = cv2.cvtColor(frames[t], cv2.COLOR_RGB2GRAY)
            expected = _join_middles(expected, masks[0], masks[t])
            for _ in range(_TRIES):
                moved, error = self._search(shown, frames[t], window, expected, tracks[0])
                found = (error < self.round_trip) & flow.find_inside(masks[t], moved)
                tracks[t], good = moved, np.zeros(len(queries), bool)
                for _ in range(2):  # the second time against a picture that is turned back by better points
                    anchored = self._anchor_tracks(
                        first, current, masks[0], tracks[0], tracks[t], found | good
                    )
                    good = np.isfinite(anchored[:, 0])
                    tracks[t] = np.where(good[:, None], anchored, moved)
                seen = (found | good) & flow.find_inside(masks[t], tracks[t])
                fitted = _fit(tracks[0][seen], tracks[t][seen])
                expected = expected if fitted is None else fitted
                if fitted is None or seen.mean() > _ENOUGH:
                    break
            if seen.mean() < self.give_up:
                break
            sure[t] = np.where(seen, np.where(good, 1.0, 1 / (1 + error**2)), 0.0)
        return Tracks(tracks, sure > 0, sure)

    def _search(
        self,
        shown: np.ndarray,
        frame: np.ndarray,
        window: np.ndarray,
        expected: np.ndarray,
        queries: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Positions of ``queries`` in ``frame`` [px], shape (N, 2), and the error of the way back, shape (N,)."""
        seen = _look_through(frame, _chain(expected, window))
        pair = (each[None] / np.float32(255) for each in (shown, seen))
        forth, back = (np.asarray(each[0]) for each in _match(self._graph, self._weights, *pair))
        start = _apply(cv2.invertAffineTransform(window), queries)
        moved = start + flow.look_up(forth, start)
        error = np.linalg.norm(moved + flow.look_up(back, moved) - start, axis=1)
        return _apply(_chain(expected, window), moved), error


@partial(jax.jit, static_argnums=0)
def _match(graph: Any, weights: Any, first: jax.Array, second: jax.Array) -> tuple[jax.Array, jax.Array]:
    with jax.default_matmul_precision("highest"):
        return nnx.merge(graph, weights)(first, second)


def _frame(mask: np.ndarray) -> np.ndarray:
    """The map from a square of `_SIDE` to the picture in which the object fills it up to `_ROOM`, shape (2, 3)."""
    x, y, width, height = cv2.boundingRect(mask.astype(np.uint8))
    middle, longest = np.array([x + width / 2, y + height / 2]), max(width, height, 16)
    step = (1 + 2 * _ROOM) * longest / _SIDE
    return np.hstack([step * np.eye(2), (middle - step * _SIDE / 2)[:, None]])


def _look_through(picture: np.ndarray, window: np.ndarray) -> np.ndarray:
    """The part of a picture that lies in a window of `_frame`, shape (_SIDE, _SIDE, 3)."""
    step = np.sqrt(abs(np.linalg.det(window[:, :2])))
    if step > 1.5:  # fine texture would flicker
        picture = cv2.GaussianBlur(picture, None, 0.5 * step)
    indices = window.copy()  # of pixels, whose centres are at +0.5
    indices[:, 2] += window[:, :2] @ (0.5, 0.5) - 0.5
    how = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(picture, indices, (_SIDE, _SIDE), flags=how, borderMode=cv2.BORDER_REPLICATE)


def _join_middles(expected: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """The map with its linear part as it is, that takes the middle of one mask to that of the other."""
    old, new = (np.argwhere(mask).mean(0)[::-1] + 0.5 for mask in (before, after))
    return np.hstack([expected[:, :2], (new - expected[:, :2] @ old)[:, None]])


def _fit(before: np.ndarray, after: np.ndarray) -> np.ndarray | None:
    """The affine map of most points, shape (2, 3); None if there is none that keeps an area."""
    if len(before) < 3:
        return None
    fitted, _ = cv2.estimateAffine2D(before, after, ransacReprojThreshold=3.0, maxIters=200)
    return None if fitted is None or np.linalg.det(fitted[:, :2]) < 0.02 else fitted


def _chain(second: np.ndarray, first: np.ndarray) -> np.ndarray:
    """The affine map ``second`` after ``first``, shape (2, 3)."""
    return np.hstack([second[:, :2] @ first[:, :2], (second[:, :2] @ first[:, 2] + second[:, 2])[:, None]])


def _apply(affine: np.ndarray, points: np.ndarray) -> np.ndarray:
    return points @ affine[:, :2].T + affine[:, 2]
