"""Particle-to-grid and grid-to-particle transfers with quadratic B-splines (Jiang et al. 2016, section 7).

One window of 3x3x3 nodes is scattered (gathered) per particle as a whole: XLA on CPU handles that an
order of magnitude faster than 27 single updates per particle.
"""

from __future__ import annotations

import dataclasses
from functools import partial

import jax
import jax.numpy as jnp
from jax import lax
from jax.ad_checkpoint import checkpoint_name

from physagent_jax.core.pytree import register_dataclass
from physagent_jax.kernels import find_platform
from physagent_jax.mpm.health import Health, measure_health
from physagent_jax.mpm.linalg import matmul
from physagent_jax.mpm.state import Grid

STOPPED = "stopped"
"""Name for `jax.checkpoint_policies`: which particles were stopped at a wall."""


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Stencil:
    """The grid nodes and weights of each particle.

    Attributes:
        base: Window index of the lowest of the three nodes per axis, int32, shape (n, 3).
        weights: B-spline weights per axis and node, shape (n, 3, 3).
        offsets: Node minus particle position per axis and node [m], shape (n, 3, 3).
        slopes: d weight / d particle position per axis and node [1/m], shape (n, 3, 3).
    """

    base: jax.Array
    weights: jax.Array
    offsets: jax.Array
    slopes: jax.Array

    def take(self, particles: jax.Array) -> Stencil:
        """The stencils of some particles."""
        return jax.tree.map(lambda leaf: leaf[particles], self)

    def place_particles(self, grid: Grid) -> jax.Array:
        """Positions of the particles [m], shape (n, 3)."""
        return (self.base + grid.origin) * grid.dx - self.offsets[..., 0]


def stencil(x: jax.Array, grid: Grid) -> Stencil:
    """Quadratic B-spline stencils of particles at ``x`` [m], shape (n, 3)."""
    scaled = x / grid.dx
    low = jnp.floor(scaled - 0.5)
    f = scaled - low  # distance to the lowest node in cells, in [0.5, 1.5)
    weights = jnp.stack([0.5 * (1.5 - f) ** 2, 0.75 - (f - 1.0) ** 2, 0.5 * (f - 0.5) ** 2], axis=-1)
    slopes = jnp.stack([f - 1.5, 2.0 - 2.0 * f, f - 0.5], axis=-1) / grid.dx
    offsets = (jnp.arange(3, dtype=x.dtype) - f[..., None]) * grid.dx
    return Stencil(low.astype(jnp.int32) - grid.origin, weights, offsets, slopes)


def scatter_momentum(
    s: Stencil,
    grid: Grid,
    mass: jax.Array,
    momentum: jax.Array,
    affine: jax.Array,
    impulse: jax.Array | None = None,
) -> jax.Array:
    """Scatter mass and momentum; node i gets w_i (momentum + affine (x_i - x)) + impulse grad w_i and w_i mass.

    Args:
        s: Stencils of the n particles.
        grid: The window; particles outside it deposit on its rim (`simulate` notices and redoes the frame).
        mass: [kg], shape (n,).
        momentum: [kg m/s], shape (n, 3).
        affine: m C plus, in MLS-MPM, the stress impulse (Hu et al. 2018, eq. 29) [kg/s], shape (n, 3, 3).
        impulse: -dt V0 tau for the classical stress form [kg m^2/s], shape (n, 3, 3); None = not used.

    Returns:
        Momentum and mass at the nodes, shape (nx, ny, nz, 4).
    """
    w = _multiply_weights(s.weights)
    slopes = [] if impulse is None else [_multiply_weights(_replace_by_slopes(s, axis)) for axis in range(3)]
    components = []
    for d in range(3):
        q = (
            momentum[:, d, None, None, None]
            + affine[:, d, 0, None, None, None] * s.offsets[:, 0, :, None, None]
            + affine[:, d, 1, None, None, None] * s.offsets[:, 1, None, :, None]
            + affine[:, d, 2, None, None, None] * s.offsets[:, 2, None, None, :]
        )
        q = w * q
        if impulse is not None:
            q = q + sum(impulse[:, d, axis, None, None, None] * slopes[axis] for axis in range(3))
        components.append(q)
    components.append(w * mass[:, None, None, None])
    return _scatter(s.base, jnp.stack(components, axis=-1), grid.shape)


@register_dataclass
@dataclasses.dataclass(frozen=True)
class Moved:
    """Particles after G2P.

    Attributes:
        x, v, C: As in `State`.
        F: Trial deformation gradients, before the return mapping, shape (n, 3, 3).
        health: Extremes over the particles.
    """

    x: jax.Array
    v: jax.Array
    C: jax.Array
    F: jax.Array
    health: Health


def p2g(form: str, grid: Grid, x, v, C, tau, mass, volume, dv, dt) -> jax.Array:
    """`scatter_momentum` of momentum, affine momentum and the impulse -dt V0 tau of the stress, by either stress form.

    Args:
        form: "mls" or "gradient".
        grid: The window.
        x: Positions [m], shape (n, 3).
        v: Velocities [m/s], shape (n, 3).
        C: Affine velocity matrices [1/s], shape (n, 3, 3).
        tau: Kirchhoff stress [Pa], shape (n, 3, 3).
        mass: [kg], shape (n,).
        volume: Rest volume [m^3], shape (n,).
        dv: Added to all velocities [m/s], shape (3,).
        dt: [s].

    Returns:
        Momentum and mass at the nodes, shape (nx, ny, nz, 4).
    """
    s, impulse = stencil(x, grid), -dt * volume[:, None, None] * tau
    momentum, affine = mass[:, None] * (v + dv), mass[:, None, None] * C
    if form == "mls":
        return scatter_momentum(s, grid, mass, momentum, affine + (4 / grid.dx**2) * impulse)
    return scatter_momentum(s, grid, mass, momentum, affine, impulse)


def p2g_apart(form: str, grid: Grid, x, v, C, tau, mass, volume, dv, push, unit, dt) -> jax.Array:
    """As `p2g`, what the particles bring and what this step gives them apart, for `mpm.inertia`.

    The first four numbers of a node are momentum and mass of v + dv and C; the others are the impulse of tau and of
    ``push``, a velocity [m/s] of shape (n, 3) or (1, 3), and sum w m^2 ``unit``, one over a mass [1/kg]; shape
    (nx, ny, nz, 8).
    """
    s, impulse, each = stencil(x, grid), -dt * volume[:, None, None] * tau, mass[:, None]
    brought = scatter_momentum(s, grid, mass, each * (v + dv), each[..., None] * C)
    affine, classical = ((4 / grid.dx**2) * impulse, None) if form == "mls" else (jnp.zeros_like(C), impulse)
    given = scatter_momentum(s, grid, mass * (unit * mass), each * push, affine, classical)
    return jnp.concatenate([brought, given], axis=-1)


def grid_velocity(nodes: jax.Array, least: jax.Array) -> jax.Array:
    """Node velocities [m/s], shape (nx, ny, nz, 3), from momentum and mass; zero where that is not above ``least``."""
    momentum, mass = nodes[..., :3], nodes[..., 3:]
    occupied = mass > least
    return jnp.where(occupied, momentum / jnp.where(occupied, mass, 1.0), 0.0)


def g2p(form: str, wall: int, grid: Grid, x, v, C, F, velocity, dt) -> Moved:
    """`gather_affine`, and the particles moved and deformed with the velocities gathered.

    Args:
        form: Whose velocity gradient deforms: C for "mls", sum v_i (grad w_i)^T for "gradient".
        wall: As in `Model`, for `Health.beyond`.
        grid: The window.
        x: Positions [m], shape (n, 3).
        v: Not used; a kernel may write the new ones in its place.
        C: Not used, as ``v``.
        F: Deformation gradients, shape (n, 3, 3).
        velocity: Node velocities [m/s], shape (nx, ny, nz, 3).
        dt: [s].
    """
    del v, C
    s = stencil(x, grid)
    v, C = gather_affine(s, grid, velocity)
    grad_v = C if form == "mls" else velocity_gradient(s, grid, velocity)
    trial, x = F + dt * matmul(grad_v, F), x + dt * v
    return Moved(x, v, C, trial, measure_health(wall, grid, x, v, trial, dt * grad_v))


@partial(jax.custom_jvp, nondiff_argnums=(0, 1))
def stop(
    low: float, high: float, x: jax.Array, v: jax.Array, beyond: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Positions within ``low``..``high``, and velocities that do not lead out, if ``beyond`` says that any do."""

    def clip(x, v):
        stopped = jnp.where(x < low, jnp.maximum(v, 0), jnp.where(x > high, jnp.minimum(v, 0), v))
        return jnp.clip(x, low, high), stopped

    if find_platform() != "cpu":  # where a branch costs more than the work
        return clip(x, v)
    return jax.lax.cond(beyond > 0, clip, lambda x, v: (x, v), x, v)


@stop.defjvp
def _differentiate_stop(low, high, primals, tangents):
    """By who was stopped, which a reverse pass may keep (`STOPPED`): to find it again it would have to repeat G2P."""
    x, v, _ = primals
    out, leading = checkpoint_name(find_stopped(low, high, x, v), STOPPED)
    x_dot, v_dot, _ = tangents
    return stop(low, high, *primals), (jnp.where(out, 0, x_dot), jnp.where(leading, 0, v_dot))


def find_stopped(low: float, high: float, x: jax.Array, v: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Find the coordinates that `stop` sets, and their velocities."""
    under, over = x < low, x > high
    return under | over, (under & (v <= 0)) | (over & (v >= 0))


def find_walls(wall: int, grid: Grid) -> tuple[float, float]:
    """Between which coordinates [m] particles stay, ``wall`` cells from the domain's faces."""
    return wall * grid.dx, (grid.cells - wall) * grid.dx


def scatter_mass(s: Stencil, grid: Grid, mass: jax.Array) -> jax.Array:
    """Scatter ``mass`` [kg], shape (n,), alone; return shape (nx, ny, nz)."""
    values = _multiply_weights(s.weights) * mass[:, None, None, None]
    return _scatter(s.base, values[..., None], grid.shape)[..., 0]


def gather_affine(s: Stencil, grid: Grid, velocity: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Gather v = sum w_i v_i and C = 4/dx^2 sum w_i v_i (x_i - x)^T.

    Args:
        s: Stencils of the n particles.
        grid: The window.
        velocity: Node velocities [m/s], shape (nx, ny, nz, 3).

    Returns:
        Particle velocities [m/s], shape (n, 3), and affine matrices [1/s], shape (n, 3, 3).
    """
    v = _gather(s.base, velocity)
    w, wd = s.weights, s.weights * s.offsets
    # Contracting one axis after the other costs 2 * (27 + 9 + 3) products instead of 4 * 27.
    x0 = (v * w[:, 0, :, None, None, None]).sum(1)
    x1 = (v * wd[:, 0, :, None, None, None]).sum(1)
    y0 = (x0 * w[:, 1, :, None, None]).sum(1)
    y1 = (x0 * wd[:, 1, :, None, None]).sum(1)
    yx = (x1 * w[:, 1, :, None, None]).sum(1)
    wz, wdz = w[:, 2, :, None], wd[:, 2, :, None]
    moments = jnp.stack([(yx * wz).sum(1), (y1 * wz).sum(1), (y0 * wdz).sum(1)], axis=-1)
    return (y0 * wz).sum(1), moments * (4 / grid.dx**2)


def velocity_gradient(s: Stencil, grid: Grid, velocity: jax.Array) -> jax.Array:
    """Gather grad v = sum v_i (grad w_i)^T [1/s], shape (n, 3, 3); the classical form's, where MLS takes C."""
    del grid
    v = _gather(s.base, velocity)
    columns = [
        (v * _multiply_weights(_replace_by_slopes(s, axis))[..., None]).sum((1, 2, 3)) for axis in range(3)
    ]
    return jnp.stack(columns, axis=-1)


def _replace_by_slopes(s: Stencil, axis: int) -> jax.Array:
    """The weights with those of one axis replaced by their slopes."""
    return s.weights.at[:, axis].set(s.slopes[:, axis])


def _multiply_weights(weights: jax.Array) -> jax.Array:
    """Tensor-product weights, shape (n, 3, 3, 3)."""
    return weights[:, 0, :, None, None] * weights[:, 1, None, :, None] * weights[:, 2, None, None, :]


def _scatter(base: jax.Array, values: jax.Array, shape: tuple[int, int, int]) -> jax.Array:
    numbers = lax.ScatterDimensionNumbers(
        update_window_dims=(1, 2, 3, 4), inserted_window_dims=(), scatter_dims_to_operand_dims=(0, 1, 2)
    )
    zeros = jnp.zeros((*shape, values.shape[-1]), values.dtype)
    # CLIP, because an out-of-range negative index would otherwise wrap to the opposite face.
    return lax.scatter_add(zeros, base, values, numbers, mode=lax.GatherScatterMode.CLIP)


def _gather(base: jax.Array, values: jax.Array) -> jax.Array:
    numbers = lax.GatherDimensionNumbers(
        offset_dims=(1, 2, 3, 4), collapsed_slice_dims=(), start_index_map=(0, 1, 2)
    )
    return lax.gather(values, base, numbers, (3, 3, 3, values.shape[-1]), mode=lax.GatherScatterMode.CLIP)
