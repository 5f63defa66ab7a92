"""The inside of an object in pictures for people: Gaussians at filled particles, which a tear lays open.

A capture, or a sampled mesh, is a skin around nothing. Where it comes apart one would see through. What is seen there
has the colour of the skin nearest to it. As long as nothing comes apart, the skin hides all of it, and it is left out.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from physagent_jax.core.arrays import to_device
from physagent_jax.gaussians.binding import Binding
from physagent_jax.gaussians.cloud import GaussianCloud
from physagent_jax.scene.body import Body

RADIUS = 0.45  # standard deviation over the spacing of particles: the least that leaves no gaps
ROOM = 2.5  # standard deviations from the skin, so that none sticks out of it
DEEP = 0.5  # [spacings] from the skin at least; what is nearer is skin
SOLID = 0.98  # opacity
APART = 1.5  # times the distance at rest, from which on two neighbours have come apart
FEW = 0.002  # share of the neighbours for which that does not count
MOST_PAIRED, NEIGHBOURS = 4000, 6  # particles whose neighbours are looked at, and how many of these


def comes_apart(x: np.ndarray) -> bool:
    """Return whether particles that were neighbours part in any frame, by more than a few of them.

    Distances tell this for every material; a plastic one forgets its deformation gradient.

    Args:
        x: Positions [m], shape (T, n, 3).
    """
    count = x.shape[1]
    if count <= NEIGHBOURS:
        return False
    chosen = np.arange(0, count, -(-count // MOST_PAIRED))
    tree: Any = KDTree(x[0])  # scipy annotates `query` for a single neighbour only
    rest, near = tree.query(x[0][chosen], k=np.arange(2, NEIGHBOURS + 2))
    for frame in x[1:]:
        length = np.linalg.norm(frame[near] - frame[chosen][:, None], axis=2)
        if (length > APART * rest).mean() > FEW:
            return True
    return False


def add_inside(cloud: GaussianCloud, body: Body) -> tuple[GaussianCloud, Binding]:
    """The Gaussians of a body's skin and, after them, round ones at the filled particles within.

    Args:
        cloud: The skin, as it is shown, in the order of ``body.cloud``.
        body: The object at rest.

    Returns:
        The Gaussians, and what they follow: each of the inside its own particle.
    """
    particles, binding, means = body.particles, body.binding, np.asarray(cloud.means)
    filled = np.flatnonzero(np.zeros(0) if particles.enclosed is None else particles.enclosed)
    spacing = np.cbrt(particles.volume[filled])
    depth, nearest = KDTree(means).query(particles.x[filled])
    within = depth > DEEP * spacing
    filled, nearest = filled[within], np.asarray(nearest)[within]
    radius = np.minimum(RADIUS * spacing, depth / ROOM)[within]
    sh = np.zeros((len(filled), *cloud.sh.shape[1:]), np.float32)
    sh[:, 0] = np.asarray(cloud.sh)[nearest, 0]
    inside = GaussianCloud(
        means=particles.x[filled],  # type: ignore[arg-type]
        quats=np.tile(np.float32([1, 0, 0, 0]), (len(filled), 1)),  # type: ignore[arg-type]
        scales=np.repeat(radius[:, None], 3, axis=1),  # type: ignore[arg-type]
        opacities=np.full(len(filled), SOLID),  # type: ignore[arg-type]
        sh=sh,  # type: ignore[arg-type]
    )
    bound = binding.indices.shape[1]
    follows = Binding(
        indices=np.repeat(filled[:, None], bound, axis=1),  # type: ignore[arg-type]
        weights=np.eye(1, bound).repeat(len(filled), axis=0),  # type: ignore[arg-type]
        offsets=np.zeros((len(filled), bound, 3)),  # type: ignore[arg-type]
    )
    return _join(cloud, inside), _join(binding, follows)


def _join(first: Any, second: Any) -> Any:
    """The rows of two arrays of structures, one after the other, each in the type of the first."""
    return type(first)(
        **{
            field.name: to_device(
                np.concatenate([np.asarray(getattr(each, field.name)) for each in (first, second)]),
                getattr(first, field.name).dtype,
            )
            for field in dataclasses.fields(first)
        }
    )
