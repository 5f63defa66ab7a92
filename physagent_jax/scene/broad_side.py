"""From where an object's broad side is seen, for objects whose file or user does not say where to look from."""

from __future__ import annotations

import functools
import warnings
from pathlib import Path

import numpy as np

from physagent_jax.scene.config import Domain, Source
from physagent_jax.scene.load import load_object
from physagent_jax.scene.placement import place

STEP = 15  # [degrees] between the directions that are tried
GAIN = 1.1  # times as much as from the front must be seen from elsewhere; what is about as broad all around stays
AS_GOOD = 0.985  # of the largest silhouette counts as the largest: of such, the direction nearest to the front is taken
TRIMMED = 0.005  # share of the points on each side that may be floaters
FEWEST_CELLS, MOST_CELLS = 8, 48  # across the object, for counting its silhouette


def find_broad_side(source: Source, domain: Domain) -> float:
    """The azimuth from which the object fills most of a picture [degrees], in (-90, 90]; 0 if it hardly matters.

    The file is read for that, before the sentence is: what left and right mean depends on where the camera stands.

    Args:
        source: The object, at an absolute path.
        domain: What it is placed in.

    Raises:
        UserError: The object cannot be used.
    """
    return _find_cached(source.model_dump_json(), domain.model_dump_json())


@functools.lru_cache(maxsize=64)
def _find_cached(source: str, domain: str) -> float:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # they are heeded when the object is loaded in earnest
        parsed = Source.model_validate_json(source)
        cloud, _ = place(load_object(parsed, Path()), parsed, Domain.model_validate_json(domain))
    return find_broad_azimuth(np.asarray(cloud.means, np.float64))


def find_broad_azimuth(points: np.ndarray) -> float:
    """The azimuth (`CameraConfig.azimuth_degrees`) from which ``points``, shape (n, 3), have the largest silhouette.

    From behind a silhouette is the same as from in front: only directions up to a quarter turn from 0 are tried.
    """
    low, high = np.quantile(points, [TRIMMED, 1 - TRIMMED], axis=0)
    inner = points[((points >= low) & (points <= high)).all(axis=1)]
    points = inner if len(inner) else points
    points = points - points.mean(0)
    cells = int(np.clip(np.sqrt(len(points)) / 4, FEWEST_CELLS, MOST_CELLS))
    cell = max(float(np.ptp(points, axis=0).max()), 1e-9) / cells
    tried = sorted(range(STEP - 90, 91, STEP), key=lambda azimuth: (abs(azimuth), -azimuth))
    areas = [_count_cells(points, azimuth, cell) for azimuth in tried]
    if max(areas) <= GAIN * areas[0]:
        return 0.0
    return float(next(a for a, area in zip(tried, areas) if area >= AS_GOOD * max(areas)))


def _count_cells(points: np.ndarray, azimuth: float, cell: float) -> int:
    """Cells of a picture taken horizontally from ``azimuth`` that show a point."""
    angle = np.radians(azimuth)
    across = points[:, 0] * np.cos(angle) + points[:, 1] * np.sin(angle)
    places = np.floor(np.stack([across, points[:, 2]], axis=1) / cell).astype(np.int64)
    return len(np.unique(places, axis=0))
