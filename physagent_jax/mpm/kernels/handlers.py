"""The transfer kernels as XLA custom calls: operands in, results out.

A handler is compiled when it is first asked for, once per precision and machine: Numba keeps the result on disk.
"""

# pyright: reportCallIssue=false

from __future__ import annotations

import numpy as np
from numba import njit

from physagent_jax.kernels import ffi
from physagent_jax.kernels.numbers import NO_WRAPPERS
from physagent_jax.kernels.team import run_in_team
from physagent_jax.mpm.kernels.adjoint import g2p_adjoint, grid_velocity_adjoint, p2g_adjoint
from physagent_jax.mpm.kernels.apart import p2g_apart, p2g_apart_adjoint
from physagent_jax.mpm.kernels.inertia import (
    aggregate,
    sharpened_velocity,
    sharpened_velocity_adjoint,
    sum_neighbours,
)
from physagent_jax.mpm.kernels.transfer import g2p, p2g


def register_handler(kernel: str, precision: str) -> str:
    """Name under which XLA can call a kernel, like "p2g" or "p2g_adjoint", in "float32" or "float64"."""
    return ffi.register_target(f"physagent_{kernel}_{precision}", _HANDLERS[kernel, precision])


@njit(**NO_WRAPPERS)
def _p2g(frame, number, team):
    scalars = ffi.get_operand(frame, 12, number, 1)
    p2g(
        team,
        ffi.get_operand(frame, 0, number, 2),
        ffi.get_operand(frame, 1, number, 2),
        ffi.get_operand(frame, 2, number, 3),
        ffi.get_operand(frame, 3, number, 3),
        (
            ffi.get_operand(frame, 4, number, 1),
            ffi.get_operand(frame, 5, number, 1),
            ffi.get_operand(frame, 6, number, 1),
            ffi.get_operand(frame, 7, number, 3),
        ),
        ffi.get_operand(frame, 8, number, 1),
        ffi.get_operand(frame, 9, number, 1),
        ffi.get_operand(frame, 10, number, 1),
        ffi.get_operand(frame, 11, np.int32, 1),
        scalars[0],
        scalars[1],
        (scalars[2] != 0, scalars[3] != 0, scalars[4] != 0),
        ffi.get_result(frame, 0, number, 4),
        ffi.get_result(frame, 1, number, 2),
        ffi.get_result(frame, 2, np.int32, 2),
    )


@njit(**NO_WRAPPERS)
def _p2g_apart(frame, number, team):
    scalars = ffi.get_operand(frame, 13, number, 1)
    p2g_apart(
        team,
        (
            ffi.get_operand(frame, 0, number, 2),
            ffi.get_operand(frame, 1, number, 2),
            ffi.get_operand(frame, 2, number, 3),
            ffi.get_operand(frame, 3, number, 3),
        ),
        (
            ffi.get_operand(frame, 4, number, 1),
            ffi.get_operand(frame, 5, number, 1),
            ffi.get_operand(frame, 6, number, 1),
            ffi.get_operand(frame, 7, number, 3),
        ),
        ffi.get_operand(frame, 8, number, 1),
        ffi.get_operand(frame, 9, number, 1),
        ffi.get_operand(frame, 10, number, 1),
        ffi.get_operand(frame, 11, number, 2),
        ffi.get_operand(frame, 12, np.int32, 1),
        scalars[0],
        scalars[1],
        scalars[6],
        (scalars[2] != 0, scalars[3] != 0, scalars[4] != 0, scalars[5] != 0),
        ffi.get_result(frame, 0, number, 4),
        ffi.get_result(frame, 1, number, 2),
        ffi.get_result(frame, 2, np.int32, 2),
    )


@njit(**NO_WRAPPERS)
def _g2p(frame, number, team):
    scalars = ffi.get_operand(frame, 6, number, 1)
    g2p(
        team,
        (ffi.get_operand(frame, 0, number, 2), ffi.get_operand(frame, 3, number, 3)),
        ffi.get_operand(frame, 4, number, 4),
        ffi.get_operand(frame, 5, np.int32, 1),
        scalars[0],
        scalars[1],
        scalars[2] != 0,
        scalars[3],
        scalars[4],
        (
            ffi.get_result(frame, 0, number, 2),
            ffi.get_result(frame, 1, number, 2),
            ffi.get_result(frame, 2, number, 3),
            ffi.get_result(frame, 3, number, 3),
        ),
        ffi.get_result(frame, 4, number, 2),
        ffi.get_result(frame, 5, number, 1),
    )


@njit(**NO_WRAPPERS)
def _p2g_adjoint(frame, number, team):
    scalars = ffi.get_operand(frame, 13, number, 1)
    p2g_adjoint(
        team,
        (
            ffi.get_operand(frame, 0, number, 2),
            ffi.get_operand(frame, 1, number, 2),
            ffi.get_operand(frame, 2, number, 3),
            ffi.get_operand(frame, 3, number, 3),
            ffi.get_operand(frame, 6, number, 1),
            ffi.get_operand(frame, 7, number, 1),
        ),
        (ffi.get_operand(frame, 4, number, 1), ffi.get_operand(frame, 5, number, 1)),
        ffi.get_operand(frame, 8, number, 1),
        ffi.get_operand(frame, 9, np.int32, 1),
        scalars[0],
        scalars[1],
        scalars[2] != 0,
        ffi.get_operand(frame, 10, number, 4),
        (ffi.get_operand(frame, 11, number, 1), ffi.get_operand(frame, 12, number, 1)),
        (
            ffi.get_result(frame, 0, number, 1),
            ffi.get_result(frame, 1, number, 1),
            ffi.get_result(frame, 2, number, 1),
            ffi.get_result(frame, 3, number, 1),
            ffi.get_result(frame, 4, number, 1),
            ffi.get_result(frame, 5, number, 1),
            ffi.get_result(frame, 6, number, 1),
            ffi.get_result(frame, 7, number, 1),
        ),
        ffi.get_result(frame, 8, number, 2),
        ffi.get_result(frame, 9, number, 1),
    )


@njit(**NO_WRAPPERS)
def _p2g_apart_adjoint(frame, number, team):
    scalars = ffi.get_operand(frame, 14, number, 1)
    p2g_apart_adjoint(
        team,
        (
            ffi.get_operand(frame, 0, number, 2),
            ffi.get_operand(frame, 1, number, 2),
            ffi.get_operand(frame, 2, number, 3),
            ffi.get_operand(frame, 3, number, 3),
            ffi.get_operand(frame, 6, number, 1),
            ffi.get_operand(frame, 7, number, 1),
        ),
        (ffi.get_operand(frame, 4, number, 1), ffi.get_operand(frame, 5, number, 1)),
        ffi.get_operand(frame, 8, number, 1),
        ffi.get_operand(frame, 9, number, 2),
        ffi.get_operand(frame, 10, np.int32, 1),
        scalars[0],
        scalars[1],
        scalars[2],
        (scalars[3] != 0, scalars[4] != 0),
        ffi.get_operand(frame, 11, number, 4),
        (ffi.get_operand(frame, 12, number, 1), ffi.get_operand(frame, 13, number, 1)),
        (
            ffi.get_result(frame, 0, number, 1),
            ffi.get_result(frame, 1, number, 1),
            ffi.get_result(frame, 2, number, 1),
            ffi.get_result(frame, 3, number, 1),
            ffi.get_result(frame, 4, number, 1),
            ffi.get_result(frame, 5, number, 1),
            ffi.get_result(frame, 6, number, 1),
            ffi.get_result(frame, 7, number, 1),
            ffi.get_result(frame, 8, number, 1),
        ),
        ffi.get_result(frame, 9, number, 2),
        ffi.get_result(frame, 10, number, 1),
    )


@njit(**NO_WRAPPERS)
def _g2p_adjoint(frame, number, team):
    scalars = ffi.get_operand(frame, 8, number, 1)
    g2p_adjoint(
        team,
        ffi.get_operand(frame, 0, number, 2),
        ffi.get_operand(frame, 1, number, 3),
        ffi.get_operand(frame, 2, number, 4),
        ffi.get_operand(frame, 3, np.int32, 1),
        scalars[0],
        scalars[1],
        (
            ffi.get_operand(frame, 4, number, 2),
            ffi.get_operand(frame, 5, number, 2),
            ffi.get_operand(frame, 6, number, 3),
            ffi.get_operand(frame, 7, number, 3),
        ),
        ffi.get_result(frame, 0, number, 1),
        ffi.get_result(frame, 1, number, 1),
        ffi.get_result(frame, 2, number, 4),
        ffi.get_result(frame, 3, number, 2),
        ffi.get_result(frame, 4, number, 2),
        ffi.get_result(frame, 5, np.int32, 2),
        ffi.get_result(frame, 6, number, 1),
    )


@njit(**NO_WRAPPERS)
def _grid_velocity_adjoint(frame, number, team):
    grid_velocity_adjoint(
        team,
        ffi.get_operand(frame, 0, number, 4),
        ffi.get_operand(frame, 1, number, 1)[0],
        ffi.get_operand(frame, 2, number, 4),
        ffi.get_result(frame, 0, number, 4),
    )


@njit(**NO_WRAPPERS)
def _aggregate(frame, number, team):
    scalars = ffi.get_operand(frame, 1, number, 1)
    aggregate(
        team,
        ffi.get_operand(frame, 0, number, 4),
        (scalars[0], scalars[1], scalars[2], scalars[3]),
        ffi.get_result(frame, 0, number, 4),
        ffi.get_result(frame, 1, number, 4),
        ffi.get_result(frame, 2, number, 4),
    )


@njit(**NO_WRAPPERS)
def _sum_neighbours(frame, number, team):
    sum_neighbours(team, ffi.get_operand(frame, 0, number, 4), ffi.get_result(frame, 0, number, 4))


@njit(**NO_WRAPPERS)
def _sharpened_velocity(frame, number, team):
    scalars = ffi.get_operand(frame, 2, number, 1)
    sharpened_velocity(
        team,
        ffi.get_operand(frame, 0, number, 4),
        ffi.get_operand(frame, 1, number, 4),
        (scalars[0], scalars[1], scalars[2], scalars[3]),
        scalars[4] != 0,
        ffi.get_result(frame, 0, number, 4),
    )


@njit(**NO_WRAPPERS)
def _sharpened_velocity_adjoint(frame, number, team):
    scalars = ffi.get_operand(frame, 3, number, 1)
    sharpened_velocity_adjoint(
        team,
        ffi.get_operand(frame, 0, number, 4),
        ffi.get_operand(frame, 1, number, 4),
        (scalars[0], scalars[1], scalars[2], scalars[3]),
        scalars[4] != 0,
        ffi.get_operand(frame, 2, number, 4),
        ffi.get_result(frame, 0, number, 4),
        ffi.get_result(frame, 1, number, 4),
    )


# Written out one by one: Numba does not find again on disk what is made by a function for several kernels.


def _p2g_float32(frame):
    return run_in_team(frame, np.float32, _p2g)


def _p2g_float64(frame):
    return run_in_team(frame, np.float64, _p2g)


def _p2g_apart_float32(frame):
    return run_in_team(frame, np.float32, _p2g_apart)


def _p2g_apart_float64(frame):
    return run_in_team(frame, np.float64, _p2g_apart)


def _g2p_float32(frame):
    return run_in_team(frame, np.float32, _g2p)


def _g2p_float64(frame):
    return run_in_team(frame, np.float64, _g2p)


def _p2g_adjoint_float32(frame):
    return run_in_team(frame, np.float32, _p2g_adjoint)


def _p2g_adjoint_float64(frame):
    return run_in_team(frame, np.float64, _p2g_adjoint)


def _p2g_apart_adjoint_float32(frame):
    return run_in_team(frame, np.float32, _p2g_apart_adjoint)


def _p2g_apart_adjoint_float64(frame):
    return run_in_team(frame, np.float64, _p2g_apart_adjoint)


def _g2p_adjoint_float32(frame):
    return run_in_team(frame, np.float32, _g2p_adjoint)


def _g2p_adjoint_float64(frame):
    return run_in_team(frame, np.float64, _g2p_adjoint)


def _grid_velocity_adjoint_float32(frame):
    return run_in_team(frame, np.float32, _grid_velocity_adjoint)


def _grid_velocity_adjoint_float64(frame):
    return run_in_team(frame, np.float64, _grid_velocity_adjoint)


def _aggregate_float32(frame):
    return run_in_team(frame, np.float32, _aggregate)


def _aggregate_float64(frame):
    return run_in_team(frame, np.float64, _aggregate)


def _sum_neighbours_float32(frame):
    return run_in_team(frame, np.float32, _sum_neighbours)


def _sum_neighbours_float64(frame):
    return run_in_team(frame, np.float64, _sum_neighbours)


def _sharpened_velocity_float32(frame):
    return run_in_team(frame, np.float32, _sharpened_velocity)


def _sharpened_velocity_float64(frame):
    return run_in_team(frame, np.float64, _sharpened_velocity)


def _sharpened_velocity_adjoint_float32(frame):
    return run_in_team(frame, np.float32, _sharpened_velocity_adjoint)


def _sharpened_velocity_adjoint_float64(frame):
    return run_in_team(frame, np.float64, _sharpened_velocity_adjoint)


_HANDLERS = {
    ("p2g", "float32"): _p2g_float32,
    ("p2g", "float64"): _p2g_float64,
    ("p2g_apart", "float32"): _p2g_apart_float32,
    ("p2g_apart", "float64"): _p2g_apart_float64,
    ("g2p", "float32"): _g2p_float32,
    ("g2p", "float64"): _g2p_float64,
    ("p2g_adjoint", "float32"): _p2g_adjoint_float32,
    ("p2g_adjoint", "float64"): _p2g_adjoint_float64,
    ("p2g_apart_adjoint", "float32"): _p2g_apart_adjoint_float32,
    ("p2g_apart_adjoint", "float64"): _p2g_apart_adjoint_float64,
    ("g2p_adjoint", "float32"): _g2p_adjoint_float32,
    ("g2p_adjoint", "float64"): _g2p_adjoint_float64,
    ("grid_velocity_adjoint", "float32"): _grid_velocity_adjoint_float32,
    ("grid_velocity_adjoint", "float64"): _grid_velocity_adjoint_float64,
    ("aggregate", "float32"): _aggregate_float32,
    ("aggregate", "float64"): _aggregate_float64,
    ("sum_neighbours", "float32"): _sum_neighbours_float32,
    ("sum_neighbours", "float64"): _sum_neighbours_float64,
    ("sharpened_velocity", "float32"): _sharpened_velocity_float32,
    ("sharpened_velocity", "float64"): _sharpened_velocity_float64,
    ("sharpened_velocity_adjoint", "float32"): _sharpened_velocity_adjoint_float32,
    ("sharpened_velocity_adjoint", "float64"): _sharpened_velocity_adjoint_float64,
}
