"""The tiled rasteriser against the dense reference: image and gradients, and its sorting and sizing."""

from __future__ import annotations

import dataclasses
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from physagent_jax.core.errors import UserError
from physagent_jax.render import choose_pair_capacity, look_at, rasterize, render, renderer
from physagent_jax.render.project import project
from physagent_jax.render.reference import render_reference
from physagent_jax.render.tiles import build_tile_lists, count_pairs, find_tile_rectangles, sort_pairs
from tests.render.scenes import BACKGROUND, camera, random_splats

FIELDS = ("rgb", "depth", "alpha")


def assert_same(a, b, atol):
    for name in FIELDS:
        np.testing.assert_allclose(getattr(a, name), getattr(b, name), atol=atol, err_msg=name)


@pytest.mark.parametrize(("count", "scale", "lanes"), [(60, 0.15, 5), (400, 0.3, 1)])
def test_image_equals_the_dense_reference(x64, count, scale, lanes):
    """The second scene is opaque: early stopping must change nothing. Five lanes do not divide the tiles."""
    splats, cam = random_splats(count, degree=3, scale=scale), camera()
    drawn, total = rasterize(splats, cam, BACKGROUND, capacity=8192, lanes=lanes)
    assert total <= 8192
    expected = jax.jit(render_reference)(splats, cam, BACKGROUND)
    assert_same(drawn, expected, 1e-9)
    if count == 400:
        assert np.max(drawn.alpha) > 1 - 1e-4


def loss(image):
    rng = np.random.default_rng(5)
    return sum(jnp.sum(getattr(image, name) * rng.normal(size=getattr(image, name).shape)) for name in FIELDS)


@jax.jit
@jax.grad
def dense_gradient(splats, cam):
    return loss(render_reference(splats, cam, BACKGROUND))


@partial(jax.jit, static_argnums=2)
@jax.grad
def tiled_gradient(splats, cam, lanes):
    return loss(rasterize(splats, cam, BACKGROUND, capacity=8192, lanes=lanes)[0])


@pytest.mark.parametrize(("eye", "lanes"), [("outside", 5), ("inside", 1)])
def test_gradients_equal_those_of_the_dense_reference(x64, eye, lanes):
    """With respect to centres, covariances, opacities, colours and rotations, for a random cotangent.

    Seen from inside, Gaussians lie behind the camera, at the clamped rim of the view, and saturate alpha.
    """
    cam = camera(distance=3 if eye == "outside" else 0.3)
    splats = random_splats(150, degree=2, scale=0.12)
    splats = dataclasses.replace(splats, opacities=splats.opacities.at[:40].set(0.9999))
    got, expected = tiled_gradient(splats, cam, lanes), dense_gradient(splats, cam)
    for field in dataclasses.fields(splats):
        a, b = np.asarray(getattr(got, field.name)), np.asarray(getattr(expected, field.name))
        assert np.abs(b).max() > 0
        np.testing.assert_allclose(a, b, atol=1e-8 * np.abs(b).max(), err_msg=field.name)


def test_single_precision_is_close_to_double():
    """Rounding may push an alpha across 1/255 at single pixels; all others agree to 1e-4."""
    splats, cam = random_splats(100, degree=3, scale=0.1, dtype=np.float32), camera()
    drawn = render(splats, cam, background=BACKGROUND)
    with jax.enable_x64(True):
        exact = jax.tree.map(lambda a: jnp.asarray(np.asarray(a), jnp.float64), splats)
        expected = jax.jit(render_reference)(exact, cam, BACKGROUND)
    error = np.abs(np.asarray(drawn.rgb) - np.asarray(expected.rgb)).max(-1)
    assert np.quantile(error, 0.99) < 1e-4 and error.max() < 2 / 255


def test_gradient_reaches_the_camera_pose():
    """Against central differences in the camera's translation."""
    splats, cam = random_splats(40, scale=0.3, dtype=np.float32), camera()

    @jax.jit
    def brightness(shift):
        moved = dataclasses.replace(cam, viewmat=jnp.asarray(cam.viewmat, jnp.float32).at[:3, 3].add(shift))
        weights = jnp.linspace(-1, 1, 50)
        return jnp.sum(rasterize(splats, moved, BACKGROUND, capacity=4096)[0].rgb.sum(-1) * weights)

    gradient = jax.grad(brightness)(jnp.zeros(3))
    step = 5e-3 * np.eye(3, dtype=np.float32)
    differences = [(brightness(s) - brightness(-s)) / 1e-2 for s in step]
    np.testing.assert_allclose(gradient, differences, rtol=0.05, atol=0.05 * np.abs(gradient).max())


def test_too_small_a_capacity_gives_nan_and_the_need():
    splats, cam = random_splats(100, degree=3, scale=0.1, dtype=np.float32), camera()
    exact, needed = rasterize(splats, cam, BACKGROUND, capacity=4096)
    needed = int(needed)
    short, total = rasterize(splats, cam, BACKGROUND, capacity=needed - 1)
    assert total == needed and all(np.isnan(getattr(short, name)).all() for name in FIELDS)
    assert_same(rasterize(splats, cam, BACKGROUND, capacity=needed)[0], exact, 0)


def test_render_grows_its_capacity_once_and_remembers_it():
    splats, far, near = random_splats(700, scale=0.2, dtype=np.float32), camera(distance=30.0), camera()
    renderer.capacities.pop((700, 50, 37), None)
    render(splats, far)
    small = renderer.capacities[700, 50, 37]
    image = render(splats, near)
    large = renderer.capacities[700, 50, 37]
    assert small < choose_pair_capacity(splats, near) <= large
    assert not np.isnan(image.rgb).any()
    compiled = renderer.draw._cache_size()
    render(splats, far)
    render(splats, near)
    assert renderer.capacities[700, 50, 37] == large
    assert renderer.draw._cache_size() <= compiled + 1  # the far view, once, with the new capacity


def test_impossible_numbers_of_pairs_are_refused_not_wrapped():
    """2^31 pairs and more would wrap an int32."""
    rectangles = jnp.asarray([[0, 0, 60000, 60000]] * 3, jnp.int32) // jnp.asarray([1, 1, 2, 2])
    assert count_pairs(rectangles) == np.iinfo(np.int32).max
    with pytest.raises(UserError, match="too many tiles"):
        renderer.round_up(int(count_pairs(rectangles)))


@pytest.mark.parametrize(("tiles", "count"), [(400, 5000), (40_000, 1_000_000)])
def test_sorting_by_tile_and_rank_with_and_without_packed_keys(tiles, count):
    """The second case needs 36 bits, more than the packed key has."""
    rng = np.random.default_rng(0)
    rank = np.sort(rng.integers(0, count, 20_000)).astype(np.int32)
    tile = rng.integers(0, tiles + 1, 20_000).astype(np.int32)
    order = np.lexsort((rank, tile))
    got = sort_pairs(jnp.asarray(tile), jnp.asarray(rank), tiles, count)
    np.testing.assert_array_equal(got[0], tile[order])
    np.testing.assert_array_equal(got[1], rank[order])


def test_tile_lists_hold_exactly_the_pairs_that_reach_a_pixel():
    """Brute force over tiles and pixels: nobody is missing, lists are in order of depth."""
    splats, cam = random_splats(200, scale=0.05, dtype=np.float32), camera()
    projected = project(splats, cam)
    build = jax.jit(build_tile_lists, static_argnums=(1, 2), static_argnames=("capacity", "tile_size"))
    lists = jax.device_get(build(projected, 50, 37, capacity=4096, tile_size=16))
    a, b, c = np.asarray(projected.conics).T
    v, u = np.mgrid[:37, :50] + 0.5
    dx = u - np.asarray(projected.means2d)[:, 0, None, None]
    dy = v - np.asarray(projected.means2d)[:, 1, None, None]
    q = a[:, None, None] * dx**2 + 2 * b[:, None, None] * dx * dy + c[:, None, None] * dy**2
    reached = np.asarray(projected.opacities)[:, None, None] * np.exp(-q / 2) >= 1 / 255
    depths = np.asarray(projected.depths)
    for tile in range(12):
        listed = np.asarray(lists.gaussians[lists.starts[tile] : lists.starts[tile + 1]])
        row, column = divmod(tile, 4)
        block = reached[:, row * 16 : row * 16 + 16, column * 16 : column * 16 + 16]
        assert set(np.flatnonzero(block.any((1, 2)))) <= set(listed)
        assert (np.diff(depths[listed]) >= 0).all() and len(set(listed)) == len(listed)
    assert (
        lists.total
        == lists.starts[-1]
        == np.sum(np.prod(find_tile_rectangles(projected, 50, 37, 16)[:, 2:], axis=1))
    )


def test_gaussians_that_are_not_finite_or_behind_are_ignored():
    """A simulation that blows up for one particle must not blank the image."""
    splats, cam = random_splats(100, degree=3, scale=0.1, dtype=np.float32), camera()
    good = dataclasses.replace(splats, opacities=splats.opacities.at[:7].set(0))
    bad = dataclasses.replace(
        splats,
        means=splats.means.at[0].set(jnp.nan).at[1].set(jnp.inf).at[2].set(-10 * cam.forward),
        covariances=splats.covariances.at[3].set(jnp.nan),
        rotations=splats.rotations.at[3].set(jnp.nan),
        sh=splats.sh.at[4, 0].set(jnp.inf).at[5, 3].set(jnp.nan),
        opacities=splats.opacities.at[6].set(jnp.inf),
    )
    assert_same(render(bad, cam), render(good, cam), 1e-6)
    gradients = jax.jit(jax.grad(lambda s: loss(rasterize(s, cam, BACKGROUND, capacity=4096)[0])))(bad)
    assert all(jnp.isfinite(g).all() for g in jax.tree.leaves(gradients))


def test_a_picture_that_needs_more_room_gets_it_whatever_another_thread_has_noted(monkeypatch):
    """Between a picture that lacks room and the second attempt, another thread notes enough for both."""
    splats, view = random_splats(200, scale=0.3, dtype=np.float32), camera()
    key = (200, view.width, view.height)
    monkeypatch.setattr(renderer, "capacities", {key: 64})
    first = renderer.rasterize

    def and_another_thread(*arguments, **options):
        result = first(*arguments, **options)
        renderer.capacities[key] = 1 << 16
        return result

    monkeypatch.setattr(renderer, "rasterize", and_another_thread)
    assert np.isfinite(np.asarray(render(splats, view).rgb)).all()
    assert renderer.capacities[key] == 1 << 16


@pytest.mark.parametrize(
    ("eye", "target", "up", "message"),
    [
        ([1, 2, 3], [1, 2, 3], [0, 0, 1], "coincide"),
        ([0, 0, 3], [0, 0, 0], [0, 0, 1], "parallel"),
        ([0, 0, np.nan], [0, 0, 0], [0, 0, 1], "`eye` must be three finite"),
        ([0, 1, 0], [0, 0, 0], [0, np.inf, 1], "`up` must be three finite"),
    ],
)
def test_cameras_that_look_nowhere_are_refused(eye, target, up, message):
    with pytest.raises(UserError, match=message):
        look_at(eye, target, up, fov_degrees=40, width=16, height=16)
