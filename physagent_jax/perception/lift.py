"""From pixels to the world: trusted depth, unprojection, extents and centre of the visible surface."""

from __future__ import annotations

import cv2
import numpy as np

from physagent_jax.render.camera import Camera

SURFACE_SHARE = 1 / 3
"""Share of the way from the outline's middle to the visible surface's at which the object's middle lies.

Leaves and thin parts have more surface than outline. It takes 0.005 body lengths off on a plant, 0.002 on a robot; on
ten others it adds 0.001.
"""
RIM_PIXELS = 4  # [px] from the trusted part in which a rim is looked for
RIM_DEPTH = 0.15
"""[share of the object's width in the picture] by which a rim can lie behind the trusted depth beside it: the last four
of two hundred pixels across a ball fall back by that."""
NEAREST, FARTHEST = 1e-9, 1e9
"""Smaller and larger depths are marks for "no surface" [m]."""
MOST_RATIO = 1e3
"""Depths of one clip do not differ by more."""
_KERNEL = np.ones((3, 3), np.uint8)


def keep_possible_depth(depth: np.ndarray) -> np.ndarray:
    """``depth`` in single precision, nan where it cannot be a distance: not above 0, not finite, or beyond all scenes.

    Renderers and cameras write 0, inf or a number like 1e10 where they see no surface.

    Args:
        depth: z-depth [m], of any shape.
    """
    depth = np.asarray(depth)
    possible = (depth >= NEAREST) & (depth <= FARTHEST)
    return np.where(possible, depth, np.nan).astype(np.float32)


def keep_comparable_depth(depth: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """``depth`` without what is more than `MOST_RATIO` times nearer or farther than the object in frame 0.

    Args:
        depth: z-depth [m], nan where unknown, shape (T, H, W).
        mask: The object in frame 0, shape (H, W).
    """
    known = depth[0][mask & np.isfinite(depth[0])]
    if not len(known):
        return depth
    middle = float(np.median(known))
    comparable = (depth >= middle / MOST_RATIO) & (depth <= middle * MOST_RATIO)
    return np.where(comparable, depth, np.float32(np.nan))


def fill_dropped(depth: np.ndarray, masks: np.ndarray) -> np.ndarray:
    """``depth`` with the object's dropped pixels as the mean of their known neighbours on the object.

    Args:
        depth: z-depth [m], nan where unknown, shape (T, H, W).
        masks: The object, shape (T, H, W).

    Returns:
        float32, shape (T, H, W); larger holes stay nan.
    """
    filled = depth.astype(np.float32)
    for frame, mask in zip(filled, masks):
        for _ in range(2):
            known = mask & np.isfinite(frame)
            holes = mask & ~known
            if not holes.any():
                break
            weight = cv2.blur(known.astype(np.float32), (3, 3))
            total = cv2.blur(np.where(known, frame, 0).astype(np.float32), (3, 3))
            holes &= weight > 0.2
            frame[holes] = total[holes] / weight[holes]
    return filled


def keep_trusted_depth(depth: np.ndarray, mask: np.ndarray) -> tuple[np.ndarray, float]:
    """Keep depth where it can be trusted: inside an eroded mask and close to its 3x3 median.

    Depth at an object's edge is a blend of what is in front and what is behind. Where erosion would eat a
    thin object, it is lessened.

    Args:
        depth: z-depth [m], nan where unknown, shape (H, W).
        mask: The object, shape (H, W).

    Returns:
        depth: Smoothed by a 3x3 median, nan where not trusted, float32, shape (H, W).
        noise: Median absolute difference from the 3x3 median [m].
    """
    seen = mask & np.isfinite(depth)
    if not seen.any():
        return np.full_like(depth, np.nan), 0.0
    inner = seen
    for times in (2, 1):
        eroded = cv2.erode(seen.astype(np.uint8), _KERNEL, iterations=times) > 0
        if eroded.sum() > 0.4 * seen.sum():
            inner = eroded
            break
    else:
        return np.where(seen, depth, np.nan).astype(np.float32), 0.0
    median = cv2.medianBlur(np.where(seen, depth, 0).astype(np.float32), 3)
    off = np.abs(depth - median)
    noise = float(np.median(off[inner]))
    extent = np.subtract(*np.percentile(depth[inner], [95, 5]))
    trusted = inner & (off <= 3 * 1.4826 * noise + 0.02 * extent)  # slopes are no outliers
    return np.where(trusted, median, np.nan).astype(np.float32), noise


def cast_rays(camera: Camera) -> np.ndarray:
    """World directions of the pixels with unit z-depth, shape (H, W, 3)."""
    x, y = np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5)
    return unproject(np.stack([x, y], -1), np.ones(x.shape), camera) - camera.center


def unproject(xy: np.ndarray, depth: np.ndarray, camera: Camera) -> np.ndarray:
    """World points of pixels: p = K^-1 [x, y, 1] D, then camera to world.

    Args:
        xy: Pixel positions, centres at +0.5 [px], shape (..., 2).
        depth: z-depth [m], shape (...).
        camera: The camera.

    Returns:
        World points [m], shape (..., 3).
    """
    rays = np.concatenate([xy, np.ones_like(xy[..., :1])], -1) @ np.linalg.inv(np.asarray(camera.K, float)).T
    view = np.asarray(camera.viewmat, float)
    return (rays * depth[..., None] - view[:3, 3]) @ view[:3, :3]


def unproject_surface(depth: np.ndarray, camera: Camera, corner: tuple[int, int] = (0, 0)) -> np.ndarray:
    """World points of all pixels with finite depth [m], shape (n, 3).

    Args:
        depth: z-depth [m], shape (h, w): a picture's, or a part of it.
        camera: The camera.
        corner: Column and row at which the part begins [px].
    """
    y, x = np.nonzero(np.isfinite(depth))
    xy = np.stack([x + corner[0] + 0.5, y + corner[1] + 0.5], 1)
    return unproject(xy, depth[y, x].astype(float), camera)


def sample(depth: np.ndarray, xy: np.ndarray) -> np.ndarray:
    """Bilinear depth at pixel positions [m], shape (N,); nan where any of the four pixels is."""
    h, w = depth.shape
    x, y = (np.clip(np.nan_to_num(each, nan=-1.0), -1.0, max(h, w) + 1.0) - 0.5 for each in xy.T)
    x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
    inside = (x0 >= 0) & (y0 >= 0) & (x0 < w - 1) & (y0 < h - 1)
    x0, y0 = np.clip(x0, 0, w - 2), np.clip(y0, 0, h - 2)
    fx, fy = x - x0, y - y0
    top = depth[y0, x0] * (1 - fx) + depth[y0, x0 + 1] * fx
    bottom = depth[y0 + 1, x0] * (1 - fx) + depth[y0 + 1, x0 + 1] * fx
    return np.where(inside, top * (1 - fy) + bottom * fy, np.nan)


def measure_facing(depth: np.ndarray, xy: np.ndarray, camera: Camera, *, reach: float = 1.5) -> np.ndarray:
    """Cosine of the angle between the surface's normal and the viewing axis, shape (N,).

    Args:
        depth: Trusted depth [m], nan elsewhere, shape (H, W).
        xy: Pixel positions [px], shape (N, 2).
        camera: The camera.
        reach: Depth differences are taken this far on either side [px]; 0 is returned where that leaves the surface.
    """
    steps = [sample(depth, xy + s) - sample(depth, xy - s) for s in ((reach, 0.0), (0.0, reach))]
    slope = np.hypot(*steps) / (2 * reach) * float(np.asarray(camera.K)[0, 0]) / sample(depth, xy)
    return np.nan_to_num(1 / np.sqrt(1 + slope**2))


def measure_box(depth: np.ndarray, mask: np.ndarray, trusted: np.ndarray, camera: Camera) -> np.ndarray:
    """Lowest and highest corner of the world-axis box around the visible surface [m], shape (2, 3); nan if unknown.

    Takes the whole mask: the trusted part is too small by the eroded rim. Where the rim's depth is that of what is
    behind the object, it counts as `RIM_DEPTH` behind the trusted depth beside it.

    Args:
        depth: z-depth [m], nan where unknown, shape (H, W).
        mask: The object, shape (H, W).
        trusted: Its trusted depth, nan elsewhere, shape (H, W).
        camera: The camera.
    """
    x, y, width, height = cv2.boundingRect(mask.astype(np.uint8))
    box = np.s_[y : y + height, x : x + width]
    surface, trusted = np.where(mask[box], depth[box], np.nan).astype(np.float32), trusted[box]
    known = np.isfinite(trusted)
    if known.any():
        across = (max(width, height) - 1) * float(np.median(trusted[known])) / float(camera.K[0, 0])
        size = 2 * RIM_PIXELS + 1
        farthest = cv2.dilate(np.where(known, trusted, 0).astype(np.float32), np.ones((size, size), np.uint8))
        farthest[farthest == 0] = np.quantile(trusted[known], 0.99)
        surface = np.minimum(surface, farthest + np.float32(RIM_DEPTH * across))
    points = unproject_surface(surface, camera, corner=(x, y))
    return np.percentile(points, [0.03, 99.97], axis=0) if len(points) else np.full((2, 3), np.nan)


def find_middle(points: np.ndarray) -> np.ndarray:
    """Trimmed mean of points, without the outer tenth by distance from the median, shape (3,); nan without points."""
    if not len(points):
        return np.full(3, np.nan)
    distance = np.linalg.norm(points - np.median(points, axis=0), axis=1)
    return points[distance <= np.quantile(distance, 0.9)].mean(axis=0)


def measure_rim_depth(depth: np.ndarray, mask: np.ndarray) -> float:
    """z-depth of the outline, where the surface turns away from the camera [m]; nan if no depth is known.

    The outline of a round body runs around its middle, so its depth tells where the hidden half ends;
    that of a plate is the plate's own depth. A smooth surface meets its outline as
    ``z = z_rim - c sqrt(d)``, d being the distance from it, which is fitted and extrapolated to d = 0. An object with
    no outline inside the picture, or none with known depth beside it, has the median depth.

    Args:
        depth: Trusted depth [m], nan elsewhere, shape (H, W).
        mask: The object, shape (H, W).
    """
    known = np.isfinite(depth)
    if not known.any():
        return float("nan")
    reach = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 3)
    near = known & (reach < max(0.35 * reach.max(), 4.0))
    bins = np.round(reach[near]).astype(int)
    d = np.unique(bins)
    if len(d) < 3:
        return float(np.median(depth[known]))
    z = [np.median(depth[near][bins == b]) for b in d]
    slope, rim = np.polyfit(np.sqrt(d), z, 1)
    front, back = np.percentile(depth[known], [5, 100])
    return float(np.clip(rim, front, back + 0.5 * (back - front)))


def unproject_mask(depth: np.ndarray, mask: np.ndarray, camera: Camera) -> np.ndarray:
    """World points of all the mask's pixels, each at the nearest trusted depth [m], shape (n, 3).

    Args:
        depth: Trusted depth [m], nan elsewhere, shape (H, W).
        mask: The object, shape (H, W).
        camera: The camera.
    """
    x, y, width, height = cv2.boundingRect(mask.astype(np.uint8))
    box = np.s_[y : y + height, x : x + width]
    if not np.isfinite(depth[box]).any():
        return np.zeros((0, 3))
    surface = np.where(mask[box], _fill_nearest(depth[box]), np.float32(np.nan))
    return unproject_surface(surface, camera, corner=(x, y))


def find_middle_across(
    points: np.ndarray, depth: np.ndarray, camera: Camera
) -> tuple[np.ndarray, np.ndarray]:
    """The middle across the line of sight: of the object's outline as seen from far away, and of its visible surface.

    A centrally symmetric body seen from far away has its centre in its outline's middle, however it is turned. From
    near, what is near is larger, and the mask's mean misses the centre by up to 0.06 body lengths. So the surface's
    points are projected along the line of sight, without perspective, and the mean is that of the area they cover. The
    visible surface's mean by true area takes part with `SURFACE_SHARE`.

    Args:
        points: Points of `unproject_mask` [m], shape (n, 3), n >= 1.
        depth: Trusted depth [m], nan elsewhere, shape (H, W).
        camera: The camera.

    Returns:
        Two unit vectors across the line of sight to the object, in the world, shape (2, 3), and the middle's
        coordinates along them, measured from the world's origin [m], shape (2,).
    """
    sight = points.mean(0) - camera.center
    distance = float(np.linalg.norm(sight))
    right = np.cross(sight, np.asarray(camera.viewmat, float)[1, :3])
    right /= np.linalg.norm(right)
    across = np.stack([right, np.cross(sight / distance, right)])
    flat, cell = points @ across.T, distance / float(np.asarray(camera.K)[0, 0])
    low = flat.min(0)
    most = 4 * (camera.width + camera.height)  # what is so far off the rest is none of the object
    index = np.floor(np.minimum((flat - low) / cell, most)).astype(int) + 1
    covered = np.zeros(index.max(0) + 2, np.uint8)
    covered[tuple(index.T)] = 1
    covered = cv2.morphologyEx(covered, cv2.MORPH_CLOSE, _KERNEL)  # where a cell fell between two pixels
    middle = low + cell * (np.argwhere(covered).mean(0) - 0.5)
    return across, middle + SURFACE_SHARE * (across @ _find_surface_mean(depth, camera) - middle)


def _find_surface_mean(depth: np.ndarray, camera: Camera) -> np.ndarray:
    """Mean of the visible surface by true area [m], shape (3,)."""
    y, x = (i[::5] for i in np.nonzero(np.isfinite(depth)))
    xy, z = np.stack([x + 0.5, y + 0.5], 1), depth[y, x].astype(float)
    area = z**2 / np.maximum(measure_facing(depth, xy, camera), 0.3)
    return area @ unproject(xy, z, camera) / area.sum()


def _fill_nearest(depth: np.ndarray) -> np.ndarray:
    """``depth`` with unknown pixels as the nearest known one; some must be known."""
    known = np.isfinite(depth)
    labels = np.asarray(
        cv2.distanceTransformWithLabels(
            (~known).astype(np.uint8), cv2.DIST_L2, 3, labelType=cv2.DIST_LABEL_PIXEL
        )[1],
        int,
    )
    value = np.zeros(labels.max() + 1, np.float32)
    value[labels[known]] = depth[known]
    return value[labels]


def find_center(depth: np.ndarray, mask: np.ndarray, camera: Camera) -> np.ndarray:
    """The object's likely centre: the middle of its outline, at the depth of its rim; world [m], shape (3,).

    It is nan if no depth is known. The mean of the visible surface lies too near. It would seem to travel when the
    object turns on the spot.

    Args:
        depth: Trusted depth [m], nan elsewhere, shape (H, W).
        mask: The object, shape (H, W).
        camera: The camera.
    """
    outline = unproject_mask(depth, mask, camera)
    if not len(outline):
        return np.full(3, np.nan)
    across, middle = find_middle_across(outline, depth, camera)
    view = np.asarray(camera.viewmat, float)
    rim = measure_rim_depth(depth, mask) - view[2, 3]
    return np.linalg.solve(np.vstack([across, view[2, :3]]), [*middle, rim])
