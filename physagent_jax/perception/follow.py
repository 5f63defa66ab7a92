"""The object's pose from frame to frame: tracks lifted to 3D, in links of a chain that is re-seeded on the way.

Points of frame 0 are followed as long as they serve: comparison with one and the same frame does not
drift. When too many are lost, or the object has turned so far out of the picture plane that it shows
another side, new points are seeded and the motion since then is put after the motion until then.
"""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np

from physagent_jax.perception import lift
from physagent_jax.perception.ends import Ends, PartPrompt
from physagent_jax.perception.fit import Affine, fit_affine
from physagent_jax.perception.protocols import EncodedClip, Tracks
from physagent_jax.render.camera import Camera

SEEDS = 300
"""Points seeded per link, about."""
PART_SEEDS = 60
"""The same on each part that is followed by itself, more densely: a thin one has few pixels."""
FEWEST = 12
"""Pairs of points below which no motion is fitted."""
KEPT_LINK = 0.6
"""A new link starts when a smaller fraction of the seeds is left."""
KEPT_FIT = 0.35
"""No motion is fitted to a smaller fraction of the seeds."""
LARGEST_TILT = 20.0
"""A new link starts when the object has turned further out of the picture plane [deg]."""
AROUND, SAME_COLOUR, SAME_PICTURE = 2, 24, 0.02
"""Pixels around a part, their difference, of 255, and the share of them that may differ, where it looks as at first."""
AWAY = 1.5
"""A part that looks so is not farther off than this [px]; nearer by, its own tracks tell its place better."""
LEAST_CORNER = 1e-5
"""Smallest eigenvalue of the gradient's covariance that counts as texture (as `cv2.cornerMinEigenVal` scales it)."""


@dataclasses.dataclass
class Path:
    """The object's motion, frame by frame.

    Attributes:
        poses: Map from the chain's first frame to this one, None where unknown.
        chain: Which chain a frame belongs to: poses of different chains cannot be compared. Shape (T,).
        kept: Fraction of the link's seeds that the fit used, shape (T,).
        tracks: All links' points [px], shape (T, N, 2).
        visible: Which of them were followed, shape (T, N).
        texture: Share of the first seeds that lie on enough texture to be told from their neighbours.
        links: How many sets of points were seeded.
        ends: The object's ends; None if they were not followed.
    """

    poses: list[Affine | None]
    chain: np.ndarray
    kept: np.ndarray
    tracks: np.ndarray
    visible: np.ndarray
    texture: float = 0.0
    links: int = 0
    ends: Ends | None = None


def follow(
    frames: np.ndarray,
    depths: np.ndarray,
    camera: Camera,
    clip: EncodedClip,
    parts: tuple[PartPrompt, ...] = (),
) -> Path:
    """Follow the object through the clip.

    Args:
        frames: Pictures, uint8, shape (T, H, W, 3).
        depths: Trusted z-depth [m], nan elsewhere, shape (T, H, W).
        camera: The camera.
        clip: Follows points in them.
        parts: Parts of the object to follow as well.
    """
    count = len(frames)
    path = Path(
        [None] * count,
        np.full(count, -1),
        np.zeros(count),
        np.zeros((count, 0, 2)),
        np.zeros((count, 0), bool),
        ends=Ends.split(lift.unproject_surface(depths[0], camera), count, parts)
        if np.isfinite(depths[0]).any()
        else None,
    )
    start, base, chain, horizon = 0, Affine.identity(), 0, count
    while start < count and not (start == count - 1 and path.poses[start] is not None):
        seeds, corner = place_seeds(frames[start], depths[start])
        if start == 0 and len(seeds):
            path.texture = float(np.mean(corner > LEAST_CORNER))
        reached = start
        if len(seeds) >= FEWEST:
            path.poses[start], path.chain[start] = base, chain
            path.kept[start] = path.kept[start] or 1.0
            path.links += 1
            span = slice(start, min(start + horizon, count))
            more = _place_part_seeds(path.ends, start, frames[start], depths[start], camera)
            reached = link(path, span, base, chain, seeds, clip, depths, camera, more)
        if reached > start:
            horizon = max(
                4, 2 * (reached - start)
            )  # tracking further than the next link goes would be wasted
            start, base = reached, path.poses[reached]
        else:  # nothing could be followed from here: what comes later is another chain
            start, base, chain = start + 1, Affine.identity(), chain + 1
            if path.ends is not None:
                path.ends.lose()
    if path.ends is not None and path.ends.prompts:
        _bring_home(path.ends, frames, depths[0], camera)
    return path


def _bring_home(ends: Ends, frames: np.ndarray, depth: np.ndarray, camera: Camera) -> None:
    """Put parts back where the picture shows them as it did at first: tracks that were lost on the way out drift.

    Args:
        ends: The parts, as they were followed.
        frames: Pictures, uint8, shape (T, H, W, 3).
        depth: Trusted z-depth of the first one [m], nan elsewhere, shape (H, W).
        camera: The camera.
    """
    y, x = np.nonzero(np.isfinite(depth))
    surface = lift.unproject(np.stack([x + 0.5, y + 0.5], 1), depth[y, x], camera)
    pixel = float(np.median(depth[y, x]) / np.asarray(camera.K)[0, 0])
    for part, mine in enumerate(ends.find_parts(0, surface).T):
        own = np.zeros(depth.shape, np.uint8)
        own[y[mine], x[mine]] = 1
        around = cv2.dilate(own, np.ones((2 * AROUND + 1,) * 2, np.uint8)) > 0
        first = frames[0][around].astype(np.int16)
        for t, frame in enumerate(frames[1:], 1):
            changed = np.abs(frame[around] - first).max(-1) > SAME_COLOUR
            if around.any() and changed.mean() < SAME_PICTURE:
                ends.bring_home(t, part, AWAY * pixel)


def link(path, span, base, chain, own, clip: EncodedClip, depths, camera, more=()) -> int:
    """Follow one set of seeds, write what it finds into ``path``; return the last frame that it reached.

    The seeds ``more`` tell of one part each: the whole would else be taken for the part that has most of them.
    """
    start = reached = span.start
    seeds = np.concatenate([own, *more])
    whole = np.arange(len(seeds)) < len(own)
    followed = _track(own, more, clip, span)
    before = lift.unproject(seeds, lift.sample(depths[start], seeds), camera)
    known = np.isfinite(before[:, 0])  # seeds at the rim of what broke up may have no depth
    face = lift.measure_facing(depths[start], seeds, camera)
    if path.ends is not None:
        path.ends.start_link(start, before)
    forward = camera.forward
    for t in range(start + 1, span.stop):
        at, on, sure = followed.xy[t], followed.visible[t], followed.confidence[t]
        after = lift.unproject(at, lift.sample(depths[t], at), camera)
        pairs = on & (sure > 0) & known & np.isfinite(after[:, 0])
        kept = (pairs & whole).sum() / len(own)
        if (pairs & whole).sum() < FEWEST or kept < KEPT_FIT:
            break
        if reached > start and path.ends is not None and path.ends.drops_part(reached, pairs):
            break  # it is seeded anew where it is still seen
        # Where the surface is steep, a pixel off is far off in depth.
        trust = (np.minimum(face, lift.measure_facing(depths[t], at, camera))[pairs] + 0.05) * sure[pairs]
        mine = whole[pairs]
        step = fit_affine(before[pairs & whole], after[pairs & whole], trust[mine])
        path.poses[t], path.chain[t], path.kept[t] = step.after(base), chain, kept
        if path.ends is not None:
            path.ends.fit(t, before[pairs], after[pairs], trust, pairs)
        reached = t
        tilt = np.degrees(np.arccos(np.clip(forward @ step.rotation @ forward, -1, 1)))
        loses = path.ends is not None and path.ends.loses_part(pairs)
        if kept < KEPT_LINK or tilt > LARGEST_TILT or loses:
            break
    full = np.zeros_like(followed.xy[:, whole])
    shown = np.zeros_like(followed.visible[:, whole])
    full[span], shown[start : reached + 1] = (
        followed.xy[span, whole],
        followed.visible[start : reached + 1, whole],
    )
    path.tracks = np.concatenate([path.tracks, full], 1)
    path.visible = np.concatenate([path.visible, shown], 1)
    return reached


def _track(own, more, clip: EncodedClip, span: slice) -> Tracks:
    """Tracks of the seeds of the whole, then of each part's, from the span's start to its end.

    A tracker takes for one body what it follows together. So a part's seeds are followed by themselves as well, and
    with the whole where that loses them: there they are found again when they come back.
    """

    def track(seeds) -> Tracks:
        return _clean(clip.track(np.insert(seeds, 0, span.start, axis=1), until=span.stop))

    found, begin = track(np.concatenate([own, *more])), len(own)
    for seeds in filter(len, more):
        columns, apart = slice(begin, begin + len(seeds)), track(seeds)
        begin += len(seeds)
        for kept, better in (
            (found.xy, apart.xy),
            (found.confidence, apart.confidence),
            (found.visible, apart.visible),
        ):
            kept[:, columns][apart.visible] = better[apart.visible]
    return found


def _clean(tracks: Tracks) -> Tracks:
    """Tracks that are visible only where they are numbers, nan elsewhere, with a confidence of 0 to 1."""
    finite = np.asarray(np.isfinite(tracks.xy).all(-1))
    sure = np.clip(np.nan_to_num(np.asarray(tracks.confidence, float), nan=0.0, posinf=1.0), 0.0, 1.0)
    xy = np.where(finite[..., None], tracks.xy, np.nan)
    return Tracks(xy, np.asarray(tracks.visible, bool) & finite, sure)


def _place_part_seeds(
    ends: Ends | None, start: int, frame: np.ndarray, depth: np.ndarray, camera: Camera
) -> list[np.ndarray]:
    """More seeds on each part [px], shape (N, 2) each."""
    if ends is None or not ends.prompts:
        return []
    y, x = np.nonzero(np.isfinite(depth))
    belongs = ends.find_parts(start, lift.unproject(np.stack([x + 0.5, y + 0.5], 1), depth[y, x], camera))
    found = []
    for mine in belongs.T:
        within = np.full_like(depth, np.nan)
        within[y[mine], x[mine]] = depth[y[mine], x[mine]]
        found.append(place_seeds(frame, within, PART_SEEDS, least=2, rim=0)[0])
    return found


def place_seeds(
    frame: np.ndarray, depth: np.ndarray, count: int = SEEDS, *, least: int = 3, rim: int = 1
) -> tuple[np.ndarray, np.ndarray]:
    """The best-textured pixel of each cell of a grid over the trusted surface.

    Args:
        frame: Picture, uint8, shape (H, W, 3).
        depth: Trusted z-depth, nan elsewhere, shape (H, W).
        count: How many, about.
        least: Side of a cell, at least [px].
        rim: Width of the surface's rim that is left out [px].

    Returns:
        Points [px], shape (N, 2), and their corner strength, shape (N,).
    """
    known = cv2.erode(np.isfinite(depth).astype(np.uint8), np.ones((2 * rim + 1,) * 2, np.uint8)) > 0
    cell = max(least, round(float(np.sqrt(known.sum() / count))))
    corner = cv2.cornerMinEigenVal(cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY), 5)
    score = np.where(known, corner, -1.0)
    h, w = (n // cell * cell for n in score.shape)
    cells = (
        score[:h, :w].reshape(h // cell, cell, w // cell, cell).transpose(0, 2, 1, 3).reshape(-1, cell * cell)
    )
    best = cells.argmax(1)
    index = np.flatnonzero(cells[np.arange(len(cells)), best] >= 0)
    row, column = np.divmod(index, w // cell)
    y, x = row * cell + best[index] // cell, column * cell + best[index] % cell
    return np.stack([x + 0.5, y + 0.5], 1), corner[y, x]
