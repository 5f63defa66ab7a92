"""Point tracks without weights: dense optical flow, anchored on the first frame so that it does not drift."""

from __future__ import annotations

import dataclasses
import functools
from typing import Any

import cv2
import numpy as np

from physagent_jax.perception.protocols import Tracker, Tracks

_MARGIN = 16
"""Background kept around the object in a flow crop [px]."""

_FULL_SIZE = 120
"""Crops of up to twice this longest side are matched at full size, larger ones at a half or a quarter [px]."""

_STOP = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 10, 0.02)
"""Lucas-Kanade ends after so many steps, or below this one [px]."""


@dataclasses.dataclass
class FlowTracker(Tracker):
    """DIS optical flow (Kroeger et al. 2016) from frame to frame, corrected against the first frame.

    Chained flow drifts. So each frame is warped back by the affine map of the tracks (RANSAC), and what is
    left is found by Lucas-Kanade between the first frame and the warped one, both ways. Crops follow the
    mask, which takes most of a fast motion off the flow.

    Attributes:
        round_trip: Largest forward-backward error of the flow [px].
        anchor_round_trip: Largest forward-backward error of the correction [px].
        patience: Frames for which a point may go without correction.
        give_up: The remaining frames are left invisible when fewer than this fraction of points is visible.
    """

    round_trip: float = 1.0
    anchor_round_trip: float = 0.3
    patience: int = 3
    give_up: float = 0.35

    def __post_init__(self):
        self._dis: Any = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_FAST)

    def encode(self, frames: np.ndarray, masks: np.ndarray) -> FlowClip:
        """The clip without its background; see `protocols.Tracker`. What is followed lies on the object.

        A still background at the object's edge would hold the flow back, so the object's mean colour takes its place.
        """
        plain = np.array([255, 255, 255], np.uint8)
        if masks[0].any():
            plain = frames[0][masks[0]].mean(0).round().astype(np.uint8)
        return FlowClip(self, np.where(masks[..., None], frames, plain), masks)

    def follow(self, clip: FlowClip, span: range, queries: np.ndarray) -> Tracks:
        """Follow points that are given in the first frame of a span; flow tells no confidence.

        Args:
            clip: The pictures.
            span: Frames, one after the other.
            queries: Points (x, y) in the first one [px], shape (N, 2).
        """
        tracks = np.repeat(np.asarray(queries, np.float64)[None], len(span), axis=0)
        visible = np.zeros(tracks.shape[:2], bool)
        visible[0] = True
        missed, masks = np.zeros(len(queries), int), clip.masks[span.start : span.stop]
        for t in range(1, len(span)):
            if not (masks[t - 1].any() and masks[t].any()):
                break
            moved, found = clip.match(span[t]).move(tracks[t - 1], self.round_trip)
            found &= visible[t - 1]
            anchored = self._anchor_tracks(
                clip.grey[span[0]], clip.grey[span[t]], masks[0], tracks[0], moved, found
            )
            good = np.isfinite(anchored[:, 0])
            missed = np.where(good, 0, missed + 1)
            tracks[t] = np.where(good[:, None], anchored, moved)
            visible[t] = (found | good) & (missed <= self.patience) & find_inside(masks[t], tracks[t])
            if visible[t].sum() < self.give_up * len(queries):
                visible[t] = False
                break
        return Tracks(tracks, visible, visible.astype(float))

    def match(
        self, before: np.ndarray, after: np.ndarray, mask_before: np.ndarray, mask_after: np.ndarray
    ) -> Match:
        """The flow between two grey frames around the object, shapes (H, W)."""
        (xa, ya, wa, ha), (xb, yb, wb, hb) = (
            cv2.boundingRect(m.astype(np.uint8)) for m in (mask_before, mask_after)
        )
        w, h = max(wa, wb, 32) + 2 * _MARGIN, max(ha, hb, 32) + 2 * _MARGIN
        corner_a = np.array([xa + wa // 2 - w // 2, ya + ha // 2 - h // 2])
        corner_b = np.array([xb + wb // 2 - w // 2, yb + hb // 2 - h // 2])
        a, b = _crop(before, corner_a, w, h), _crop(after, corner_b, w, h)
        # Flow at a reduced size smooths over what turns: rotations of small objects read 5 degrees low.
        self._dis.setFinestScale(int(np.clip(np.log2(max(w, h) / _FULL_SIZE), 0, 2)))
        return Match(corner_a, corner_b, self._dis.calc(a, b, None), self._dis.calc(b, a, None))

    def _anchor_tracks(self, first, current, mask, queries, moved, found):
        """Positions in ``current`` found by comparison with ``first``; nan where that fails.

        Args:
            first: Grey first frame, shape (H, W).
            current: Grey frame to search, shape (H, W).
            mask: The object in ``first``, shape (H, W).
            queries: Points in ``first`` [px], shape (N, 2).
            moved: Their positions by flow [px], shape (N, 2).
            found: Which of these can be trusted, shape (N,).
        """
        anchored = np.full_like(queries, np.nan)
        if found.sum() < 6:
            return anchored
        affine, _ = cv2.estimateAffine2D(
            queries[found], moved[found], ransacReprojThreshold=3.0, maxIters=200
        )
        if affine is None or np.linalg.det(affine[:, :2]) < 0.02:
            return anchored
        x, y, w, h = cv2.boundingRect(mask.astype(np.uint8))
        corner, w, h = np.array([x - _MARGIN, y - _MARGIN]), w + 2 * _MARGIN, h + 2 * _MARGIN
        to_current = affine.copy()  # crop's pixel indices -> picture's pixel indices
        to_current[:, 2] = affine[:, :2] @ (corner + 0.5) + affine[:, 2] - 0.5
        back = cv2.warpAffine(
            current,
            to_current,
            (w, h),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
        start = (queries - corner - 0.5).astype(np.float32)
        guess = ((moved - affine[:, 2]) @ np.linalg.inv(affine[:, :2]).T - corner - 0.5).astype(np.float32)
        guess[~found] = start[~found]  # lost points may come back where the affine map expects them
        here = _crop(first, corner, w, h)
        end, ok, _ = _run_lucas_kanade(here, back, start, guess)
        again, ok_back, _ = _run_lucas_kanade(back, here, end, start)
        good = (ok & ok_back).ravel() > 0
        good &= np.linalg.norm(again - start, axis=1) < self.anchor_round_trip
        good &= np.linalg.norm(end - guess, axis=1) < 8
        anchored[good] = ((end + corner + 0.5) @ affine[:, :2].T + affine[:, 2])[good]
        return anchored


@dataclasses.dataclass(frozen=True)
class Match:
    """The flow between crops of two frames.

    Attributes:
        corner_before, corner_after: Corners of the crops [px], shape (2,).
        forth, back: Displacements from the one to the other and back [px], shape (h, w, 2).
    """

    corner_before: np.ndarray
    corner_after: np.ndarray
    forth: np.ndarray
    back: np.ndarray

    def move(self, points: np.ndarray, round_trip: float) -> tuple[np.ndarray, np.ndarray]:
        """Points [px] where the flow carries them, shape (N, 2), and whether the way back agrees, shape (N,)."""
        start = points - self.corner_before
        moved = start + look_up(self.forth, start)
        error = np.linalg.norm(moved + look_up(self.back, moved) - start, axis=1)
        return moved + self.corner_after, error < round_trip + 0.05 * np.linalg.norm(moved - start, axis=1)


@dataclasses.dataclass(frozen=True)
class FlowClip:
    """Implements `protocols.EncodedClip`; points are followed forwards only.

    Points are followed in several spans and sets, and the flow is the same for all: it is computed once.

    Attributes:
        tracker: How.
        frames: Pictures, uint8, shape (T, H, W, 3).
        masks: The object, bool, shape (T, H, W).
    """

    tracker: FlowTracker
    frames: np.ndarray
    masks: np.ndarray
    _matches: dict[int, Match] = dataclasses.field(default_factory=dict, init=False, repr=False)

    @functools.cached_property
    def grey(self) -> np.ndarray:
        """The pictures in grey, uint8, shape (T, H, W)."""
        return np.stack([cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY) for frame in self.frames])

    def match(self, t: int) -> Match:
        """The flow from the frame before ``t`` to it."""
        if t not in self._matches:
            pair = slice(t - 1, t + 1)
            self._matches[t] = self.tracker.match(*self.grey[pair], *self.masks[pair])
        return self._matches[t]

    def track(self, queries: np.ndarray, until: int | None = None) -> Tracks:
        """Tracks of ``queries``, invisible before their frames and from ``until`` on."""
        xy = np.repeat(np.asarray(queries, np.float64)[None, :, 1:], len(self.frames), axis=0)
        visible, sure = np.zeros(xy.shape[:2], bool), np.zeros(xy.shape[:2])
        starts = queries[:, 0].astype(int)
        for start in np.unique(starts).tolist():
            span, own = range(start, len(self.frames) if until is None else until), starts == start
            found = self.tracker.follow(self, span, queries[own, 1:])
            at = slice(span.start, span.stop)
            xy[at, own], visible[at, own], sure[at, own] = found.xy, found.visible, found.confidence
        return Tracks(xy, visible, sure)


def _run_lucas_kanade(a, b, points, guess):
    return cv2.calcOpticalFlowPyrLK(
        a,
        b,
        points,
        guess.copy(),
        winSize=(15, 15),
        maxLevel=1,
        criteria=_STOP,
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )


def _crop(image: np.ndarray, corner: np.ndarray, w: int, h: int) -> np.ndarray:
    """The w x h window at integer ``corner``, continued beyond the picture by its edge."""
    shift = np.array([[1, 0, corner[0]], [0, 1, corner[1]]], np.float64)
    return cv2.warpAffine(
        image, shift, (w, h), flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP, borderMode=cv2.BORDER_REPLICATE
    )


def look_up(flow: np.ndarray, xy: np.ndarray) -> np.ndarray:
    """Bilinear flow at positions (pixel centres at +0.5), shape (N, 2)."""
    at = (xy - 0.5).astype(np.float32)
    return cv2.remap(flow, at[:, None, 0], at[:, None, 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)[
        :, 0
    ]


def find_inside(mask: np.ndarray, xy: np.ndarray) -> np.ndarray:
    """Return whether positions lie on the mask, shape (N,)."""
    h, w = mask.shape
    x, y = np.floor(xy[:, 0]).astype(int), np.floor(xy[:, 1]).astype(int)
    on = (x >= 0) & (y >= 0) & (x < w) & (y < h)
    return on & mask[np.clip(y, 0, h - 1), np.clip(x, 0, w - 1)]
