"""The blending kernels as XLA custom calls: operands in, results out."""

# pyright: reportCallIssue=false

from __future__ import annotations

import numpy as np

from physagent_jax.kernels import ffi
from physagent_jax.render.kernels.blend import blend, blend_backward


def register_handler(kernel: str) -> str:
    """Name under which XLA can call "blend" or "blend_backward", both in float32."""
    return ffi.register_target(
        f"physagent_{kernel}", {"blend": _blend, "blend_backward": _blend_backward}[kernel]
    )


def _blend(frame):
    if not ffi.answer_query(frame):
        sizes = ffi.get_operand(frame, 4, np.int32, 1)
        blend(
            ffi.get_operand(frame, 0, np.float32, 2),
            ffi.get_operand(frame, 1, np.float32, 1),
            ffi.get_operand(frame, 2, np.int32, 1),
            ffi.get_operand(frame, 3, np.int32, 1),
            sizes[0],
            sizes[1],
            sizes[2],
            ffi.get_operand(frame, 5, np.float32, 1),
            ffi.get_result(frame, 0, np.float32, 3),
            ffi.get_result(frame, 1, np.float32, 2),
            sizes[3],
        )
    return 0


def _blend_backward(frame):
    if not ffi.answer_query(frame):
        sizes = ffi.get_operand(frame, 4, np.int32, 1)
        blend_backward(
            ffi.get_operand(frame, 0, np.float32, 2),
            ffi.get_operand(frame, 1, np.float32, 1),
            ffi.get_operand(frame, 2, np.int32, 1),
            ffi.get_operand(frame, 3, np.int32, 1),
            sizes[0],
            ffi.get_operand(frame, 5, np.float32, 1),
            ffi.get_operand(frame, 6, np.float32, 3),
            ffi.get_operand(frame, 7, np.float32, 2),
            ffi.get_operand(frame, 8, np.float32, 3),
            ffi.get_operand(frame, 9, np.float32, 2),
            ffi.get_operand(frame, 10, np.float32, 2),
            ffi.get_result(frame, 0, np.float32, 3),
            ffi.get_result(frame, 1, np.float32, 3),
            sizes[3],
        )
    return 0
