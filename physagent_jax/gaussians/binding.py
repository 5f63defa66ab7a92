"""Gaussians that follow simulated particles."""

from __future__ import annotations

import dataclasses
import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from scipy.spatial import KDTree

from physagent_jax.core.arrays import to_device
from physagent_jax.core.errors import UserError
from physagent_jax.core.pytree import register_dataclass
from physagent_jax.gaussians.cloud import GaussianCloud, Splats
from physagent_jax.gaussians.covariance import quats_scales_to_covariances, transform_covariances
from physagent_jax.gaussians.polar import polar_rotation

# A Gaussian nearer to a particle than this fraction of the scene's extent is that particle: float32
# positions are not resolved any finer.
_COINCIDENT = 1e-6


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Binding:
    """The particles that each Gaussian follows, chosen in the rest pose.

    Attributes:
        indices: Particles, shape (g, k), int32.
        weights: Their weights, non-negative, each row sums to one, shape (g, k).
        offsets: Rest vector from the particle to the Gaussian, X_g - X_p [m], shape (g, k, 3).
    """

    indices: jax.Array
    weights: jax.Array
    offsets: jax.Array


def bind(
    gaussian_means: np.ndarray | jax.Array, particle_positions: np.ndarray | jax.Array, *, k: int = 4
) -> Binding:
    """Bind Gaussians to their nearest particles with inverse squared distances as weights.

    A Gaussian that coincides with a particle follows that particle alone. If all do (the usual case: the
    centres were made particles), the binding has a single column, and `deform` skips the blending.
    Runs on the host; the same input gives the same binding.

    Args:
        gaussian_means: Rest centres [m], shape (g, 3).
        particle_positions: Rest positions in the same frame [m], shape (n, 3).
        k: Particles per Gaussian, at most n are used.

    Raises:
        UserError: There is no particle, or ``k`` is not positive.
    """
    means = np.asarray(gaussian_means, np.float64)
    particles = np.asarray(particle_positions, np.float64)
    if len(particles) == 0:
        raise UserError("Gaussians cannot be bound: there are no particles")
    if k < 1:
        raise UserError("`k` must be at least 1", got=k)
    k = min(k, len(particles))
    tree: Any = KDTree(particles)  # scipy annotates `query` for a single neighbour only
    distances, indices = tree.query(means, k=np.arange(1, k + 1))
    tolerance = _COINCIDENT * max(np.ptp(particles, axis=0).max(), np.finfo(np.float32).tiny)
    coincident = distances[:, 0] <= tolerance
    if coincident.all():
        indices, distances = indices[:, :1], distances[:, :1]
    weights = 1.0 / np.maximum(distances, tolerance) ** 2
    weights[coincident] = np.arange(weights.shape[1]) == 0
    weights /= weights.sum(axis=1, keepdims=True)
    offsets = np.where(coincident[:, None, None], 0.0, means[:, None, :] - particles[indices])
    return Binding(
        to_device(indices, np.int32),
        to_device(weights, np.float32),
        to_device(offsets, np.float32),
    )


def bind_pieces(
    gaussian_means: np.ndarray,
    particle_positions: np.ndarray,
    gaussian_piece: np.ndarray,
    particle_piece: np.ndarray,
) -> Binding:
    """Bind Gaussians as `bind` does, each to particles of its own piece, so that nothing spans a gap as pieces part.

    Args:
        gaussian_means: Rest centres [m], shape (g, 3).
        particle_positions: Rest positions in the same frame [m], shape (n, 3).
        gaussian_piece: The piece of each Gaussian, int, shape (g,); one without particles is bound to all.
        particle_piece: The piece of each particle, int, shape (n,).
    """
    means, particles = np.asarray(gaussian_means), np.asarray(particle_positions)
    if (gaussian_piece == gaussian_piece[:1]).all():
        return bind(means, particles)
    found = []
    for piece in np.unique(gaussian_piece):
        own = np.flatnonzero(particle_piece == piece)
        own = own if len(own) else np.arange(len(particles))
        mine = np.flatnonzero(gaussian_piece == piece)
        found.append((mine, own, bind(means[mine], particles[own])))
    width = max(bound.indices.shape[1] for _, _, bound in found)
    indices, weights = np.zeros((len(means), width), np.int32), np.zeros((len(means), width), np.float32)
    offsets = np.zeros((len(means), width, 3), np.float32)
    for mine, own, bound in found:
        columns = slice(bound.indices.shape[1])
        indices[mine] = own[0]
        indices[mine, columns] = own[np.asarray(bound.indices)]
        weights[mine, columns], offsets[mine, columns] = bound.weights, bound.offsets
    return Binding(*map(to_device, (indices, weights, offsets), (np.int32, np.float32, np.float32)))


@jax.jit
def deform(
    cloud: GaussianCloud, binding: Binding, x: jax.Array, F: jax.Array, pre_rotation: np.ndarray | jax.Array
) -> Splats:
    """Move and deform a cloud with its particles (PhysGaussian, Xie et al. 2024, eqs. 8 and 9).

    Each bound particle p predicts the Gaussian by its own affine map; the predictions are blended:
    x_g = sum_p w_p (x_p + F_p (X_g - X_p)), F_g = sum_p w_p F_p, Sigma = F_g Sigma_0 F_g^T. An affine motion
    of all particles therefore moves the Gaussians by exactly that motion.

    SH coefficients stay as they are: `Splats.rotations` = polar(F_g) pre_rotation lets the renderer rotate
    the view direction instead, which is the same to any degree. Where det F_g < 0 the rotation is the
    nearest proper one, see `polar_rotation`. Colours of degree 0 are the same from everywhere: the rotations
    are not computed then, and are all ``pre_rotation``.

    Args:
        cloud: The rest cloud, in the frame of the particles' rest positions.
        binding: From `bind`, in the same rest pose.
        x: Particle positions [m], shape (n, 3).
        F: Deformation gradients of the particles since the rest pose, shape (n, 3, 3).
        pre_rotation: Rotation from the frame in which the SH were captured to the cloud's, shape (3, 3).
    """
    # Full precision: GPUs would otherwise round single precision products to ten bits.
    einsum = functools.partial(jnp.einsum, precision="highest")
    if binding.indices.shape[1] == 1:
        nearest = binding.indices[:, 0]
        F_g = F[nearest]
        means = x[nearest] + einsum("gij,gj->gi", F_g, binding.offsets[:, 0])
    else:
        F_near = F[binding.indices]
        predictions = x[binding.indices] + einsum("gkij,gkj->gki", F_near, binding.offsets)
        means = einsum("gk,gki->gi", binding.weights, predictions)
        F_g = einsum("gk,gkij->gij", binding.weights, F_near)
    captured = jnp.asarray(pre_rotation, F_g.dtype)
    if cloud.sh.shape[1] == 1:
        rotations = jnp.broadcast_to(captured, F_g.shape)
    else:
        rotations = einsum("gij,jk->gik", polar_rotation(F_g), captured)
    return Splats(
        means=means,
        covariances=transform_covariances(F_g, quats_scales_to_covariances(cloud.quats, cloud.scales)),
        opacities=cloud.opacities,
        sh=cloud.sh,
        rotations=rotations,
    )
