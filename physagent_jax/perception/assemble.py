"""Poses, masks and depth put together into measures per frame, with a reason where there is none."""

from __future__ import annotations

import dataclasses

import numpy as np

from physagent_jax.perception import lift
from physagent_jax.perception.fit import estimate_hidden_spread
from physagent_jax.perception.follow import Path
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
MIDDLE_OFF, DEPTH_OFF = 0.02, 0.08
"""How far the middle in one picture is off, across the view and, guessed from the rim, along it [body lengths]."""
INDEPENDENT_VIEWS = 4.0
"""Neighbouring frames err alike: so many of a clip's views count."""
CUT = "the object is cut off by the picture's border"
GONE = "the object is not in the picture"
LOST = "too few points could be followed"
LOOSE = "the parts move too differently to share one rotation or stretch"


def touches_border(mask: np.ndarray) -> bool:
    """Whether the object reaches the picture's border."""
    return bool(mask[0].any() or mask[-1].any() or mask[:, 0].any() or mask[:, -1].any())


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


def assemble(path: Path, masks: np.ndarray, depth: np.ndarray, trusted: np.ndarray, camera: Camera) -> Frames:
    """Measures every frame.

    Args:
        path: The object's poses.
        masks: The object, bool, shape (T, H, W).
        depth: z-depth [m], nan where unknown, shape (T, H, W).
        trusted: Its trusted part, nan elsewhere, shape (T, H, W).
        camera: The camera.
    """
    nothing = np.full((2, 3), np.nan)
    corners = np.stack(
        [lift.measure_box(*seen, camera) if seen[1].any() else nothing for seen in zip(depth, masks, trusted)]
    )
    edges = corners[:, 1] - corners[:, 0]
    size, center = float(edges[0].max()), lift.find_center(trusted[0], masks[0], camera)
    area, cut, out = masks.sum((1, 2)), *_find_leaving(masks)
    center = _ride_along(path, trusted, masks, cut, center, size, camera)
    points = [lift.unproject_surface(d, camera)[::7] for d in trusted]
    loose = np.array([p is not None and p.residual > LOOSEST * size for p in path.poses])
    path = dataclasses.replace(path, poses=[None if bad else p for p, bad in zip(path.poses, loose)])
    centroid = (_find_centroids(path, points, cut, center) - center) / size
    centroid[out] = np.nan
    forward = camera.forward.astype(float)

    def why(*conditions):
        """The first reason that holds, per frame."""
        return [next((reason for bad, reason in conditions if bad[t]), "") for t in range(len(masks))]

    gone, lost = (area == 0, GONE), (np.array([p is None for p in path.poses]), LOST)

    return Frames(
        size=size,
        center=center,
        centroid=centroid,
        poses=path.poses,
        chain=path.chain,
        corners=np.where(cut[:, None, None], np.nan, (corners - center) / size),
        box=np.where(cut[:, None], np.nan, np.maximum(edges / size, THINNEST)),
        depth_shown=np.array(
            [len(p) > 3 and estimate_hidden_spread(p, forward) > LEAST_RELIEF * size for p in points]
        ),
        reasons={
            "centroid": why(gone, (~np.isfinite(centroid[:, 0]), CUT)),
            "rotation": why(gone, (loose, LOOSE), lost),
            "box": why(gone, (cut, CUT)),
        },
    )


def _ride_along(
    path: Path, trusted, masks: np.ndarray, cut: np.ndarray, guess: np.ndarray, size: float, camera: Camera
) -> np.ndarray:
    """The point of frame 0 that stays in the object's middle as the object turns; world [m], shape (3,).

    One view does not tell how far behind the surface the middle lies; with the wrong depth it would swing about the
    right one in a turn. The middle in each frame is a ray that the riding point should meet: two equations that
    are linear in its depth. Without a turn they say nothing about it, and the guess stands.

    Args:
        path: The poses; those of the first chain are used.
        trusted: Trusted z-depth [m], nan elsewhere, shape (T, H, W).
        masks: The object, shape (T, H, W).
        cut: Whether the object is cut off by the border, shape (T,).
        guess: From frame 0 alone [m], shape (3,).
        size: The body length [m].
        camera: The camera.
    """
    view, K = np.asarray(camera.viewmat, float), np.asarray(camera.K, float)
    posed = [(t, p) for t, p in enumerate(path.poses) if p is not None and path.chain[t] == path.chain[0]]
    posed = [(t, p) for t, p in posed if not cut[t]]
    if len(posed) < 2 or path.poses[0] is None:
        return guess
    rows, values = [], []
    for t, pose in posed:
        u, v, _ = np.linalg.solve(K, [*lift.find_middle_pixel(trusted[t], masks[t], camera), 1.0])
        across = np.stack([view[0] - u * view[2], view[1] - v * view[2]])
        rows.append(across[:, :3] @ pose.matrix)
        values.append(-(across[:, :3] @ pose.offset + across[:, 3]))
    line = guess - camera.center
    line = line / np.linalg.norm(line)
    across, off = np.concatenate(rows) @ line, np.concatenate(values) - np.concatenate(rows) @ guess
    trust = INDEPENDENT_VIEWS / len(posed) / MIDDLE_OFF**2
    return guess + line * (trust * across @ off) / (trust * across @ across + 1 / DEPTH_OFF**2)


def _find_centroids(path: Path, points: list[np.ndarray], cut: np.ndarray, center: np.ndarray) -> np.ndarray:
    """World position of the object's centre per frame [m], shape (T, 3); nan where it cannot be told.

    The centre rides on the fitted motion. Where no points could be followed, it moves by as much as the
    mean of the visible surface, which is less exact as another side comes into view, and tells nothing
    while the object is cut off.

    Args:
        path: The poses.
        points: Visible surface per frame [m], each (n, 3).
        cut: Whether the object is cut off by the border, shape (T,).
        center: Centre in frame 0 [m], shape (3,).
    """
    centers, start, whole = np.full((len(points), 3), np.nan), {}, None
    for t, (pose, chain) in enumerate(zip(path.poses, path.chain)):
        if len(points[t]) == 0:
            continue
        middle, here = lift.find_middle(points[t]), None
        if t == 0:
            here = center
        elif pose is not None and chain in start:
            here = pose(start[chain])
        elif whole is not None and not cut[t]:
            here = whole[0] + middle - whole[1]
        if here is None:
            continue
        centers[t] = here
        if pose is not None and chain not in start:
            start[chain] = np.linalg.solve(pose.matrix, here - pose.offset)
        if not cut[t]:
            whole = here, middle
    return centers
