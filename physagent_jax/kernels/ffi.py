"""Numba functions as XLA custom calls, through the typed foreign function interface.

XLA hands a handler the address of a call frame, laid out as jaxlib's own header has it (`jaxlib/include/xla/ffi/
api/c_api.h`, the same in 0.10.1 to 0.12.0). The offsets below count in words of eight bytes.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportPrivateImportUsage=false, reportAttributeAccessIssue=false

from __future__ import annotations

import ctypes

import jax
import numpy as np
from numba import carray, njit, types
from numba.extending import intrinsic

from physagent_jax.kernels.numbers import WITHIN

HANDLER = types.int64(types.int64)
"""Signature of a handler: the address of the call frame, and 0 for success."""

_FRAME_EXTENSION = 1
_FRAME_OPERANDS, _FRAME_RESULTS = 9, 14  # XLA_FFI_Args.args and XLA_FFI_Rets.rets, within XLA_FFI_CallFrame
_BUFFER_DATA, _BUFFER_RANK, _BUFFER_EXTENTS = 3, 4, 5  # XLA_FFI_Buffer
_EXTENSION_TYPE, _EXTENSION_METADATA, _METADATA = 1, 3, 1  # XLA_FFI_Metadata_Extension
_VERSION_BYTES = 24  # of the version numbers within XLA_FFI_Metadata
_VERSION = (0, 1)  # the oldest API that all supported versions of jaxlib accept


def register(name: str, handler) -> None:
    """Makes a Numba ``cfunc`` with signature `HANDLER` callable as ``jax.ffi.ffi_call(name, ...)`` on CPU."""
    new_capsule = ctypes.pythonapi.PyCapsule_New
    new_capsule.restype, new_capsule.argtypes = ctypes.py_object, (ctypes.c_void_p,) + (ctypes.c_char_p,) * 2
    jax.ffi.register_ffi_target(name, new_capsule(handler.address, None, None), platform="cpu")


@intrinsic
def _pointer(typing, address, number):
    """``address`` as a pointer to numbers of a type, which is given as a NumPy class such as ``np.float32``."""
    pointed = number.dtype

    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], context.get_value_type(signature.return_type))

    return types.CPointer(pointed)(types.int64, number), generate


@njit(**WITHIN)
def word(address, index):
    """The ``index``-th word from ``address`` on."""
    return carray(_pointer(address, np.int64), (index + 1,))[index]


@njit(**WITHIN)
def operand(frame, index):
    """Address of an operand's buffer."""
    return word(word(frame, _FRAME_OPERANDS), index)


@njit(**WITHIN)
def result(frame, index):
    """Address of a result's buffer."""
    return word(word(frame, _FRAME_RESULTS), index)


@njit(**WITHIN)
def extent(buffer, axis):
    """Length of a buffer along ``axis``."""
    return word(word(buffer, _BUFFER_EXTENTS), axis)


@njit(**WITHIN)
def flat(buffer, number):
    """All of a buffer's numbers, in one dimension; ``number`` is their NumPy class."""
    count = 1
    for axis in range(word(buffer, _BUFFER_RANK)):
        count *= extent(buffer, axis)
    return carray(_pointer(word(buffer, _BUFFER_DATA), number), (count,))


@njit(**WITHIN)
def answers_query(frame):
    """Whether the call only asked for the handler's API version, which it then has got."""
    extension = word(frame, _FRAME_EXTENSION)
    if extension == 0 or (word(extension, _EXTENSION_TYPE) & 0xFFFFFFFF) != _METADATA:
        return False
    version = carray(_pointer(word(extension, _EXTENSION_METADATA) + _VERSION_BYTES, np.int32), (2,))
    version[0], version[1] = _VERSION
    return True
