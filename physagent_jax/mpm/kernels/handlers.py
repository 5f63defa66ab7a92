"""The kernels as XLA custom calls: operands in, results out.

A handler is compiled when it is first asked for, once per precision and machine: Numba keeps the result on disk.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import cfunc, njit

from physagent_jax.mpm.kernels import ffi, store
from physagent_jax.mpm.kernels.svd import polar, svd
from physagent_jax.mpm.kernels.threads import thread_count
from physagent_jax.mpm.kernels.transfer import g2p, p2g


@cache
def handler(kernel: str, precision: str) -> str:
    """Name under which XLA can call "p2g", "g2p", "svd" or "polar" in "float32" or "float64"."""
    thread_count()  # starts the threads: compiled code from the disk asks for them as it is loaded
    name = f"physagent_{kernel}_{precision}"
    with store.kept():
        function = cfunc(ffi.HANDLER, cache=True)(_HANDLERS[kernel, precision])
    ffi.register(name, function)
    return name


@njit(cache=True)
def _vectors(buffer, number):
    return ffi.flat(buffer, number).reshape(ffi.extent(buffer, 0), 3)


@njit(cache=True)
def _matrices(buffer, number):
    return ffi.flat(buffer, number).reshape(ffi.extent(buffer, 0), 3, 3)


@njit(cache=True)
def _table(buffer, number):
    return ffi.flat(buffer, number).reshape(ffi.extent(buffer, 0), ffi.extent(buffer, 1))


@njit(cache=True)
def _grid(buffer, number):
    nx, ny, nz = ffi.extent(buffer, 0), ffi.extent(buffer, 1), ffi.extent(buffer, 2)
    return ffi.flat(buffer, number).reshape(nx, ny, nz, ffi.extent(buffer, 3))


@njit(cache=True)
def _p2g(frame, number):
    scalars = ffi.flat(ffi.operand(frame, 9), number)
    p2g(
        _vectors(ffi.operand(frame, 0), number),
        _vectors(ffi.operand(frame, 1), number),
        _matrices(ffi.operand(frame, 2), number),
        _matrices(ffi.operand(frame, 3), number),
        ffi.flat(ffi.operand(frame, 4), number),
        ffi.flat(ffi.operand(frame, 5), number),
        ffi.flat(ffi.operand(frame, 6), number),
        ffi.flat(ffi.operand(frame, 7), number),
        ffi.flat(ffi.operand(frame, 8), np.int32),
        scalars[0],
        scalars[1],
        scalars[2] != 0,
        scalars[3] != 0,
        _grid(ffi.result(frame, 0), number),
        _table(ffi.result(frame, 1), number),
    )


@njit(cache=True)
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


@njit(cache=True)
def _svd(frame, number):
    control = ffi.flat(ffi.operand(frame, 1), np.int32)
    svd(
        ffi.flat(ffi.operand(frame, 0), number),
        control[0],
        ffi.flat(ffi.result(frame, 0), number),
        ffi.flat(ffi.result(frame, 1), number),
        ffi.flat(ffi.result(frame, 2), number),
        control[1],
    )


@njit(cache=True)
def _polar(frame, number):
    control = ffi.flat(ffi.operand(frame, 1), np.int32)
    F, R = ffi.flat(ffi.operand(frame, 0), number), ffi.flat(ffi.result(frame, 0), number)
    polar(F, control[0], R, control[1])


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


def _svd_float32(frame):
    if not ffi.answers_query(frame):
        _svd(frame, np.float32)
    return 0


def _svd_float64(frame):
    if not ffi.answers_query(frame):
        _svd(frame, np.float64)
    return 0


def _polar_float32(frame):
    if not ffi.answers_query(frame):
        _polar(frame, np.float32)
    return 0


def _polar_float64(frame):
    if not ffi.answers_query(frame):
        _polar(frame, np.float64)
    return 0


_HANDLERS = {
    ("p2g", "float32"): _p2g_float32,
    ("p2g", "float64"): _p2g_float64,
    ("g2p", "float32"): _g2p_float32,
    ("g2p", "float64"): _g2p_float64,
    ("svd", "float32"): _svd_float32,
    ("svd", "float64"): _svd_float64,
    ("polar", "float32"): _polar_float32,
    ("polar", "float64"): _polar_float64,
}
