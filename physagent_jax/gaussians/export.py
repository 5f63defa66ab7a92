"""Deformed splats as a cloud again, for files and viewers."""

from __future__ import annotations

import operator

import jax
import numpy as np

from physagent_jax.core.arrays import to_device
from physagent_jax.gaussians.cloud import GaussianCloud, Splats
from physagent_jax.gaussians.covariance import decompose_covariances
from physagent_jax.gaussians.sh import rotate_sh


def splats_to_cloud(splats: Splats) -> GaussianCloud:
    """A cloud that an ordinary 3DGS viewer shows as the renderer shows the splats. Runs on the host.

    What a compiled scene is filled up with to a handy size, Gaussians of no opacity at the end, is left out.
    Covariances are decomposed into quaternions and scales, and the SH coefficients are rotated into the
    world frame, in which a viewer evaluates them.

    Args:
        splats: Gaussians in world space.
    """
    splats = jax.tree.map(operator.itemgetter(slice(_count_drawn(splats.opacities))), splats)
    quats, scales = decompose_covariances(splats.covariances)
    return GaussianCloud(
        means=splats.means,
        quats=to_device(quats, np.float32),
        scales=to_device(scales, np.float32),
        opacities=splats.opacities,
        sh=rotate_sh(splats.sh, splats.rotations),
    )


def _count_drawn(opacities: jax.Array) -> int:
    """The number of Gaussians up to the last visible one."""
    return int(np.flatnonzero(np.asarray(opacities)).max(initial=-1)) + 1
