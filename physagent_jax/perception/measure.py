"""From pictures to the motion report: segment, follow, lift, measure, tell."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.perception import lift, timing
from physagent_jax.perception.assemble import assemble, in_view
from physagent_jax.perception.backends import make_backends
from physagent_jax.perception.ends import PartPrompt
from physagent_jax.perception.extents import choose_directions, describe_extents, find_disagreement
from physagent_jax.perception.fit import to_matrix
from physagent_jax.perception.follow import follow
from physagent_jax.perception.pieces import count_pieces
from physagent_jax.perception.prompt import find_prompt
from physagent_jax.perception.protocols import (
    Cues,
    Depth,
    EncodedClip,
    Masks,
    PerceptionBackends,
    Segmenter,
    SegmentPrompt,
    Setting,
)
from physagent_jax.perception.schema import Box, MotionReport, Quality
from physagent_jax.perception.uncertainty import Difficulty, estimate_uncertainty
from physagent_jax.perception.unobservable import (
    explain_depth,
    explain_outline,
    find_leaving_frame,
    report_nothing,
)
from physagent_jax.perception.windows import Frames, measure_window
from physagent_jax.perception.words import ViewerWords, describe_motion
from physagent_jax.render.camera import Camera

VISIBLE = 0.01
"""Least motion that counts as seen [body lengths]; one pixel, if that is more."""
LEAST_TEXTURE = 0.5
"""Share of points on texture below which the report warns."""

LARGEST_UNCERTAINTY = 0.05
"""Depth that is less certain is not used [share of itself]."""
_MADE_PROMPT = (
    "Nobody marked the object: the segmenter was shown a box and a point, by what stands out in frame 0."
)
_NO_SCALE = "The depth has no known scale: sizes and places in metres are arbitrary, body lengths are not."


@dataclasses.dataclass(frozen=True)
class Perception:
    """The report, and the intermediate results that can be drawn over the pictures.

    Attributes:
        report: What the agents read.
        masks: The object, bool, shape (T, H, W).
        tracks: Followed points, pixel centres at +0.5 [px], shape (T, N, 2); points that were seeded later
            are added behind the earlier ones.
        visible: Where a point was followed and used, bool, shape (T, N).
        depth: The estimate of depth, as the backend gave it.
    """

    report: MotionReport
    masks: np.ndarray
    tracks: np.ndarray
    visible: np.ndarray
    depth: Depth


def perceive(
    rgb: np.ndarray,
    depth: np.ndarray | None,
    camera: Camera,
    *,
    frame_dt: float,
    up: Sequence[float] = (0.0, 0.0, 1.0),
    windows: Sequence[tuple[int, int]] = (),
    backends: PerceptionBackends | None = None,
    prompt: SegmentPrompt | None = None,
    parts: Sequence[PartPrompt] = (),
    ground: float | None = None,
    length: float | None = None,
) -> Perception:
    """Measures how the object in the pictures moves.

    Args:
        rgb: Pictures, uint8, shape (T, H, W, 3).
        depth: z-depth [m] as from an RGB-D camera, nan or 0 where there is no surface, shape (T, H, W); None
            if there is no such camera. It reaches no backend unless ``backends.depth`` is a sensor.
        camera: The fixed camera.
        frame_dt: Seconds per frame [s].
        up: World up, for the words.
        windows: Further windows of interest as (first, last) frames, inclusive.
        backends: What finds the object, its depth and its points; those that need no weights by default.
        prompt: Which object is meant; None = the only one, for which a prompt is made if the segmenter needs one.
        parts: Parts of it that are followed by themselves, by their place in frame 0.
        ground: Height along ``up`` of the ground that the object touches in frame 0 [m]; None = it touches none.
        length: Nominal length of the object's longest side [m]; None = unknown.

    Returns:
        The report with masks and tracks.

    Raises:
        UserError: Shapes do not fit, or a window lies outside of the clip.
    """
    rgb = _check_input(rgb, depth, camera, windows)
    if prompt is not None:
        prompt.check_fit(rgb.shape[:3])
    backends = backends or make_backends()
    words = ViewerWords(camera, up)
    estimate, masks, clip, notes = _look(
        rgb, depth, camera, backends, prompt, Setting(words.up, ground, length)
    )
    z = lift.keep_comparable_depth(lift.keep_possible_depth(estimate.z), masks[0])
    z = lift.fill_dropped(z, masks)
    spans = _find_spans(len(rgb), windows)
    trusted, noise = zip(*(lift.keep_trusted_depth(d, m) for d, m in zip(z, masks)))
    trusted = np.stack(trusted)
    if estimate.uncertainty is not None and estimate.relief_known:
        trusted = np.where(estimate.uncertainty <= LARGEST_UNCERTAINTY * z, trusted, np.float32(np.nan))
    if why := explain_outline(masks[0]) or explain_depth(trusted[0], camera):
        report = report_nothing(masks, why, frame_dt, spans, notes)
        none = np.zeros((len(rgb), 0, 2))
        return Perception(report, masks, none, np.zeros(none.shape[:2], bool), estimate)
    path = follow(rgb, trusted, camera, clip, tuple(parts))
    if path.texture < LEAST_TEXTURE:
        notes.append(
            "The surface has little texture: rotation and shape are guessed from its outline and shading."
        )
    axes = choose_directions(np.stack([axis for _, axis in words.axes()]), camera.forward)
    frames = assemble(path, masks, z, trusted, camera, axes, estimate)
    size = frames.size
    quality = Quality(
        tracks_kept=float(path.kept[in_view(masks)].min()),
        fit_residual=max((p.residual for p in path.poses if p is not None), default=0.0) / size,
        depth_noise=noise[0] / size,
        mask_fraction=float(masks[0].mean()),
        leaves_frame=find_leaving_frame(masks),
        notes=(*notes, *frames.weaknesses(in_view(masks))),
    )
    pixel = float(np.nanmedian(trusted[0]) / np.asarray(camera.K)[0, 0]) / size
    report = _make_report(
        frames,
        lift.unproject_surface(trusted[0], camera)[::17],
        frame_dt,
        spans,
        quality,
        threshold=max(VISIBLE, pixel),
        blind=None if estimate.relief_known else camera.forward.astype(float),
    )
    turns = frames.rotation_from(0, len(rgb) - 1)
    assert frames.lengths is not None and frames.breadths is not None
    blur = pixel + quality.depth_noise
    extents = describe_extents(frames.lengths, axes, turns, blur, camera.forward)
    breadths = [
        describe_extents(each, axes, turns, blur, camera.forward)
        for each in np.moveaxis(frames.breadths, 1, 0)
    ]
    stretches = [frames.stretch_from(0, t) for t in range(len(rgb))]
    hard = Difficulty(
        pixel=pixel,
        noise=quality.depth_noise,
        residual=quality.fit_residual,
        turn=frames.tilt,
        links=path.links - 1,
        travel=float(np.nanmax(np.linalg.norm(frames.centroid, axis=1))),
        disagreement=find_disagreement(extents, stretches),
        drift=None if frames.drift is None else frames.find_drift(0, len(rgb) - 1),
        assumed=not frames.relief_known,
        bridged=0.0 if frames.turned is None else float(np.degrees(frames.turned.guessed)),
    )
    report = report.model_copy(
        update={
            "extents": extents,
            "parts": () if path.ends is None else path.ends.describe(size, breadths),
            "pieces": tuple(count_pieces(masks)),
            "uncertainty": estimate_uncertainty(hard, turns, report.oscillation, frame_dt),
            "unmeasured_direction": None if estimate.relief_known else tuple(camera.forward.tolist()),
        }
    )
    return Perception(
        report.model_copy(update={"text": describe_motion(report, words)}),
        masks,
        path.tracks,
        path.visible,
        estimate,
    )


def _look(
    rgb: np.ndarray,
    depth: np.ndarray | None,
    camera: Camera,
    backends: PerceptionBackends,
    prompt: SegmentPrompt | None,
    setting: Setting,
) -> tuple[Depth, np.ndarray, EncodedClip, list[str]]:
    """The depth, the masks, the clip ready to be tracked, and what weakened them."""
    estimator = backends.depth
    if estimator.takes_cues:
        found = _segment(rgb, None, backends.segmenter, prompt)
        masks = _check_shape("segmenter", np.asarray(found.masks, bool), rgb)
        clip = backends.tracker.encode(rgb, masks)
        estimate = estimator.estimate(rgb, camera, None, Cues(masks, clip, setting))
        _check_shape("depth estimator", estimate.z, rgb)
    else:
        estimate = estimator.estimate(rgb, camera, depth if estimator.takes_measured else None)
        z = _check_shape("depth estimator", lift.keep_possible_depth(estimate.z), rgb)
        found = _segment(rgb, z, backends.segmenter, prompt)
        masks = _check_shape("segmenter", np.asarray(found.masks, bool), rgb)
        clip = backends.tracker.encode(rgb, masks)
    notes = [*estimate.notes, *([] if estimate.scale_known else [_NO_SCALE]), *found.notes]
    return estimate, masks, clip, notes


def _check_shape(what: str, seen: np.ndarray, rgb: np.ndarray) -> np.ndarray:
    if seen.shape != rgb.shape[:3]:
        raise UserError(f"the {what} must give one value per pixel, {rgb.shape[:3]}", got=seen.shape)
    return seen


def _check_input(rgb, depth, camera: Camera, windows) -> np.ndarray:
    rgb = np.asarray(rgb)
    if rgb.ndim != 4 or rgb.shape[-1] != 3 or rgb.dtype != np.uint8 or len(rgb) == 0:
        raise UserError(
            "`rgb` must be uint8 of shape (T, H, W, 3) with T >= 1", got=f"{rgb.dtype} {rgb.shape}"
        )
    if rgb.shape[1:3] != (camera.height, camera.width):
        raise UserError(
            "`rgb` and `camera` differ in size",
            got=f"{rgb.shape[1:3]}, {(camera.height, camera.width)}",
            do="pass the camera that the pictures were taken with",
        )
    if depth is not None and np.shape(depth) != rgb.shape[:3]:
        raise UserError("`depth` must have the shape (T, H, W) of `rgb`", got=np.shape(depth))
    for first, last in windows:
        if not 0 <= first <= last < len(rgb):
            raise UserError(
                f"window ({first}, {last}) is outside of the clip", do=f"stay within 0..{len(rgb) - 1}"
            )
    return rgb


def _find_spans(count: int, windows) -> list[tuple[int, int]]:
    """Whole clip, its quarters (neighbours share a frame, so that displacements add up), windows asked for."""
    marks = [round(k * (count - 1) / 4) for k in range(5)]
    spans = [(0, count - 1), *zip(marks, marks[1:])]
    return spans + [w for w in dict.fromkeys((int(a), int(b)) for a, b in windows) if w not in spans]


def _segment(
    rgb: np.ndarray, z: np.ndarray | None, segmenter: Segmenter, prompt: SegmentPrompt | None
) -> Masks:
    notes: tuple[str, ...] = ()
    if prompt is None and segmenter.needs_prompt:
        prompt, notes = find_prompt(rgb, z), (_MADE_PROMPT,)
        if prompt is None:
            return Masks(np.zeros(rgb.shape[:3], bool))
    if segmenter.takes_depth:
        found = segmenter.segment(rgb, prompt, depth=z)
    else:
        found = segmenter.segment(rgb, prompt)
    return dataclasses.replace(found, notes=(*notes, *found.notes))


def _make_report(
    frames: Frames,
    rest: np.ndarray,
    frame_dt,
    spans,
    quality,
    *,
    threshold: float,
    blind: np.ndarray | None = None,
) -> MotionReport:
    """The report without its text.

    Args:
        frames: Measures per frame.
        rest: Surface points of frame 0 [m], shape (n, 3).
        frame_dt: Seconds per frame [s].
        spans: Windows.
        quality: Confidence figures.
        threshold: Least motion that is seen [body lengths].
        blind: Line of sight along which no swing is told from noise, shape (3,); None = depth is measured.
    """
    path = frames.centroid if blind is None else frames.centroid - np.outer(frames.centroid @ blind, blind)
    turn = frames.rotation_from(0, len(frames.centroid) - 1)
    stretches = [frames.stretch_from(0, t) for t in range(len(turn))]
    begun = timing.find_onset(_measure_distances(frames, rest, 0), threshold)
    volume = [frames.volume(t) for t in range(len(turn))]
    return MotionReport(
        frame_count=len(turn),
        frame_dt=frame_dt,
        object_size=frames.size,
        object_center=tuple(frames.center.tolist()),
        windows=tuple(measure_window(frames, *span) for span in spans),
        centroid=tuple(tuple(c.tolist()) if np.isfinite(c).all() else None for c in frames.centroid),
        rotation_degrees=tuple(None if v is None else float(np.degrees(np.linalg.norm(v))) for v in turn),
        volume_ratio=tuple(v if np.isfinite(v) else None for v in volume),
        rotation=tuple(None if v is None else tuple(np.degrees(v).tolist()) for v in turn),
        stretch=tuple(None if S is None else to_matrix(S) for S in stretches),
        box=_measure_boxes(frames),
        oscillation=timing.find_oscillation(path, frame_dt, threshold + quality.fit_residual),
        onset_frame=begun,
        settle_frame=timing.find_settling(_measure_distances(frames, rest, -1), threshold),
        quality=quality,
        text="",
    )


def _measure_boxes(frames: Frames) -> tuple[Box | None, ...]:
    if frames.corners is None:
        return ()
    return tuple(
        Box(low=tuple(low.tolist()), high=tuple(high.tolist())) if np.isfinite(low).all() else None
        for low, high in frames.corners
    )


def _measure_distances(frames: Frames, rest: np.ndarray, frame: int) -> np.ndarray:
    """The object's distance in each frame from its place in ``frame`` [body lengths], shape (T,).

    RMS distance of its points, which also sees it turn or stretch on the spot. Without a common pose: the
    centroid's distance or the change of the box's half edges, whichever is larger.
    """

    def distance(t):
        pose, other = frames.poses[t], frames.poses[frame]
        if pose is None or other is None or frames.chain[t] != frames.chain[frame]:
            box = np.nan_to_num(np.linalg.norm(frames.box[t] - frames.box[frame]) / 2)
            return np.maximum(np.linalg.norm(frames.centroid[t] - frames.centroid[frame]), box)
        return np.sqrt(np.mean(np.sum((pose(rest) - other(rest)) ** 2, axis=1))) / frames.size

    return np.array([distance(t) for t in range(len(frames.poses))])
