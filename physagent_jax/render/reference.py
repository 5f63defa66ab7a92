"""The renderer's readable twin: every Gaussian at every pixel, differentiated by JAX.

Slow and memory hungry, an oracle for tests: full matrices, the Jacobian of the pinhole camera by automatic
differentiation, no tiles. Give it float64 arrays (under `jax.enable_x64`) for tight comparisons.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.gaussians.cloud import Splats
from physagent_jax.gaussians.sh import eval_sh
from physagent_jax.render.camera import Camera
from physagent_jax.render.renderer import RenderedImage

# The convention's figures, written here once more: an oracle that took them from the renderer could not
# notice a change there.
ALPHA_MIN, ALPHA_MAX = 1.0 / 255.0, 0.999
TRANSMITTANCE_STOP = 1e-4
EPS2D = 0.3
NEAR_PLANE = 0.01


def render_reference(splats: Splats, camera: Camera, background: np.ndarray | jax.Array) -> RenderedImage:
    """Render densely; same arguments and result as `rasterize`, without a capacity.

    Args:
        splats: Gaussians in world space.
        camera: Pinhole camera.
        background: Colour behind the splats, shape (3,).
    """
    view, K = jnp.asarray(camera.viewmat), jnp.asarray(camera.K)
    W, t = view[:3, :3], view[:3, 3]
    points = splats.means @ W.T + t
    order = jnp.argsort(points[:, 2])
    points = points[order]

    def pinhole(p):
        return jnp.stack([K[0, 0] * p[0] / p[2] + K[0, 2], K[1, 1] * p[1] / p[2] + K[1, 2]])

    in_front = points[:, 2] > NEAR_PLANE
    safe = jnp.where(in_front[:, None], points, jnp.asarray([0.0, 0.0, 1.0]))
    centers = jax.vmap(pinhole)(safe)
    J = jax.vmap(jax.jacfwd(pinhole))(_clamp_to_view(safe, camera))
    sigma = splats.covariances[order][:, np.array([0, 1, 2, 1, 3, 4, 2, 4, 5])].reshape(-1, 3, 3)
    covariances = J @ W @ sigma @ W.T @ J.transpose(0, 2, 1) + EPS2D * jnp.eye(2)

    center = -W.T @ t
    rays = jnp.einsum("nji,nj->ni", splats.rotations, splats.means - center)
    directions = rays / jnp.linalg.norm(rays, axis=-1, keepdims=True)
    colors = jnp.maximum(eval_sh(splats.sh, directions) + 0.5, 0.0)[order]

    v, u = jnp.mgrid[: camera.height, : camera.width]
    pixels = jnp.stack([u, v], axis=-1) + 0.5
    d = pixels - centers[:, None, None]
    a, b, c = covariances[:, 0, 0], covariances[:, 0, 1], covariances[:, 1, 1]
    inverse = jnp.stack([c, -b, -b, a], axis=-1).reshape(-1, 2, 2) / (a * c - b * b)[:, None, None]
    q = jnp.sum(d * jnp.einsum("nij,nhwj->nhwi", inverse, d), axis=-1)
    alpha = jnp.minimum(splats.opacities[order][:, None, None] * jnp.exp(-q / 2), ALPHA_MAX)
    alpha = jnp.where((alpha >= ALPHA_MIN) & in_front[:, None, None], alpha, 0.0)

    before = jnp.concatenate([jnp.ones_like(alpha[:1]), jnp.cumprod(1 - alpha, axis=0)[:-1]])
    alpha = jnp.where(before > TRANSMITTANCE_STOP, alpha, 0.0)
    weights = before * alpha
    coverage = 1 - jnp.prod(1 - alpha, axis=0)
    rgb = jnp.einsum("nhw,nc->hwc", weights, colors) + (1 - coverage)[..., None] * jnp.asarray(background)
    depth = jnp.einsum("nhw,n->hw", weights, points[:, 2])
    depth = jnp.where(coverage > 0, depth / jnp.where(coverage > 0, coverage, 1), 0)
    return RenderedImage(rgb, depth, coverage)


def _clamp_to_view(points: jax.Array, camera: Camera) -> jax.Array:
    """Points moved sideways into the view widened by 0.3 half widths, as gsplat does before linearising."""
    K = jnp.asarray(camera.K)
    focal, principal = jnp.diagonal(K)[:2], K[:2, 2]
    size = jnp.asarray([camera.width, camera.height], points.dtype)
    margin = 0.3 * 0.5 * size / focal
    slopes = points[:, :2] / points[:, 2:]
    slopes = jnp.clip(slopes, -principal / focal - margin, (size - principal) / focal + margin)
    return jnp.concatenate([slopes * points[:, 2:], points[:, 2:]], axis=-1)
