"""The kernels of singular values as XLA custom calls: operands in, results out."""

# pyright: reportCallIssue=false

from __future__ import annotations

import numpy as np
from numba import njit

from physagent_jax.kernels import ffi
from physagent_jax.kernels.numbers import NO_WRAPPERS
from physagent_jax.kernels.team import run_in_team
from physagent_jax.mpm.linalg.kernels.svd import compose, decompose


def register_handler(kernel: str, precision: str) -> str:
    """Name under which XLA can call "decompose" or "compose" in "float32" or "float64"."""
    return ffi.register_target(f"physagent_{kernel}_{precision}", _HANDLERS[kernel, precision])


@njit(**NO_WRAPPERS)
def _decompose(frame, number, team):
    decompose(
        team,
        ffi.get_operand(frame, 0, number, 1),
        ffi.get_operand(frame, 1, np.int32, 1)[0],
        ffi.get_result(frame, 0, number, 2),
        ffi.get_result(frame, 1, number, 3),
    )


@njit(**NO_WRAPPERS)
def _compose(frame, number, team):
    compose(
        team,
        ffi.get_operand(frame, 0, number, 3),
        ffi.get_operand(frame, 2, number, 2),
        ffi.get_operand(frame, 3, number, 2),
        ffi.get_result(frame, 0, number, 1),
        ffi.get_result(frame, 1, number, 1),
    )


# Written out one by one: Numba does not find again on disk what is made by a function for several kernels.


def _decompose_float32(frame):
    return run_in_team(frame, np.float32, _decompose)


def _decompose_float64(frame):
    return run_in_team(frame, np.float64, _decompose)


def _compose_float32(frame):
    return run_in_team(frame, np.float32, _compose)


def _compose_float64(frame):
    return run_in_team(frame, np.float64, _compose)


_HANDLERS = {
    ("decompose", "float32"): _decompose_float32,
    ("decompose", "float64"): _decompose_float64,
    ("compose", "float32"): _compose_float32,
    ("compose", "float64"): _compose_float64,
}
