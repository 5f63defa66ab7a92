"""The shape of an object before it is simulated: from where its broad side is seen, along what it is longest."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from physagent_jax.core.strict import Vector
from physagent_jax.forces.part import split_name
from physagent_jax.scene.camera import UP
from physagent_jax.scene.config import Domain, Source
from physagent_jax.scene.foot import find_foot_edges
from physagent_jax.scene.load import load_named_parts, load_object
from physagent_jax.scene.mesh_formats import MeshPart
from physagent_jax.scene.placement import find_up_rotation, place

STEP = 15  # [degrees] between the directions that are tried
GAIN = 1.1  # times as much as from the front must be seen from elsewhere; what is about as broad all around stays
AS_GOOD = 0.985  # of the largest silhouette counts as the largest: of such, the direction nearest to the front is taken
RICHER = 1.25  # times as varied the colours must be on the other side for that to be the face
_STEEP = 0.9  # rise of a front, from which on it is up or down
_AGREE = 0.8  # length of the sum of the ways from right to left over the sum of their lengths, at least
LONGER = 1.3  # times as long as along the other axes it must be along its long one
TRIMMED = 0.005  # share of the points on each side that may be floaters
FEWEST_CELLS, MOST_CELLS = 8, 48  # across the object, for counting its silhouette


def find_broad_side(source: Source, domain: Domain) -> float:
    """The azimuth from which the object fills most of a picture [degrees]; 0 if it hardly matters.

    The file is read for that, before the sentence is: what left and right mean depends on where the camera stands.

    Args:
        source: The object, at an absolute path.
        domain: What it is placed in.

    Raises:
        UserError: The object cannot be used.
    """
    return _measure_cached(source.model_dump_json(), domain.model_dump_json())[0]


def find_long_axis(source: Source, domain: Domain) -> Vector | None:
    """The world axis along which the object is clearly longest (unit vector); None if it has none.

    Arguments and errors as of `find_broad_side`.
    """
    return _measure_cached(source.model_dump_json(), domain.model_dump_json())[1]


def find_extents(source: Source, domain: Domain, ways: Sequence[Vector]) -> tuple[float, float, float]:
    """The extents along unit vectors in the world, as shares of its longest side.

    Other arguments and errors as of `find_broad_side`.
    """
    return measure_extents(_measure_cached(source.model_dump_json(), domain.model_dump_json())[2], ways)


def find_edges(source: Source, domain: Domain) -> list[tuple[Vector, float]]:
    """The straight edges of its foot, as `find_foot_edges` tells them; arguments and errors as of `find_broad_side`."""
    return find_foot_edges(_measure_cached(source.model_dump_json(), domain.model_dump_json())[2])


def measure_extents(points: np.ndarray, ways: Sequence[Vector]) -> tuple[float, float, float]:
    """The extents of points, shape (n, 3), along three unit vectors, as shares of the longest along an axis."""
    first, second, third = np.ptp(points @ np.transpose(ways), axis=0) / np.ptp(points, axis=0).max()
    return round(float(first), 3), round(float(second), 3), round(float(third), 3)


@functools.lru_cache(maxsize=64)
def _measure_cached(source: str, domain: str) -> tuple[float, Vector | None, np.ndarray]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # they are heeded when the object is loaded in earnest
        parsed = Source.model_validate_json(source)
        loaded = load_object(parsed, Path())
        domain_read = Domain.model_validate_json(domain)
        cloud, placement = place(loaded.cloud, parsed, domain_read, loaded.origin)
        way = find_named_front(load_named_parts(parsed, Path()), placement.rotation)
    points = np.asarray(cloud.means, np.float64)
    if way is None and loaded.front is not None:
        way = placement.rotation @ find_up_rotation(loaded.front).T[:, 2]
    front = None
    if way is not None and abs(way[2]) < _STEEP:
        front = float(np.degrees(np.arctan2(way[0], -way[1])))
    colours = np.asarray(cloud.sh, np.float64)[:, 0]
    low, high = np.quantile(points, [TRIMMED, 1 - TRIMMED], axis=0)
    kept = points[((points >= low) & (points <= high)).all(axis=1)]
    return find_broad_azimuth(points, colours, front), _find_long_axis(points), kept


def find_named_front(surfaces: Sequence[MeshPart], rotation: np.ndarray) -> np.ndarray | None:
    """The way in which something looks whose file names its left and its right; a unit vector, shape (3,).

    Left is its own: that of a figure that looks at the viewer is on the viewer's right.

    Args:
        surfaces: Surfaces with their names, in the file's frame.
        rotation: From there to the world, shape (3, 3).

    Returns:
        None if no two surfaces are called alike but for their sides, or if they contradict each other.
    """
    centres: dict[str, dict[tuple[str, ...], np.ndarray]] = {"left": {}, "right": {}}
    for each in surfaces:
        words = split_name(each.names[0]) if each.names else ()
        for side in set(words) & centres.keys():
            rest = tuple(word for word in words if word != side)
            centres[side].setdefault(rest, each.vertices[each.faces].mean((0, 1)) @ rotation.T)
    left, right = centres.values()
    across = np.array([left[rest] - right[rest] for rest in left.keys() & right.keys()]).reshape(-1, 3)
    across[:, 2] = 0.0
    length = float(np.linalg.norm(across.sum(0)))
    if not length > _AGREE * np.linalg.norm(across, axis=1).sum() > 0:
        return None
    return np.cross(across.sum(0) / length, UP)


def _find_long_axis(points: np.ndarray) -> Vector | None:
    extent = np.subtract(*np.quantile(points, [1 - TRIMMED, TRIMMED], axis=0))
    shorter, longest = np.argsort(extent)[-2:]
    if not extent[longest] >= LONGER * extent[shorter]:
        return None
    x, y, z = np.eye(3)[longest].tolist()
    return x, y, z


def find_broad_azimuth(points: np.ndarray, colours: np.ndarray, front: float | None = None) -> float:
    """The azimuth (`CameraConfig.azimuth_degrees`) from which an object's face is seen [degrees], in (-180, 180].

    The largest silhouette says which sides are broad. It is the same from behind: of the two, the side with the more
    varied colours is the face if it is clearly so, else the one within a quarter turn of 0. Where the front is known,
    the side within a quarter turn of it is the face, whatever its colours: parts called left and right tell it, or the
    format.

    Args:
        points: Shape (n, 3).
        colours: In any linear units, shape (n, 3).
        front: The azimuth from which the front is seen [degrees]; None = nothing tells it.
    """
    low, high = np.quantile(points, [TRIMMED, 1 - TRIMMED], axis=0)
    inner = ((points >= low) & (points <= high)).all(axis=1)
    if inner.any():
        points, colours = points[inner], colours[inner]
    points = points - points.mean(0)
    cells = int(np.clip(np.sqrt(len(points)) / 4, FEWEST_CELLS, MOST_CELLS))
    cell = max(float(np.ptp(points, axis=0).max()), 1e-9) / cells
    tried = sorted(range(STEP - 90, 91, STEP), key=lambda azimuth: (abs(azimuth), -azimuth))
    areas = [len(find_seen(points, (front or 0.0) + azimuth, cell)) for azimuth in tried]
    found = 0
    if max(areas) > GAIN * areas[0]:
        found = next(azimuth for azimuth, area in zip(tried, areas) if area >= AS_GOOD * max(areas))
    if front is not None:
        return 180 - (180 - front - found) % 360
    behind = found + 180 if found <= 0 else found - 180
    here, there = (_measure_variety(colours[find_seen(points, each, cell)]) for each in (found, behind))
    return float(behind if there > RICHER * here else found)


def find_seen(points: np.ndarray, azimuth: float, cell: float) -> np.ndarray:
    """Indices of the points that are in front in the cells of a picture taken horizontally from ``azimuth``."""
    angle = np.radians(azimuth)
    across = points[:, 0] * np.cos(angle) + points[:, 1] * np.sin(angle)
    depth = points[:, 1] * np.cos(angle) - points[:, 0] * np.sin(angle)
    column, row = (np.floor(each / cell).astype(np.int64) for each in (across, points[:, 2]))
    order = np.lexsort((depth, row, column))
    column, row = column[order], row[order]
    first = np.ones(len(order), bool)
    first[1:] = (np.diff(column) != 0) | (np.diff(row) != 0)
    return order[first]


def _measure_variety(colours: np.ndarray) -> float:
    """The mean distance of colours (m, 3) from their mean."""
    return float(np.sqrt(colours.var(axis=0).sum()))
