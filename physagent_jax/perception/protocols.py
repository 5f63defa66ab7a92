"""Protocols of vision models for perception: pictures in, arrays out.

The defaults in `backends` need no weights; SAM 2, Depth Anything and CoTracker 3 stand behind the same protocols. Pixel
positions have pixel centres at +0.5, everywhere.
"""

from __future__ import annotations

import dataclasses
from typing import Protocol

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.render.camera import Camera


class Backend(Protocol):
    """The base of all backends; they derive from their protocol and so inherit the defaults."""

    @property
    def name(self) -> str:
        """The implementation's name, with its weights if it has any: another name is another run."""
        return type(self).__name__


@dataclasses.dataclass(frozen=True)
class SegmentPrompt:
    """The place of the object in one frame: by points, by a box, by both, or by a mask alone.

    Attributes:
        frame: The frame that the prompt speaks of.
        points: Positions (x, y) [px], shape (P, 2).
        labels: True where a point is on the object, False where it is on something else, shape (P,); None = all on it.
        box: Corners (x0, y0, x1, y1) [px], shape (4,).
        mask: The object in that frame, bool, shape (H, W).

    Raises:
        UserError: The prompt says nothing, or a mask beside points or a box.
    """

    frame: int = 0
    points: np.ndarray | None = None
    labels: np.ndarray | None = None
    box: np.ndarray | None = None
    mask: np.ndarray | None = None

    def __post_init__(self):
        outlined = self.points is not None or self.box is not None
        if outlined == (self.mask is not None):
            raise UserError("a prompt is points, a box, both, or a mask alone", do="Give one of these")
        if self.labels is not None and (self.points is None or len(self.labels) != len(self.points)):
            raise UserError("`labels` are one per point", do="Give as many labels as points, or none")

    def check_fit(self, shape: tuple[int, int, int]) -> None:
        """Refuse a prompt that shows no object in a clip.

        Args:
            shape: Frames, height and width of the clip.

        Raises:
            UserError: Its frame is not in the clip; no point is on the object, or one outside of the picture; its box
                is empty or outside of the picture; its mask is empty or of another size.
        """
        count, height, width = shape
        picture = f"the picture of {width} x {height} pixels"
        if not 0 <= self.frame < count:
            do = f"Stay within 0..{count - 1}"
            raise UserError("the prompt's frame is not in the clip", got=self.frame, do=do)
        if self.points is not None:
            _check_points(
                np.asarray(self.points), self.labels, (width, height), picture, self.box is not None
            )
        if self.box is not None:
            _check_box(np.asarray(self.box), (width, height), picture)
        if self.mask is not None and np.shape(self.mask) != (height, width):
            raise UserError(
                f"the prompt's mask must have the shape ({height}, {width})", got=np.shape(self.mask)
            )
        if self.mask is not None and not np.any(self.mask):
            raise UserError("the prompt's mask shows no object", do="Set its pixels to True")


def _check_points(points: np.ndarray, labels, size: tuple[int, int], picture: str, boxed: bool) -> None:
    """Refuse points that are none, or outside of the picture, or without a box all beside the object."""
    if points.ndim != 2 or points.shape[1] != 2 or not len(points):
        raise UserError("the prompt's points must have the shape (P, 2), P >= 1", got=points.shape)
    if not ((points >= 0) & (points <= size)).all():
        raise UserError(f"the prompt's points must lie in {picture}", got=points.tolist())
    if labels is not None and not np.any(labels) and not boxed:
        raise UserError("no point of the prompt is on the object", do="Add one that is, or a box")


def _check_box(box: np.ndarray, size: tuple[int, int], picture: str) -> None:
    """Refuse a box without area, or outside of the picture."""
    if box.shape != (4,) or not ((box[:2] < box[2:]) & (box[:2] < size) & (box[2:] > 0)).all():
        what = f"the prompt's box must be x0 y0 x1 y1 with x0 < x1 and y0 < y1, and reach into {picture}"
        raise UserError(what, got=box.tolist())


@dataclasses.dataclass(frozen=True)
class Masks:
    """The object's masks.

    Attributes:
        masks: True on the object, bool, shape (T, H, W).
        notes: What weakened them, a sentence each, for the report.
    """

    masks: np.ndarray
    notes: tuple[str, ...] = ()


class Segmenter(Backend, Protocol):
    """Finds the object in each frame."""

    @property
    def needs_prompt(self) -> bool:
        """Return whether it must be told where the object is; without a prompt, `perceive` then makes one."""
        return False

    @property
    def takes_prompt(self) -> bool:
        """Return whether it can be told; a run that has a prompt for one that cannot is refused before it begins."""
        return self.needs_prompt

    @property
    def takes_depth(self) -> bool:
        """Return whether it looks at depth too: `perceive` then passes it as ``depth``; others get pictures alone."""
        return False

    def segment(
        self, frames: np.ndarray, prompt: SegmentPrompt | None, depth: np.ndarray | None = None
    ) -> Masks:
        """Masks of the object. A segmenter that does not take depth may leave that argument out.

        Args:
            frames: Pictures, uint8, shape (T, H, W, 3).
            prompt: Which object is meant; None = it is the only one.
            depth: z-depth, nan where unknown, shape (T, H, W); of the background too, if it has a surface there.

        Raises:
            UserError: It needs a prompt, or cannot take one.
        """
        ...


@dataclasses.dataclass(frozen=True)
class Depth:
    """The distance of the surface behind each pixel.

    Attributes:
        z: z-depth, not ray length, nan where there is no surface, float32, shape (T, H, W): in metres if
            ``scale_known``, else in a unit that is the same in all frames.
        scale_known: Whether the unit is a metre. Lengths in body lengths do not depend on it.
        uncertainty: Standard deviation in the unit of ``z``, shape (T, H, W); None = not told.
        relief_known: Whether the form of the surface is seen. If not, ``z`` is a form that fits the outline, and turns
            out of the picture plane and stretch along the line of sight are not observable.
        drift: Standard deviation of the object's distance against that in frame 0, in the unit of ``z``, shape (T,);
            None = as small as that of ``z`` is.
        notes: What weakened it, a sentence each, for the report.
    """

    z: np.ndarray
    scale_known: bool = True
    uncertainty: np.ndarray | None = None
    relief_known: bool = True
    drift: np.ndarray | None = None
    notes: tuple[str, ...] = ()


@dataclasses.dataclass(frozen=True)
class Setting:
    """The facts of a scene that are known beside its camera.

    Attributes:
        up: World up, unit vector, shape (3,).
        ground: Height along ``up`` of the ground that the object touches in frame 0 [m]; None = it touches none.
        length: Nominal length of the object's longest side [m]; None = unknown.
    """

    up: np.ndarray
    ground: float | None = None
    length: float | None = None


@dataclasses.dataclass(frozen=True)
class Cues:
    """The cues to distance beside the pixels' colours.

    Attributes:
        masks: The object, bool, shape (T, H, W).
        clip: Follows points.
        setting: Facts of the scene.
    """

    masks: np.ndarray
    clip: EncodedClip
    setting: Setting


class DepthEstimator(Backend, Protocol):
    """Says how far away the surface behind each pixel is."""

    @property
    def takes_measured(self) -> bool:
        """Return whether it uses a measured channel: without, `perceive` passes none, to no other backend either."""
        return False

    @property
    def takes_cues(self) -> bool:
        """Return whether it needs the object's outline and tracks: `perceive` then segments first, without depth."""
        return False

    def estimate(
        self, frames: np.ndarray, camera: Camera, measured: np.ndarray | None, cues: Cues | None = None
    ) -> Depth:
        """Depth of every pixel. An estimator that does not take cues may leave that argument out.

        Args:
            frames: Pictures, uint8, shape (T, H, W, 3).
            camera: Where they were taken from.
            measured: z-depth that a camera measured [m], nan or 0 where there is no surface, shape (T, H, W); None =
                the camera has no such channel.
            cues: Outline, tracks and facts of the scene.

        Raises:
            UserError: It needs a measured channel and there is none.
        """
        ...


@dataclasses.dataclass(frozen=True)
class Tracks:
    """Points followed through a clip.

    Attributes:
        xy: Positions [px], shape (T, N, 2); meaningless where not visible, nan allowed.
        visible: Whether the point was found in the frame, bool, shape (T, N).
        confidence: How far its position can be trusted, 0..1, shape (T, N).
    """

    xy: np.ndarray
    visible: np.ndarray
    confidence: np.ndarray


class EncodedClip(Protocol):
    """A clip made ready for any number of queries."""

    def track(self, queries: np.ndarray, until: int | None = None) -> Tracks:
        """Follow points.

        Args:
            queries: Points (t, x, y): a frame and a position in it [px], shape (N, 3). They need not be followed back
                to frames before ``t``.
            until: Frame (exclusive) from which on the tracks are of no use; they may be left invisible there.
        """
        ...


class Tracker(Backend, Protocol):
    """Follows points through the frames."""

    def encode(self, frames: np.ndarray, masks: np.ndarray) -> EncodedClip:
        """Do what does not depend on the queries, once per clip.

        Args:
            frames: Pictures, uint8, shape (T, H, W, 3).
            masks: The object, bool, shape (T, H, W): a hint where to look.
        """
        ...


@dataclasses.dataclass(frozen=True)
class PerceptionBackends:
    """The models that perception sees with; `backends.make_backends` makes them by name."""

    segmenter: Segmenter
    depth: DepthEstimator
    tracker: Tracker

    @property
    def names(self) -> dict[str, str]:
        """The implementation in each role: part of what a run is."""
        return {role.name: getattr(self, role.name).name for role in dataclasses.fields(self)}
