"""The particles that an `Anchor` holds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from physagent_jax.core.errors import UserError
from physagent_jax.core.npy import read_npy
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.scene.config import Anchor

MASK_BYTES = 256 * 2**20  # one per Gaussian


def select_anchored(
    anchor: Anchor,
    x_rest: np.ndarray,
    gaussian_index: np.ndarray,
    base_dir: str | Path,
    *,
    gaussian_count: int | None = None,
) -> np.ndarray:
    """Select the particles that are held fixed.

    Args:
        anchor: What is held.
        x_rest: Rest positions [m], shape (n, 3).
        gaussian_index: Gaussian of each particle, -1 for filled ones, shape (n,).
        base_dir: Folder that a relative ``mask_path`` starts from.
        gaussian_count: Gaussians of the cloud that the indices point into; if given, a mask must have exactly
            this length (else it must at least cover the highest index).

    Returns:
        Bool per particle, shape (n,).

    Raises:
        UserError: A box or mask selects nothing, or the mask is missing, not bool or of the wrong length.
    """
    x_rest = np.asarray(x_rest)
    if anchor.kind == "none":
        return np.zeros(len(x_rest), bool)
    if anchor.kind in ("base", "top"):
        return _select_slab(x_rest[:, 2], anchor.fraction, top=anchor.kind == "top")
    if anchor.region is not None:
        return make_region_mask(anchor.region, x_rest, "anchor.region")
    if anchor.kind == "box":
        return _select_box(np.asarray(anchor.point), np.asarray(anchor.half_size), x_rest)
    return _read_mask(
        Path(base_dir, str(anchor.mask_path)), x_rest, np.asarray(gaussian_index), gaussian_count
    )


def _select_slab(height: np.ndarray, fraction: float, *, top: bool) -> np.ndarray:
    low, high = height.min(), height.max()
    return height >= high - fraction * (high - low) if top else height <= low + fraction * (high - low)


def _select_box(point: np.ndarray, half_size: np.ndarray, x_rest: np.ndarray) -> np.ndarray:
    inside = np.all(np.abs(x_rest - point) <= half_size, axis=1)
    if not inside.any():
        raise UserError(
            "the anchor's box holds no particles",
            got=f"point {point.tolist()}, half_size {half_size.tolist()}; the object spans "
            f"{x_rest.min(axis=0).round(3).tolist()} to {x_rest.max(axis=0).round(3).tolist()} m",
            do="Move or enlarge the box",
        )
    return inside


def _read_mask(path: Path, x_rest: np.ndarray, index: np.ndarray, gaussian_count: int | None) -> np.ndarray:
    mask = read_npy(path, most=MASK_BYTES, what="the anchor mask")
    needed = int(index.max()) + 1 if gaussian_count is None else gaussian_count
    fits = mask.ndim == 1 and (len(mask) == needed if gaussian_count is not None else len(mask) >= needed)
    if mask.dtype != np.bool_ or not fits:
        raise UserError(
            f"the anchor mask {path} must hold one bool per Gaussian, shape ({needed},)",
            got=f"{mask.dtype}, shape {mask.shape}",
            do="Make it from the same file, crop and opacity threshold",
        )
    surface = index >= 0
    if not surface.any() or not mask[index[surface]].any():
        raise UserError(
            f"the anchor mask {path} selects no particles", do="Set at least one Gaussian to True"
        )
    selection = np.zeros(len(x_rest), bool)
    selection[surface] = mask[index[surface]]
    if (~surface).any():  # what is inside a held part is held with it
        nearest = KDTree(x_rest[surface]).query(x_rest[~surface])[1]
        selection[~surface] = selection[surface][nearest]
    return selection
