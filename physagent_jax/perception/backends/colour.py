"""Segmentation without weights: distance from the border's colour, then a matte or GrabCut at the edge."""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.perception.protocols import Masks, Segmenter, SegmentPrompt

_SPECK, _FLOATER = 8, 0.004
"""Connected pieces smaller than this [px], or than this share of the object, are noise or a capture's stray splats."""
_TOO_BUSY = "The background is too busy to tell the object by its colour."


@dataclasses.dataclass(frozen=True)
class ColorSegmenter(Segmenter):
    """The object is what differs in colour from the picture's border.

    Over a plain background the edge is where an estimated coverage exceeds one half: the colour there is
    taken as a blend of the background and of the nearest interior colour. Over a busy one, the first guess
    is refined by GrabCut (Rother et al. 2004) on a reduced crop. Where the background's own colours differ as an
    object's would, nothing is found, and the notes say so.

    Attributes:
        threshold: Colour distance that counts as different [8-bit levels].
        plain_spread: Border colours with a median deviation below this are a plain background [8-bit levels].
        grabcut_size: GrabCut runs on a crop reduced to this longest side [px].
        border_share: What differs and covers more of the border of frame 0 than this is a floor or another wall.
    """

    threshold: float = 12.0
    plain_spread: float = 6.0
    grabcut_size: int = 112
    border_share: float = 0.25

    def segment(self, frames: np.ndarray, prompt: SegmentPrompt | None) -> Masks:
        """Masks of the object; see `protocols.Segmenter`. It takes no prompt."""
        if prompt is not None:
            raise UserError(
                "segmentation by colour takes no prompt", do="Leave it out, or choose another segmenter"
            )
        background, spread = find_border_colour(frames)
        if 3 * spread > 5 * self.threshold:
            return Masks(np.zeros(frames.shape[:3], bool), (_TOO_BUSY,))
        threshold = max(self.threshold, 3 * spread)
        masks = []
        for frame in frames:
            difference = frame.astype(np.float32) - background
            guess = np.einsum("hwc,hwc->hw", difference, difference) > threshold**2
            if guess.any():
                guess = (
                    _estimate_matte(difference, guess)
                    if spread < self.plain_spread
                    else self._run_grabcut(frame, guess)
                )
            masks.append(remove_specks(guess))
            if len(masks) == 1 and _take_border(masks[-1]).mean() > self.border_share:
                return Masks(np.zeros(frames.shape[:3], bool), (_TOO_BUSY,))
        return Masks(np.stack(masks))

    def _run_grabcut(self, frame: np.ndarray, guess: np.ndarray) -> np.ndarray:
        """GrabCut on a reduced crop around ``guess``, with a sure rim of background."""
        x, y, w, h = cv2.boundingRect(guess.astype(np.uint8))
        x0, y0 = max(x - 8, 0), max(y - 8, 0)
        box = np.s_[y0 : y + h + 8, x0 : x + w + 8]
        crop, start = frame[box], guess[box].astype(np.uint8)
        scale = min(1.0, self.grabcut_size / max(start.shape))
        small = cv2.resize(crop, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        labels = cv2.resize(start, small.shape[1::-1], interpolation=cv2.INTER_NEAREST)
        labels = np.where(labels > 0, cv2.GC_PR_FGD, cv2.GC_PR_BGD).astype(np.uint8)
        labels[cv2.dilate((labels == cv2.GC_PR_FGD).astype(np.uint8), np.ones((9, 9), np.uint8)) == 0] = (
            cv2.GC_BGD
        )
        if min((labels == k).sum() for k in (cv2.GC_PR_FGD, cv2.GC_BGD)) < 10:
            return guess  # too little of one class to learn colours from
        models = np.zeros((1, 65)), np.zeros((1, 65))
        cv2.setRNGSeed(0)  # GrabCut's clustering draws from a global generator
        cv2.grabCut(small, labels, (0, 0, 0, 0), *models, 2, cv2.GC_INIT_WITH_MASK)
        inside = np.isin(labels, (cv2.GC_FGD, cv2.GC_PR_FGD)).astype(np.float32)
        refined = np.zeros_like(guess)
        refined[box] = cv2.resize(inside, start.shape[::-1], interpolation=cv2.INTER_LINEAR) > 0.5
        return refined


def find_border_colour(frames: np.ndarray) -> tuple[np.ndarray, float]:
    """Median colour of the border over all frames, shape (3,), and its median absolute deviation."""
    border = np.concatenate([_take_border(frame) for frame in frames]).astype(np.float32)
    median = np.median(border, axis=0)
    return median, float(np.median(np.linalg.norm(border - median, axis=1)))


def _take_border(picture: np.ndarray) -> np.ndarray:
    """Pixels of the outermost rows and columns, shape (N, ...)."""
    return np.concatenate([picture[0], picture[-1], picture[:, 0], picture[:, -1]])


def _estimate_matte(difference: np.ndarray, guess: np.ndarray) -> np.ndarray:
    """Keep the pixels of ``guess`` whose coverage is above one half.

    Args:
        difference: Colour minus background, shape (H, W, 3).
        guess: First guess, too wide by the soft edge, shape (H, W).
    """
    box = find_box(guess, margin=3)
    mask = guess.copy()
    mask[box] = _cut_band(difference[box], guess[box])
    return mask


def find_box(mask: np.ndarray, margin: int = 0) -> tuple[slice, slice]:
    """Rows and columns that hold a mask, with a margin where the picture has room for it."""
    x, y, width, height = cv2.boundingRect(mask.astype(np.uint8))
    return np.s_[max(y - margin, 0) : y + height + margin, max(x - margin, 0) : x + width + margin]


def _cut_band(difference: np.ndarray, guess: np.ndarray) -> np.ndarray:
    """`_estimate_matte` of a crop."""
    core = np.asarray(cv2.erode(guess.astype(np.uint8), np.ones((5, 5), np.uint8)))
    if not core.any():
        return guess
    reach, label = cv2.distanceTransformWithLabels(1 - core, cv2.DIST_L2, 3, labelType=cv2.DIST_LABEL_PIXEL)
    label = np.asarray(label, np.int64)
    owner = np.zeros(label.max() + 1, np.int64)
    owner[label[core > 0]] = np.flatnonzero(core)
    band = np.flatnonzero(guess & (core == 0) & (reach < 5))  # thin parts have no core near: kept as guessed
    flat = difference.reshape(-1, 3)
    inner = flat[owner[label.ravel()[band]]]
    coverage = np.einsum("ic,ic->i", flat[band], inner) / np.maximum(np.einsum("ic,ic->i", inner, inner), 1.0)
    mask = guess.copy()
    mask.ravel()[band[coverage < 0.5]] = False
    return mask


def remove_specks(mask: np.ndarray) -> np.ndarray:
    """``mask`` without pieces smaller than a speck."""
    box, kept = find_box(mask), np.zeros_like(mask, bool)
    if not mask.any():
        return kept
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask[box].astype(np.uint8), connectivity=8)
    keep = stats[:, cv2.CC_STAT_AREA] >= max(_SPECK, _FLOATER * mask.sum())
    keep[0] = False
    kept[box] = keep[np.asarray(labels, np.int64)]
    return kept
