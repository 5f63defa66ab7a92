import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.scene.anchor import select_anchored
from physagent_jax.scene.config import Anchor

X = np.stack([np.zeros(11), np.zeros(11), np.linspace(1.0, 2.0, 11)], axis=1)  # a rod, 0.1 m apart
ON_SURFACE = np.arange(11)


def held(anchor, x=X, index=ON_SURFACE, base_dir=".", **options):
    return np.flatnonzero(select_anchored(anchor, x, index, base_dir, **options)).tolist()


def test_none_holds_nothing():
    assert held(Anchor()) == []


def test_slabs_are_fractions_of_the_height():
    assert held(Anchor(kind="base", fraction=0.25)) == [0, 1, 2]
    assert held(Anchor(kind="top", fraction=0.15)) == [9, 10]


def test_a_box_is_absolute():
    assert held(Anchor(kind="box", point=(0, 0, 1.5), half_size=(0.1, 0.1, 0.11))) == [4, 5, 6]
    with pytest.raises(UserError, match="holds no particles"):
        held(Anchor(kind="box", point=(3, 0, 1.5), half_size=(0.1, 0.1, 0.1)))


def test_a_mask_selects_gaussians_and_what_is_inside_next_to_them(tmp_path):
    mask = np.zeros(20, bool)
    mask[[3, 17]] = True
    np.save(tmp_path / "mask.npy", mask)
    index = np.full(11, -1)
    index[0], index[5], index[10] = 17, 3, 4  # the rest is filled
    anchor = Anchor(kind="mask", mask_path="mask.npy")
    assert held(anchor, index=index, base_dir=tmp_path, gaussian_count=20) == [0, 1, 2, 3, 4, 5, 6, 7]


@pytest.mark.parametrize(
    ("mask", "message"),
    [
        (np.ones(19, bool), r"shape \(20,\)"),
        (np.ones(20), "one bool"),
        (np.zeros(20, bool), "selects no particles"),
        (None, "cannot read"),
    ],
)
def test_a_bad_mask_is_refused(tmp_path, mask, message):
    if mask is not None:
        np.save(tmp_path / "mask.npy", mask)
    with pytest.raises(UserError, match=message):
        held(Anchor(kind="mask", mask_path="mask.npy"), base_dir=tmp_path, gaussian_count=20)
