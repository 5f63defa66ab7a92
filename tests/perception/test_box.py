"""The box around the visible surface where the mask's rim has the depth of what is behind."""

import numpy as np
import pytest

from physagent_jax.perception.extents import measure_breadths
from physagent_jax.perception.lift import keep_trusted_depth, measure_box
from physagent_jax.render.camera import look_at

SIZE, DISTANCE, RADIUS = 200, 4.0, 0.8


def ball():
    """Depth of a ball [m], nan beside it, and the camera; along +y."""
    camera = look_at((0, -DISTANCE, 0), (0, 0, 0), (0, 0, 1), fov_degrees=40, width=SIZE, height=SIZE)
    focal = float(camera.K[0, 0])
    x, z = (np.indices((SIZE, SIZE))[::-1] + 0.5 - SIZE / 2) / focal
    # A ray (x, 1, z) t meets the ball where |t (x, 1, z) - (0, DISTANCE, 0)| = RADIUS.
    a = x**2 + z**2 + 1
    root = DISTANCE**2 - a * (DISTANCE**2 - RADIUS**2)
    with np.errstate(invalid="ignore"):
        return ((DISTANCE - np.sqrt(root)) / a).astype(np.float32), camera


def edges(depth, mask, camera):
    low, high = measure_box(depth, mask, keep_trusted_depth(depth, mask)[0], camera)
    return high - low


def test_a_ball_is_as_wide_as_it_is():
    depth, camera = ball()
    wide, deep, high = edges(depth, np.isfinite(depth), camera)
    outline = 2 * RADIUS * np.sqrt(1 - (RADIUS / DISTANCE) ** 2)  # what can be seen from so near
    assert (wide, high) == (pytest.approx(outline, rel=0.03), pytest.approx(outline, rel=0.03))
    assert deep == pytest.approx(
        RADIUS, rel=0.25
    )  # its near half, and the rim of a picture is never seen whole


@pytest.mark.parametrize("wall", [6.0, 20.0])
def test_a_rim_that_reads_the_wall_behind_does_not_reach_there(wall):
    depth, camera = ball()
    mask = np.isfinite(depth)
    behind = np.where(mask, depth, np.float32(wall))
    wider = mask | np.roll(mask, 1, 0) | np.roll(mask, -1, 0) | np.roll(mask, 1, 1) | np.roll(mask, -1, 1)
    clean = edges(depth, mask, camera)
    np.testing.assert_allclose(edges(behind, wider, camera), clean, rtol=0.25)
    assert edges(behind, wider, camera)[1] < 1.25 * clean[1] < 0.6 * (wall - DISTANCE + RADIUS)


def test_the_breadth_of_an_end_is_that_of_the_outermost_third():
    chance = np.random.default_rng(0)
    body = chance.uniform((-0.2, 0, -0.5), (0.2, 0, 0.5), (6000, 3))
    squeezed = body * np.where(body[:, [2]] > 1 / 6, (0.5, 1, 1), 1)
    up, right = np.array([[0.0, 0, 1]]), np.array([[1.0, 0, 0], [0, 0, 1]])
    before, after = measure_breadths([body, squeezed], up, right)[:, 0]
    assert after[0] / before[0] == pytest.approx(0.5, abs=0.03)
    assert np.isnan(after[1])  # along the end, not across
