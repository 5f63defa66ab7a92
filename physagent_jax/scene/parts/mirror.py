"""The upright mirror plane of a solid: what is left and right of an animal, a person or a plane is alike.

Upright planes at all angles are tried, each near the centre of mass. A plane's likeness is how near the image of each
cell comes to the solid (as in Podolak et al., SIGGRAPH 2006, "A planar-reflective symmetry transform").
"""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_jax.scene.parts.lattice import Lattice, find_depth

_ANGLES = 48  # in half a turn
_OFFSETS = np.linspace(-0.06, 0.06, 5)  # of the length, from the centre of mass
_SAMPLES = 1000  # cells whose images are looked at
_NEAR = 0.08  # of the length, at which an image that misses the solid counts no more


@dataclasses.dataclass(frozen=True)
class Mirror:
    """An upright plane.

    Attributes:
        normal: Unit vector across it, level, shape (3,).
        offset: Its distance from the origin along that [m].
        likeness: Mean nearness of the solid to its own image, from 0 to 1.
    """

    normal: np.ndarray
    offset: float
    likeness: float

    def measure(self, places: np.ndarray) -> np.ndarray:
        """Signed distances from the plane [m], shape (...,), of places of shape (..., 3)."""
        return places @ self.normal - self.offset

    def reflect(self, places: np.ndarray) -> np.ndarray:
        """The images of places, shape (..., 3)."""
        return places - 2 * self.measure(places)[..., None] * self.normal


def find_mirrors(lattice: Lattice) -> list[Mirror]:
    """The planes that are more alike than those beside them, likeliest first."""
    solid, places = lattice.solid, lattice.places
    size = float(np.ptp(places, axis=0).max())
    middle = places.mean(0)
    missed = find_depth(~solid) * lattice.spacing / (_NEAR * size)
    first, at = places[0], np.argwhere(solid)[0]
    sample = places[:: -(-len(places) // _SAMPLES)]
    weights = np.linalg.norm((sample - middle)[:, :2], axis=1)
    weights /= max(float(weights.sum()), 1e-12)
    best: list[Mirror] = []
    for angle in np.pi * np.arange(_ANGLES) / _ANGLES:
        normal = np.array([np.cos(angle), np.sin(angle), 0.0])
        planes = [Mirror(normal, float(middle @ normal) + size * offset, 0.0) for offset in _OFFSETS]
        images = np.stack([plane.reflect(sample) for plane in planes])
        index = np.round((images - first) / lattice.spacing).astype(int) + at
        inside = ((index >= 0) & (index < solid.shape)).all(-1)
        cells = tuple(np.moveaxis(index.clip(0, np.array(solid.shape) - 1), -1, 0))
        nearness = np.where(inside, (1 - missed[cells]).clip(0, 1), 0.0) @ weights
        top = int(nearness.argmax())
        best.append(dataclasses.replace(planes[top], likeness=float(nearness[top])))
    peaks = [
        each
        for k, each in enumerate(best)
        if each.likeness >= max(best[k - 1].likeness, best[(k + 1) % _ANGLES].likeness)
    ]
    return sorted(peaks, key=lambda each: -each.likeness)
