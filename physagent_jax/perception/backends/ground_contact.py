"""Distance from pictures alone: where the object touches the ground, and how its apparent size changes."""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np

from physagent_jax.perception.follow import follow
from physagent_jax.perception.lift import cast_rays
from physagent_jax.perception.protocols import Cues, Depth, DepthEstimator, EncodedClip
from physagent_jax.render.camera import Camera

FRONT = 0.6
"""Mean height of the assumed front over its largest height."""
RELIEF_OFF = 0.5
"""Standard deviation of the assumed front, over its largest height."""
DISTANCE_OFF = 0.06
"""Standard deviation of the distance in frame 0, over itself: half the depth of what stands there is not seen."""
SIZE_OFF = 0.004
"""Standard deviation of the scale of the tracks [1]."""
CONTACT_OFF = 1.0
"""Standard deviation of the lowest point of the outline [px]."""
LOST_OFF = 0.15
"""Standard deviation of the distance over itself where no track tells of it."""
AGREE = 3.0
"""The two cues agree within so many standard deviations: the object then touches the ground."""
FOOT = 0.1
"""Share of the outline's height at its lower end whose width tells the depth of the foot."""
_NOTE = "No depth is measured: distance is told by {}apparent size, and the form is assumed from the outline."


@dataclasses.dataclass(frozen=True)
class GroundContact(DepthEstimator):
    """Depth without a depth channel and without weights: a rounded front in the outline, at one distance per frame.

    In frame 0 the distance follows from the lowest point of the outline, whose line of sight meets the ground; without
    a ground that the object touches, from its nominal length; else its unit is the body length.

    Later, tracks tell how the picture of the object is stretched. What comes nearer grows alike in all directions; what
    turns, bends or is deformed does not. So the distance may be what any scale between the two principal stretches
    means, and is taken as the one that has changed least. All of that range is in doubt, unless the contact with the
    ground confirms a distance in it.
    """

    @property
    def takes_cues(self) -> bool:
        """It needs the outline and the tracks."""
        return True

    def estimate(
        self, frames: np.ndarray, camera: Camera, measured: np.ndarray | None, cues: Cues | None = None
    ) -> Depth:
        """A depth that is known along the outline, and assumed inside of it; see `protocols.DepthEstimator`."""
        assert cues is not None and measured is None
        masks, setting = cues.masks, cues.setting
        nothing = np.full(masks.shape, np.nan, np.float32)
        if not masks[0].any():
            return Depth(nothing, relief_known=False, drift=np.full(len(masks), np.nan))
        focal = float(np.asarray(camera.K)[0, 0])
        rounded = np.stack([_round_front(mask) for mask in masks]) / focal  # [distances]
        contact = noise = np.full(len(masks), np.nan)
        if setting.ground is not None:
            contact, noise = _measure_contact(masks, camera, setting.up, setting.ground)
        longest = max(cv2.boundingRect(masks[0].astype(np.uint8))[2:]) / focal
        first, source = float(contact[0]), "the contact with the ground"
        if not np.isfinite(first):
            first, source = (setting.length or 1.0) / longest, "its nominal length" if setting.length else ""
        low, high = _measure_scales(frames, masks, camera, cues.clip)
        front = first * (1 - FRONT * float(rounded[0].max()))  # what is tracked lies in front of the outline
        near, far = first + front * (1 / high - 1), first + front * (1 / low - 1)
        distance, drift = _combine(first, near, far, contact, noise)
        known = masks & np.isfinite(distance)[:, None, None]
        z = np.where(known, distance[:, None, None] * (1 - rounded), nothing).astype(np.float32)
        spread = np.hypot(RELIEF_OFF * rounded.max((1, 2)), DISTANCE_OFF) * distance
        spread = np.hypot(spread, drift)[:, None, None]
        return Depth(
            z,
            scale_known=bool(source),
            uncertainty=np.where(known, spread, nothing).astype(np.float32),
            relief_known=False,
            drift=drift,
            notes=(_NOTE.format(f"{source} and " if source else ""),),
        )


def _round_front(mask: np.ndarray) -> np.ndarray:
    """Height of a rounded front over the plane of the outline [px], shape (H, W): exact for a ball, and a cylinder."""
    inside = np.pad(mask, 1).astype(np.uint8)
    reach = cv2.distanceTransform(inside, cv2.DIST_L2, 5)[1:-1, 1:-1]
    return np.sqrt(reach * (2 * reach.max() - reach))


def _measure_contact(
    masks: np.ndarray, camera: Camera, up: np.ndarray, height: float
) -> tuple[np.ndarray, np.ndarray]:
    """z-depth of the foot if it touches the ground, and its standard deviation [m], each (T,); nan if not to be seen.

    What floats shows it too far away: its lowest point hides ground that lies behind it.
    """
    falls, found = -(cast_rays(camera) @ up), np.full((2, len(masks)), np.nan)
    above, focal = camera.center @ up - height, float(np.asarray(camera.K)[0, 0])
    with np.errstate(divide="ignore"):
        ground = np.where(falls * above > 0, above / falls, np.nan)
    slope = np.abs(np.diff(ground, axis=0, append=ground[-1:]))
    for t, mask in enumerate(masks):
        y, x = np.nonzero(mask & np.isfinite(ground + slope))
        if not len(y) or mask[-1].any():  # its foot is below the picture
            continue
        lowest = np.argsort(ground[y, x], kind="stable")[len(y) // 2000]
        foot = y >= y.max() - FOOT * (np.ptp(y) + 1)
        behind = 1 + 0.5 * (np.ptp(x[foot]) + 1) / focal  # a foot is about as deep as it is broad
        found[:, t] = ground[y, x][lowest] * behind, CONTACT_OFF * slope[y, x][lowest]
    return found[0], found[1]


def _measure_scales(
    frames: np.ndarray, masks: np.ndarray, camera: Camera, clip: EncodedClip
) -> tuple[np.ndarray, np.ndarray]:
    """Principal stretches of the object's picture since frame 0, the smaller and the larger, each (T,); nan if lost."""
    flat = np.where(masks, np.float32(1), np.float32(np.nan))
    path, axes = follow(frames, flat, camera, clip), np.asarray(camera.viewmat, float)[:2, :3]
    scales = np.full((len(frames), 2), np.nan)
    for t, (pose, chain) in enumerate(zip(path.poses, path.chain)):
        if pose is not None and chain == path.chain[0]:
            scales[t] = np.linalg.svd(axes @ pose.matrix @ axes.T, compute_uv=False)[::-1]
    return scales[:, 0], scales[:, 1]


def _combine(
    first: float, near: np.ndarray, far: np.ndarray, contact: np.ndarray, noise: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The distance per frame, and its standard deviation against that in frame 0 [m], each (T,).

    Args:
        first: Distance in frame 0 [m].
        near: Smallest distance that the apparent size allows [m], nan if lost, shape (T,).
        far: Largest distance that it allows [m], shape (T,).
        contact: Distance by contact, if it touches the ground [m], shape (T,).
        noise: Its standard deviation [m], shape (T,).
    """
    least = SIZE_OFF * first
    lost = ~np.isfinite(near)
    near, far = np.where(lost, first, near), np.where(lost, first, far)
    by_size = np.clip(first, near, far)
    doubt = np.maximum(far, first) - np.minimum(near, first)
    with np.errstate(invalid="ignore"):
        tolerance = AGREE * np.hypot(least, noise)
        touches = (contact >= near - tolerance) & (contact <= far + tolerance) & ~lost
    distance = np.where(touches, 0.5 * (by_size + contact), by_size)
    doubt = np.where(touches, np.abs(by_size - contact), doubt)
    doubt[lost] = LOST_OFF * first
    distance[0], doubt[0] = first, 0.0
    return distance, np.hypot(doubt / 1.645, least)
