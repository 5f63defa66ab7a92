"""The kernels of singular values as JAX functions."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from physagent_jax.kernels import ffi
from physagent_jax.kernels.lanes import BATCH
from physagent_jax.kernels.threads import choose_team
from physagent_jax.mpm.linalg.kernels.handlers import register_handler
from physagent_jax.mpm.linalg.kernels.svd import FRAME


def svd(F: jax.Array, sweeps: int) -> tuple[jax.Array, jax.Array, jax.Array]:
    """U, s and V of F = U diag(s) V^T by ``sweeps`` Jacobi sweeps, of any number of matrices, shape (..., 3, 3)."""
    matrices, count = F.reshape(-1, 3, 3), F.size // 9
    s, basis = decompose(matrices, sweeps)
    # The last batch begins before the one before it ends.
    batches = basis.shape[0]
    rows = jnp.moveaxis(basis, -1, 1).reshape(batches * BATCH, FRAME)
    repeated = batches * BATCH - s.shape[-1]
    last = rows[(batches - 1) * BATCH + repeated :]
    rows = jnp.concatenate([rows[: (batches - 1) * BATCH], last])[:count]
    u, v, x, y = jnp.split(rows, 4, axis=1)
    U, V = (jnp.stack([a, b, jnp.cross(a, b)], axis=-1).reshape(F.shape) for a, b in ((u, v), (x, y)))
    return U, s[:, :count].T.reshape(F.shape[:-1]), V


def decompose(F: jax.Array, sweeps: int) -> tuple[jax.Array, jax.Array]:
    """Singular values, shape (3, n), and the frames as `compose` takes them, of n matrices.

    Where there are fewer than a kernel takes at a time, zeros are added.
    """
    matrices = _pad_to_batch(F)
    count = matrices.shape[0]
    ffi.check_operands("decompose", {"F": matrices}, {"F": (count, 3, 3)}, F.dtype)
    results = (
        jax.ShapeDtypeStruct((3, count), F.dtype),
        jax.ShapeDtypeStruct((-(-count // BATCH), FRAME, BATCH), F.dtype),
    )
    call = jax.ffi.ffi_call(register_handler("decompose", F.dtype.name), results, vmap_method="sequential")
    s, basis = call(matrices, jnp.asarray([sweeps], jnp.int32), **choose_team())
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
    count, matrices = F.shape[0], _pad_to_batch(F)
    nothing = jnp.zeros((3, 0), F.dtype)

    def padded(diagonal):
        missing = matrices.shape[0] - count
        return nothing if diagonal is None else jnp.pad(diagonal, ((0, 0), (0, missing)))

    shapes = ((0, 3, 3) if diagonal is None else matrices.shape for diagonal in (change, spatial))
    results = tuple(jax.ShapeDtypeStruct(shape, F.dtype) for shape in shapes)
    call = jax.ffi.ffi_call(
        register_handler("compose", F.dtype.name),
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
    ffi.check_operands("compose", operands, shapes, F.dtype)
    new_F, tau = call(*operands.values(), **choose_team())
    return new_F[:count], tau[:count]


def _pad_to_batch(F: jax.Array) -> jax.Array:
    """The matrices, and zeros so that they are at least as many as the kernels take at a time."""
    return jnp.pad(F, ((0, max(0, BATCH - F.shape[0])), (0, 0), (0, 0)))
