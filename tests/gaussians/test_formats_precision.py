"""Positions far from the origin: doubles keep their shape, what was rounded before is said."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from physagent_jax.gaussians import read_ply, read_splats, write_ply
from physagent_jax.gaussians.formats.lattice import describe_lattice, find_origin
from tests.gaussians.test_ply import columns, save

FAR = np.array([500_000.0, 5_400_000.0, 300.0])


def cloud_at(place, *, count=600, size=1.0, dtype=np.float64) -> tuple[dict, np.ndarray]:
    """Properties of Gaussians around ``place``, and their positions relative to it."""
    rng = np.random.default_rng(2)
    offsets = size * rng.uniform(-0.5, 0.5, (count, 3))
    properties = {name: values.astype(np.float64) for name, values in columns(count=count).items()}
    return properties | dict(zip("xyz", (place + offsets).astype(dtype).T)), offsets


@pytest.mark.parametrize("size", [1e-3, 1.0, 100.0])
@pytest.mark.parametrize("floaters", [0, 3])
def test_doubles_far_away_keep_their_shape(tmp_path, size, floaters):
    properties, offsets = cloud_at(FAR, size=size)
    properties["x"][:floaters] += 1e4 * size
    offsets[:floaters, 0] += 1e4 * size
    loaded = read_splats(save(tmp_path / "a.ply", properties))
    assert loaded.origin.dtype == np.float64 and loaded.cloud.means.dtype == np.float32
    found = np.asarray(loaded.cloud.means, np.float64) + loaded.origin - FAR
    assert np.abs(found - offsets)[floaters:].max() < 1e-6 * size + 4e-9  # 4e-9: doubles at 5.4e6, twice
    assert np.abs(loaded.origin - FAR).max() <= 2 * size
    assert loaded.notes == ()


def test_positions_that_single_precision_holds_are_kept_to_the_bit(tmp_path):
    for place, dtype in ((np.zeros(3), np.float64), (np.array([1.0, 0, 0]), np.float64), (FAR, np.float32)):
        properties, _ = cloud_at(place, dtype=dtype)
        loaded = read_splats(save(tmp_path / "a.ply", properties))
        assert not loaded.origin.any()
        for axis, name in enumerate("xyz"):
            np.testing.assert_array_equal(loaded.cloud.means[:, axis], properties[name].astype(np.float32))


def test_what_was_rounded_before_is_said_with_the_number_of_values(tmp_path):
    properties, _ = cloud_at(FAR, dtype=np.float32)
    counts = [len(np.unique(properties[name])) for name in "xyz"]  # steps of 1/32, 1/2 and 1/32768
    assert counts[0] in (33, 34) and counts[1] == 3 and counts[2] > 500
    notes = read_splats(save(tmp_path / "a.ply", properties)).notes
    assert len(notes) == 1
    assert f"{counts[0]} distinct values along x and 3 distinct values along y:" in notes[0]
    with pytest.warns(UserWarning, match="coarse lattice"):
        read_ply(tmp_path / "a.ply")


def test_an_axis_that_single_precision_has_flattened_is_said():
    means = np.random.default_rng(0).uniform(-0.2, 0.2, (500, 3)) + [0, 5_400_000, 0]
    assert "1 distinct value along y" in str(describe_lattice(means.astype(np.float32).astype(np.float64)))


@pytest.mark.parametrize(
    "means",
    [
        np.random.default_rng(0).normal(size=(5000, 3)),
        np.random.default_rng(0).normal(size=(5000, 3)) * [1, 1, 0],  # a sheet
        np.stack(np.meshgrid(*[0.1 * np.arange(12)] * 3), -1).reshape(-1, 3),  # a grid that somebody made
        np.zeros((5000, 3)),
    ],
)
def test_other_clouds_are_no_lattice(means):
    assert describe_lattice(means) is None


def test_the_origin_is_a_short_number():
    means = FAR + np.random.default_rng(0).normal(size=(100, 3))
    origin = find_origin(means)
    np.testing.assert_array_equal(origin, np.round(origin))
    assert not find_origin(np.zeros((3, 3))).any() and not find_origin(np.full((3, 3), 0.1)).any()


def test_a_cloud_with_an_origin_is_written_in_file_coordinates(tmp_path):
    properties, offsets = cloud_at(FAR)
    loaded = read_splats(save(tmp_path / "a.ply", properties))
    write_ply(tmp_path / "b.ply", loaded.cloud, origin=loaded.origin)
    again = read_splats(tmp_path / "b.ply")
    found = np.asarray(again.cloud.means, np.float64) + again.origin - FAR
    assert np.abs(found - offsets).max() < 1e-6
    with pytest.warns(UserWarning, match="relative to"):
        read_ply(tmp_path / "b.ply")
    write_ply(tmp_path / "c.ply", loaded.cloud, origin=np.zeros(3))
    assert b"double" not in (tmp_path / "c.ply").read_bytes()


def test_ordinary_reading_warns_of_nothing(robot_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_ply(robot_path)
