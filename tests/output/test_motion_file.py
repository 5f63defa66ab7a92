from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.output.motion_file import Motion, read_motion, write_motion


def motion(frames: int = 6, particles: int = 40, gaussians: int = 70) -> Motion:
    rng = np.random.default_rng(0)
    quats = rng.normal(size=(gaussians, 4))
    return Motion(
        times=np.arange(frames) * 0.04,
        x=rng.uniform([0.3, 0.5, 3.0], [3.7, 0.9, 3.1], (frames, particles, 3)),
        F=np.eye(3) + 0.3 * rng.normal(size=(frames, particles, 3, 3)),
        binding_indices=rng.integers(0, particles, (gaussians, 4)),
        binding_weights=rng.dirichlet(np.ones(4), gaussians),
        binding_offsets=0.05 * rng.normal(size=(gaussians, 4, 3)),
        cloud_means=rng.uniform(0, 4, (gaussians, 3)),
        cloud_quats=quats / np.linalg.norm(quats, axis=1, keepdims=True),
        cloud_scales=np.exp(rng.uniform(-12, -3, (gaussians, 3))),
        cloud_opacities=rng.uniform(0, 1, gaussians),
        cloud_sh=rng.normal(size=(gaussians, 9, 3)),
        cloud_rotation=np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]),
    )


def test_round_trip_within_the_documented_resolution(tmp_path):
    given = motion()
    back = read_motion(write_motion(tmp_path / "motion.npz", given))
    step = np.ptp(given.x, axis=(0, 1)) / 65535
    # float32 of the result adds 1e-7 of its size.
    assert (np.abs(back.x - given.x) <= 0.5 * step + 5e-7).all()
    np.testing.assert_allclose(back.F - np.eye(3), given.F - np.eye(3), rtol=2**-11, atol=2e-7)
    np.testing.assert_array_equal(back.times, given.times)
    np.testing.assert_array_equal(back.binding_indices, given.binding_indices)
    np.testing.assert_array_equal(back.cloud_rotation, given.cloud_rotation)
    for name in ("binding_weights", "binding_offsets", "cloud_means", "cloud_quats", "cloud_scales"):
        np.testing.assert_allclose(getattr(back, name), getattr(given, name), rtol=1e-6, err_msg=name)
    for name in ("cloud_opacities", "cloud_sh"):
        np.testing.assert_allclose(
            getattr(back, name), getattr(given, name), rtol=1e-3, atol=1e-4, err_msg=name
        )


def test_an_axis_without_motion_is_exact(tmp_path):
    given = motion()
    given.x[..., 2] = 1.25
    given.F[:] = np.eye(3)
    back = read_motion(write_motion(tmp_path / "motion.npz", given))
    assert (back.x[..., 2] == 1.25).all()
    assert (back.F == np.eye(3)).all()


def test_same_motion_same_bytes_and_numpy_reads_it(tmp_path):
    one, two = (write_motion(tmp_path / name, motion()).read_bytes() for name in ("a.npz", "b.npz"))
    assert one == two
    with np.load(tmp_path / "a.npz", allow_pickle=False) as archive:
        assert int(archive["format"]) == 1
        assert archive["x_quantised"].dtype == np.uint16
        assert archive["F_minus_identity"].dtype == np.float16


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("times", np.zeros(5)),
        ("F", np.zeros((6, 39, 3, 3))),
        ("binding_weights", np.zeros((70, 3))),
        ("cloud_sh", np.zeros((69, 9, 3))),
        ("x", np.full((6, 40, 3), np.nan)),
    ],
)
def test_refuses_arrays_that_disagree_or_are_not_finite(tmp_path, field, value):
    with pytest.raises(ValueError, match=f"`{field}`"):
        write_motion(tmp_path / "motion.npz", dataclasses.replace(motion(), **{field: value}))
    assert not list(tmp_path.iterdir())


def test_other_files_are_user_errors(tmp_path):
    (tmp_path / "text.npz").write_text("not an archive")
    np.savez(tmp_path / "newer.npz", format=np.int64(2))
    np.savez(tmp_path / "other.npz", weights=np.zeros(3))
    for name, message in (
        ("absent.npz", "cannot read"),
        ("text.npz", "cannot read"),
        ("newer.npz", "format 2"),
        ("other.npz", "format 0"),
    ):
        with pytest.raises(UserError, match=message):
            read_motion(tmp_path / name)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("x_quantised", None),
        ("x_quantised", np.zeros((6, 40, 3))),
        ("x_quantised", np.zeros((6, 40), np.uint16)),
        ("x_low", np.full(3, np.nan)),
        ("F_minus_identity", np.zeros((6, 40, 2, 2), np.float16)),
        ("times", np.zeros(5)),
        ("binding_indices", np.full((70, 4), 40, np.int32)),
        ("binding_indices", np.full((70, 4), -1, np.int32)),
        ("format", np.zeros((2, 2), np.int64)),
        ("format", np.array("one")),
    ],
)
def test_arrays_that_are_missing_or_do_not_fit_are_told(tmp_path, key, value):
    """Whatever one array of an otherwise good file is replaced by."""
    path = write_motion(tmp_path / "motion.npz", motion())
    with np.load(path) as archive:
        arrays = dict(archive)
    arrays.pop(key)
    np.savez(path, **(arrays if value is None else arrays | {key: value}))
    with pytest.raises(UserError, match="motion.npz (is damaged|has motion format)"):
        read_motion(path)
