"""Segmentation without weights, by depth and colour: the object is what stands in front of the background."""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.perception.backends.colour import ColorSegmenter, find_border_colour, remove_specks
from physagent_jax.perception.background import Background, find_background
from physagent_jax.perception.protocols import Masks, Segmenter, SegmentPrompt

_STAYS = 0.95
"""Share of the frames in which a still thing at the border is in front of the background's surfaces."""
_AGREE = 0.5
"""Overlap (intersection over union) with depth's mask from which colour may draw the edge."""
_TRUE_EDGE = 40
"""Percentile of the distances from colour's edge to depth's that is the rim's: the rest may lie inside the object."""
_BESIDE = np.ones((3, 3), np.uint8)
"""A pixel and its neighbours."""
_LEAST_SHARE = 2e-4
"""Less of the picture than this is noise, not an object."""
_UNEXPLAINED = 0.5
"""Share of the border on flat surfaces below which the report warns."""


@dataclasses.dataclass(frozen=True)
class RgbdSegmenter(Segmenter):
    """The object is what stands in front of the flat surfaces that reach the picture's border.

    Where the camera sees no surface behind the object, it is what has depth, with the edge that colour draws before a
    plain background: inside of it, what has the background's colour is the object too. Still things that reach the
    border are furniture. Without depth, or where nothing stands out in it, colour alone decides before a plain
    background; before a busy one, nothing is found and the notes say so.

    Attributes:
        colour: What decides where depth does not.
    """

    colour: ColorSegmenter = ColorSegmenter(border_share=1.0)  # depth tells floors and walls

    @property
    def takes_depth(self) -> bool:
        """It looks at depth."""
        return True

    def segment(
        self, frames: np.ndarray, prompt: SegmentPrompt | None, depth: np.ndarray | None = None
    ) -> Masks:
        """Masks of the object; see `protocols.Segmenter`. It takes no prompt."""
        if prompt is not None:
            raise UserError(
                "segmentation by depth and colour takes no prompt",
                do="Leave it out, or choose another segmenter",
            )
        if depth is None or not np.isfinite(depth).any():
            return self._segment_by_colour(frames, "There is no depth")
        inverse = 1 / depth
        background = find_background(inverse)
        if background.open:
            return self._segment_before_nothing(frames, np.isfinite(depth))
        masks = np.stack([remove_specks(_find_standing_out(w, background)) for w in inverse])
        masks = _remove_furniture(masks)
        if masks[0].mean() < _LEAST_SHARE:
            return self._segment_by_colour(frames, "Nothing stands in front of the background")
        notes = ()
        if background.explained < _UNEXPLAINED:
            notes = ("The background is not flat: what is object and what background is partly a guess.",)
        return Masks(masks, notes)

    def _segment_before_nothing(self, frames: np.ndarray, seen: np.ndarray) -> Masks:
        """Masks where the camera sees no surface behind the object; ``seen`` is where it has depth, (T, H, W)."""
        solid = np.stack([remove_specks(_vote(s, np.ones_like(s))) for s in seen])
        if find_border_colour(frames)[1] >= self.colour.plain_spread:
            return Masks(solid)
        drawn = self.colour.segment(frames, None).masks
        overlap = (drawn & solid).sum() / max((drawn | solid).sum(), 1)
        if overlap < _AGREE and not _is_touching_border(solid[0]):
            note = "The object has the background's colour: its mask was taken from depth."
            return Masks(solid, (note,))
        return Masks(drawn | _find_patches(solid, drawn))

    def _segment_by_colour(self, frames: np.ndarray, why: str) -> Masks:
        """Colour's masks before a plain background, else none."""
        if find_border_colour(frames)[1] >= self.colour.plain_spread:
            note = f"{why}, and the background is too busy to tell the object by its colour."
            return Masks(np.zeros(frames.shape[:3], bool), (note,))
        return Masks(
            self.colour.segment(frames, None).masks, (f"{why}: the object was found by its colour.",)
        )


def _find_patches(solid: np.ndarray, drawn: np.ndarray) -> np.ndarray:
    """Patches of the object that colour does not draw: they lie deeper within depth's masks than its faint rim.

    They are broader than the rims on both sides of a gap, which depth does not see.
    """
    depth = np.stack([cv2.distanceTransform(each.astype(np.uint8), cv2.DIST_L2, 5) for each in solid])
    edge = np.stack([each & (cv2.erode(each.astype(np.uint8), _BESIDE) == 0) for each in drawn]) & solid
    rim = float(np.percentile(depth[edge], _TRUE_EDGE)) if edge.any() else 0.0
    across = 2 * int(np.ceil(rim)) + 1
    missing = ((depth > rim) & ~drawn).astype(np.uint8)
    return np.stack(
        [cv2.morphologyEx(each, cv2.MORPH_OPEN, np.ones((across, across), np.uint8)) > 0 for each in missing]
    )


def _find_standing_out(inverse: np.ndarray, background: Background) -> np.ndarray:
    """Segment the foreground of one frame; dropped pixels take the value of most of their neighbours."""
    known = np.isfinite(inverse)
    filled = np.where(known, inverse, background.inverse).astype(np.float32)
    height = (filled - background.inverse).astype(np.float32)
    weight = cv2.blur(known.astype(np.float32), (3, 3))
    mean = cv2.blur(np.where(known, height, 0).astype(np.float32), (3, 3)) / np.maximum(weight, 1e-6)
    smooth = cv2.medianBlur(np.where(known, height, mean).astype(np.float32), 3)
    return _vote(known & (smooth > background.tolerance), known)


def _vote(mask: np.ndarray, known: np.ndarray) -> np.ndarray:
    """``mask``, with unknown pixels and single ones as most of their known neighbours are."""
    weight = cv2.blur(known.astype(np.float32), (5, 5))
    share = cv2.blur((mask & known).astype(np.float32), (5, 5)) / np.maximum(weight, 1e-6)
    guessed = np.where(known, mask, share > 0.5)
    return (cv2.medianBlur(guessed.astype(np.uint8), 3) > 0) | (guessed & (share > 0.25))


def _remove_furniture(masks: np.ndarray) -> np.ndarray:
    """``masks`` without what stays at the border through the whole clip."""
    stays = (masks.mean(0) >= _STAYS).astype(np.uint8)
    count, labels = cv2.connectedComponents(stays, connectivity=8)
    labels = np.asarray(labels)
    border = np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]]))
    border = border[border > 0]
    if not len(border) or len(border) == count - 1:  # nothing there, or the object itself fills the picture
        return masks
    still = cv2.dilate(np.isin(labels, border).astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    return masks & ~still


def _is_touching_border(mask: np.ndarray) -> bool:
    return bool(mask[0].any() or mask[-1].any() or mask[:, 0].any() or mask[:, -1].any())
