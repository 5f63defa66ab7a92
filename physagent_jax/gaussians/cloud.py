"""3D Gaussians as pytrees: the captured cloud, and the deformed splats that the renderer draws."""

from __future__ import annotations

import dataclasses
import math

import jax
import numpy as np

from physagent_jax.core.pytree import register_dataclass


@register_dataclass
@dataclasses.dataclass(frozen=True)
class GaussianCloud:
    """A static 3D Gaussian splatting object (Kerbl et al. 2023), in linear units.

    Attributes:
        means: Centres [m], shape (n, 3).
        quats: Unit quaternions wxyz, shape (n, 4).
        scales: Standard deviations along the local axes [m], shape (n, 3).
        opacities: In [0, 1], shape (n,).
        sh: Spherical harmonics coefficients, shape (n, (degree + 1)**2, 3); colour = SH + 0.5.
    """

    means: jax.Array
    quats: jax.Array
    scales: jax.Array
    opacities: jax.Array
    sh: jax.Array

    @property
    def count(self) -> int:
        """Number of Gaussians."""
        return self.means.shape[0]

    @property
    def sh_degree(self) -> int:
        """Degree of the spherical harmonics, 0 to 3."""
        return round(self.sh.shape[1] ** 0.5) - 1

    def of_least_degree(self) -> GaussianCloud:
        """The same colours with the least degree that has them: bands that are zero for all Gaussians are left out."""
        used = np.flatnonzero(np.asarray(self.sh).any(axis=(0, 2)))
        degree = math.isqrt(int(used.max(initial=0)))
        return dataclasses.replace(self, sh=self.sh[:, : (degree + 1) ** 2])


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Splats:
    """Gaussians in world space at one instant, as the renderer takes them.

    Attributes:
        means: Centres [m], shape (n, 3).
        covariances: Upper triangles (xx, xy, xz, yy, yz, zz) [m^2], shape (n, 6).
        opacities: In [0, 1], shape (n,).
        sh: Coefficients in the frame in which the cloud was captured, shape (n, k, 3).
        rotations: Rotation from that captured frame to the world, shape (n, 3, 3): the polar factor of F
            times the scene's pre-rotation. View directions are rotated back by it before SH evaluation.
    """

    means: jax.Array
    covariances: jax.Array
    opacities: jax.Array
    sh: jax.Array
    rotations: jax.Array
