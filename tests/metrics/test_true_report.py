"""A motion report filled from true trajectories: rigid and affine motions with known answers."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physagent_jax.core.errors import UserError
from physagent_jax.metrics import report_true_motion
from physagent_jax.render.camera import look_at

CAMERA = look_at((0, -10, 0), (0, 0, 0), (0, 0, 1), fov_degrees=40, width=320, height=240)


@pytest.fixture(scope="module")
def box():
    return np.random.default_rng(0).uniform(-1, 1, (4000, 3)) * (1.0, 0.5, 0.25)


def seen(frames, **options):
    return report_true_motion(np.stack(frames), frame_dt=0.04, camera=CAMERA, **options)


def test_translation_in_windows_and_series(box):
    """Displacement in body lengths, per frame and per window; the ends move alike; nothing turns or stretches."""
    report = seen([box + (0.1 * t, 0, -0.02 * t) for t in range(21)], windows=[(5, 10)])
    assert report.object_size == pytest.approx(2, rel=0.01)
    assert report.centroid[20] == pytest.approx((1.0, 0, -0.2), rel=0.01)
    assert report.window(5, 10).displacement == pytest.approx((0.25, 0, -0.05), rel=0.01)
    assert report.window(0, 20).path_length == pytest.approx(np.hypot(1.0, 0.2), rel=0.01)
    assert len(report.parts) == 6 and len(report.pieces) == len(report.box) == 21
    for part in report.parts:
        assert part.centroid[20] == pytest.approx((1.0, 0, -0.2), rel=0.01)
        assert np.linalg.norm(part.rotation[20]) < 1e-4
    assert np.array(report.stretch[20]) == pytest.approx(np.eye(3), abs=1e-5)
    assert report.box[20].low[0] - report.box[0].low[0] == pytest.approx(1.0, rel=0.01)
    assert set(report.pieces) == {1} and report.quality.leaves_frame is None
    assert (report.onset_frame, report.settle_frame) == (1, None)
    assert report.uncertainty.displacement == 0
    assert "to the right" in report.text and "Its shape" not in report.text


def test_extents_are_along_the_viewers_directions(box):
    """A true stretch along one of them is that one's alone; a turn widens the interval."""
    report = seen([box * (1 + 0.1 * t, 1, 1 - 0.05 * t) for t in range(6)])
    assert [e.direction for e in report.extents] == [(1, 0, 0), (0, 0, 1), (0, 1, 0)]
    assert [e.ratio[5] for e in report.extents] == pytest.approx([1.5, 0.75, 1.0], rel=0.01)
    assert all(e.half_width[5] < 0.02 for e in report.extents)


def test_rotation_vector_is_unwrapped(box):
    """A turn by 400 degrees about z is that, of the whole and of the ends."""
    turns = [Rotation.from_rotvec((0, 0, np.radians(a))).apply(box) for a in range(0, 401, 20)]
    report = seen(turns)
    assert report.rotation[-1] == pytest.approx((0, 0, 400), abs=1e-3)
    assert report.window(0, 20).rotation_degrees == pytest.approx(400, abs=1e-3)
    for part in report.parts:
        assert part.rotation[-1] == pytest.approx((0, 0, 400), abs=1e-3)


def test_twist_turns_the_ends_against_each_other(box):
    """Each end turns its own way while the whole does not."""
    frames = []
    for t in range(11):
        angle = np.radians(6.0 * t) * np.sign(box[:, 0])
        c, s = np.cos(angle), np.sin(angle)
        frames.append(
            np.stack([box[:, 0], c * box[:, 1] - s * box[:, 2], s * box[:, 1] + c * box[:, 2]], axis=1)
        )
    report = seen(frames)
    ends = {part.direction: part.rotation[-1] for part in report.parts}
    assert ends[1.0, 0.0, 0.0] == pytest.approx((60, 0, 0), abs=0.5)
    assert ends[-1.0, 0.0, 0.0] == pytest.approx((-60, 0, 0), abs=0.5)
    assert abs(report.rotation[-1][0]) < 3


def test_stretch_after_a_turn_is_in_the_axes_of_frame_0(box):
    """S of R S: stretched along its own x, then turned."""
    turn = Rotation.from_rotvec((0, 0, np.radians(50)))
    report = seen([box, turn.apply(box * (1.5, 0.8, 0.8))])
    assert np.diag(report.stretch[1]) == pytest.approx((1.5, 0.8, 0.8), abs=1e-4)
    assert report.rotation[1] == pytest.approx((0, 0, 50), abs=1e-3)


def test_uniform_stretch_tears_nothing_and_a_cut_does(box):
    """Pieces are counted after the overall deformation is undone; splinters do not count."""
    torn, splinter = box.copy(), box.copy()
    torn[box[:, 0] > 0.1] += (1.5, 0, 0)
    splinter[:10] += (5, 5, 5)
    report = seen([box, box * (3, 1, 1), torn, splinter])
    assert report.pieces == (1, 1, 2, 1)


def test_swing_is_periodic_and_settles(box):
    """A damped swing has its frequency, an onset, and comes to rest."""
    times = 0.04 * np.arange(100)
    path = 0.5 * np.sin(2 * np.pi * 1.5 * times) * np.exp(-2.0 * times)
    report = seen([box + (p, 0, 0) for p in path])
    assert report.oscillation.frequency_hz == pytest.approx(1.5, rel=0.05)
    still = np.flatnonzero(np.abs(path - path[-1]) > 0.01 * report.object_size)[-1] + 1
    assert (report.onset_frame, report.settle_frame) == (1, still)


def test_leaves_the_picture(box):
    """The first frame at the border; without a camera there is no picture to leave."""
    frames = [box + (0.5 * t, 0, 0) for t in range(21)]
    leaves = seen(frames).quality.leaves_frame
    assert 5 < leaves < 10  # half a picture is 4.9 m wide at that distance; the box ends at 1 m
    report = report_true_motion(np.stack(frames), frame_dt=0.04)
    assert report.quality.leaves_frame is None and report.text == ""


def test_a_single_particle_and_a_single_frame_are_no_error():
    """Nothing to fit is no motion, not a crash."""
    assert report_true_motion(np.zeros((2, 1, 3)), frame_dt=0.1).rotation[1] == pytest.approx((0, 0, 0))
    assert report_true_motion(np.zeros((1, 5, 3)), frame_dt=0.1).frame_count == 1


@pytest.mark.parametrize("positions", [np.zeros((2, 3)), np.full((2, 4, 3), np.nan), np.zeros((0, 4, 3))])
def test_bad_positions_are_refused(positions):
    """Of the wrong shape, or not finite."""
    with pytest.raises(UserError, match="positions"):
        report_true_motion(positions, frame_dt=0.1)


def test_windows_outside_the_clip_are_refused(box):
    """They would be silently cut otherwise."""
    with pytest.raises(UserError, match="outside of the clip"):
        seen([box, box], windows=[(0, 2)])


def test_a_part_is_followed_by_itself():
    """An arm that turns by half a radian about its shoulder, on a body that stays."""
    chance = np.random.default_rng(3)
    body = chance.uniform((-0.2, -0.1, -0.5), (0.2, 0.1, 0.5), (400, 3))
    arm = chance.uniform((0.2, -0.05, 0.05), (0.7, 0.05, 0.15), (100, 3))
    shoulder, c, s = np.array([0.2, 0.0, 0.1]), np.cos(0.5), np.sin(0.5)
    raised = shoulder + (arm - shoulder) @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    x = np.stack([np.concatenate([body, arm]), np.concatenate([body, raised])])
    report = report_true_motion(x, frame_dt=0.04, parts={7: np.arange(500) >= 400})
    (part,) = [each for each in report.parts if each.limb is not None]
    size = np.ptp(x[0], axis=0).max()
    assert part.limb == 7 and part.direction[0] > 0.9
    np.testing.assert_allclose(part.centroid[1], (raised - arm).mean(0) / size, atol=1e-6)
    np.testing.assert_allclose(part.rotation[1], (0, -np.degrees(0.5), 0), atol=1e-4)
