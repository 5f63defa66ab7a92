"""The stiffness matrix of particles at their grid nodes, assembled and factorised.

Conjugate gradients take thousands of rounds where parts are thin, and it is there that a factorisation is cheap: few
nodes have neighbours on all sides. Particles over the same nodes are summed up as one dense block, so that assembling
takes no longer for many particles in a cell than for few.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import bsr_matrix, csc_matrix
from scipy.sparse.linalg import splu

MOST_WORK = 2e10  # components times the square of those in a front, that are factorised in seconds
_LEAST_RELATIVE = 1e-12  # of the mean diagonal, added where nothing else is


def assemble(inverse, weight, reach, mu, lam, tie, slope, tied) -> bsr_matrix:
    """The matrix K of `GridElasticity.apply_stiffness`, components of a node together, shape (3 m, 3 m) [N/m].

    Args:
        inverse: Nodes under each particle, shape (n, s).
        weight: Interpolation weights, shape (n, s).
        reach: Gradients g_ip [1/m], shape (n, s, 3).
        mu: Shear modulus times volume [J], shape (n,).
        lam: First Lame parameter times volume [J], shape (n,).
        tie: Stiffness of the tie [N/m], shape (n,).
        slope: Its stiffness against the slope of each particle [J], shape (n,).
        tied: Sum of the ties at the nodes [N/m], shape (m,).
    """
    count, size = inverse.shape
    nodes, eye = len(tied), np.eye(3)
    order = np.argsort(inverse[:, 0], kind="stable")  # the first node tells all
    starts = np.flatnonzero(np.r_[True, np.diff(inverse[order, 0]) != 0])
    blocks = np.empty((len(starts), size, size, 3, 3))
    for index, (start, end) in enumerate(zip(starts, np.r_[starts[1:], count])):
        own = order[start:end]
        g, w = reach[own].reshape(len(own), -1), weight[own]
        sheared, pressed, sloped = (
            ((each[own, None] * g).T @ g).reshape(size, 3, size, 3) for each in (mu, lam, slope)
        )
        scalar = np.trace(sheared - sloped, axis1=1, axis2=3) - (tie[own, None] * w).T @ w
        blocks[index] = sheared.transpose(0, 2, 3, 1) + pressed.transpose(0, 2, 1, 3)
        blocks[index] += scalar[:, :, None, None] * eye
    each = inverse[order[starts]].astype(np.int64)
    pairs, place = np.unique((each[:, :, None] * nodes + each[:, None, :]).ravel(), return_inverse=True)
    place = place.ravel()
    data = np.empty((len(pairs), 3, 3))
    for i in range(3):
        for j in range(3):
            data[:, i, j] = np.bincount(place, blocks[..., i, j].ravel(), len(pairs))
    rows, columns = np.divmod(pairs, nodes)
    own = rows == columns
    data[own] += tied[rows[own], None, None] * eye
    pointers = np.searchsorted(rows, np.arange(nodes + 1))
    return bsr_matrix((data, columns, pointers), shape=(3 * nodes, 3 * nodes))


def factorise(matrix: bsr_matrix, free: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """A function from forces (m, 3) [N] to the displacements [m] of the components that are ``free``, shape (m, 3)."""
    index = np.flatnonzero(free.ravel())
    part = csc_matrix(matrix.tocsr()[index][:, index])
    part.setdiag(part.diagonal() + _LEAST_RELATIVE * part.diagonal().mean())
    factors = splu(part, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=dict(SymmetricMode=True))

    def solve(force: np.ndarray) -> np.ndarray:
        u = np.zeros(free.size)
        u[index] = factors.solve(force.ravel()[index])
        return u.reshape(free.shape)

    return solve
