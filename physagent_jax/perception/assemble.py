"""Poses, masks and depth put together into measures per frame, with a reason where there is none."""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_jax.perception import lift
from physagent_jax.perception.bridging import bridge
from physagent_jax.perception.ends import DIRECTIONS
from physagent_jax.perception.extents import measure_breadths, measure_lengths
from physagent_jax.perception.fit import Affine, estimate_hidden_spread
from physagent_jax.perception.follow import Path
from physagent_jax.perception.protocols import Depth
from physagent_jax.perception.reasons import CUT, GONE, LOOSE, LOST, NO_DEPTH, NO_SIZE, TURNED
from physagent_jax.perception.unobservable import touches_border
from physagent_jax.perception.windows import Frames
from physagent_jax.render.camera import Camera

LEAST_AREA = 0.35
"""A cut-off object with less than this share of its first area left says nothing about its centre."""
LEAST_RELIEF = 0.04
"""Relief of the visible surface needed to see stretch along the view [body lengths]."""
THINNEST = 0.03
"""Box edges are taken as at least this long, so that a flat front gives no infinite ratio [body lengths]."""
LOOSEST = 0.05
"""Parts that are this far off the best affine motion share no rotation or stretch [body lengths]."""
MIDDLE_OFF = 0.02
"""Error of the outline's middle in one picture [body lengths]."""
ACROSS_OFF, DEPTH_OFF = 0.03, 0.12
"""Error of the first guess of the centre, across the view and, from the rim, along it [body lengths]."""
FULL_TILT = 20.0
"""Turned out of the picture plane by this, the fit's stretch behind the visible surface is not believed [deg]."""
MOST_EXTENT = 1e3
"""A visible surface that is longer is none of the object: its depth is wrong [body lengths]."""
MOST_TILT = 10.0
"""Turned out of the picture plane by more than this over an assumed form, a pose is not believed [deg]."""
INDEPENDENT_VIEWS = 4.0
"""Neighbouring frames err alike: so many of a clip's views count."""


def _find_leaving(masks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frames in which the object is cut off by the border, and those in which it is mostly out; each (T,).

    Once mostly out, it stays out until its area is back: a splinter that is left inside is not the object.
    """
    area = masks.sum((1, 2))
    cut, out = np.array([touches_border(m) for m in masks]), np.zeros(len(masks), bool)
    for t in range(len(masks)):
        gone_before = t > 0 and (out[t - 1] or area[t - 1] == 0)
        out[t] = area[t] < LEAST_AREA * area[0] and (cut[t] or gone_before)
    return cut | out, out


def in_view(masks: np.ndarray) -> np.ndarray:
    """Frames in which enough of the object shows to follow it, shape (T,)."""
    return masks.any((1, 2)) & ~_find_leaving(masks)[1]


def assemble(
    path: Path,
    masks: np.ndarray,
    depth: np.ndarray,
    trusted: np.ndarray,
    camera: Camera,
    directions: np.ndarray,
    estimate: Depth,
) -> Frames:
    """Measure every frame.

    Args:
        path: The object's poses.
        masks: The object, bool, shape (T, H, W).
        depth: z-depth [m], nan where unknown, shape (T, H, W).
        trusted: Its trusted part, nan elsewhere, shape (T, H, W).
        camera: The camera.
        directions: Along which extents are measured, unit vectors, shape (k, 3).
        estimate: The depth as it was estimated: whether its relief is known, and how its distance may drift.
    """
    corners = np.stack([lift.measure_box(*seen, camera) for seen in zip(depth, masks, trusted)])
    edges = corners[:, 1] - corners[:, 0]
    size, center = float(edges[0].max()), lift.find_center(trusted[0], masks[0], camera)
    beyond = edges.max(1) > MOST_EXTENT * size
    area, cut, out = masks.sum((1, 2)), *_find_leaving(masks)
    points = [lift.unproject_surface(d, camera)[::7] for d in trusted]
    outlines = [lift.unproject_mask(d, m, camera) for d, m in zip(trusted, masks)]
    center = _ride_along(path, points[0], outlines, trusted, cut, center, size, camera)
    loose = np.array([p is not None and p.residual > LOOSEST * size for p in path.poses])
    # A fit that is bad for some frames parts those before it from those after it, as a gap does.
    bridged = bridge(path.poses, np.where(path.chain < 0, -1, 2 * path.chain + loose))
    path = dataclasses.replace(path, poses=[None if bad else p for p, bad in zip(path.poses, loose)])
    centroid = (_find_centroids(path, points, cut, center, camera) - center) / size
    centroid[out] = np.nan
    forward = camera.forward.astype(float)
    tilt = np.array([0.0 if p is None else _measure_tilt(p, forward) for p in path.poses])
    turned = (tilt > MOST_TILT) & (not estimate.relief_known)
    if turned.any():
        path = dataclasses.replace(path, poses=[None if bad else p for p, bad in zip(path.poses, turned)])

    def why(*conditions):
        """The first reason that holds, per frame."""
        return [next((reason for bad, reason in conditions if bad[t]), "") for t in range(len(masks))]

    gone, blind = (area == 0, GONE), (~np.isfinite(trusted).any((1, 2)), NO_DEPTH)
    lost = (np.array([p is None for p in path.poses]), LOST)

    return Frames(
        size=size,
        center=center,
        centroid=centroid,
        poses=path.poses,
        chain=path.chain,
        corners=np.where((cut | beyond)[:, None, None], np.nan, (corners - center) / size),
        box=np.where((cut | beyond)[:, None], np.nan, np.maximum(edges / size, THINNEST)),
        lengths=np.where((cut | beyond)[:, None], np.nan, measure_lengths(outlines, directions) / size),
        breadths=np.where(
            (cut | beyond)[:, None, None], np.nan, measure_breadths(outlines, DIRECTIONS, directions) / size
        ),
        depth_shown=np.array(
            [
                estimate.relief_known
                and len(p) > 3
                and estimate_hidden_spread(p, forward) > LEAST_RELIEF * size
                for p in points
            ]
        ),
        reasons={
            "centroid": why(gone, blind, (~np.isfinite(centroid[:, 0]), CUT)),
            "rotation": why(gone, blind, (loose, LOOSE), (turned, TURNED), lost),
            "box": why(gone, (cut, CUT), blind, (beyond, NO_SIZE)),
        },
        drift=None if estimate.drift is None else estimate.drift / size,
        relief_known=estimate.relief_known,
        tilt=float(tilt.max()),
        turned=bridged if estimate.relief_known else None,
    )


def _measure_tilt(pose: Affine, forward: np.ndarray) -> float:
    """Angle by which a pose turns out of the picture plane [deg]; ``forward`` is the viewing direction, shape (3,)."""
    return float(np.degrees(np.arccos(np.clip(forward @ pose.rotation @ forward, -1, 1))))


@dataclasses.dataclass(frozen=True)
class _Rider:
    """The centre as a point that rides on the fitted motion, from ``anchor`` on the visible surface before it.

    Points on the surface tell how the anchor moves, but little of how the body is stretched behind them: an error
    of 0.1 there moves the centre by 0.03 body lengths, half of what turns were misjudged by. So the lever from anchor
    to centre turns with the fit, and takes part in its stretch as long as the same side is seen.

    Attributes:
        anchor: In the chain's first frame [m], shape (3,).
        lever: From there to the centre [m], shape (3,).
        forward: The viewing direction, shape (3,).
    """

    anchor: np.ndarray
    lever: np.ndarray
    forward: np.ndarray

    @classmethod
    def place(cls, center: np.ndarray, surface: np.ndarray, camera: Camera) -> _Rider:
        """For a centre whose line of sight meets the visible surface ``surface``, shape (n, 3)."""
        sight = (center - camera.center) / np.linalg.norm(center - camera.center)
        lever = sight * (sight @ (center - lift.find_middle(surface)))
        return cls(center - lever, lever, camera.forward.astype(float))

    def turn(self, pose: Affine) -> np.ndarray:
        """The rotation that carries the lever under a pose, shape (3, 3)."""
        share = max(1 - _measure_tilt(pose, self.forward) / FULL_TILT, 0.0)
        return share * pose.matrix + (1 - share) * pose.rotation

    def __call__(self, pose: Affine) -> np.ndarray:
        """The position of the centre [m], shape (3,)."""
        return pose(self.anchor) + self.turn(pose) @ self.lever


def _ride_along(
    path: Path,
    surface: np.ndarray,
    outlines: list[np.ndarray],
    trusted: np.ndarray,
    cut: np.ndarray,
    guess: np.ndarray,
    size: float,
    camera: Camera,
) -> np.ndarray:
    """The point of frame 0 that stays in the outline's middle as the object turns; world [m], shape (3,).

    One view does not tell how far behind the surface the middle lies; with the wrong depth it would swing about the
    right one in a turn. Each frame's outline has its middle, which the riding point should meet: two linear equations
    for the centre. Without a turn they say nothing about its depth, and the guess stands.

    Args:
        path: The poses; those of the first chain are used.
        surface: The visible surface in frame 0 [m], shape (n, 3).
        outlines: All the mask's pixels per frame [m], each (n, 3).
        trusted: Trusted z-depth [m], nan elsewhere, shape (T, H, W).
        cut: Whether the object is cut off by the border, shape (T,).
        guess: From frame 0 alone [m], shape (3,).
        size: The body length [m].
        camera: The camera.
    """
    posed = [(t, p) for t, p in enumerate(path.poses) if p is not None and path.chain[t] == path.chain[0]]
    posed = [(t, p) for t, p in posed if not cut[t] and len(outlines[t])]
    if len(posed) < 2 or path.poses[0] is None:
        return guess
    rider, rows, off = _Rider.place(guess, surface, camera), [], []
    for t, pose in posed:
        across, middle = lift.find_middle_across(outlines[t], trusted[t], camera)
        rows.append(across @ rider.turn(pose))
        off.append(middle - across @ rider(pose))
    A, b = np.concatenate(rows), np.concatenate(off)
    trust = INDEPENDENT_VIEWS / len(posed) / MIDDLE_OFF**2
    sight = (guess - camera.center) / np.linalg.norm(guess - camera.center)
    along = np.outer(sight, sight)
    prior = along / DEPTH_OFF**2 + (np.eye(3) - along) / ACROSS_OFF**2
    return guess + np.linalg.solve(trust * A.T @ A + prior, trust * A.T @ b)


def _find_centroids(
    path: Path, points: list[np.ndarray], cut: np.ndarray, center: np.ndarray, camera: Camera
) -> np.ndarray:
    """World position of the object's centre per frame [m], shape (T, 3); nan where it cannot be told.

    The centre rides on the fitted motion. Where no points could be followed, it moves by as much as the
    mean of the visible surface, which is less exact as another side comes into view, and tells nothing
    while the object is cut off.

    Args:
        path: The poses.
        points: Visible surface per frame [m], each (n, 3).
        cut: Whether the object is cut off by the border, shape (T,).
        center: Centre in frame 0 [m], shape (3,).
        camera: The camera.
    """
    centers, riders, whole = np.full((len(points), 3), np.nan), {}, None
    for t, (pose, chain) in enumerate(zip(path.poses, path.chain)):
        if len(points[t]) == 0:
            continue
        middle, here = lift.find_middle(points[t]), None
        if t == 0:
            here = center
        elif pose is not None and chain in riders:
            here = riders[chain](pose)
        elif whole is not None and not cut[t]:
            here = whole[0] + middle - whole[1]
        if here is None:
            continue
        centers[t] = here
        if pose is not None and chain not in riders:
            rider = _Rider.place(here, points[t], camera)
            lever = np.linalg.solve(rider.turn(pose), rider.lever)
            anchor = np.linalg.solve(pose.matrix, rider.anchor - pose.offset)
            riders[chain] = dataclasses.replace(rider, anchor=anchor, lever=lever)
        if not cut[t]:
            whole = here, middle
    return centers
