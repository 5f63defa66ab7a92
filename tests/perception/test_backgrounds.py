"""Motions before backgrounds with depth everywhere, as an RGB-D camera in a room has them."""

import dataclasses

import cv2
import numpy as np
import pytest

from physagent_jax.metrics.motion import compare, measure_true_motion
from physagent_jax.perception.backends.rgbd import RgbdSegmenter
from physagent_jax.perception.background import find_background
from physagent_jax.perception.measure import perceive
from physagent_jax.perception.pieces import count_pieces
from physagent_jax.render.camera import Camera
from tests.perception.scenes import Clip, blob, film, rotated, texture, translated

DT = 0.04


def rays(view: Camera) -> np.ndarray:
    """World directions with unit z-depth, shape (H, W, 3)."""
    x, y = np.meshgrid(np.arange(view.width) + 0.5, np.arange(view.height) + 0.5)
    return (np.stack([x, y, np.ones_like(x)], -1) @ np.linalg.inv(view.K).T) @ view.viewmat[:3, :3]


def hit(view: Camera, normal, offset: float) -> np.ndarray:
    """z-depth of the plane normal . x = offset, inf where there is none, shape (H, W)."""
    z = (offset - view.center @ normal) / (rays(view) @ normal)
    return np.where(z > 0, z, np.inf)


def put_before(clip: Clip, background: str) -> Clip:
    """The clip before a textured wall, or in a room with a floor that it touches and a wall."""
    view = clip.camera
    wall = hit(view, np.array([0.3, 1.0, 0.1]), 1.4)
    z = wall if background == "wall" else np.minimum(hit(view, np.array([0, 0, 1.0]), -0.55), wall)
    points = view.center + rays(view) * z[..., None]
    picture = texture(points.reshape(-1, 3), 7).reshape(*z.shape, 3)
    seen = np.isfinite(clip.depth)
    rgb = np.where(seen[..., None], clip.rgb, picture).astype(np.uint8)
    return dataclasses.replace(clip, rgb=rgb, depth=np.where(seen, clip.depth, z).astype(np.float32))


def spoil(clip: Clip, seed: int = 0) -> Clip:
    """Depth with noise of 0.12 % of z^2 and 3 % of the pixels dropped; noisy colours."""
    rng = np.random.default_rng(seed)
    depth = clip.depth + rng.normal(0, 0.0012, clip.depth.shape) * clip.depth**2
    depth = np.where(rng.uniform(size=depth.shape) < 0.03, np.nan, depth)
    rgb = np.clip(clip.rgb + rng.normal(0, 2, clip.rgb.shape), 0, 255).astype(np.uint8)
    return dataclasses.replace(clip, rgb=rgb, depth=depth.astype(np.float32))


def look(clip: Clip):
    report = perceive(clip.rgb, clip.depth, clip.camera, frame_dt=DT).report
    return report, compare(report, measure_true_motion(clip.particles))


@pytest.mark.parametrize("noisy", [False, True])
@pytest.mark.parametrize("background", ["nothing", "wall", "room"])
def test_a_shift_of_half_a_length(background, noisy):
    clip = film(blob(), translated((0.5, 0, 0)), frames=12)
    clip = clip if background == "nothing" else put_before(clip, background)
    report, errors = look(spoil(clip) if noisy else clip)
    assert errors["centroid_error_max"] < 0.03 and errors["rotation_error_max"] < 4
    assert errors["centroid_error_max"] < report.uncertainty.displacement
    assert set(report.pieces) == {1}


@pytest.mark.parametrize("background", ["wall", "room"])
def test_a_spin_of_60_degrees(background):
    report, errors = look(spoil(put_before(film(blob(), rotated((0, 0, 1), 60)), background)))
    assert errors["rotation_error_max"] < 10
    assert errors["rotation_error_max"] < report.uncertainty.rotation
    assert np.dot(report.windows[0].rotation_axis, (0, 0, 1)) > 0.98


@pytest.mark.parametrize("noisy", [False, True])
@pytest.mark.parametrize("background", ["nothing", "wall", "room"])
def test_what_is_still_reads_as_still(background, noisy):
    clip = film(blob(), translated((0, 0, 0)), frames=10)
    clip = clip if background == "nothing" else put_before(clip, background)
    report, _ = look(spoil(clip) if noisy else clip)
    assert report.onset_frame is None and report.oscillation is None
    assert "Nothing moves visibly" in report.text


def test_the_mask_is_the_object_and_not_what_has_depth():
    clip = film(blob(), translated((0.3, 0, 0)), frames=3)
    truth = np.isfinite(clip.depth)
    for background in ("wall", "room"):
        seen = spoil(put_before(clip, background))
        masks = RgbdSegmenter().segment(seen.rgb, None, depth=seen.depth).masks
        assert (masks & truth).sum() / (masks | truth).sum() > 0.95


def test_floor_and_wall_are_found():
    view = film(blob(count=100), translated((0, 0, 0)), frames=1).camera
    z = np.minimum(hit(view, np.array([0, 0, 1.0]), -0.55), hit(view, np.array([0, 1.0, 0]), 1.5))
    rng = np.random.default_rng(0)
    noisy = 1 / z + rng.normal(0, 0.0012, (3, *z.shape))
    found = find_background(noisy)
    assert not found.open and found.explained > 0.95
    assert np.abs(found.inverse - 1 / z).max() < 0.002 < found.tolerance < 0.01


def test_a_cupboard_at_the_border_is_no_object():
    clip = put_before(film(blob(), translated((0.4, 0, 0)), frames=8), "wall")
    clip.depth[:, 40:, :30], clip.rgb[:, 40:, :30] = 2.4, (90, 60, 40)
    report, errors = look(clip)
    assert errors["centroid_error_max"] < 0.03 and errors["size_ratio"] == pytest.approx(1, abs=0.03)


def test_an_empty_room_has_no_object():
    clip = film(blob(), translated((0, 0, 0)), frames=4)
    clip.depth[:] = np.nan
    clip = put_before(clip, "room")
    report = perceive(clip.rgb, clip.depth, clip.camera, frame_dt=DT).report
    assert report.centroid == (None,) * 4 and report.onset_frame is None
    assert any("Nothing stands in front" in note for note in report.quality.notes)
    assert "not observable" in report.text


def test_the_inside_of_what_is_as_white_as_the_background_is_the_object():
    solid = np.zeros((3, 60, 60), bool)
    solid[:, 10:50, 10:50] = True
    rgb = np.full((3, 60, 60, 3), 255, np.uint8)
    rgb[solid] = 120
    rgb[:, 20:40, 10:30] = 255  # an overexposed patch that reaches the outline
    masks = RgbdSegmenter().segment(rgb, None, depth=np.where(solid, 2.0, np.nan).astype(np.float32)).masks
    assert (masks & ~solid).sum() == 0
    assert (solid & ~masks).sum() <= 3 * 24


def test_a_gap_that_faint_rims_bridge_stays_one():
    """Depth reaches three pixels beyond what is seen of two blocks, four pixels apart: they are no one thing."""
    blocks = np.zeros((3, 60, 60), bool)
    blocks[:, 15:45, 10:28], blocks[:, 15:45, 32:50] = True, True
    solid = np.stack([cv2.dilate(each.astype(np.uint8), np.ones((7, 7), np.uint8)) > 0 for each in blocks])
    rgb = np.where(blocks[..., None], 120, 255).astype(np.uint8).repeat(3, axis=-1)
    masks = RgbdSegmenter().segment(rgb, None, depth=np.where(solid, 2.0, np.nan).astype(np.float32)).masks
    assert count_pieces(masks) == [2, 2, 2] and (masks & ~blocks).sum() == 0
