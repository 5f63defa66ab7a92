"""CLIPsim: the formula, with vectors that are known. The model itself: `test_clip_model.py`."""

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.metrics.clip_similarity import measure_clip_similarity


class Known:
    """An encoder whose pictures are unit vectors in the plane: red is the cosine with every sentence."""

    name = "known"

    def compare(self, rgb, sentence):
        """The mean of the red channel, from 0 to 1."""
        return rgb[..., 0].mean((1, 2)) / 255.0


def test_it_is_the_mean_over_the_frames_beside_that_of_the_first():
    rgb = np.zeros((4, 2, 2, 3), np.uint8)
    rgb[1:, ..., 0] = np.array([51, 102, 255])[:, None, None]
    said = measure_clip_similarity(rgb, "push it left", Known())
    assert said.mean == pytest.approx((0 + 0.2 + 0.4 + 1) / 4) and said.still == 0.0 and said.model == "known"


@pytest.mark.parametrize(
    "rgb", [np.zeros((0, 2, 2, 3), np.uint8), np.zeros((2, 2, 3), np.uint8), np.zeros((1, 2, 2, 3))]
)
def test_what_is_no_clip_is_refused(rgb):
    with pytest.raises(UserError, match="8 bits"):
        measure_clip_similarity(rgb, "push it left", Known())


def test_the_order_of_frames_does_not_matter():
    """So a clip whose frames are shuffled is no control: another sentence is."""
    rgb = np.random.default_rng(0).integers(0, 255, (7, 4, 4, 3), np.uint8)
    told, mixed = (measure_clip_similarity(each, "a", Known()) for each in (rgb, rgb[[3, 0, 6, 1, 5, 2, 4]]))
    assert told.mean == pytest.approx(mixed.mean) and told.still != mixed.still
