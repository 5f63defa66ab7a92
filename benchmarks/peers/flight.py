"""A cube in free flight that is thrown, stretches and twists: smooth, so that all codes' errors converge to nothing.

Nothing touches it, because what touches a wall converges with the first power of a cell at best, and no reference
would be fine enough. Particles lie on a lattice, two per cell and axis. The cells are as coarse, and the matter as much
stiffer, that a substep may be as long as on the customary grid of 100 cells with 1e5 Pa (`drop`).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.peers.scene import Material, PeerScene

SIZE = 2.0  # side of the domain [m]
SIDE = 0.6  # of the cube [m]
CELLS = 40  # along a side of the domain, for one; the cube has 12
FRAMES = 2
FRAME_DT = 0.05  # [s]; the clip is two periods of the cube's first mode
YOUNGS_MODULUS = 5e5  # [Pa]
STRETCHING = 2.5  # [m/s], a tenth of the speed of sound
TWISTING = 7.5  # [1/s]
DRIFT = (0.3, 0.2, 0.1)  # [m/s], so that particles cross cells
_BLOCKS = 4  # along an edge, whose means are compared


def flight(finer: int = 1, material: Material = Material.NEO_HOOKEAN, dtype: Any = np.float32) -> PeerScene:
    """The cube with ``finer`` times as many cells along a side and as many particles in each."""
    count = 24 * finer
    axis = (np.arange(count) + 0.5) * (SIDE / count)
    material_points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    r = material_points - SIDE / 2
    wave = np.sin(np.pi * r[:, 2] / SIDE)
    v = np.stack([-TWISTING * wave * r[:, 1], TWISTING * wave * r[:, 0], STRETCHING * wave], -1)
    return PeerScene.of(
        (material_points + 0.5 * (SIZE - SIDE)).astype(dtype),
        v=v + np.asarray(DRIFT),
        size=SIZE,
        cells=CELLS * finer,
        material=material,
        volume=SIDE**3 / count**3,
        density=1000.0,
        youngs_modulus=YOUNGS_MODULUS,
        poissons_ratio=0.3,
        domain_box=3 * finer,
    )


def block_means(x: np.ndarray) -> np.ndarray:
    """Mean positions of the cube's 64 blocks [m], shape (..., 64, 3), of positions in `flight`'s order.

    A block holds the same matter at every resolution, and its mean converges with the square of a cell.
    """
    count = round(x.shape[-2] ** (1 / 3))
    width = count // _BLOCKS
    blocks = x.reshape(*x.shape[:-2], _BLOCKS, width, _BLOCKS, width, _BLOCKS, width, 3)
    means = blocks.astype(float).mean(axis=(-6, -4, -2))
    return means.reshape(*x.shape[:-2], _BLOCKS**3, 3)
