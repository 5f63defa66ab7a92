"""Segmentation by SAM 2 (Ravi et al. 2024), as the package `transformers` has it."""

from __future__ import annotations

from typing import Any

import numpy as np

from physagent_jax.core.errors import UserError
from physagent_jax.perception.backends.pretrained import load_pretrained
from physagent_jax.perception.protocols import Masks, Segmenter, SegmentPrompt

WEIGHTS = "facebook/sam2.1-hiera-small"
_KINDS = ("sam2_video", "sam2")
_PACKAGES = ("torchvision",)  # its processor needs it, and says so less plainly


class Sam2Segmenter(Segmenter):
    """The object that a prompt marks in one frame, followed through the clip by the model's memory.

    Args:
        weights: A folder as `save_pretrained` leaves it, or "owner/name" in the hub's cache.
        device: Device of torch; "auto" = a GPU if there is one.
        download: Whether files that are missing may be fetched.

    Raises:
        UserError: As `pretrained.load_pretrained`.
    """

    def __init__(self, weights: str = WEIGHTS, *, device: str = "auto", download: bool = False):
        classes = ("Sam2VideoModel", "Sam2VideoProcessor")
        self._sam = load_pretrained("sam2", weights, classes, _KINDS, device, download, _PACKAGES)

    @property
    def name(self) -> str:
        """The model and its weights."""
        return f"sam2:{self._sam.name}"

    @property
    def needs_prompt(self) -> bool:
        """It segments what it is told to."""
        return True

    def segment(self, frames: np.ndarray, prompt: SegmentPrompt | None) -> Masks:
        """Masks where the model's logits exceed 0; see `protocols.Segmenter`."""
        if prompt is None:
            raise UserError("SAM 2 must be told where the object is", do="Give a point, a box or a mask")
        model, processor = self._sam.model, self._sam.processor
        masks = np.zeros(frames.shape[:3], bool)
        with self._sam.torch.inference_mode():
            session = processor.init_video_session(
                video=list(frames),
                inference_device=self._sam.device,
                processing_device="cpu",
                video_storage_device="cpu",
            )
            processor.add_inputs_to_inference_session(
                session, frame_idx=prompt.frame, obj_ids=1, **convert_prompt(prompt)
            )
            for reverse in (False, True)[: 1 + (prompt.frame > 0)]:
                for seen in model.propagate_in_video_iterator(
                    session, start_frame_idx=prompt.frame, reverse=reverse
                ):
                    (found,) = processor.post_process_masks(
                        [seen.pred_masks], original_sizes=[frames.shape[1:3]], binarize=True
                    )
                    masks[seen.frame_idx] = found[0, 0].cpu().numpy()
        return Masks(masks)


def convert_prompt(prompt: SegmentPrompt) -> dict[str, Any]:
    """The inputs of `Sam2VideoProcessor.add_inputs_to_inference_session` for one object.

    The processor takes indices of pixels, whose centres are at integers: 0.5 is taken off.
    """
    if prompt.mask is not None:
        return {"input_masks": np.asarray(prompt.mask, bool)}
    inputs: dict[str, Any] = {}
    if prompt.points is not None:
        points = np.asarray(prompt.points, float) - 0.5
        labels = np.ones(len(points), int) if prompt.labels is None else np.asarray(prompt.labels, int)
        inputs |= {"input_points": [[points.tolist()]], "input_labels": [[labels.tolist()]]}
    if prompt.box is not None:
        inputs["input_boxes"] = [[(np.asarray(prompt.box, float) - 0.5).tolist()]]
    return inputs
