"""The object's pixels in a photo: a mask that is given, or GrabCut from a box or from the middle."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import dijkstra

from physagent_jax.core.errors import UserError
from physagent_jax.core.npy import read_npy
from physagent_jax.core.reading import shorten
from physagent_jax.gaussians.formats import read_head
from physagent_jax.scene.config.photo import Photo
from physagent_jax.scene.photo.picture import MOST_BYTES, Picture, is_picture, read_picture

COARSE, FINE = 240, 720  # [px] longer sides at which GrabCut finds the object, and its edge
BORDER = 0.03  # of the shorter side that is background where no box says otherwise
SPREAD = 0.33  # standard deviation of the weight of the middle, over the sides
NOISE = 1.5  # of a colour difference between neighbours that is none [8-bit levels]
BAND = 0.02  # of the longer side about the coarse edge that the fine one is looked for in
SPECK = 0.2  # of the largest piece, below which a piece is not the object
HOLE = 0.003  # of the object, below which a hole in it is none
FEWEST, LEAST = 400, 0.001  # pixels of an object, and its share of the picture
BRIGHT = 127  # level above which a pixel of a mask is the object


def find_foreground(picture: Picture, photo: Photo, base_dir: Path) -> np.ndarray:
    """The object's mask, bool, shape (h, w) of the picture.

    Without a mask or a box, what edges part from the border, near the middle, is the first guess. GrabCut (Rother et
    al. 2004) refines it on a small picture, and again along the edge on a larger one.

    Args:
        picture: The photo.
        photo: What is known of it.
        base_dir: Folder that relative paths start from.

    Raises:
        UserError: Nothing stands out, it is tiny, or it touches all borders; a mask cannot be read or does not fit.
    """
    if photo.mask_path is not None:
        mask = _read_mask(base_dir / photo.mask_path, picture)
    else:
        mask = _drop_specks(_cut_out(picture.rgb, _scale_box(photo, picture)))
    _check(mask, picture.name)
    return mask


def _scale_box(photo: Photo, picture: Picture) -> tuple[float, float, float, float] | None:
    """The box of the file's pixels in shares of the sides."""
    if photo.box is None:
        return None
    width, height = picture.size
    x0, y0, x1, y1 = photo.box
    if x0 >= width or y0 >= height:
        raise UserError(
            "the image's box lies outside of it", got=photo.box, do=f"Stay within {width} x {height}"
        )
    return x0 / width, y0 / height, min(x1 / width, 1.0), min(y1 / height, 1.0)


def _cut_out(rgb: np.ndarray, box: tuple[float, float, float, float] | None) -> np.ndarray:
    small = _reduce(rgb, COARSE)
    labels = _start_in_middle(small) if box is None else _start_in_box(small, box)
    found = _run_grabcut(small, labels, 5)
    large = _reduce(rgb, FINE)
    rough = cv2.resize(found.astype(np.float32), large.shape[1::-1], interpolation=cv2.INTER_LINEAR) > 0.5
    reach = max(round(BAND * max(large.shape)), 2)
    kernel = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    inner, outer = cv2.erode(rough.astype(np.uint8), kernel), cv2.dilate(rough.astype(np.uint8), kernel)
    labels = np.where(rough, cv2.GC_PR_FGD, cv2.GC_PR_BGD).astype(np.uint8)
    labels[inner > 0], labels[outer == 0] = cv2.GC_FGD, cv2.GC_BGD
    if box is not None:
        labels[_start_in_box(large, box) == cv2.GC_BGD] = cv2.GC_BGD
    fine = _run_grabcut(large, labels, 2).astype(np.float32)
    return cv2.resize(fine, rgb.shape[1::-1], interpolation=cv2.INTER_LINEAR) > 0.5


def _reduce(rgb: np.ndarray, longest: int) -> np.ndarray:
    scale = min(1.0, longest / max(rgb.shape))
    size = [max(round(side * scale), 1) for side in rgb.shape[1::-1]]
    return np.asarray(cv2.resize(rgb, size, interpolation=cv2.INTER_AREA))


def _start_in_box(rgb: np.ndarray, box: tuple[float, float, float, float]) -> np.ndarray:
    """Labels for GrabCut: what is outside of the box is background."""
    height, width = rgb.shape[:2]
    labels = np.full(rgb.shape[:2], cv2.GC_BGD, np.uint8)
    x0, y0, x1, y1 = np.rint(np.multiply(box, [width, height, width, height])).astype(int)
    labels[y0 : max(y1, y0 + 1), x0 : max(x1, x0 + 1)] = cv2.GC_PR_FGD
    return labels


def _start_in_middle(rgb: np.ndarray) -> np.ndarray:
    """Labels for GrabCut: what edges part from the border, the more so the nearer to the middle.

    The way from the border to each pixel is as long as the colour differences along the shortest one (geodesic
    saliency, Wei et al. 2012): a gradient of the sky is no way, an outline is.
    """
    height, width = rgb.shape[:2]
    rim = max(round(BORDER * min(height, width)), 1)
    border = np.ones((height, width), bool)
    border[rim:-rim, rim:-rim] = False
    smooth = cv2.bilateralFilter(rgb, 7, 30, 5)
    lab = np.asarray(cv2.cvtColor(smooth, cv2.COLOR_RGB2LAB), np.float32)
    index = np.arange(height * width).reshape(height, width)
    pairs = [(np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])]
    first, second = (np.concatenate([index[each[side]].ravel() for each in pairs]) for side in (0, 1))
    steps = np.linalg.norm(lab.reshape(-1, 3)[first] - lab.reshape(-1, 3)[second], axis=1)
    steps = np.maximum(steps - NOISE, 1e-3)
    graph = sparse.coo_matrix((steps, (first, second)), shape=(index.size, index.size)).tocsr()
    away = dijkstra(graph, directed=False, indices=index[border], min_only=True).reshape(height, width)
    y, x = np.mgrid[:height, :width]
    off = ((x + 0.5) / width - 0.5) ** 2 + ((y + 0.5) / height - 0.5) ** 2
    weighed = away * np.exp(-0.5 * off / SPREAD**2)
    level = np.asarray(np.clip(255 * weighed / max(float(weighed.max()), 1e-6), 0, 255), np.uint8)
    chosen = cv2.threshold(level, 0, 255, cv2.THRESH_BINARY + cv2.THRESH_OTSU)[1] > 0
    labels = np.where(chosen, cv2.GC_PR_FGD, cv2.GC_PR_BGD).astype(np.uint8)
    labels[border] = cv2.GC_BGD
    return labels


def _run_grabcut(rgb: np.ndarray, labels: np.ndarray, rounds: int) -> np.ndarray:
    """The foreground, bool; the labels' own where too little of one class is there to learn colours from."""
    sure = np.isin(labels, (cv2.GC_FGD, cv2.GC_PR_FGD))
    if min(sure.sum(), (~sure).sum()) < 10:
        return sure
    models = np.zeros((1, 65)), np.zeros((1, 65))
    cv2.setRNGSeed(0)
    cv2.grabCut(rgb[..., ::-1].copy(), labels, (0, 0, 0, 0), *models, rounds, cv2.GC_INIT_WITH_MASK)
    return np.isin(labels, (cv2.GC_FGD, cv2.GC_PR_FGD))


def _drop_specks(mask: np.ndarray) -> np.ndarray:
    """The mask without small pieces and small holes."""
    for share, wanted in ((SPECK, True), (HOLE, False)):
        count, labels, stats, _ = cv2.connectedComponentsWithStats(
            (mask == wanted).astype(np.uint8), connectivity=8
        )
        if count < 2:
            continue
        areas = stats[1:, cv2.CC_STAT_AREA]
        least = share * (areas.max() if wanted else mask.sum())
        small = np.flatnonzero(areas < least) + 1
        mask = np.where(np.isin(labels, small), not wanted, mask)
    return mask


def _read_mask(path: Path, picture: Picture) -> np.ndarray:
    """The mask of a file, at the size of the picture as it was read."""
    what = "the image's mask"
    if is_picture(read_head(path, what=what)):
        shown = read_picture(path)
        given, size = shown.rgb.max(axis=2) > BRIGHT, shown.size
    else:
        given = read_npy(path, most=MOST_BYTES, what=what)
        size = given.shape[::-1]
    if size != picture.size or given.dtype.kind not in "biuf":
        raise UserError(
            f"{what} {shorten(path)} is of another size or kind",
            got=f"{given.dtype}, {' x '.join(map(str, size))}, beside an image of {' x '.join(map(str, picture.size))}",
            do="Give a picture that is bright on the object, or .npy of one bool per pixel",
        )
    fitted = cv2.resize(
        (given > 0).astype(np.float32), picture.rgb.shape[1::-1], interpolation=cv2.INTER_AREA
    )
    return np.asarray(fitted) > 0.5


def _check(mask: np.ndarray, name: str) -> None:
    """Refuse a mask that shows no object that can be lifted."""
    count, help_it = int(mask.sum()), "Say where the object is by --image-box x0 y0 x1 y1 or --image-mask"
    if count == 0:
        raise UserError(f"no object stands out in {name}", got="no pixel that is not background", do=help_it)
    if mask[0].any() and mask[-1].any() and mask[:, 0].any() and mask[:, -1].any():
        raise UserError(
            f"the object in {name} touches all of its borders: its outline is not in the picture",
            got=f"{mask.mean():.0%} of the image",
            do=f"{help_it}, or give a photo with room around it",
        )
    if count < max(FEWEST, LEAST * mask.size):
        got = f"{count} pixels of {mask.shape[1]} x {mask.shape[0]}"
        raise UserError(f"the object in {name} is too small to be lifted", got=got, do=f"{help_it}, or crop")
