"""Projection of Gaussians onto the image plane (EWA splatting)."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.gaussians.cloud import Splats
from physagent_jax.gaussians.sh import eval_sh
from physagent_jax.render.camera import Camera

NEAR_PLANE = 0.01
"""Gaussians with a centre nearer than this are not drawn [m]."""

EPS2D = 0.3
"""Added to the variances in the image, so that a Gaussian covers a pixel [px^2]."""

ALPHA_MIN = 1.0 / 255.0
"""A Gaussian does not touch pixels where its alpha is smaller."""

# The linearised projection is taken no further outside the view than this many half widths: it is
# meaningless far outside, where it would smear Gaussians across the image (3DGS, gsplat).
_JACOBIAN_LIMIT = 0.3


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Projected:
    """Gaussians on the image plane.

    Attributes:
        means2d: Centres [px], shape (n, 2).
        conics: Upper triangles (xx, xy, yy) of the inverse covariances [1/px^2], shape (n, 3).
        depths: z in the camera frame [m], shape (n,).
        opacities: Shape (n,); zero where a Gaussian is not drawn.
        colors: Red, green, blue, not negative, shape (n, 3).
        extents: Half width and height of the box outside which alpha < 1/255 [px], shape (n, 2); negative
            where a Gaussian is not drawn. Carries no gradient.
    """

    means2d: jax.Array
    conics: jax.Array
    depths: jax.Array
    opacities: jax.Array
    colors: jax.Array
    extents: jax.Array


def project(splats: Splats, camera: Camera) -> Projected:
    """Projects Gaussians with the local affine approximation of the pinhole camera.

    Zwicker et al. 2001, "EWA volume splatting", with gsplat's conventions: covariance J W Sigma W^T J^T +
    0.3 px^2, J clamped to 1.3 times the field of view. Not drawn are Gaussians behind the near plane, fainter
    than 1/255, or not finite (a simulation may blow up for single particles). Written in scalars (structure of
    arrays): batches of 3x3 products are an order of magnitude slower on the CPU.

    Args:
        splats: Gaussians in world space.
        camera: Pinhole camera.
    """
    size = np.asarray([camera.width, camera.height], splats.means.dtype)
    return _project(splats, camera.viewmat, camera.K, size)


@jax.jit
def _project(splats: Splats, view, K, size) -> Projected:
    """The program behind `project`, one for pictures of any ``size`` [px], shape (2,)."""
    splats, finite = _drop_nans(splats)
    dtype = splats.means.dtype
    view, K = jnp.asarray(view, dtype), jnp.asarray(K, dtype)
    W = view[:3, :3]
    x, y, depths = (sum(W[i, j] * splats.means[:, j] for j in range(3)) + view[i, 3] for i in range(3))
    in_front = depths > NEAR_PLANE
    z = jnp.where(in_front, depths, 1.0)  # keeps the unused branch and its derivatives finite
    means2d = jnp.stack([K[0, 0] * x / z + K[0, 2], K[1, 1] * y / z + K[1, 2]], axis=-1)

    a, b, c = _project_covariances(splats.covariances, W, K, size, x / z, y / z, z)
    det = a * c - b * b
    visible = finite & in_front & (det > 0) & (splats.opacities >= ALPHA_MIN)
    det = jnp.where(visible, det, 1.0)
    conics = jnp.stack([c / det, -b / det, a / det], axis=-1)

    # alpha = o exp(-q / 2) >= 1/255 inside the ellipse q <= 2 ln(255 o), whose box is exact:
    reach = jnp.sqrt(2 * jnp.log(jnp.where(visible, splats.opacities / ALPHA_MIN, 1.0)))
    extents = jnp.stack([reach * jnp.sqrt(a), reach * jnp.sqrt(c)], axis=-1)
    return Projected(
        means2d=means2d,
        conics=conics,
        depths=depths,
        opacities=jnp.where(visible, splats.opacities, 0.0),
        colors=_evaluate_colors(splats, view),
        extents=jax.lax.stop_gradient(jnp.where(visible[:, None], extents, -1.0)),
    )


def _drop_nans(splats: Splats) -> tuple[Splats, jax.Array]:
    """Splats with zeros for what is not finite, and which ones are. Shape (n,).

    Without this, products with a weight of zero would carry a NaN into pixels and gradients.
    """
    finite = jnp.isfinite(
        jnp.sum(splats.means, axis=-1)
        + jnp.sum(splats.covariances, axis=-1)
        + splats.opacities
        + jnp.sum(splats.sh, axis=(-2, -1))
    )
    clean = dataclasses.replace(
        splats,
        means=jnp.where(finite[:, None], splats.means, 0),
        covariances=jnp.where(finite[:, None], splats.covariances, 0),
        opacities=jnp.where(finite, splats.opacities, 0),
        sh=jnp.where(finite[:, None, None], splats.sh, 0),
        rotations=jnp.where(finite[:, None, None], splats.rotations, 0),
    )
    return clean, finite


def _project_covariances(covariances, W, K, size, x_over_z, y_over_z, z):
    """Entries xx, xy, yy of the covariances in the image, with the blur [px^2]."""
    focal_x, focal_y = K[0, 0], K[1, 1]
    width, height = size[0], size[1]
    margin_x = _JACOBIAN_LIMIT * 0.5 * width / focal_x
    margin_y = _JACOBIAN_LIMIT * 0.5 * height / focal_y
    u = jnp.clip(x_over_z, -K[0, 2] / focal_x - margin_x, (width - K[0, 2]) / focal_x + margin_x)
    v = jnp.clip(y_over_z, -K[1, 2] / focal_y - margin_y, (height - K[1, 2]) / focal_y + margin_y)
    # The two rows of J W, with J = [[fx / z, 0, -fx x / z^2], [0, fy / z, -fy y / z^2]].
    row_x = [focal_x / z * (W[0, j] - u * W[2, j]) for j in range(3)]
    row_y = [focal_y / z * (W[1, j] - v * W[2, j]) for j in range(3)]
    xx, xy, xz, yy, yz, zz = (covariances[:, i] for i in range(6))

    def times_sigma(r):
        return (
            r[0] * xx + r[1] * xy + r[2] * xz,
            r[0] * xy + r[1] * yy + r[2] * yz,
            r[0] * xz + r[1] * yz + r[2] * zz,
        )

    sx, sy = times_sigma(row_x), times_sigma(row_y)
    a = sum(s * r for s, r in zip(sx, row_x)) + EPS2D
    b = sum(s * r for s, r in zip(sx, row_y))
    c = sum(s * r for s, r in zip(sy, row_y)) + EPS2D
    return a, b, c


def _evaluate_colors(splats: Splats, view: jax.Array) -> jax.Array:
    """Colours seen by the camera: the view direction is rotated back to the captured frame, not the SH."""
    if splats.sh.shape[1] == 1:
        directions = jnp.zeros_like(splats.means)  # a constant colour, no direction needed
    else:
        center = -view[:3, :3].T @ view[:3, 3]
        rays = splats.means - center
        rays = sum(rays[:, j, None] * splats.rotations[:, j, :] for j in range(3))  # R^T (x - center)
        length = jnp.sqrt(jnp.sum(rays * rays, axis=-1, keepdims=True))
        directions = rays / jnp.maximum(length, NEAR_PLANE)
    return jnp.maximum(eval_sh(splats.sh, directions) + 0.5, 0.0)
