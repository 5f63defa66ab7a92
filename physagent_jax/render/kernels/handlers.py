"""The blending kernels as XLA custom calls: operands in, results out."""

from __future__ import annotations

import numpy as np
from numba import njit

from physagent_jax.kernels import ffi
from physagent_jax.kernels.numbers import WITHIN
from physagent_jax.kernels.target import target
from physagent_jax.render.kernels.blend import PACKED, PIXELS, blend, blend_backward


def handler(kernel: str) -> str:
    """Name under which XLA can call "blend" or "blend_backward", both in float32."""
    return target(f"physagent_{kernel}", {"blend": _blend, "blend_backward": _blend_backward}[kernel])


@njit(**WITHIN)
def _tiles(buffer):
    return ffi.flat(buffer, np.float32).reshape(ffi.extent(buffer, 0), PIXELS)


@njit(**WITHIN)
def _features(buffer):
    return ffi.flat(buffer, np.float32).reshape(ffi.extent(buffer, 0), 4, PIXELS)


@njit(**WITHIN)
def _packed(buffer):
    return ffi.flat(buffer, np.float32).reshape(ffi.extent(buffer, 0), PACKED)


def _blend(frame):
    if not ffi.answers_query(frame):
        sizes = ffi.flat(ffi.operand(frame, 4), np.int32)
        blend(
            _packed(ffi.operand(frame, 0)),
            ffi.flat(ffi.operand(frame, 1), np.float32),
            ffi.flat(ffi.operand(frame, 2), np.int32),
            ffi.flat(ffi.operand(frame, 3), np.int32),
            sizes[0],
            sizes[1],
            sizes[2],
            ffi.flat(ffi.operand(frame, 5), np.float32),
            _features(ffi.result(frame, 0)),
            _tiles(ffi.result(frame, 1)),
            sizes[3],
        )
    return 0


def _blend_backward(frame):
    if not ffi.answers_query(frame):
        sizes, gradient = ffi.flat(ffi.operand(frame, 4), np.int32), ffi.result(frame, 0)
        parts = sizes[3]
        blend_backward(
            _packed(ffi.operand(frame, 0)),
            ffi.flat(ffi.operand(frame, 1), np.float32),
            ffi.flat(ffi.operand(frame, 2), np.int32),
            ffi.flat(ffi.operand(frame, 3), np.int32),
            sizes[0],
            ffi.flat(ffi.operand(frame, 5), np.float32),
            _features(ffi.operand(frame, 6)),
            _tiles(ffi.operand(frame, 7)),
            _features(ffi.operand(frame, 8)),
            _tiles(ffi.operand(frame, 9)),
            _tiles(ffi.operand(frame, 10)),
            ffi.flat(gradient, np.float32).reshape(parts, ffi.extent(gradient, 1), PACKED),
            ffi.flat(ffi.result(frame, 1), np.float32).reshape(parts, 3, PIXELS),
            parts,
        )
    return 0
