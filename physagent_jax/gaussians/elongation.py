"""Gaussians that a deformation has drawn out into needles, shortened again: for pictures that people look at."""

from __future__ import annotations

import dataclasses

import jax.numpy as jnp
import numpy as np

from physagent_jax.gaussians.cloud import Splats
from physagent_jax.gaussians.covariance import covariance_matrices

EASY_STRETCH = 1.3  # times the longest standard deviation at rest; up to there nothing is shortened
MOST_STRETCH = 2.0  # times that; farther apart, neighbours no longer make a surface
MOST_RATIO = 4.0  # of the longest to the middle one, unless it was more at rest
MOST_SHARE = 0.04  # of the object's size that a standard deviation may reach by being stretched


def cap_elongation(splats: Splats, rest_scales: np.ndarray, size: float) -> Splats:
    """Shorten the axes of Gaussians that are far longer than at rest; those that are as at rest stay as they are.

    F Sigma F^T (PhysGaussian, Xie et al. 2024) follows a stretch that matter takes by coming apart between Gaussians,
    not within them. Xie et al. bound the ratio of the axes when the capture is trained; here it is done to what is
    drawn, whatever the capture.

    Args:
        splats: Deformed.
        rest_scales: Standard deviations at rest [m], shape (n, 3).
        size: The object's longest side [m].

    Returns:
        The same Gaussians; no axis is longer than `EASY_STRETCH` times the longest at rest and also longer than
        `MOST_STRETCH` times that, `MOST_SHARE` of ``size``, or `MOST_RATIO` times the middle one.
    """
    rest = np.sort(np.asarray(rest_scales, np.float64), axis=1)
    covariances = np.asarray(splats.covariances)
    rest_ratio, easy = rest[:, 2] / np.maximum(rest[:, 1], 1e-12), EASY_STRETCH * rest[:, 2]
    limit = np.maximum(easy, np.minimum(MOST_STRETCH * rest[:, 2], MOST_SHARE * size))
    scales = np.sqrt(np.maximum(_compute_eigenvalues(covariances), 0))
    along_first = _limit_first(scales, easy, rest_ratio, limit)
    capped = scales[:, 2] > along_first * (1 + 1e-4)
    if not capped.any():
        return splats
    eigenvalues, axes = np.linalg.eigh(covariance_matrices(covariances[capped]))
    scales = np.sqrt(np.maximum(eigenvalues, 0))
    first = _limit_first(scales, easy[capped], rest_ratio[capped], limit[capped])
    scales = np.minimum(scales, limit[capped][:, None])
    scales[:, 2] = np.minimum(scales[:, 2], first)
    sigma = np.einsum("nij,nj,nkj->nik", axes, scales**2, axes)
    shortened = covariances.copy()
    shortened[capped] = sigma[:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]
    return dataclasses.replace(splats, covariances=jnp.asarray(shortened))


def _limit_first(
    scales: np.ndarray, easy: np.ndarray, rest_ratio: np.ndarray, limit: np.ndarray
) -> np.ndarray:
    """The largest allowed length of the longest axis [m], shape (n,); ``scales`` ascending, shape (n, 3)."""
    by_ratio = np.maximum(MOST_RATIO, rest_ratio) * np.minimum(scales[:, 1], limit)
    return np.maximum(easy, np.minimum(limit, by_ratio))


def _compute_eigenvalues(covariances: np.ndarray) -> np.ndarray:
    """Of symmetric matrices, ascending, shape (n, 3): in closed form, which is fast enough for every frame.

    Smith, "Eigenvalues of a symmetric 3 x 3 matrix", Communications of the ACM 4 (1961).
    """
    xx, xy, xz, yy, yz, zz = np.asarray(covariances, np.float64).T
    mean = (xx + yy + zz) / 3
    a, b, c = xx - mean, yy - mean, zz - mean
    spread = np.sqrt((a * a + b * b + c * c + 2 * (xy * xy + xz * xz + yz * yz)) / 6)
    determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    cosine = np.clip(determinant / (2 * np.maximum(spread, 1e-100) ** 3), -1, 1)
    angle = np.arccos(cosine) / 3
    first = mean + 2 * spread * np.cos(angle)
    third = mean + 2 * spread * np.cos(angle + 2 * np.pi / 3)
    return np.stack([third, 3 * mean - first - third, first], axis=1)
