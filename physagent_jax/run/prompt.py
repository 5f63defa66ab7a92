"""A prompt for a segmenter: from shares of the picture to pixels."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from physagent_jax.agents.context import AgentContext
from physagent_jax.core.errors import UserError
from physagent_jax.core.npy import read_npy
from physagent_jax.perception.ends import PartPrompt
from physagent_jax.perception.protocols import SegmentPrompt
from physagent_jax.run.spec import PromptChoice
from physagent_jax.scene.body import Body

MASK_BYTES = 256 * 2**20  # one per pixel


def make_prompt(
    choice: PromptChoice, width: int, height: int, mask: np.ndarray | None = None
) -> SegmentPrompt:
    """The prompt for pictures of a size.

    Args:
        choice: Choice of the spec.
        width: Width of the pictures [px].
        height: Height of the pictures [px].
        mask: That of ``choice``, of any size; see `read_mask`.
    """
    size = np.array([width, height], float)
    if mask is not None:
        scaled = cv2.resize(mask.astype(np.uint8), (width, height), interpolation=cv2.INTER_NEAREST_EXACT)
        return SegmentPrompt(frame=choice.frame, mask=scaled.astype(bool))
    return SegmentPrompt(
        frame=choice.frame,
        points=None if choice.points is None else np.array(choice.points) * size,
        labels=None if choice.labels is None else np.array(choice.labels),
        box=None if choice.box is None else (np.array(choice.box).reshape(2, 2) * size).ravel(),
    )


def make_part_prompts(context: AgentContext, body: Body) -> tuple[PartPrompt, ...]:
    """The places of the parts that the sentence names, in frame 0, as somebody who points at them tells them."""
    rest = np.asarray(body.particles.x, float)
    low, size = rest.min(0), np.ptp(rest, axis=0)
    asked = {each.limb for each in context.expectations if each.limb is not None}
    parts = {limb: context.brief.parts[limb].moved for limb in sorted(asked)}
    return tuple(
        PartPrompt(limb, low + np.array(region.inside) * size, low + np.array(region.outside) * size)
        for limb, region in parts.items()
    )


def read_mask(
    choice: PromptChoice, width: int, height: int, frame_count: int, base_dir: str | Path
) -> np.ndarray | None:
    """The mask that ``choice`` names, bool, shape (height, width); None if it names none.

    Args:
        choice: Choice of the spec.
        width: Width of the pictures [px].
        height: Height of the pictures [px].
        frame_count: Frame count of the clip.
        base_dir: Folder that a relative path starts from.

    Raises:
        UserError: The mask is missing, not bool, of another size or empty; or the prompt's frame is not in the clip.
    """
    if choice.frame >= frame_count:
        raise UserError(
            "`perception.prompt.frame` is not in the clip",
            got=choice.frame,
            do=f"Stay within 0..{frame_count - 1}",
        )
    if choice.mask_path is None:
        return None
    path = Path(base_dir) / choice.mask_path
    mask = read_npy(path, most=MASK_BYTES, what="the prompt's mask")
    if mask.dtype != np.bool_ or mask.shape != (height, width):
        raise UserError(
            f"the prompt's mask {path} must hold one bool per pixel, shape ({height}, {width})",
            got=f"{mask.dtype}, shape {mask.shape}",
            do="Make it from a picture of the same run",
        )
    if not mask.any():
        raise UserError(f"the prompt's mask {path} shows no object", do="Set its pixels to True")
    return mask
