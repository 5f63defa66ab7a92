"""Conjugate gradients for linear elasticity on the grid, as one compiled program of the simulator's own transfers.

Stiffness times displacement is a G2P, a law and a P2G, in single precision: three to four milliseconds for 20,000
particles where sparse matrices take 14. That is enough for one solve; whoever wants more digits computes what is left
and solves for it.
"""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from physagent_jax.core.arrays import to_device
from physagent_jax.core.pytree import register_dataclass
from physagent_jax.mpm import Grid, transfer
from physagent_jax.mpm.kernels import load_cpu_kernels

ROUND_UP = (
    8  # nodes, to which the window's sides are rounded, so that objects of about a size share a program
)


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Stiffness:
    """The parts of the stiffness matrix; see `scene.elasticity` for the tie.

    Attributes:
        grid: The window; ``form`` is `Model.stress_form`.
        x: Positions [m], shape (n, 3).
        mu, lam: Lame parameters times volume [J], shape (n,).
        tie, slope: Stiffness that ties nodes to the linear field of a particle [N/m], and against its slope [J].
        tied: Sum of the ties at the nodes [N/m], shape (nx, ny, nz, 1).
        diagonal: Diagonal of the matrix [N/m], shape (nx, ny, nz, 3).
        cpu: Whether the CPU kernels do the transfers; static, so that the choice is part of the program.
    """

    grid: Grid
    x: jax.Array
    mu: jax.Array
    lam: jax.Array
    tie: jax.Array
    slope: jax.Array
    tied: jax.Array
    diagonal: jax.Array
    form: str = dataclasses.field(metadata=dict(static=True))
    cpu: bool = dataclasses.field(metadata=dict(static=True))

    def apply(self, u: jax.Array) -> jax.Array:
        """Forces [N] of displacements ``u`` [m] of the nodes, both (nx, ny, nz, 3)."""
        x, grid, n = self.x, self.grid, len(self.x)
        kernels = load_cpu_kernels() if self.cpu else transfer
        zero, one, none = jnp.zeros((n, 3, 3)), jnp.ones(n), jnp.zeros(3)
        # F = I + dt grad u loses digits where grad u is small: u is moved to the scale of a cell before.
        scale = grid.dx / jnp.maximum(jnp.abs(u).max(), 1e-30)
        unstrained = jnp.broadcast_to(jnp.eye(3), (n, 3, 3))
        moved = kernels.g2p(self.form, 1, grid, x, none + 0 * x, zero, unstrained, scale * u, jnp.float32(1))
        slopes = moved.F - unstrained
        strain = slopes + slopes.transpose(0, 2, 1)
        pressure = self.lam * jnp.trace(slopes, axis1=1, axis2=2)
        stress = self.mu[:, None, None] * strain + pressure[:, None, None] * jnp.eye(3)
        stress = stress - self.slope[:, None, None] * slopes
        out = kernels.p2g(self.form, grid, x, -moved.v, zero, stress, self.tie, one, none, jnp.float32(-1))
        return out[..., :3] / scale + self.tied * u


def make_window(nodes: np.ndarray, dx: float) -> Grid:
    """A window over all of ``nodes``, int (m, 3), of a domain with cells of ``dx`` [m]."""
    low, high = nodes.min(0), nodes.max(0) + 1
    shape = tuple(int(-(-side // ROUND_UP) * ROUND_UP) for side in high - low)
    return Grid(to_device(low.astype(np.int32)), shape, dx, int(low.max()) + max(shape))  # type: ignore[arg-type]


@jax.jit
def solve(stiffness: Stiffness, force: jax.Array, free: jax.Array, share, rounds):
    """Displacements [m] that answer ``force`` [N], and how many rounds these took.

    Args:
        stiffness: Stiffness of the body.
        force: Shape (nx, ny, nz, 3), zero where nothing can move.
        free: Components that can move, of the same shape.
        share: Share of the residual, measured by the diagonal's inverse, that is left.
        rounds: At most.
    """

    def measure(r):
        return (r * r / stiffness.diagonal).sum()

    def go_on(carry):
        _, _, _, rz, curvature, done = carry
        return (rz > enough) & (curvature > 0) & (done < rounds)

    def iterate(carry):
        x, r, p, rz, _, done = carry
        answer = jnp.where(free, stiffness.apply(p), 0.0)
        curvature = (p * answer).sum()
        alpha = jnp.where(curvature > 0, rz / curvature, 0.0)
        x, r = x + alpha * p, r - alpha * answer
        after = measure(r)
        return x, r, r / stiffness.diagonal + after / rz * p, after, curvature, done + 1

    rz = measure(force)
    enough = share**2 * rz
    first = jnp.zeros_like(force), force, force / stiffness.diagonal, rz, jnp.float32(1), jnp.int32(0)
    x, _, _, _, _, done = lax.while_loop(go_on, iterate, first)
    return x, done
