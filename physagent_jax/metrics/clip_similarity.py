"""CLIPsim: how alike the pictures of a clip and a sentence are to a CLIP model (PhysAgent's appendix).

The mean over the frames of the cosine between the embeddings of picture and sentence. It does not know the order of the
frames, and a clip in which nothing moves has most of it: that of the first frame alone stands beside it. Published
methods differ by 0.001 to 0.02, and models by more: it means nothing without the name of the model.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np

from physagent_jax.core.errors import MissingPackageError, UserError

if TYPE_CHECKING:
    from physagent_jax.metrics.clip_encoder import ClipEncoder


class PictureEncoder(Protocol):
    """Something that places pictures and sentences in one space."""

    name: str

    def compare(self, rgb: np.ndarray, sentence: str) -> np.ndarray:
        """Cosine of each picture with the sentence, shape (T,); ``rgb`` is uint8, shape (T, height, width, 3)."""
        ...


@dataclasses.dataclass(frozen=True)
class ClipSimilarity:
    """A model's score of a clip.

    Attributes:
        mean: CLIPsim, in [-1, 1].
        still: That of the first frame alone: what the sentence has in common with the object at rest.
        model: Name of the model.
    """

    mean: float
    still: float
    model: str


def measure_clip_similarity(rgb: np.ndarray, sentence: str, encoder: PictureEncoder) -> ClipSimilarity:
    """CLIPsim of a clip.

    Args:
        rgb: Pictures, uint8, shape (T, height, width, 3).
        sentence: What should be seen.
        encoder: The model.

    Raises:
        UserError: There are no pictures, or what there is are none.
    """
    if rgb.ndim != 4 or rgb.shape[-1] != 3 or len(rgb) == 0 or rgb.dtype != np.uint8:
        raise UserError(
            "a clip must be pictures of 8 bits, shape (T, height, width, 3)", got=f"{rgb.dtype} {rgb.shape}"
        )
    cosines = np.asarray(encoder.compare(rgb, sentence), np.float64)
    return ClipSimilarity(float(cosines.mean()), float(cosines[0]), encoder.name)


def load_clip(folder: str | Path) -> ClipEncoder:
    """The CLIP model of a folder; nothing is downloaded.

    Args:
        folder: As Hugging Face keeps them: config.json, model.safetensors, the tokenizer's files, and
            preprocessor_config.json where pictures are prepared otherwise than OpenAI's models do.

    Raises:
        UserError: The extra is not installed, or the folder does not hold a CLIP model.
    """
    try:
        from physagent_jax.metrics.clip_encoder import ClipEncoder
    except ImportError as error:
        raise MissingPackageError(
            f"CLIPsim needs a package that is not installed ({error})", "clip"
        ) from None
    return ClipEncoder.load(folder)
