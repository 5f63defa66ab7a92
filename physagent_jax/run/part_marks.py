"""The parts of an object in pictures of it: each in a colour of its own, with its number."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np
from scipy.spatial import KDTree

from physagent_jax.forces.part import Part
from physagent_jax.forces.regions import make_region_mask
from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.render.camera import Camera
from physagent_jax.scene.body import Body
from physagent_jax.scene.surfels import SH_DC

COLOURS = np.array(
    [(230, 60, 50), (40, 110, 220), (40, 160, 70), (240, 160, 20), (150, 70, 200), (20, 170, 180), (220, 80, 150)],
    np.float64,
)  # fmt: skip
TINT = 0.6  # share of the colour in what is drawn
_BEHIND = 0.02  # [longest side] by which a place may lie behind what is drawn and still be seen
_FEWEST = 3  # Gaussians of a part that are seen, from which on its number is drawn


def find_masks(body: Body, parts: Sequence[Part]) -> list[np.ndarray]:
    """The particles of each part, those beside its joint too; bool, shape (n,) each."""
    points = np.asarray(body.particles.x, np.float64)
    return [~make_region_mask(part.rest, points) for part in parts]


def find_owners(body: Body, parts: Sequence[Part]) -> np.ndarray:
    """The part of each Gaussian, the smallest where parts lie within each other; -1 = none; int, shape (g,)."""
    owner = np.full(body.particles.count, -1)
    masks = find_masks(body, parts)
    for index in sorted(range(len(parts)), key=lambda k: -masks[k].sum()):
        owner[masks[index]] = index
    near = KDTree(np.asarray(body.particles.x)).query(np.asarray(body.cloud.means))[1]
    return owner[near]


def tint(cloud: GaussianCloud, owner: np.ndarray) -> GaussianCloud:
    """The cloud with its parts in their colours.

    Args:
        cloud: The Gaussians.
        owner: The part of each; -1 = none, shape (g,).
    """
    share = np.where(owner >= 0, TINT, 0.0)[:, None]
    sh = (1 - share[:, None]) * np.asarray(cloud.sh, np.float64)
    sh[:, 0] += share * (COLOURS[owner % len(COLOURS)] / 255 - 0.5) / SH_DC
    return dataclasses.replace(cloud, sh=jnp.asarray(sh, cloud.sh.dtype))


def place_numbers(
    camera: Camera, depth: np.ndarray, means: np.ndarray, owner: np.ndarray
) -> list[tuple[int, tuple[int, int]]]:
    """The parts that are seen, each with a pixel (x, y) that shows it, near the middle of what is seen of it.

    Args:
        camera: The camera.
        depth: Depth of what is drawn [m], not finite or 0 where nothing is, shape (H, W).
        means: Centres of the Gaussians [m], shape (g, 3).
        owner: The part of each; -1 = none, shape (g,).
    """
    seen = means @ camera.viewmat[:3, :3].T + camera.viewmat[:3, 3]
    pixels = np.floor((seen @ camera.K.T)[:, :2] / np.maximum(seen[:, 2:], 1e-9)).astype(int)
    height, width = depth.shape
    inside = ((pixels >= 0) & (pixels < (width, height))).all(1) & (seen[:, 2] > 0)
    x, y = np.where(inside[:, None], pixels, 0).T
    shown = inside & (seen[:, 2] <= depth[y, x] + _BEHIND * np.ptp(means, axis=0).max())
    found = []
    for index in range(owner.max(initial=-1) + 1):
        mine = pixels[shown & (owner == index)]
        if len(mine) >= _FEWEST:
            at = mine[np.linalg.norm(mine - np.median(mine, axis=0), axis=1).argmin()]
            found.append((index, (int(at[0]), int(at[1]))))
    return found
