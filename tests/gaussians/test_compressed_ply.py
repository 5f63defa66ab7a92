"""SuperSplat's compressed PLY, against files packed bit by bit."""

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.formats import read_splats
from tests.gaussians.format_bytes import compressed_ply

BOUNDS = [-1, 0, 10, 3, 2, 20, -4, -5, -6, 0, -1, -2, 0.1, 0.2, 0.3, 0.6, 0.7, 0.9]


def pack(parts, shifts):
    return sum(part << shift for part, shift in zip(parts, shifts))


def row(position=(0, 0, 0), rotation=(0, 512, 512, 512), scale=(0, 0, 0), colour=(128, 128, 128, 255)):
    return (
        pack(position, (21, 11, 0)),
        pack(rotation, (30, 20, 10, 0)),
        pack(scale, (21, 11, 0)),
        pack(colour, (24, 16, 8, 0)),
    )


def read(tmp_path, content):
    path = tmp_path / "a.compressed.ply"
    path.write_bytes(content)
    return read_splats(path)


@pytest.mark.parametrize("format_name", ["binary_little_endian", "binary_big_endian"])
def test_every_part_of_a_word_lands_where_the_layout_says(tmp_path, format_name):
    rows = [row((2047, 0, 1024), scale=(0, 1023, 2047), colour=(255, 0, 51, 204))]
    loaded = read(tmp_path, compressed_ply(rows, [BOUNDS], format_name=format_name))
    cloud = loaded.cloud
    np.testing.assert_allclose(cloud.means[0], [3, 0, 10 + 10 * 1024 / 2047], rtol=1e-6)
    np.testing.assert_allclose(np.log(cloud.scales[0]), [-4, -1, -2], rtol=1e-6)
    colour = np.array([0.6, 0.2, 0.3 + 0.6 * 0.2])  # of the chunk's bounds
    np.testing.assert_allclose(np.asarray(cloud.sh[0, 0]) * 0.28209479177387814 + 0.5, colour, rtol=1e-6)
    assert cloud.opacities[0] == pytest.approx(0.8)
    assert loaded.up is None and loaded.count_in_file == 1


@pytest.mark.parametrize("place", range(4))
def test_the_component_left_out_is_the_one_that_is_named(tmp_path, place):
    """Levels of 0, 1023 and 512 stand for -1/sqrt(2), 1/sqrt(2) and almost zero; wxyz in this order."""
    rows = [row(rotation=(place, 767, 512, 256))]
    quat = read(tmp_path, compressed_ply(rows, [BOUNDS])).cloud.quats[0]
    three = (np.array([767, 512, 256]) / 1023 - 0.5) * np.sqrt(2)
    expected = np.insert(three, place, np.sqrt(1 - np.sum(three**2)))
    np.testing.assert_allclose(quat, expected, atol=1e-6)


def test_colours_without_bounds_and_higher_harmonics(tmp_path):
    """The ends of the range are exact, the rest are middles of bins: 8 ((b + 1/2) / 256 - 1/2)."""
    rest = [[0, 255, 128, 10, 20, 30, 40, 50, 60]]
    rows = [row(colour=(255, 0, 128, 255))]
    cloud = read(tmp_path, compressed_ply(rows, [BOUNDS], coloured=False, rest=rest)).cloud
    np.testing.assert_allclose(
        np.asarray(cloud.sh[0, 0]) * 0.28209479177387814 + 0.5, [1, 0, 128 / 255], atol=1e-6
    )
    value = lambda b: {0: -4.0, 255: 4.0}.get(b, 8 * ((b + 0.5) / 256 - 0.5))  # noqa: E731
    expected = np.array([value(b) for b in rest[0]]).reshape(3, 3).T  # red's coefficients first
    np.testing.assert_allclose(cloud.sh[0, 1:], expected, atol=1e-6)


def test_a_gaussian_takes_the_bounds_of_its_own_chunk(tmp_path):
    far = [100, 100, 100, 101, 101, 101, *BOUNDS[6:]]
    cloud = read(tmp_path, compressed_ply([row()] * 300, [BOUNDS, far])).cloud
    np.testing.assert_allclose(cloud.means[255], [-1, 0, 10])
    np.testing.assert_allclose(cloud.means[256], [100, 100, 100])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (compressed_ply([row()] * 300, [BOUNDS]), "1 chunks for 300 Gaussians"),
        (compressed_ply([row()], [BOUNDS])[:-5], "truncated or damaged"),
        (compressed_ply([row()], [BOUNDS]).replace(b"packed_scale", b"packed_skale"), "packed_scale"),
        (compressed_ply([row()], [BOUNDS]).replace(b"float min_y", b"float min_q"), "min_y"),
        (compressed_ply([row()], [BOUNDS], rest=[[0] * 8]), "8 properties"),
        (compressed_ply([row()], [BOUNDS], rest=[[0] * 9] * 2), "2 rows of `sh`"),
        (compressed_ply([], []), "holds no Gaussians"),
        (
            compressed_ply([row()], [BOUNDS]).replace(b"uint packed_color", b"float packed_color"),
            "no integers",
        ),
        (compressed_ply([row()], [BOUNDS]).replace(b"float max_z", b"float min_z"), "twice"),
    ],
)
def test_what_is_laid_out_otherwise_is_refused_in_one_line(tmp_path, content, message):
    with pytest.raises(UserError, match=message) as refused:
        read(tmp_path, content)
    assert "\n" not in str(refused.value)
