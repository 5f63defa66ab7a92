"""The CPU kernels as JAX functions, with their derivatives."""

from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp

from physagent_jax.core.errors import UserError
from physagent_jax.kernels import ffi
from physagent_jax.kernels.lanes import BATCH
from physagent_jax.kernels.numbers import SHARES
from physagent_jax.kernels.threads import thread_count
from physagent_jax.mpm import transfer
from physagent_jax.mpm.kernels.handlers import handler
from physagent_jax.mpm.kernels.svd import FRAME
from physagent_jax.mpm.kernels.transfer import NUMBERS, PADDING, WATCHED
from physagent_jax.mpm.linalg.svd import SWEEPS
from physagent_jax.mpm.materials.neo_hookean import NeoHookean
from physagent_jax.mpm.state import Grid

_BY_NUMBER = (3, 0, 1, 2)  # how the kernels want arrays over the grid, major to minor


@partial(jax.custom_vjp, nondiff_argnums=(0,))
def p2g(form: str, grid: Grid, x, v, C, tau, mass, volume, push, dt) -> jax.Array:
    """As `transfer.particles_to_grid`."""
    nothing = jnp.zeros(1, x.dtype)
    return _scatter(form, grid, x, v, C, tau, nothing, nothing, mass, volume, push, dt, neo_hookean=False)


@partial(jax.custom_vjp, nondiff_argnums=(0,))
def p2g_neo_hookean(form: str, grid: Grid, x, v, C, F, mu, lam, mass, volume, push, dt) -> jax.Array:
    """`p2g` with the stress of `materials.NeoHookean`, which never goes through memory."""
    return _scatter(form, grid, x, v, C, F, mu, lam, mass, volume, push, dt, neo_hookean=True)


def _scatter(form, grid, x, v, C, tau, mu, lam, mass, volume, push, dt, *, neo_hookean: bool) -> jax.Array:
    count = len(x)
    _check(
        "p2g",
        grid,
        dict(x=x, v=v, C=C, tau=tau, mu=mu, lam=lam, mass=mass, volume=volume, push=push),
        dict(x=(count, 3), v=(count, 3), C=(count, 3, 3), tau=(count, 3, 3), mass=(count,), volume=(count,))
        | dict.fromkeys(("mu", "lam"), (count,) if neo_hookean else (1,))
        | dict(push=(3,)),
    )
    parts, size = thread_count(), NUMBERS * grid.shape[0] * grid.shape[1] * grid.shape[2] + PADDING
    nodes = jax.ShapeDtypeStruct((*grid.shape, NUMBERS), x.dtype)
    private = jax.ShapeDtypeStruct((parts, size), x.dtype)
    call = jax.ffi.ffi_call(
        handler("p2g", x.dtype.name),
        (nodes, private),
        vmap_method="sequential",
        output_layouts=(_BY_NUMBER, None),
    )
    scalars = _scalars(x.dtype, dt, grid.dx, form == "gradient", neo_hookean)
    return call(x, v, C, tau, mu, lam, mass, volume, push, grid.origin, scalars)[0]


@partial(jax.custom_vjp, nondiff_argnums=(0, 1))
def g2p(form: str, wall: int, grid: Grid, x, v, C, F, velocity, dt) -> transfer.Moved:
    """As `transfer.grid_to_particles`. ``v`` and ``C`` only lend their memory."""
    count = len(x)
    _check(
        "g2p",
        grid,
        dict(x=x, v=v, C=C, F=F, velocity=velocity),
        dict(x=(count, 3), v=(count, 3), C=(count, 3, 3), F=(count, 3, 3), velocity=(*grid.shape, 3)),
    )
    shares, size = thread_count() * SHARES, NUMBERS * grid.shape[0] * grid.shape[1] * grid.shape[2] + PADDING
    results = tuple(jax.ShapeDtypeStruct(like.shape, x.dtype) for like in (x, v, C, F))
    results += tuple(jax.ShapeDtypeStruct(shape, x.dtype) for shape in ((shares, WATCHED), (size,)))
    # A particle's old x and F are read before its new ones are written: they may lie in the same place.
    call = jax.ffi.ffi_call(
        handler("g2p", x.dtype.name),
        results,
        vmap_method="sequential",
        input_layouts=(None, None, None, None, _BY_NUMBER, None, None),
        input_output_aliases={k: k for k in range(4)},
    )
    walls = (wall * grid.dx, (grid.cells - wall) * grid.dx)
    scalars = _scalars(x.dtype, dt, grid.dx, form == "gradient", *walls)
    x, v, C, F, watched, _ = call(x, v, C, F, velocity, grid.origin, scalars)
    least_J, most_J, least_increment, speed, strange, outside, beyond = watched.T
    return transfer.Moved(
        *(x, v, C, F),
        transfer.Watch(
            least_J.min(),
            most_J.max(),
            least_increment.min(),
            speed.max(),
            strange.sum() == 0,
            outside.sum().astype(jnp.int32),
            beyond.sum().astype(jnp.int32),
        ),
    )


def _check(kernel: str, grid: Grid, operands: dict[str, jax.Array], shapes: dict[str, tuple[int, ...]]):
    """`ffi.check`, and that a stencil has room in the window: beyond it the kernels would write elsewhere."""
    if min(grid.shape) < 3:
        raise UserError(
            f"the kernel {kernel} takes windows of three nodes or more along each axis", got=grid.shape
        )
    operands, shapes = operands | {"origin": grid.origin}, shapes | {"origin": (3,)}
    ffi.check(kernel, operands, shapes, operands["x"].dtype, origin="int32")


def svd(F: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
    """As `linalg.svd`, of any number of matrices, shape (..., 3, 3)."""
    matrices, count = F.reshape(-1, 3, 3), F.size // 9
    s, basis = decompose(matrices)
    # The last batch begins before the one before it ends.
    batches = basis.shape[0]
    rows = jnp.moveaxis(basis, -1, 1).reshape(batches * BATCH, FRAME)
    repeated = batches * BATCH - s.shape[-1]
    last = rows[(batches - 1) * BATCH + repeated :]
    rows = jnp.concatenate([rows[: (batches - 1) * BATCH], last])[:count]
    u, v, x, y = jnp.split(rows, 4, axis=1)
    U, V = (jnp.stack([a, b, jnp.cross(a, b)], axis=-1).reshape(F.shape) for a, b in ((u, v), (x, y)))
    return U, s[:, :count].T.reshape(F.shape[:-1]), V


def decompose(F: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Singular values, shape (3, n), and the frames as `compose` takes them, of n matrices.

    Where there are fewer than a kernel takes at a time, zeros are added.
    """
    matrices = _batch(F)
    count = matrices.shape[0]
    ffi.check("decompose", {"F": matrices}, {"F": (count, 3, 3)}, F.dtype)
    results = (
        jax.ShapeDtypeStruct((3, count), F.dtype),
        jax.ShapeDtypeStruct((-(-count // BATCH), FRAME, BATCH), F.dtype),
    )
    call = jax.ffi.ffi_call(handler("decompose", F.dtype.name), results, vmap_method="sequential")
    s, basis = call(matrices, _control(F.dtype))
    return s, basis


def compose(
    basis: jax.Array, F: jax.Array, change: jax.Array | None, spatial: jax.Array | None
) -> tuple[jax.Array, jax.Array]:
    """F + U diag(change) V^T and U diag(spatial) U^T; what is None makes its result empty.

    Args:
        basis: From `decompose`.
        F: Shape (n, 3, 3).
        change: Shape (3, n).
        spatial: Shape (3, n).
    """
    count, matrices = F.shape[0], _batch(F)
    nothing = jnp.zeros((3, 0), F.dtype)

    def padded(diagonal):
        missing = matrices.shape[0] - count
        return nothing if diagonal is None else jnp.pad(diagonal, ((0, 0), (0, missing)))

    shapes = ((0, 3, 3) if diagonal is None else matrices.shape for diagonal in (change, spatial))
    results = tuple(jax.ShapeDtypeStruct(shape, F.dtype) for shape in shapes)
    call = jax.ffi.ffi_call(
        handler("compose", F.dtype.name),
        results,
        vmap_method="sequential",
        input_output_aliases={} if change is None else {1: 0},
    )
    total = matrices.shape[0]
    operands = dict(basis=basis, F=matrices, change=padded(change), spatial=padded(spatial))
    shapes = dict(basis=(-(-total // BATCH), FRAME, BATCH), F=(total, 3, 3))
    shapes |= {
        name: (3, 0 if own is None else total) for name, own in (("change", change), ("spatial", spatial))
    }
    ffi.check("compose", operands, shapes, F.dtype)
    new_F, tau = call(*operands.values(), _control(F.dtype))
    return new_F[:count], tau[:count]


def _batch(F: jax.Array) -> jax.Array:
    """The matrices, and zeros so that they are at least as many as the kernels take at a time."""
    return jnp.pad(F, ((0, max(0, BATCH - F.shape[0])), (0, 0), (0, 0)))


def _control(dtype) -> jax.Array:
    return jnp.asarray([SWEEPS[dtype.itemsize], thread_count()], jnp.int32)


def _scalars(dtype, *numbers) -> jax.Array:
    return jnp.stack([jnp.asarray(number, dtype) for number in numbers])


def _p2g_forward(form, grid, *operands):
    return p2g(form, grid, *operands), (grid, operands)


def _p2g_backward(form, residuals, cotangent):
    grid, operands = residuals
    _, pull = jax.vjp(lambda *operands: transfer.particles_to_grid(form, grid, *operands), *operands)
    return (None, *pull(cotangent))


def _p2g_neo_hookean_forward(form, grid, *operands):
    return p2g_neo_hookean(form, grid, *operands), (grid, operands)


def _p2g_neo_hookean_backward(form, residuals, cotangent):
    grid, operands = residuals

    def reference(x, v, C, F, mu, lam, mass, volume, push, dt):
        tau = NeoHookean(mu, lam).stress(F)
        return transfer.particles_to_grid(form, grid, x, v, C, tau, mass, volume, push, dt)

    return (None, *jax.vjp(reference, *operands)[1](cotangent))


def _g2p_forward(form, wall, grid, *operands):
    return g2p(form, wall, grid, *operands), (grid, operands)


def _g2p_backward(form, wall, residuals, cotangent):
    grid, operands = residuals
    _, pull = jax.vjp(lambda *operands: transfer.grid_to_particles(form, wall, grid, *operands), *operands)
    return (None, *pull(cotangent))


p2g.defvjp(_p2g_forward, _p2g_backward)
p2g_neo_hookean.defvjp(_p2g_neo_hookean_forward, _p2g_neo_hookean_backward)
g2p.defvjp(_g2p_forward, _g2p_backward)
