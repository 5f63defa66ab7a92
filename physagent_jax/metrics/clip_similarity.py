"""CLIPsim: how alike the pictures of a clip and a sentence are to a CLIP model (PhysAgent's appendix).

The mean over the frames of the cosine between the embeddings of picture and sentence. It does not know the order of the
frames, and a clip in which nothing moves has most of it: that of the first frame alone stands beside it. Published
methods differ by 0.001 to 0.02, and models by more: it means nothing without the name of the model.
"""

from __future__ import annotations

import dataclasses
import importlib
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from physagent_jax.core.errors import MissingPackageError, UserError

_BATCH = 16  # pictures at a time: a gigabyte with the largest of the published models


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


class TransformersClip:
    """A CLIP model of `transformers`.

    Args:
        model: `CLIPModel`.
        processor: `CLIPProcessor`: the model's own resizing, cropping, normalisation and tokens.
        name: Name of the weights.
    """

    def __init__(self, model: Any, processor: Any, name: str):
        if (kind := model.config.model_type) != "clip":
            raise UserError("CLIPsim is of a CLIP model", got=kind, do="Give the folder of a CLIPModel")
        self.name = name
        self._model, self._processor = model.eval(), processor

    @classmethod
    def load(cls, folder: str | Path) -> TransformersClip:
        """Read weights, tokens and picture sizes from a folder; nothing is downloaded.

        Raises:
            UserError: The extra is not installed, or the folder does not hold a CLIP model.
        """
        source = _import("transformers")
        _import("torch")
        try:
            processor = source.CLIPProcessor.from_pretrained(str(folder), local_files_only=True)
            model = source.AutoModel.from_pretrained(str(folder), local_files_only=True)
        except (OSError, ValueError, TypeError) as error:
            raise UserError(
                f"this folder holds no CLIP model that can be read ({str(error).splitlines()[0][:150]})",
                got=folder,
                do="Give a folder with config.json, weights, tokenizer and preprocessor_config.json, "
                "as of openai/clip-vit-base-patch32",
            ) from None
        return cls(model, processor, Path(folder).name)

    def compare(self, rgb: np.ndarray, sentence: str) -> np.ndarray:
        """As for `PictureEncoder`; sentences of more tokens than the model takes are cut."""
        torch = _import("torch")
        found = []
        for first in range(0, len(rgb), _BATCH):
            pictures = list(rgb[first : first + _BATCH])
            inputs = self._processor(
                text=[sentence], images=pictures, return_tensors="pt", padding=True, truncation=True
            )
            with torch.no_grad():
                answer = self._model(**inputs)
            pictures = torch.nn.functional.normalize(answer.image_embeds.double(), dim=-1)
            words = torch.nn.functional.normalize(answer.text_embeds.double(), dim=-1)
            found.append((pictures @ words[0]).cpu().numpy())
        return np.concatenate(found)


def _import(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise MissingPackageError(f"CLIPsim needs `{name}` ({error})", "clip") from None
