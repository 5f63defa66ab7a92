"""Stand-ins for SAM 2, CoTracker 3 and Depth Anything V2: their calls and conventions, with answers known beforehand.

The "networks" are told the scene's truth; the adapters around them are what adapters around the real ones would be.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import imageio.v3 as iio
import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.perception.lift import sample, unproject
from physagent_jax.perception.protocols import (
    Depth,
    DepthEstimator,
    EncodedClip,
    Masks,
    PerceptionBackends,
    Segmenter,
    Tracker,
    Tracks,
)
from tests.perception.scenes import Clip, Motion


class FakeSam2:
    """As `SAM2VideoPredictor`: a state, prompts added to a frame, masks as logits, propagated one way at a time."""

    def __init__(self, truth: np.ndarray):
        self.truth, self.directions = truth, []

    def init_state(self, video_path):
        assert len(list(Path(video_path).glob("*.jpg"))) == len(self.truth)
        return {"prompts": {}}

    def add_new_points_or_box(self, inference_state, frame_idx, obj_id, points=None, labels=None, box=None):
        assert (points is None) == (labels is None)
        there = self.truth[frame_idx]
        if points is not None:
            for (x, y), label in zip(np.asarray(points), labels):
                assert there[int(y), int(x)] == bool(label), "the prompt misses the object"
        if box is not None:
            x0, y0, x1, y1 = np.asarray(box).round().astype(int)
            assert there[y0:y1, x0:x1].sum() > 0.95 * there.sum()
        inference_state["prompts"][obj_id] = frame_idx

    def add_new_mask(self, inference_state, frame_idx, obj_id, mask):
        assert mask.ndim == 2 and (mask & self.truth[frame_idx]).sum() > 0.9 * mask.sum()
        inference_state["prompts"][obj_id] = frame_idx

    def propagate_in_video(self, inference_state, reverse=False):
        ((obj_id, start),) = inference_state["prompts"].items()
        self.directions.append(reverse)
        last = -1 if reverse else len(self.truth)
        for frame in range(start, last, -1 if reverse else 1):
            yield frame, [obj_id], np.where(self.truth[frame], 4.0, -4.0)[None, None]


class Sam2Segmenter(Segmenter):
    """A stand-in for a SAM 2 backend."""

    name = "sam2.1_hiera_fake"
    needs_prompt = True

    def __init__(self, predictor: FakeSam2):
        self.predictor, self.prompts = predictor, []

    def segment(self, frames, prompt):
        if prompt is None:
            raise UserError("SAM 2 must be told where the object is")
        self.prompts.append(prompt)
        masks = np.zeros(frames.shape[:3], bool)
        with tempfile.TemporaryDirectory() as folder:
            for index, frame in enumerate(frames):
                iio.imwrite(Path(folder, f"{index:05d}.jpg"), frame)
            state = self.predictor.init_state(folder)
        if prompt.mask is not None:
            self.predictor.add_new_mask(state, frame_idx=prompt.frame, obj_id=1, mask=prompt.mask)
        else:
            labels = prompt.labels
            if prompt.points is not None and labels is None:
                labels = np.ones(len(prompt.points), int)
            self.predictor.add_new_points_or_box(
                state, frame_idx=prompt.frame, obj_id=1, points=prompt.points, labels=labels, box=prompt.box
            )
        for reverse in (False, True)[: 1 + (prompt.frame > 0)]:
            for frame, _, logits in self.predictor.propagate_in_video(state, reverse=reverse):
                masks[frame] = logits[0, 0] > 0
        return Masks(masks)


class FakeCoTracker:
    """As CoTracker's model: a video and queries (t, x, y) in, pixel centres at integers; points of a known motion.

    Attributes:
        encodings: How often the video was encoded.
    """

    def __init__(self, clip: Clip, motion: Motion, inverse: Motion):
        self.clip, self.motion, self.inverse = clip, motion, inverse
        self.encodings = 0

    def features(self, video):
        self.encodings += 1
        return video

    def __call__(self, features, queries):
        count, camera = len(features), self.clip.camera
        phases = np.linspace(0, 1, count)
        tracks = np.zeros((count, len(queries), 2))
        for i, (t, x, y) in enumerate(queries):
            at = np.array([[x + 0.5, y + 0.5]])
            depth = sample(self.clip.depth[int(t)], at)
            rest = self.inverse(unproject(at, depth, camera), phases[int(t)])
            moved = np.concatenate([self.motion(rest, s) for s in phases])
            seen = moved @ camera.viewmat[:3, :3].T + camera.viewmat[:3, 3]
            tracks[:, i] = (seen @ camera.K.T)[:, :2] / seen[:, 2:] - 0.5
        known = np.isfinite(tracks[..., 0])
        rng = np.random.default_rng(0)
        sure = rng.uniform(size=tracks.shape[:2]) > 0.1
        # Where it is unsure it may be anywhere, and says so.
        tracks = np.where(sure[..., None], tracks, tracks + rng.normal(0, 20, tracks.shape))
        return tracks, np.where(known, 0.97, 0.1), np.where(sure, 0.95, 0.0)


class CoTrackerBackend(Tracker):
    """A stand-in for a CoTracker backend."""

    name = "cotracker3_fake"

    def __init__(self, model: FakeCoTracker):
        self.model = model

    def encode(self, frames, masks) -> EncodedClip:
        return _CoTrackerClip(self.model, self.model.features(frames))


class _CoTrackerClip:
    def __init__(self, model, features):
        self.model, self.features = model, features

    def track(self, queries, until=None) -> Tracks:
        assert queries.shape[1] == 3
        tracks, visibility, confidence = self.model(self.features, queries - (0, 0.5, 0.5))
        return Tracks(tracks + 0.5, visibility > 0.9, confidence)


class DepthAnything(DepthEstimator):
    """As Depth Anything V2: a depth for every pixel, the background's too; metric, or in a unit of its own."""

    name = "depth_anything_v2_fake"

    def __init__(self, clip: Clip, unit: float | None = None, blurred: int = 0):
        """``unit`` [m] of a relative model; ``blurred``: rows at the top of which it is unsure and wrong."""
        self.clip, self.unit, self.blurred = clip, unit, blurred

    def estimate(self, frames, camera, measured):
        assert measured is None and frames.shape == self.clip.rgb.shape
        z = np.where(np.isfinite(self.clip.depth), self.clip.depth, 6.0)
        spread = np.full(z.shape, 0.01)
        z[:, : self.blurred] += 1.5
        spread[:, : self.blurred] = 1.5
        unit = self.unit or 1.0
        return Depth((z / unit).astype(np.float32), scale_known=self.unit is None, uncertainty=spread / unit)


def model_backends(clip: Clip, motion: Motion, inverse: Motion, **depth) -> PerceptionBackends:
    """All three around one clip."""
    truth = np.isfinite(clip.depth)
    return PerceptionBackends(
        Sam2Segmenter(FakeSam2(truth)),
        DepthAnything(clip, **depth),
        CoTrackerBackend(FakeCoTracker(clip, motion, inverse)),
    )
