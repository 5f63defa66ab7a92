"""Linear elasticity on the grid nodes under particles: small displacements that answer forces.

The same nodes, weights and gradients as the simulation's (`mpm.transfer`), as sparse matrices in double precision;
where there are many particles, equations are solved by the transfers themselves (`scene.conjugate`), and where that
takes long, because parts are thin, by a factorisation (`scene.stiffness`). Node motions that no particle's strain sees
are tied to the linear field of each particle over them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np
from scipy.sparse import bsr_matrix, coo_matrix, csr_matrix
from scipy.sparse.csgraph import connected_components

from physagent_jax.core.arrays import to_device
from physagent_jax.mpm.kernels import use_cpu
from physagent_jax.scene import conjugate
from physagent_jax.scene.stiffness import MOST_WORK, assemble, factorise

TIE = 0.002  # stiffness against motions of nodes that no particle's strain sees, over that of the material
INNER_ROUNDS = 500  # of conjugate gradients
INNER_SHARE = 0.02  # of the residual that they leave
PATIENCE = 150  # rounds after which a factorisation is the shorter way where parts are thin
FEW = 30  # rounds that take as long as another factorisation
WORTH_COMPILING = 8000  # particles from which on conjugate gradients are a compiled program
LEAST_MASS = 1e-4  # of the mean node's: lighter ones on the fringe carry nothing that particles feel


class GridElasticity:
    """The elastic forces of a body at its nodes.

    Attributes:
        weight: Particles x nodes, the interpolation weights, and ``spread`` its transpose.
        gradient: 3 particles x nodes, dH/du of the displacement gradient, and ``divergence`` its transpose.
        height: Height of the nodes above the domain's lower face [m], shape (m,).
        mass: Mass of the nodes [kg], shape (m,).
        dx: Their distance [m].
        light: Nodes that carry nothing, shape (m,).
    """

    def __init__(
        self, x, volume, mass, mu, lam, *, dx: float, form: str, share: float = INNER_SHARE, tie: float = TIE
    ):
        """Arrays of one entry per particle in SI units; ``form`` is `Model.stress_form`; others as their defaults."""
        x = np.asarray(x, np.float64)
        self._x, self._form = x, form
        self._volume, self._mu, self._lam = (np.asarray(each, np.float64) for each in (volume, mu, lam))
        self._share, self.dx = share, dx
        nodes, weights, reach = _make_stencil(x, dx, form)
        flat = (nodes[..., 0] * 2**20 + nodes[..., 1]) * 2**20 + nodes[..., 2]
        unique, inverse = np.unique(flat, return_inverse=True)
        count, inverse = len(x), inverse.reshape(len(x), -1)
        rows = np.repeat(np.arange(count), inverse.shape[1])
        shape = (count, len(unique))
        self._stencil = inverse, weights, reach
        self.factors: Callable[[np.ndarray], np.ndarray] | None = None
        self.weight = csr_matrix((weights.ravel(), (rows, inverse.ravel())), shape)
        rows = (3 * np.arange(count)[:, None, None] + np.arange(3)).repeat(inverse.shape[1], 1)
        columns = np.repeat(inverse[..., None], 3, axis=2)
        self.gradient = csr_matrix((reach.ravel(), (rows.ravel(), columns.ravel())), (3 * count, len(unique)))
        self.spread, self.divergence = csr_matrix(self.weight.T), csr_matrix(self.gradient.T)
        self._nodes = np.stack([unique >> 40, (unique >> 20) % 2**20, unique % 2**20], axis=-1)
        self.height = self._nodes[:, 2] * dx
        self._particle_mass = np.asarray(mass, np.float64)
        self.mass = self.spread @ self._particle_mass
        self.light = self.mass < LEAST_MASS * self.mass.mean()
        self._tie = tie * self._volume * (self._lam + 2 * self._mu) * 4 / dx**2
        self._tied = (self.spread @ self._tie)[:, None]
        self._slope_stiffness = 0.25 * dx**2 * np.repeat(self._tie, 3)[:, None]
        self._diagonal = self._find_diagonal()

    def find_gradient(self, u) -> np.ndarray:
        """Displacement gradients of the particles, shape (n, 3, 3), for displacements of the nodes (m, 3) [m]."""
        # H[p, a, b] = sum u_a g_b
        return (self.gradient @ u).reshape(-1, 3, 3).transpose(0, 2, 1)

    def compute_force(self, tau) -> np.ndarray:
        """Forces at the nodes (m, 3) [N] of Kirchhoff stresses (n, 3, 3) [Pa]."""
        return self.divergence @ (self._volume[:, None, None] * tau).reshape(-1, 3)

    def compute_stress(self, u) -> np.ndarray:
        """Linear elasticity's stresses (n, 3, 3) [Pa] for displacements ``u`` of the nodes [m]."""
        return self._find_stress(self.gradient @ u)

    def apply_stiffness(self, u) -> np.ndarray:
        """Linear elasticity's forces at the nodes (m, 3) [N] for displacements ``u`` [m], and the tie's."""
        slopes = self.gradient @ u
        stress = self._volume[:, None, None] * self._find_stress(slopes)
        return self.divergence @ (stress.reshape(-1, 3) - self._slope_stiffness * slopes) + self._tie_nodes(u)

    def find_strain(self, stress) -> np.ndarray:
        """The linear strains (n, 3, 3) of stresses [Pa]: the inverse law."""
        trace = np.trace(stress, axis1=1, axis2=2)
        share = self._lam / (2 * self._mu + 3 * self._lam) * trace
        strain = stress.copy()
        strain[:, range(3), range(3)] -= share[:, None]
        return strain / (2 * self._mu)[:, None, None]

    def _find_stress(self, slopes) -> np.ndarray:
        H = slopes.reshape(-1, 3, 3)  # transposed; the stress is symmetric
        stress = self._mu[:, None, None] * (H + H.transpose(0, 2, 1))
        stress[:, range(3), range(3)] += (self._lam * np.trace(H, axis1=1, axis2=2))[:, None]
        return stress

    def _tie_nodes(self, u) -> np.ndarray:
        return self._tied * u - self.spread @ (self._tie[:, None] * (self.weight @ u))

    def measure_accelerations(self, force) -> tuple[float, float]:
        """Accelerations [m/s^2] of particles by ``force`` (m, 3) [N]: root mean square by mass, largest but 1 %."""
        felt = np.linalg.norm(self.weight @ (force / np.maximum(self.mass, 1e-30)[:, None]), axis=1)
        mean = np.sqrt(np.average(felt**2, weights=self._particle_mass))
        return float(mean), float(np.percentile(felt, 99))

    def measure_work(self, force) -> float:
        """Root of the work [J] that ``force`` (m, 3) [N] could do if each node moved alone."""
        return float(np.sqrt((force**2 / self._diagonal).sum()))

    def find_borne(self, support) -> np.ndarray:
        """Nodes that particles join to one of ``support``, shape (m,)."""
        count, nodes = self.weight.get_shape()
        joined = coo_matrix(self.weight)
        graph = coo_matrix(
            (np.ones(joined.nnz), (joined.row, count + joined.col)), shape=(count + nodes,) * 2
        )
        labels = connected_components(graph, directed=False)[1][count:]
        return np.isin(labels, np.unique(labels[support]))

    def solve(self, force, free, rounds: int = INNER_ROUNDS) -> tuple[np.ndarray, int]:
        """Displacements [m] that answer ``force`` [N], by conjugate gradients, and how many rounds these took.

        Args:
            force: Shape (m, 3), zero where nothing can move.
            free: Components that can move, shape (m, 3).
            rounds: At most.
        """
        if self.factors is None:
            wait = min(rounds, PATIENCE) if self._is_thin(free) else rounds
            if len(self._x) >= WORTH_COMPILING:
                u, done = self._solve_compiled(force, free, wait)
            else:
                u, done = self._iterate(force, free, wait)
            if done < wait or wait == rounds:
                return u, done
            self.factorise(free)
        u, done = self._iterate(force, free, min(rounds, FEW), self.factors)
        if done == FEW < rounds:  # what is free has changed too much
            self.factorise(free)
            u, more = self._iterate(force, free, min(rounds, FEW), self.factors)
            done += more
        return u, done

    def _is_thin(self, free) -> bool:
        """Return whether factorising takes less time than many rounds: a front of nodes passes through the body."""
        nodes = self._nodes[free.any(axis=1)]
        if not len(nodes):
            return False
        widest = min(np.bincount(each - each.min()).max() for each in nodes.T)
        return free.sum() * float(6 * widest) ** 2 <= MOST_WORK

    def factorise(self, free) -> Callable[[np.ndarray], np.ndarray]:
        """The inverse of the stiffness of the components that are ``free``, shape (m, 3); `solve` makes use of it."""
        self._factored = np.asarray(free)
        self.factors = factorise(self.matrix, self._factored)
        return self.factors

    @cached_property
    def matrix(self) -> bsr_matrix:
        """The matrix of `apply_stiffness`, components of a node together, shape (3 m, 3 m) [N/m]."""
        mu, lam, slope = self._volume * self._mu, self._volume * self._lam, self._slope_stiffness[::3, 0]
        return assemble(*self._stencil, mu, lam, self._tie, slope, self._tied[:, 0])

    def _iterate(self, force, free, rounds: int, factors: Callable | None = None) -> tuple[np.ndarray, int]:
        """`solve` in double precision; ``factors`` are those of about the same free components."""

        def precondition(r):
            if factors is None:
                return r / self._diagonal
            return np.where(free, np.where(self._factored, factors(r), r / self._diagonal), 0.0)

        def apply(p):
            if factors is None:
                return np.where(free, self.apply_stiffness(p), 0.0)
            return np.where(free, (self.matrix @ p.ravel()).reshape(p.shape), 0.0)

        x, r = np.zeros_like(force), force.copy()
        z = precondition(r)
        p, rz = z.copy(), (r * z).sum()
        enough = self._share**2 * rz
        done = 0
        while rz > enough and done < rounds:
            done += 1
            answer = apply(p)
            curvature = (p * answer).sum()
            if curvature <= 0:
                break
            alpha = rz / curvature
            x, r = x + alpha * p, r - alpha * answer
            z = precondition(r)
            rz, before = (r * z).sum(), rz
            p = z + (rz / before) * p
        return x, done

    def _solve_compiled(self, force, free, rounds: int) -> tuple[np.ndarray, int]:
        """`solve` in single precision, by the simulation's transfers."""
        stiffness, place = self._stiffness

        def spread(values, fill=0.0):
            out = np.full((*stiffness.grid.shape, values.shape[-1]), fill, values.dtype)
            out[place] = values
            return out

        # In single precision the square of a small force is none.
        scale = np.abs(force).max() or 1.0
        u, done = conjugate.solve(
            stiffness,
            to_device(spread(force / scale), np.float32),
            to_device(spread(free, False)),
            np.float32(self._share),
            np.int32(rounds),
        )
        return np.asarray(u, np.float64)[place] * scale, int(done)

    @cached_property
    def _stiffness(self) -> tuple[conjugate.Stiffness, tuple]:
        """For `_solve_compiled`, and where the nodes lie in its window."""
        grid = conjugate.make_window(self._nodes, self.dx)
        place = tuple((self._nodes - np.asarray(grid.origin)).T)
        tied, diagonal = np.zeros((*grid.shape, 1)), np.ones((*grid.shape, 3))
        tied[place], diagonal[place] = self._tied, self._diagonal
        arrays = dict(
            x=self._x,
            mu=self._volume * self._mu,
            lam=self._volume * self._lam,
            tie=self._tie,
            slope=self._slope_stiffness[::3, 0],
            tied=tied,
            diagonal=diagonal,
        )
        on_device = {name: to_device(each, np.float32) for name, each in arrays.items()}
        return conjugate.Stiffness(grid=grid, form=self._form, cpu=use_cpu(), **on_device), place

    def _find_diagonal(self) -> np.ndarray:
        squared = self.divergence.multiply(self.divergence).tocsr()  # nodes x (particle, axis)
        mu, lam = self._volume * self._mu, self._volume * self._lam
        columns = []
        for axis in range(3):
            weight = np.repeat(mu[:, None], 3, axis=1)
            weight[:, axis] += mu + lam
            columns.append(squared @ weight.ravel())
        return np.maximum(np.stack(columns, axis=1) + self._tied, 1e-30)


def _make_stencil(x: np.ndarray, dx: float, form: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes (n, 27, 3), weights (n, 27) and g_ip [1/m] (n, 27, 3) of particles at ``x``, as `mpm.transfer` has them."""
    scaled = x / dx
    low = np.floor(scaled - 0.5)
    f = scaled - low
    weights = np.stack([0.5 * (1.5 - f) ** 2, 0.75 - (f - 1.0) ** 2, 0.5 * (f - 0.5) ** 2], axis=-1)
    slopes = np.stack([f - 1.5, 2.0 - 2.0 * f, f - 0.5], axis=-1) / dx
    grid = np.stack(np.meshgrid(*[np.arange(3)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    each = np.stack([weights[:, axis, grid[:, axis]] for axis in range(3)], axis=-1)
    weight = each.prod(-1)
    if form == "mls":
        offset = (grid[None] - f[:, None]) * dx
        reach = (4 / dx**2) * weight[..., None] * offset
    else:
        slope = np.stack([slopes[:, axis, grid[:, axis]] for axis in range(3)], axis=-1)
        others = np.stack(
            [each[..., 1] * each[..., 2], each[..., 0] * each[..., 2], each[..., 0] * each[..., 1]], -1
        )
        reach = slope * others
    return low[:, None].astype(np.int64) + grid, weight, reach
