"""The kernels as XLA custom calls: operands in, results out.

A handler is compiled when it is first asked for, once per precision and machine: Numba keeps the result on disk.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from physagent_jax.kernels import ffi
from physagent_jax.kernels.lanes import PARTICLES
from physagent_jax.kernels.numbers import WITHIN
from physagent_jax.kernels.target import target
from physagent_jax.mpm.kernels.svd import compose, decompose
from physagent_jax.mpm.kernels.transfer import g2p, p2g


def handler(kernel: str, precision: str) -> str:
    """Name under which XLA can call "p2g", "g2p", "decompose" or "compose" in "float32" or "float64"."""
    return target(f"physagent_{kernel}_{precision}", _HANDLERS[kernel, precision])


@njit(**WITHIN)
def _vectors(buffer, number):
    return ffi.flat(buffer, number).reshape(ffi.extent(buffer, 0), 3)


@njit(**WITHIN)
def _matrices(buffer, number):
    return ffi.flat(buffer, number).reshape(ffi.extent(buffer, 0), 3, 3)


@njit(**WITHIN)
def _table(buffer, number):
    return ffi.flat(buffer, number).reshape(ffi.extent(buffer, 0), ffi.extent(buffer, 1))


@njit(**WITHIN)
def _grid(buffer, number):
    nx, ny, nz = ffi.extent(buffer, 0), ffi.extent(buffer, 1), ffi.extent(buffer, 2)
    return ffi.flat(buffer, number).reshape(nx, ny, nz, ffi.extent(buffer, 3))


@njit(**WITHIN)
def _p2g(frame, number):
    scalars = ffi.flat(ffi.operand(frame, 10), number)
    p2g(
        _vectors(ffi.operand(frame, 0), number),
        _vectors(ffi.operand(frame, 1), number),
        _matrices(ffi.operand(frame, 2), number),
        _matrices(ffi.operand(frame, 3), number),
        ffi.flat(ffi.operand(frame, 4), number),
        ffi.flat(ffi.operand(frame, 5), number),
        ffi.flat(ffi.operand(frame, 6), number),
        ffi.flat(ffi.operand(frame, 7), number),
        ffi.flat(ffi.operand(frame, 8), number),
        ffi.flat(ffi.operand(frame, 9), np.int32),
        scalars[0],
        scalars[1],
        scalars[2] != 0,
        scalars[3] != 0,
        _grid(ffi.result(frame, 0), number),
        _table(ffi.result(frame, 1), number),
    )


@njit(**WITHIN)
def _g2p(frame, number):
    scalars = ffi.flat(ffi.operand(frame, 6), number)
    g2p(
        _vectors(ffi.operand(frame, 0), number),
        _matrices(ffi.operand(frame, 3), number),
        _grid(ffi.operand(frame, 4), number),
        ffi.flat(ffi.operand(frame, 5), np.int32),
        scalars[0],
        scalars[1],
        scalars[2] != 0,
        scalars[3],
        scalars[4],
        _vectors(ffi.result(frame, 0), number),
        _vectors(ffi.result(frame, 1), number),
        _matrices(ffi.result(frame, 2), number),
        _matrices(ffi.result(frame, 3), number),
        _table(ffi.result(frame, 4), number),
        ffi.flat(ffi.result(frame, 5), number),
    )


@njit(**WITHIN)
def _decompose(frame, number):
    control, s, basis = ffi.flat(ffi.operand(frame, 1), np.int32), ffi.result(frame, 0), ffi.result(frame, 1)
    batches = ffi.flat(basis, number).reshape(ffi.extent(basis, 0), 18, PARTICLES)
    decompose(ffi.flat(ffi.operand(frame, 0), number), control[0], _table(s, number), batches, control[1])


@njit(**WITHIN)
def _compose(frame, number):
    basis, control = ffi.operand(frame, 0), ffi.flat(ffi.operand(frame, 4), np.int32)
    compose(
        ffi.flat(basis, number).reshape(ffi.extent(basis, 0), 18, PARTICLES),
        ffi.flat(ffi.operand(frame, 1), number),
        _table(ffi.operand(frame, 2), number),
        _table(ffi.operand(frame, 3), number),
        ffi.flat(ffi.result(frame, 0), number),
        ffi.flat(ffi.result(frame, 1), number),
        control[1],
    )


# Written out one by one: Numba does not find again on disk what is made by a function for several kernels.


def _p2g_float32(frame):
    if not ffi.answers_query(frame):
        _p2g(frame, np.float32)
    return 0


def _p2g_float64(frame):
    if not ffi.answers_query(frame):
        _p2g(frame, np.float64)
    return 0


def _g2p_float32(frame):
    if not ffi.answers_query(frame):
        _g2p(frame, np.float32)
    return 0


def _g2p_float64(frame):
    if not ffi.answers_query(frame):
        _g2p(frame, np.float64)
    return 0


def _decompose_float32(frame):
    if not ffi.answers_query(frame):
        _decompose(frame, np.float32)
    return 0


def _decompose_float64(frame):
    if not ffi.answers_query(frame):
        _decompose(frame, np.float64)
    return 0


def _compose_float32(frame):
    if not ffi.answers_query(frame):
        _compose(frame, np.float32)
    return 0


def _compose_float64(frame):
    if not ffi.answers_query(frame):
        _compose(frame, np.float64)
    return 0


_HANDLERS = {
    ("p2g", "float32"): _p2g_float32,
    ("p2g", "float64"): _p2g_float64,
    ("g2p", "float32"): _g2p_float32,
    ("g2p", "float64"): _g2p_float64,
    ("decompose", "float32"): _decompose_float32,
    ("decompose", "float64"): _decompose_float64,
    ("compose", "float32"): _compose_float32,
    ("compose", "float64"): _compose_float64,
}
