"""The blending kernels give the reference's pictures and gradients."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from benchmarks.cases.splats import sphere
from physagent_jax.render import choose_pair_capacity, look_at, rasterize
from physagent_jax.render.layout import TileLayout
from physagent_jax.render.project import project
from physagent_jax.render.rasterize import blend
from physagent_jax.render.tiles import build_tile_lists

pytest.importorskip("numba")


def opaque():
    """Large Gaussians of opacity 1: alpha is capped, and blending stops early."""
    splats = sphere(60)
    return dataclasses.replace(splats, covariances=30 * splats.covariances, opacities=jnp.ones(60))


def thin():
    """Needles, and some that are hardly visible."""
    splats = sphere(400, seed=3)
    stretch = jnp.asarray([40.0, 0.0, 0.0, 0.05, 0.0, 0.05])
    fade = jnp.where(jnp.arange(400) % 3 == 0, 0.01, 1.0)
    return dataclasses.replace(
        splats, covariances=jnp.abs(splats.covariances) * stretch, opacities=fade * splats.opacities
    )


SCENES = {"sphere": sphere(800), "opaque": opaque(), "thin": thin()}


@pytest.mark.parametrize(
    "name, width, height", [("sphere", 64, 48), ("sphere", 37, 50), ("opaque", 32, 32), ("thin", 32, 32)]
)
def test_pictures_and_gradients_are_the_references(name, width, height):
    scene = SCENES[name]
    camera = look_at((0, -3.2, 0.4), (0.2, 0, 0), (0, 0, 1), fov_degrees=40, width=width, height=height)
    capacity = choose_pair_capacity(scene, camera)
    rng = np.random.default_rng(0)
    weights = jnp.asarray(rng.normal(size=(5, height, width)), jnp.float32)

    def loss(splats, background, choice):
        image, _ = rasterize(splats, camera, background, capacity=capacity, kernels=choice)
        channels = jnp.stack([*jnp.moveaxis(image.rgb, -1, 0), image.depth, image.alpha])
        return (weights * channels).sum(), image

    found = {}
    for choice in ("reference", "cpu"):
        slope = jax.value_and_grad(loss, argnums=(0, 1), has_aux=True)
        (_, image), gradient = jax.jit(slope, static_argnums=2)(scene, jnp.ones(3), choice)
        found[choice] = image, gradient
    (image, gradient), (expected, expected_gradient) = found["cpu"], found["reference"]
    assert float(expected.alpha.max()) > 0.5
    for name in ("rgb", "depth", "alpha"):
        np.testing.assert_allclose(getattr(image, name), getattr(expected, name), atol=2e-4, err_msg=name)
        close = (
            np.abs(getattr(image, name) - getattr(expected, name))
            < 2e-5 * np.abs(getattr(expected, name)).max()
        )
        assert close.mean() > 0.999, (
            name
        )  # an alpha within round-off of a limit may fall on either side of it
    jax.tree.map(
        lambda a, b: np.testing.assert_allclose(a, b, atol=1e-3 * np.abs(b).max()),
        gradient,
        expected_gradient,
    )


def test_kernels_repeat_bit_by_bit():
    camera = look_at((0, -3.2, 0.4), (0, 0, 0), (0, 0, 1), fov_degrees=40, width=64, height=64)
    splats = SCENES["sphere"]
    capacity = choose_pair_capacity(splats, camera)

    @jax.jit
    def slope(splats):
        drawn = lambda s: rasterize(s, camera, jnp.ones(3), capacity=capacity, kernels="cpu")[0]  # noqa: E731
        return jax.grad(lambda s: drawn(s).rgb.sum())(splats)

    jax.tree.map(np.testing.assert_array_equal, slope(splats), slope(splats))


def test_a_gaussian_without_an_opacity_is_nothing():
    """NaN is no alpha: the reference leaves such a Gaussian out, and so do the kernels."""
    camera = look_at((0, -3.2, 0.4), (0, 0, 0), (0, 0, 1), fov_degrees=40, width=48, height=48)
    splats = SCENES["sphere"]
    capacity = choose_pair_capacity(splats, camera)
    projected = project(splats, camera)
    spoilt = dataclasses.replace(projected, opacities=projected.opacities.at[::7].set(jnp.nan))
    lists = build_tile_lists(projected, 48, 48, capacity=capacity, tile_size=16)
    native, reference = (
        blend(spoilt, lists, TileLayout(48, 48, 16, 1), choice)[0] for choice in (True, False)
    )
    assert np.isfinite(reference).all() and float(reference.max()) > 0.3
    np.testing.assert_allclose(native, reference, atol=2e-4)
