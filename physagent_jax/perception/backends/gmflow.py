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

SIDE = 192
"""Side of the square in which pictures are compared [px]."""

_TRIES, _ENOUGH = 3, 0.7
"""A frame in which fewer points are found than this share is searched again, with the motion that was found."""

_CONFIRMED = 0.75
"""Share of points found again in the first frame from which on the network is not asked."""

_COARSE = 0.3
"""Confidence in what the network found and nothing corrected, where the way back agrees."""

_ROOM = 0.15
"""Background kept on each side of the object [its longest side]."""


class GmflowTracker(flow.FlowTracker):
    """As `FlowTracker`, and GMFlow (Xu et al. 2022) wherever that does not find the first frame's points again.

    The frame is first turned, stretched and moved back as the object was in the frame before, and so that the masks'
    middles meet; the network finds what is left of the motion. That may be 45 degrees or half the object from frame to
    frame, and what turns on and on stays comparable with the first frame, so that nothing drifts. The network is right
    to a pixel or two; the correction of `FlowTracker` makes that a tenth. Its result counts where it has more points
    that were found again in the first frame than DIS flow has points at all.

    Args:
        weights: A checkpoint of GMFlow: `.safetensors`, or a file of `torch.save`.
        search_round_trip: Largest forward-backward error of the network's flow [its pixels: the object has about 150].

    Raises:
        UserError: There are no weights, they are of another network, or ``search_round_trip`` is no length.
    """

    def __init__(self, weights: str, search_round_trip: float = 3.0):
        if type(search_round_trip) not in (int, float) or not search_round_trip > 0:
            what = "`search_round_trip` of the tracker gmflow must be above 0"
            raise UserError(what, got=repr(search_round_trip)[:80])
        super().__init__()
        self.search_round_trip = search_round_trip
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

    def follow(self, clip: flow.FlowClip, span: range, queries: np.ndarray) -> Tracks:
        """As `FlowTracker.follow`. What the network found and nothing corrected has a lower confidence."""
        tracks = np.repeat(np.asarray(queries, np.float64)[None], len(span), axis=0)
        frames, masks, grey = (each[span.start : span.stop] for each in (clip.frames, clip.masks, clip.grey))
        sure = np.zeros(tracks.shape[:2])
        sure[0] = 1.0
        missed, expected = np.zeros(len(queries), int), np.eye(2, 3)
        for t in range(1, len(span)):
            if not (masks[t - 1].any() and masks[t].any()):
                break
            moved, found = clip.match(span[t]).move(tracks[t - 1], self.round_trip)
            found &= sure[t - 1] > 0
            anchored = self._anchor_tracks(grey[0], grey[t], masks[0], tracks[0], moved, found)
            good = np.isfinite(anchored[:, 0])
            trust = np.where(found & (missed < self.patience), 1.0, 0.0)
            if good.mean() < _CONFIRMED:
                expected = _join_middles(expected, masks[0], masks[t])
                searched = self._search(frames[0], frames[t], masks[0], masks[t], expected, tracks[0])
                more = np.isfinite(searched[1][:, 0])
                if more.sum() > (good | (trust > 0)).sum():
                    moved, anchored, trust = searched
                    good, missed = more, np.zeros_like(missed)
            missed = np.where(good, 0, missed + 1)
            tracks[t] = np.where(good[:, None], anchored, moved)
            sure[t] = np.where(good, 1.0, trust) * flow.find_inside(masks[t], tracks[t])
            if (sure[t] > 0).mean() < self.give_up:
                sure[t] = 0.0
                break
            fitted = _fit(tracks[0][sure[t] > 0], tracks[t][sure[t] > 0])
            expected = expected if fitted is None else fitted
        return Tracks(tracks, sure > 0, sure)

    def _search(
        self,
        picture: np.ndarray,
        frame: np.ndarray,
        mask: np.ndarray,
        mask_now: np.ndarray,
        expected: np.ndarray,
        queries: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Find points of the first frame in another one by the network.

        Args:
            picture: First frame, uint8, shape (H, W, 3).
            frame: Frame to search, uint8, shape (H, W, 3).
            mask: The object in the first frame, shape (H, W).
            mask_now: The object in the other one, shape (H, W).
            expected: Map from the one to the other that comes near, shape (2, 3).
            queries: Points in the first frame [px], shape (N, 2).

        Returns:
            Positions [px], shape (N, 2); the same corrected, nan where that fails; confidence without it, shape (N,).
        """
        first, current = (cv2.cvtColor(each, cv2.COLOR_RGB2GRAY) for each in (picture, frame))
        window = _frame(mask)
        shown, start = _look_through(picture, window), _apply(cv2.invertAffineTransform(window), queries)
        moved, anchored, trust = queries, np.full_like(queries, np.nan), np.zeros(len(queries))
        for _ in range(_TRIES):
            seen = _look_through(frame, _chain(expected, window))
            pair = (each[None] / np.float32(255) for each in (shown, seen))
            forth, back = (np.asarray(each[0]) for each in match_both_ways(self._graph, self._weights, *pair))
            end = start + flow.look_up(forth, start)
            error = np.linalg.norm(end + flow.look_up(back, end) - start, axis=1)
            moved = _apply(_chain(expected, window), end)
            found = (error < self.search_round_trip) & flow.find_inside(mask_now, moved)
            better, good = moved, np.zeros(len(queries), bool)
            for _ in range(2):  # the second time against a picture that is turned back by better points
                anchored = self._anchor_tracks(first, current, mask, queries, better, found | good)
                good = np.isfinite(anchored[:, 0])
                better = np.where(good[:, None], anchored, moved)
            trust = np.where(found, _COARSE / (1 + error**2), 0.0)
            fitted = _fit(queries[found | good], better[found | good])
            if fitted is None or (found | good).mean() > _ENOUGH:
                break
            expected = fitted
        return moved, anchored, trust


@partial(jax.jit, static_argnums=0)
def match_both_ways(
    graph: Any, weights: Any, first: jax.Array, second: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Flow from the first picture to the second and back [px], each of shape (1, height, width, 2).

    Args:
        graph: The network's structure.
        weights: Its weights.
        first: A picture, shape (1, height, width, 3).
        second: Another one.
    """
    with jax.default_matmul_precision("highest"):
        return nnx.merge(graph, weights)(first, second)


def _frame(mask: np.ndarray) -> np.ndarray:
    """The map from a square of `SIDE` to the picture in which the object fills it up to `_ROOM`, shape (2, 3)."""
    x, y, width, height = cv2.boundingRect(mask.astype(np.uint8))
    middle, longest = np.array([x + width / 2, y + height / 2]), max(width, height, 16)
    step = (1 + 2 * _ROOM) * longest / SIDE
    return np.hstack([step * np.eye(2), (middle - step * SIDE / 2)[:, None]])


def _look_through(picture: np.ndarray, window: np.ndarray, size: tuple[int, int] | None = None) -> np.ndarray:
    """The part of a picture that lies in a window of `_frame`, shape (SIDE, SIDE, 3)."""
    step = float(np.sqrt(abs(np.linalg.det(window[:, :2]))))
    if step > 1.5:  # fine texture would flicker
        picture = cv2.GaussianBlur(picture, (0, 0), 0.5 * step)
    indices = window.copy()  # of pixels, whose centres are at +0.5
    indices[:, 2] += window[:, :2] @ (0.5, 0.5) - 0.5
    how = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(picture, indices, (SIDE, SIDE), flags=how, borderMode=cv2.BORDER_REPLICATE)


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
