"""The object's placement: the similarity that brings a captured cloud into the simulation's domain."""

from __future__ import annotations

import dataclasses
import warnings

import numpy as np
from scipy.spatial.transform import Rotation

from physagent_jax.core.arrays import to_device
from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.scene.config import Domain, SignedAxis, Source

WALL_CELLS = 3  # the cells that `DomainBox` keeps free around the domain by default
FLOATER_SHARE = 0.01  # at most this share of the Gaussians per side can count as floaters
FLOATER_DISTANCE = 0.5  # how far outside the bulk they must be, over the bulk's longest side

# Proper rotations that bring each axis onto +z. Each is the shortest: about +x for the y axes, so that +x
# (what a picture shows to the right) stays; about +y for the x axes; half a turn about +x for -z.
_TO_PLUS_Z = {
    "+z": ("x", 0.0),
    "-z": ("x", 180.0),
    "+y": ("x", 90.0),
    "-y": ("x", -90.0),
    "+x": ("y", -90.0),
    "-x": ("y", 90.0),
}


@dataclasses.dataclass(frozen=True)
class Placement:
    """World = scale * rotation @ (source - origin) + offset.

    Attributes:
        rotation: Proper rotation from the file's frame to the world, shape (3, 3).
        scale: World metres per unit of the file [m].
        offset: World position of ``origin`` [m], shape (3,).
        origin: Point of the file that clouds are relative to [file units], float64, shape (3,); mostly zero.
    """

    rotation: np.ndarray
    scale: float
    offset: np.ndarray
    origin: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros(3))

    def to_world(self, points) -> np.ndarray:
        """Points of the file, shape (..., 3), in the world [m]."""
        return self._from_origin(np.asarray(points, np.float64) - self.origin)

    def to_source(self, points) -> np.ndarray:
        """World points [m], shape (..., 3), in the file's frame and units."""
        return self.to_origin(points) + self.origin

    def to_origin(self, points) -> np.ndarray:
        """World points [m], shape (..., 3), in the file's frame and units, relative to ``origin``."""
        return (np.asarray(points, np.float64) - self.offset) @ self.rotation / self.scale

    def cloud_to_world(self, cloud: GaussianCloud) -> GaussianCloud:
        """The cloud in the world. ``sh`` stays in the captured frame: the renderer is handed ``rotation``."""
        return _move(cloud, self._from_origin(np.asarray(cloud.means, np.float64)), self.rotation, self.scale)

    def cloud_to_source(self, cloud: GaussianCloud) -> GaussianCloud:
        """Inverse of `cloud_to_world`: in the file's frame and units, relative to ``origin``."""
        return _move(cloud, self.to_origin(cloud.means), self.rotation.T, 1.0 / self.scale)

    def _from_origin(self, points: np.ndarray) -> np.ndarray:
        return self.scale * (points @ self.rotation.T) + self.offset


def place(
    cloud: GaussianCloud, source: Source, domain: Domain, origin: np.ndarray | None = None
) -> tuple[GaussianCloud, Placement]:
    """Crops, rotates, scales and centres a loaded cloud.

    The order is PhysGaussian's: extra rotations, crop, then (ours) ``up`` onto +z, ``tilt`` and ``attitude``, then the
    plain bounding box of the centres is scaled to ``source.extent`` and centred.

    Args:
        cloud: As loaded, in the file's frame and units.
        source: How to place it.
        domain: The cube that it must fit in, with `WALL_CELLS` cells to spare.
        origin: Point of the file that the cloud is relative to [file units], shape (3,); None = zero.

    Returns:
        The cropped cloud in the world [m], and the transform from the file's frame.

    Raises:
        UserError: Nothing is left after the crop, the object has no extent, or it does not fit.
    """
    origin = np.zeros(3) if origin is None else np.asarray(origin, np.float64)
    turn = find_extra_rotation(source.rotation_degrees, source.rotation_axes)
    cloud = _crop(cloud, turn, source.crop, turn @ origin)
    upright = find_tilt_rotation(source.tilt) @ find_up_rotation(source.up)
    rotation = find_tilt_rotation(source.attitude) @ upright @ turn
    turned = np.asarray(cloud.means, np.float64) @ rotation.T
    if not np.isfinite(turned).all():
        raise UserError("the object has Gaussians whose centre is not finite", do="Export the file again")
    low, high = turned.min(axis=0), turned.max(axis=0)
    longest = float((high - low).max())
    if not longest > 0:
        raise UserError(
            "the object has no extent: all its Gaussians share one centre",
            got=f"{cloud.count} Gaussian(s)",
            do="Check `source.crop`, or choose another file",
        )
    _warn_of_floaters(turned, longest)
    scale = source.extent / longest
    center = np.full(3, 0.5 * domain.size) if source.center is None else np.asarray(source.center)
    placement = Placement(rotation, scale, center - scale * 0.5 * (low + high), origin)
    _check_fit(center, 0.5 * scale * (high - low), domain)
    return placement.cloud_to_world(cloud), placement


def find_up_rotation(up: SignedAxis) -> np.ndarray:
    """The shortest proper rotation that brings ``up`` onto +z, shape (3, 3); +x stays for z and y axes."""
    axis, degrees = _TO_PLUS_Z[up]
    return _find_exact(Rotation.from_euler(axis, degrees, degrees=True))


def find_tilt_rotation(tilt: tuple[float, float]) -> np.ndarray:
    """The rotation by a vector in the world's x-y plane [degrees], shape (3, 3)."""
    return _find_exact(Rotation.from_rotvec([*tilt, 0.0], degrees=True))


def find_extra_rotation(degrees: tuple[float, ...], axes: tuple[int, ...]) -> np.ndarray:
    """Product of right-handed rotations about the fixed axes, the first applied first, shape (3, 3)."""
    matrix = np.eye(3)
    for angle, axis in zip(degrees, axes):
        matrix = _find_exact(Rotation.from_euler("xyz"[axis], angle, degrees=True)) @ matrix
    return matrix


def _find_exact(rotation: Rotation) -> np.ndarray:
    """The matrix with rounding dust removed, so that quarter turns are exact permutations."""
    matrix = rotation.as_matrix()
    return np.where(np.abs(matrix - np.round(matrix)) < 1e-12, np.round(matrix), matrix)


def _crop(cloud: GaussianCloud, turn: np.ndarray, crop, origin: np.ndarray) -> GaussianCloud:
    """The Gaussians in a box of the turned file frame, in which ``origin`` is where the cloud's zero lies."""
    if cloud.count == 0:
        raise UserError(
            "the object has no Gaussians", do="Lower `source.opacity_threshold`, or choose another file"
        )
    if crop is None:
        return cloud
    means = np.asarray(cloud.means, np.float64) @ turn.T + origin
    low, high = np.asarray(crop[0::2]), np.asarray(crop[1::2])
    keep = np.all((means > low) & (means < high), axis=1)
    if not keep.any():
        raise UserError(
            "`source.crop` leaves no Gaussians",
            got=f"crop {list(crop)}, object from {means.min(axis=0).round(3).tolist()} "
            f"to {means.max(axis=0).round(3).tolist()}",
            do="Give (xmin, xmax, ymin, ymax, zmin, zmax) in file units around the object",
        )
    return _select(cloud, keep)


def _select(cloud: GaussianCloud, keep: np.ndarray) -> GaussianCloud:
    fields = {f.name: to_device(np.asarray(getattr(cloud, f.name))[keep]) for f in dataclasses.fields(cloud)}
    return GaussianCloud(**fields)


def _move(cloud: GaussianCloud, means: np.ndarray, rotation: np.ndarray, scale: float) -> GaussianCloud:
    quats = np.asarray(cloud.quats, np.float64)
    turned = (Rotation.from_matrix(rotation) * Rotation.from_quat(quats, scalar_first=True)).as_quat(
        scalar_first=True
    )
    scales = np.asarray(cloud.scales, np.float64) * scale
    return dataclasses.replace(
        cloud,
        means=to_device(means, np.float32),
        quats=to_device(turned, np.float32),
        scales=to_device(scales, np.float32),
    )


def _warn_of_floaters(points: np.ndarray, longest: float) -> None:
    """Warn of few, far Gaussians: they would shrink the object, since the bounding box is the plain one."""
    low = np.quantile(points, FLOATER_SHARE, axis=0, method="higher")
    high = np.quantile(points, 1 - FLOATER_SHARE, axis=0, method="lower")
    bulk = float((high - low).max())
    margin = FLOATER_DISTANCE * bulk
    outside = ((points < low - margin) | (points > high + margin)).any(axis=1)
    if 0 < outside.sum() <= 6 * FLOATER_SHARE * len(points):
        warnings.warn(
            f"{outside.sum()} of {len(points)} Gaussians float far from the object and stretch its bounding box "
            f"to {longest / max(bulk, 1e-30):.1f} times its bulk; `source.crop` removes them.",
            stacklevel=3,
        )


def _check_fit(center: np.ndarray, half: np.ndarray, domain: Domain) -> None:
    wall = WALL_CELLS * domain.dx
    slack = 1e-6 * domain.size
    if (center - half < wall - slack).any() or (center + half > domain.size - wall + slack).any():
        raise UserError(
            f"the object does not fit in the domain [0, {domain.size:g}]^3 with {WALL_CELLS} cells "
            f"({wall:.3g} m) of wall on each side",
            got=f"from {(center - half).round(3).tolist()} to {(center + half).round(3).tolist()} m",
            do="Reduce `source.extent`, move `source.center`, or enlarge `domain.size`",
        )
