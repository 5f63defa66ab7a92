"""Clouds that are not what their user means are told of, and real captures are not."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians import GaussianCloud, read_splats
from physagent_jax.gaussians.diagnosis import check_cloud, diagnose_cloud
from tests.gaussians.test_ply import STANDARD


def sound(count: int = 2000) -> GaussianCloud:
    """Gaussians of one spacing in a ball of radius 3."""
    rng = np.random.default_rng(0)
    means = rng.normal(size=(count, 3))
    means *= 3 * rng.uniform(size=(count, 1)) ** (1 / 3) / np.linalg.norm(means, axis=1, keepdims=True)
    spacing = 3 * (4 * np.pi / 3 / count) ** (1 / 3)
    return GaussianCloud(
        means=np.float32(means),
        quats=np.tile(np.float32([1, 0, 0, 0]), (count, 1)),
        scales=np.float32(0.3 * spacing * np.exp(rng.uniform(-1, 1, (count, 3)))),
        opacities=np.float32(rng.uniform(0.05, 1, count)),
        sh=np.zeros((count, 1, 3), np.float32),
    )


def changed(**values) -> GaussianCloud:
    cloud = sound()
    return dataclasses.replace(
        cloud, **{name: change(getattr(cloud, name)) for name, change in values.items()}
    )


def first(count: int, value):
    """A change of the first ``count`` rows."""

    def change(values):
        values = np.array(values)
        values[:count] = value
        return values

    return change


SICK = {
    "as large as the object: the median size is 0.": dict(scales=lambda s: 0 * s + 4.0),
    "blur into one blob: the median size is 0.2": dict(scales=lambda s: 0 * s + 1.2),
    "100 of 2,000 Gaussians are larger than half of the object": dict(scales=first(100, 4.0)),
    "300 of 2,000 Gaussians are needles": dict(scales=first(300, [0.5, 1e-3, 1e-3])),
    "only 4 distinct positions": dict(means=lambda m: 9 * np.sign(np.array(m) * [1, 1, 0])),
    "only 20 of 2,000 Gaussians have an opacity of 0.1": dict(
        opacities=lambda o: np.where(np.arange(len(o)) < 20, 0.5, 0.03)
    ),
    "share one place": dict(means=lambda m: np.zeros_like(m)),
}


@pytest.mark.parametrize("words", SICK)
@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_each_sign_is_said_with_its_numbers_in_any_unit(words, unit):
    cloud = changed(**SICK[words])
    cloud = dataclasses.replace(
        cloud, means=unit * np.asarray(cloud.means), scales=unit * np.asarray(cloud.scales)
    )
    (found,) = diagnose_cloud(cloud)
    assert words in found


def test_what_can_be_another_encoding_names_the_option():
    assert "--splat-encoding" in diagnose_cloud(changed(scales=lambda s: 0 * s + 4.0))[0]


def test_a_cloud_without_a_shape_is_refused():
    check_cloud(sound())
    check_cloud(changed(scales=lambda s: 0 * s + 1.2))  # a blob is said alone
    with pytest.raises(UserError, match="as large as the object.*a median size of 0.7.*--splat-encoding"):
        check_cloud(changed(scales=lambda s: 0 * s + 4.0))


def test_too_few_gaussians_are_said():
    import jax

    cloud = jax.tree.map(lambda leaf: leaf[:3], sound())
    assert diagnose_cloud(cloud)[0].startswith("the object has only 3 Gaussians")


def test_flat_gaussians_are_no_needles():
    """Discs, as meshes are sampled with, and 2DGS with a scale of zero."""
    assert diagnose_cloud(changed(scales=lambda s: np.array(s) * 0 + [0.1, 0.1, 0.0])) == ()
    assert diagnose_cloud(sound()) == ()


def test_the_bundled_robot_is_sound(robot_path):
    assert diagnose_cloud(read_splats(robot_path, opacity_threshold=0.02).cloud) == ()


@pytest.mark.parametrize("name", STANDARD)
def test_real_captures_are_sound(shared_data, name):
    assert diagnose_cloud(read_splats(shared_data / name, opacity_threshold=0.02).cloud) == ()
