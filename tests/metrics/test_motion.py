"""True motion of particles, and a report's errors against it."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physagent_jax.metrics.motion import compare, measure_true_motion
from physagent_jax.perception.schema import MotionReport, Quality, WindowMotion


@pytest.fixture
def box():
    return np.random.default_rng(0).uniform(-1, 1, (4000, 3)) * (1.0, 0.5, 0.25)


def test_translation_in_body_lengths(box):
    moved = measure_true_motion(np.stack([box, box + (1.0, 0, -0.5)]))
    assert moved.object_size == pytest.approx(2, rel=0.01)
    assert moved.centroid[1] == pytest.approx((0.5, 0, -0.25), rel=0.01)
    assert moved.rotation_degrees[1] == pytest.approx(0, abs=1e-6)
    assert moved.volume_ratio[1] == pytest.approx(1) and moved.stretch[1] == pytest.approx((1, 1, 1))


def test_rotation_is_unwrapped(box):
    frames = [
        Rotation.from_rotvec(np.radians(a) * np.array((0, 0, 1.0))).apply(box) for a in range(0, 400, 40)
    ]
    assert measure_true_motion(np.stack(frames)).rotation_degrees == pytest.approx(
        list(range(0, 400, 40)), abs=1e-6
    )


def test_squash_is_no_rotation(box):
    squashed = measure_true_motion(np.stack([box, box * (1.2, 1.2, 0.4)]))
    assert squashed.rotation_degrees[1] == pytest.approx(0, abs=1e-6)
    assert squashed.stretch[1] == pytest.approx((1.2, 1.2, 0.4), rel=1e-4)
    assert squashed.volume_ratio[1] == pytest.approx(1.2 * 1.2 * 0.4, rel=1e-4)


def test_one_stray_particle_does_not_make_a_box(box):
    stray = box.copy()
    stray[0] = (50, 50, 50)
    assert measure_true_motion(np.stack([box, stray])).volume_ratio[1] == pytest.approx(1, rel=0.01)


def test_a_single_particle_is_no_error():
    assert measure_true_motion(np.zeros((2, 1, 3))).rotation_degrees == pytest.approx((0, 0))


def report(centroid, rotation, volume, size=1.0):
    window = WindowMotion(
        first=0,
        last=1,
        displacement=centroid[-1],
        path_length=None,
        peak_displacement=None,
        peak_frame=None,
        rotation_axis=None,
        rotation_degrees=rotation[-1],
        stretch=((1.1, 0, 0), (0, 1, 0), (0, 0, 1)),
        stretch_view_axis_observable=True,
        volume_ratio=volume[-1],
    )
    quality = Quality(tracks_kept=1, fit_residual=0, depth_noise=0, mask_fraction=0.1, leaves_frame=None)
    return MotionReport(
        frame_count=len(centroid),
        frame_dt=0.1,
        object_size=size,
        object_center=(0, 0, 0),
        windows=(window,),
        centroid=centroid,
        rotation_degrees=rotation,
        volume_ratio=volume,
        oscillation=None,
        onset_frame=None,
        settle_frame=None,
        quality=quality,
        text="",
    )


def test_errors(box):
    truth = measure_true_motion(np.stack([box, box + (1.0, 0, 0)]))
    errors = compare(report(((0, 0, 0), (0.6, 0, 0)), (0, 3), (1, 0.9), size=truth.object_size), truth)
    assert errors["centroid_error_last"] == pytest.approx(0.1, abs=0.002)
    assert errors["rotation_error_max"] == pytest.approx(3)
    assert errors["volume_ratio_error_last"] == pytest.approx(0.1)
    assert errors["stretch_error_last"] == pytest.approx(0.1)
    assert errors["frames_observed"] == 2 and errors["size_ratio"] == pytest.approx(1)


def test_unobserved_is_none_not_zero(box):
    truth = measure_true_motion(np.stack([box, box]))
    errors = compare(report(((0, 0, 0), None), (0, None), (1, None)), truth)
    assert errors["centroid_error_last"] is None and errors["rotation_error_last"] is None
    assert errors["centroid_error_max"] == 0 and errors["frames_observed"] == 1


def test_frames_must_agree(box):
    with pytest.raises(ValueError, match="same clip"):
        compare(report(((0, 0, 0),), (0,), (1,)), measure_true_motion(np.stack([box, box])))
