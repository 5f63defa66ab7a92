"""The blending kernels as XLA custom calls: operands in, results out."""

# pyright: reportCallIssue=false

from __future__ import annotations

import numpy as np
from numba import njit

from physagent_jax.kernels import ffi
from physagent_jax.kernels.numbers import NO_WRAPPERS
from physagent_jax.kernels.team import run_in_team
from physagent_jax.render.kernels.blend import blend, blend_backward


def register_handler(kernel: str) -> str:
    """Name under which XLA can call "blend" or "blend_backward", both in float32."""
    return ffi.register_target(
        f"physagent_{kernel}", {"blend": _blend, "blend_backward": _blend_backward}[kernel]
    )


@njit(**NO_WRAPPERS)
def _run_blend(frame, number, team):
    sizes = ffi.get_operand(frame, 4, np.int32, 1)
    blend(
        team,
        ffi.get_operand(frame, 0, number, 2),
        ffi.get_operand(frame, 1, number, 1),
        ffi.get_operand(frame, 2, np.int32, 1),
        ffi.get_operand(frame, 3, np.int32, 1),
        sizes[0],
        sizes[1],
        sizes[2],
        ffi.get_operand(frame, 5, number, 1),
        ffi.get_result(frame, 0, number, 3),
        ffi.get_result(frame, 1, number, 2),
    )


@njit(**NO_WRAPPERS)
def _run_blend_backward(frame, number, team):
    sizes = ffi.get_operand(frame, 4, np.int32, 1)
    blend_backward(
        team,
        ffi.get_operand(frame, 0, number, 2),
        ffi.get_operand(frame, 1, number, 1),
        ffi.get_operand(frame, 2, np.int32, 1),
        ffi.get_operand(frame, 3, np.int32, 1),
        sizes[0],
        ffi.get_operand(frame, 5, number, 1),
        ffi.get_operand(frame, 6, number, 3),
        ffi.get_operand(frame, 7, number, 2),
        ffi.get_operand(frame, 8, number, 3),
        ffi.get_operand(frame, 9, number, 2),
        ffi.get_operand(frame, 10, number, 2),
        ffi.get_result(frame, 0, number, 3),
        ffi.get_result(frame, 1, number, 3),
    )


def _blend(frame):
    return run_in_team(frame, np.float32, _run_blend)


def _blend_backward(frame):
    return run_in_team(frame, np.float32, _run_blend_backward)
