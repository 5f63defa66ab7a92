"""The .splat format, which has no magic number: values by hand, and what is not taken for it."""

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.gaussians.formats import find_format, read_splats
from physagent_jax.gaussians.formats.antimatter15 import ANTIMATTER15
from tests.gaussians.format_bytes import splat

ROW = ((1.5, -2.0, 0.25), (0.5, 0.125, 2.0), (255, 0, 51, 204), (255, 128, 128, 128))


def read(tmp_path, content):
    path = tmp_path / "a.splat"
    path.write_bytes(content)
    return read_splats(path)


def test_values_stand_for_what_the_layout_says(tmp_path):
    half = round(128 + 128 * np.sqrt(0.5))
    loaded = read(tmp_path, splat([ROW, (*ROW[:3], (half, 128, half, 128))]))
    cloud = loaded.cloud
    np.testing.assert_array_equal(cloud.means[0], ROW[0])
    np.testing.assert_array_equal(cloud.scales[0], ROW[1])
    np.testing.assert_allclose(np.asarray(cloud.sh[0, 0]) * 0.28209479177387814 + 0.5, [1, 0, 0.2], atol=1e-6)
    assert cloud.opacities[0] == pytest.approx(0.8)
    np.testing.assert_allclose(cloud.quats[0], [1, 0, 0, 0], atol=1e-6)
    np.testing.assert_allclose(cloud.quats[1], np.array([1, 0, 1, 0]) / np.sqrt(2), atol=1e-6)
    assert loaded.up is None and loaded.format_name == ANTIMATTER15.name


def test_a_few_rows_without_sense_do_not_make_it_another_format(tmp_path):
    bad = ((np.nan, 0, 0), *ROW[1:])
    loaded = read(tmp_path, splat([ROW] * 99 + [bad]))
    assert loaded.cloud.count == 99 and any("dropped 1 Gaussians" in note for note in loaded.notes)
    with pytest.raises(UserError, match="unknown kind|no readable file"):
        read(tmp_path, splat([ROW] * 9 + [bad]))


@pytest.mark.parametrize(
    "content",
    [
        b"# a mesh\n" + b"v 0.5 0.25 0.125\n" * 500,
        b"solid cube\n" + b"facet normal 0 0 1\n" * 500,
        bytes(3200),
        np.random.default_rng(0).bytes(6400),
        b"",
    ],
)
def test_other_files_are_not_taken_for_it(content, tmp_path):
    assert find_format(content, tmp_path / "a.splat") is None


def test_a_part_of_a_row_is_refused(tmp_path):
    with pytest.raises(UserError, match="not a multiple of 32"):
        read(tmp_path, splat([ROW] * 3)[:-7])


def test_a_file_that_makes_no_sense_after_its_beginning_is_refused(tmp_path):
    rows = splat([ROW]) * (2**20 // 32)
    with pytest.raises(UserError, match="50% of the rows"):
        read(tmp_path, rows + bytes(len(rows)))
