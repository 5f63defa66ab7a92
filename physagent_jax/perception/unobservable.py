"""First frames from which nothing can be measured: how they are told, and the report of such a clip."""

from __future__ import annotations

import numpy as np

from physagent_jax.perception import lift
from physagent_jax.perception.reasons import FILLING, GONE, NO_DEPTH
from physagent_jax.perception.schema import MotionReport, Quality
from physagent_jax.perception.windows import Frames, measure_window
from physagent_jax.render.camera import Camera

LEAST_PIXELS = 8
"""Fewer pixels in frame 0 are no object, and fewer known depths tell no size [px]."""
MOST_BORDER = 0.9
"""An object on more of the border in frame 0 than this has an unknown size [share of the border's pixels]."""
LEAST_EXTENT = 0.5
"""A surface that spans less than this is a point: its depth is too small to be told from zero [pixels at its depth]."""


def touches_border(mask: np.ndarray) -> bool:
    """Return whether the object reaches the picture's border."""
    return bool(mask[0].any() or mask[-1].any() or mask[:, 0].any() or mask[:, -1].any())


def measure_border_share(mask: np.ndarray) -> float:
    """Share of the pixels along the picture's border that lie on the object."""
    border = np.ones(mask.shape, bool)
    border[1:-1, 1:-1] = False
    return float(mask[border].mean())


def explain_outline(mask: np.ndarray) -> str:
    """The reason why an outline tells neither place nor size of the object; empty if it does.

    Args:
        mask: The object in frame 0, bool, shape (H, W).
    """
    seen = int(mask.sum())
    if seen == 0:
        return GONE
    if seen < LEAST_PIXELS:
        return f"the object covers only {seen} pixel{'s' * (seen > 1)} of the picture"
    return FILLING if measure_border_share(mask) > MOST_BORDER else ""


def explain_depth(trusted: np.ndarray, camera: Camera) -> str:
    """The reason why depth tells no size of the object; empty if it does.

    Args:
        trusted: Trusted z-depth in frame 0 [m], nan elsewhere, shape (H, W).
        camera: The camera.
    """
    points = lift.unproject_surface(trusted, camera)
    if len(points) < LEAST_PIXELS:
        return NO_DEPTH
    pixel = float(np.nanmedian(trusted)) / float(np.asarray(camera.K)[0, 0])
    return NO_DEPTH if np.ptp(points, axis=0).max() < LEAST_EXTENT * pixel else ""


def report_nothing(
    masks: np.ndarray, why: str, frame_dt: float, spans: list[tuple[int, int]], notes: list[str]
) -> MotionReport:
    """The report of a clip whose first frame tells too little of the object to compare with.

    Args:
        masks: The object, bool, shape (T, H, W).
        why: The reason, as `explain_outline` or `explain_depth` gives it.
        frame_dt: Seconds per frame [s].
        spans: First and last frame of each window, inclusive.
        notes: What weakened the masks and the depth, a sentence each.
    """
    count, reason = len(masks), f"{why} in frame 0"
    nan = np.full((count, 3), np.nan)
    frames = Frames(
        0.0,
        np.zeros(3),
        nan,
        [None] * count,
        np.full(count, -1),
        nan,
        np.zeros(count, bool),
        {topic: [reason] * count for topic in ("centroid", "rotation", "box")},
    )
    quality = Quality(
        tracks_kept=0.0,
        fit_residual=0.0,
        depth_noise=0.0,
        mask_fraction=float(masks[0].mean()),
        leaves_frame=find_leaving_frame(masks),
        notes=(*notes, f"In frame 0, {why}: there is nothing to compare with."),
    )
    told = "No object is visible in the initial frame" if why == GONE else f"In the initial frame, {why}"
    return MotionReport(
        frame_count=count,
        frame_dt=frame_dt,
        object_size=0.0,
        object_center=(0.0, 0.0, 0.0),
        windows=tuple(measure_window(frames, *span) for span in spans),
        centroid=(None,) * count,
        rotation_degrees=(None,) * count,
        volume_ratio=(None,) * count,
        rotation=(None,) * count,
        stretch=(None,) * count,
        box=(None,) * count,
        pieces=(None,) * count,
        oscillation=None,
        onset_frame=None,
        settle_frame=None,
        quality=quality,
        text=f"{told}, so its motion is not observable.",
    )


def find_leaving_frame(masks: np.ndarray) -> int | None:
    """First frame in which the object touches the picture's border; None if it never does."""
    return next((t for t, mask in enumerate(masks) if touches_border(mask)), None)
