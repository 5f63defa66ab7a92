"""The motion report: what perception tells the agents. Pure data, no arrays.

Lengths are in units of the object's perceived longest extent in frame 0 ("body lengths"), directions in
world axes, so that the numbers mean the same to a person, a language model and a hard rule.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import BeforeValidator

from physagent_jax.core import strict
from physagent_jax.core.strict import Count, Numbers, Strict

Matrix = tuple[Numbers, Numbers, Numbers]


def _round(value):
    if isinstance(value, float):
        return round(value, 6)
    if isinstance(value, (list, tuple)):
        return tuple(_round(v) for v in value)
    return value


Number = Annotated[strict.Number, BeforeValidator(_round)]


class WindowMotion(Strict):
    """Motion over frames ``first``..``last`` relative to frame ``first`` (so a quarter's own motion).

    A value of None means "not observable in this window" and ``unobservable`` says why.

    Attributes:
        first, last: Frame indices, inclusive.
        displacement: Net centroid displacement [body lengths].
        displacement_view_axis_observable: False if the displacement along the viewing direction is a guess.
        path_length: Length of the centroid's path [body lengths].
        peak_displacement: The centroid's displacement at its largest distance from frame ``first``
            within the window [body lengths].
        peak_frame: The frame of that largest distance.
        rotation_axis: Unit world axis of the net rotation (right-hand rule).
        rotation_degrees: Net rotation angle about it, >= 0 (unwrapped over the window, may exceed 180).
        stretch: Symmetric stretch tensor S of the best affine fit x -> R S x + t, in world axes at frame
            ``first`` (1 = unchanged along that direction: use n.S.n for direction n).
        stretch_view_axis_observable: False if the stretch along the viewing direction is a guess.
        volume_ratio: Bounding-box volume of the visible surface over its value at frame ``first``.
        unobservable: Reasons, keyed by field name.
    """

    first: Count
    last: Count
    displacement: tuple[Number, Number, Number] | None
    displacement_view_axis_observable: bool = True
    path_length: Number | None
    peak_displacement: tuple[Number, Number, Number] | None
    peak_frame: Count | None
    rotation_axis: tuple[Number, Number, Number] | None
    rotation_degrees: Number | None
    stretch: Matrix | None
    stretch_view_axis_observable: bool = False
    volume_ratio: Number | None
    unobservable: dict[str, str] = {}


class Oscillation(Strict):
    """Periodic motion of the centroid along its principal direction, over the whole clip.

    Attributes:
        direction: Unit world direction.
        frequency_hz: Dominant frequency [Hz].
        amplitude: Half of peak-to-peak [body lengths].
        reversals: Number of direction reversals larger than the noise.
    """

    direction: tuple[Number, Number, Number]
    frequency_hz: Number
    amplitude: Number
    reversals: Count


class Extent(Strict):
    """Length of the object's outline along one direction, over its length in frame 0.

    A second estimate of stretch. The affine fit goes by points on the surface: where the ends are pressed together or
    drawn out and the middle stays, most points tell nothing of it. The outline does, but it is not fixed to the
    body: a turn alters it too, and the half width says by how much.

    Attributes:
        direction: Unit world direction: the viewer's right, up or away, whichever lie across the line of sight.
        ratio: Per frame; None where not all of the object is in the picture.
        half_width: Per frame, of an interval that should hold the body's own ratio in nine of ten clips; None where
            ``ratio`` is, or how far the object has turned is not known.
    """

    direction: tuple[Number, Number, Number]
    ratio: tuple[Number | None, ...]
    half_width: tuple[Number | None, ...]


class PartMotion(Strict):
    """Motion of one end of the object: the third of its surface that lies farthest along ``direction`` in frame 0.

    Or of a part that was asked for by its place in frame 0.

    Attributes:
        direction: Unit world axis: one of +-x, +-y, +-z; of a part, where it is.
        limb: Number of the part that was asked for; None = an end.
        place: Its middle in frame 0, seen from the object's [body lengths]; None = not told.
        centroid: Per frame, displacement from frame 0 [body lengths]; None where not observable.
        rotation: Per frame, rotation vector from frame 0 (world axis times unwrapped angle) [deg]; None where not
            observable.
        stretch: Per frame, symmetric stretch tensor from frame 0, in world axes; None where not observable. Empty = not
            measured.
        extents: Mean breadths of an end's outline across it. Empty = not measured.
    """

    direction: tuple[Number, Number, Number]
    limb: Count | None = None
    place: tuple[Number, Number, Number] | None = None
    centroid: tuple[tuple[Number, Number, Number] | None, ...]
    rotation: tuple[tuple[Number, Number, Number] | None, ...]
    stretch: tuple[Matrix | None, ...] = ()
    extents: tuple[Extent, ...] = ()


class Box(Strict):
    """World-axis box of the visible surface, relative to the centroid in frame 0 [body lengths]."""

    low: tuple[Number, Number, Number]
    high: tuple[Number, Number, Number]


class Uncertainty(Strict):
    """Half widths of intervals that should hold the truth in nine of ten clips; None = not known.

    Attributes:
        displacement: Half width of the centroid's displacement, at its worst over the clip [body lengths].
        along: Half width of its part along the viewing direction, if that is less sure than the rest [body lengths].
        rotation: Half width of the rotation angle [deg].
        axis: Half width of the direction of the rotation axis [deg].
        stretch: Half width of the stretch along a direction across the line of sight [1].
        frequency: Half width of the frequency of oscillation [Hz].
    """

    displacement: Number | None = None
    along: Number | None = None
    rotation: Number | None = None
    axis: Number | None = None
    stretch: Number | None = None
    frequency: Number | None = None


class Quality(Strict):
    """The trustworthiness of the report.

    Attributes:
        tracks_kept: Smallest fraction of tracks still followed in any frame while the object is in view;
            after a re-seeding it counts the new tracks.
        fit_residual: Largest RMS residual of the per-frame affine fit [body lengths].
        depth_noise: Median absolute depth difference within 3x3 neighbourhoods on the mask [body lengths].
        mask_fraction: Object's share of frame 0's pixels.
        leaves_frame: First frame in which the mask touches the image border, None if never.
        notes: Plain sentences about anything that weakened a measurement.
    """

    tracks_kept: Number
    fit_residual: Number
    depth_noise: Number
    mask_fraction: Number
    leaves_frame: Count | None
    notes: tuple[str, ...] = ()


class MotionReport(Strict):
    """Everything that perception measured, and the sentence that says it.

    Attributes:
        frame_count: Number of frames.
        frame_dt: Seconds per frame [s].
        object_size: Perceived longest extent in frame 0 [m].
        object_center: Perceived centroid in frame 0 [m].
        windows: The whole clip first, then its quarters, then the windows asked for.
        centroid: Per frame, displacement from frame 0 [body lengths]; None where not observable.
        rotation_degrees: Per frame, unwrapped rotation angle from frame 0 [deg]; None where not observable.
        volume_ratio: Per frame, bounding-box volume over frame 0's; None where not observable.
        rotation: Per frame, rotation vector from frame 0 (world axis times unwrapped angle) [deg]; None where not
            observable. Empty = not measured, as for the fields down to ``pieces``.
        stretch: Per frame, symmetric stretch tensor S of the best affine fit x -> R S x + t from frame 0, in world
            axes; None where not observable.
        box: Per frame, the visible surface's box; None where not all of the object is in the picture.
        extents: Lengths of the outline along the viewer's directions.
        parts: The object's six ends.
        pieces: Per frame, pieces of the object with background between them; None where it is not seen.
        uncertainty: How far the figures may be off.
        unmeasured_direction: Unit world direction of the line of sight, where no depth is measured: turns out of the
            picture plane, stretch along it, and how ends and parts move along it, are not observable. None = depth is
            measured.
        oscillation: None if the motion is not periodic.
        onset_frame: First frame with visible motion, None if nothing moved.
        settle_frame: Frame after which nothing moves any more, None if it still moves at the end.
        quality: Confidence figures.
        text: One paragraph for a language model, in the paper's manner (appendix B.1).
    """

    frame_count: Count
    frame_dt: strict.Positive
    object_size: Number
    object_center: tuple[Number, Number, Number]
    windows: tuple[WindowMotion, ...]
    centroid: tuple[tuple[Number, Number, Number] | None, ...]
    rotation_degrees: tuple[Number | None, ...]
    volume_ratio: tuple[Number | None, ...]
    rotation: tuple[tuple[Number, Number, Number] | None, ...] = ()
    stretch: tuple[Matrix | None, ...] = ()
    box: tuple[Box | None, ...] = ()
    extents: tuple[Extent, ...] = ()
    parts: tuple[PartMotion, ...] = ()
    pieces: tuple[Count | None, ...] = ()
    uncertainty: Uncertainty = Uncertainty()
    unmeasured_direction: tuple[Number, Number, Number] | None = None
    oscillation: Oscillation | None
    onset_frame: Count | None
    settle_frame: Count | None
    quality: Quality
    text: str

    def window(self, first: int, last: int) -> WindowMotion:
        """The motion over frames first..last; the window must have been asked for.

        Raises:
            KeyError: No such window in the report.
        """
        for window in self.windows:
            if (window.first, window.last) == (first, last):
                return window
        have = [(w.first, w.last) for w in self.windows]
        raise KeyError(f"window ({first}, {last}) is not in the report; have {have}")
