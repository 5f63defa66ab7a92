"""Depth from pictures alone by Depth Anything V2 (Yang et al. 2024), as the package `transformers` has it."""

from __future__ import annotations

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.perception.backends.pretrained import load_pretrained
from physagent_jax.perception.backends.still import anchor_depth, anchor_inverse, fit_ground
from physagent_jax.perception.lift import MOST_RATIO, keep_possible_depth
from physagent_jax.perception.protocols import Depth, DepthEstimator
from physagent_jax.render.camera import Camera

WEIGHTS = "depth-anything/Depth-Anything-V2-Metric-Indoor-Small-hf"
METRIC = "Depth was estimated from the pictures by {}; a focal length other than its training's stretches it."
GROUND = "Depth was estimated from the pictures by {}; its scale and shift are those of the ground at {:g} m."
NO_GROUND = "The ground at {:g} m was not found in the estimated depth, so that it gives no scale."
_RELATIVE = "Depth was estimated from the pictures by {}, without scale and shift: lengths along the view are guesses."


class DepthAnything(DepthEstimator):
    """Depth Anything V2. Metric checkpoints tell metres; relative ones an inverse depth of unknown scale and shift.

    Each frame is put on the scale of frame 0 by what stands still (`still`). The shift of a relative checkpoint stays
    unknown, and 0 is taken, unless a ground of known height is seen, which gives scale and shift.

    Args:
        weights: A folder as `save_pretrained` leaves it, or "owner/name" in the hub's cache.
        device: Device of torch; "auto" = a GPU if there is one.
        download: Whether files that are missing may be fetched.
        ground_height: Height of the ground that the pictures show, for relative checkpoints [m]; None = none is known.

    Raises:
        UserError: As `pretrained.load_pretrained`, or the height is no number.
    """

    def __init__(
        self,
        weights: str = WEIGHTS,
        *,
        device: str = "auto",
        download: bool = False,
        ground_height: float | None = None,
    ):
        self._ground_height = check_height(ground_height)
        classes = ("AutoModelForDepthEstimation", "AutoImageProcessor")
        self._net = load_pretrained("depth_anything", weights, classes, ("depth_anything",), device, download)

    @property
    def name(self) -> str:
        """The model and its weights."""
        return f"depth_anything:{self._net.name}"

    @property
    def metric(self) -> bool:
        """Return whether the checkpoint tells metres."""
        return self._net.model.config.depth_estimation_type == "metric"

    def estimate(self, frames: np.ndarray, camera: Camera, measured: np.ndarray | None) -> Depth:
        """Depth of every pixel; a measured channel is not looked at. See `protocols.DepthEstimator`."""
        del measured
        raw = np.stack([self._look(frame) for frame in frames])
        if self.metric:
            z, notes = anchor_depth(raw, frames)
            return Depth(keep_possible_depth(z), notes=(METRIC.format(self.name), *notes))
        inverse, notes = anchor_inverse(raw, frames)
        return scale_inverse(inverse, camera, self._ground_height, self.name, notes)

    def _look(self, frame: np.ndarray) -> np.ndarray:
        """The model's own answer for a picture, shape (H, W)."""
        torch, processor = self._net.torch, self._net.processor
        inputs = processor(images=frame, return_tensors="pt").to(self._net.device)
        with torch.inference_mode():
            seen = self._net.model(**inputs)
        (found,) = processor.post_process_depth_estimation(seen, target_sizes=[frame.shape[:2]])
        return found["predicted_depth"].cpu().numpy().astype(np.float32)


def scale_inverse(
    inverse: np.ndarray, camera: Camera, ground_height: float | None, name: str, notes: tuple[str, ...]
) -> Depth:
    """The depth of inverse depths that share an unknown scale and shift.

    Args:
        inverse: Inverse depth, larger = nearer, shape (T, H, W).
        camera: The camera.
        ground_height: As of `DepthAnything`.
        name: Name of the estimator.
        notes: What weakens it so far.
    """
    line = None if ground_height is None else fit_ground(inverse[0], camera, ground_height)
    if ground_height is not None and line is None:
        notes = (*notes, NO_GROUND.format(ground_height))
    if line is not None:
        inverse, told = line[0] * inverse + line[1], GROUND.format(name, ground_height)
    else:
        inverse, told = inverse / max(float(np.nanmax(inverse[0])), 1e-9), _RELATIVE.format(name)
    nearest = float(np.nanmax(inverse[0]))
    with np.errstate(divide="ignore"):
        z = np.where(inverse * MOST_RATIO > nearest, 1 / inverse, np.nan)
    return Depth(keep_possible_depth(z), scale_known=line is not None, notes=(told, *notes))


def check_height(height: object) -> float | None:
    """``height``, if it is a number or None.

    Raises:
        UserError: It is neither.
    """
    if height is None:
        return None
    if isinstance(height, bool) or not isinstance(height, int | float) or not np.isfinite(height):
        raise UserError("`ground_height` must be a number of metres", got=repr(height)[:80])
    return float(height)
