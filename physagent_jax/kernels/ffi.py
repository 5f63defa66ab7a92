"""Numba functions as XLA custom calls, through the typed foreign function interface.

XLA hands a handler the address of a call frame, laid out as jaxlib's own header has it (`jaxlib/include/xla/ffi/
api/c_api.h`, the same in 0.10.1 to 0.12.0). The offsets below count in words of eight bytes.

Intrinsics write LLVM's code themselves: the same in Numba's Python (`carray`, `reshape`) took half of the time that
a kernel takes to compile.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportPrivateImportUsage=false, reportAttributeAccessIssue=false

from __future__ import annotations

import ctypes
from typing import Any

import jax
import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array

from physagent_jax.core.errors import UserError
from physagent_jax.core.once import once
from physagent_jax.kernels import ahead, store
from physagent_jax.kernels.numbers import NO_WRAPPERS

HANDLER = types.int64(types.int64)
"""Signature of a handler: the address of the call frame, and 0 for success."""

_WORD = ir.IntType(64)
FRAME_API, FRAME_CONTEXT = 2, 3  # XLA_FFI_CallFrame.api and .ctx
_FRAME_EXTENSION = 1
_FRAME_OPERANDS, _FRAME_RESULTS = 9, 14  # XLA_FFI_Args.args and XLA_FFI_Rets.rets, within XLA_FFI_CallFrame
_FRAME_ATTRIBUTES = 20  # XLA_FFI_Attrs.attrs, likewise
SCHEDULE_TASK, DESTROY_ERROR = 17, 8  # XLA_FFI_ThreadPool_Schedule, XLA_FFI_Error_Destroy, within XLA_FFI_Api
_SCALAR_VALUE = 1  # XLA_FFI_Scalar
_BUFFER_DATA, _BUFFER_RANK, _BUFFER_EXTENTS = 3, 4, 5  # XLA_FFI_Buffer
_EXTENSION_TYPE, _EXTENSION_METADATA, _METADATA = 1, 3, 1  # XLA_FFI_Metadata_Extension
_VERSION_WORD = 3  # XLA_FFI_Api_Version.major_version and .minor_version, within XLA_FFI_Metadata
_TRAITS_WORD = 4  # XLA_FFI_Metadata.traits: XLA_FFI_HANDLER_TRAITS_COMMAND_BUFFER_COMPATIBLE is 1
_VERSION = 0 + (1 << 32)  # 0.1, the oldest that all supported versions of jaxlib accept


@once
def register_target(name: str, function) -> str:
    """Make ``function``, a handler, callable as ``jax.ffi.ffi_call(name, ...)`` on CPU, compiled if need be."""
    handler = _make_handler(name, function)
    new_capsule = ctypes.pythonapi.PyCapsule_New
    new_capsule.restype, new_capsule.argtypes = ctypes.py_object, (ctypes.c_void_p,) + (ctypes.c_char_p,) * 2
    jax.ffi.register_ffi_target(name, new_capsule(handler.address, None, None), platform="cpu")
    return name


@once
def _make_handler(name: str, function):
    """The compiled handler, kept as long as XLA may call it; made once, as XLA refuses another under the same name."""
    ahead.wait_for(name)
    return store.load_or_compile(name, HANDLER, function)


def check_operands(
    kernel: str, operands: dict[str, Any], shapes: dict[str, tuple[int, ...]], dtype, **others
) -> None:
    """Refuse operands that a kernel would take for others: it reads memory as if they were what it expects.

    Args:
        kernel: Its name.
        operands: By name, traced or not.
        shapes: What the kernel expects of each.
        dtype: Type of the operands that ``others`` does not name.
        others: Types of some.

    Raises:
        UserError: One has another type or shape.
    """
    for name, shape in shapes.items():
        got, expected = jax.typeof(operands[name]), np.dtype(others.get(name, dtype))
        if got.shape != shape or got.dtype != expected:  # type: ignore[attr-defined]
            raise UserError(
                f"the kernel {kernel} takes `{name}` as {expected} of {shape}",
                got=got,
                do="Give all arrays in one precision",
            )


@intrinsic(prefer_literal=True)
def get_operand(typing, frame, index, number, rank):
    """An operand as a C-ordered array of ``number``, a NumPy class: of its own rank, or flat for rank 1."""
    return _build_array(frame, index, number, rank, _FRAME_OPERANDS)


@intrinsic(prefer_literal=True)
def get_result(typing, frame, index, number, rank):
    """A result as a C-ordered array of ``number``, a NumPy class: of its own rank, or flat for rank 1."""
    return _build_array(frame, index, number, rank, _FRAME_RESULTS)


def _build_array(frame, index, number, rank, buffers: int):
    array, size = types.Array(number.dtype, rank.literal_value, "C"), number.dtype.bitwidth // 8

    def generate(context, builder, signature, arguments):
        buffer = load_word(builder, load_word(builder, arguments[0], buffers), index.literal_value)
        data = builder.inttoptr(
            load_word(builder, buffer, _BUFFER_DATA), context.get_value_type(number.dtype).as_pointer()
        )
        extents = load_word(builder, buffer, _BUFFER_EXTENTS)
        if array.ndim == 1:
            shape = [_multiply_words(builder, extents, load_word(builder, buffer, _BUFFER_RANK))]
        else:
            shape = [load_word(builder, extents, axis) for axis in range(array.ndim)]
        strides = [_WORD(size)]
        for length in reversed(shape[1:]):
            strides.insert(0, builder.mul(strides[0], length))
        made = context.make_array(array)(context, builder)
        return populate_array(made, data, shape, strides, size, meminfo=None)._getvalue()

    return array(frame, index, number, rank), generate


@intrinsic
def get_attribute(typing, frame, index):
    """An attribute that is an int64; they are in the order of their names."""

    def generate(context, builder, signature, arguments):
        return load_attribute(builder, *arguments)

    return types.int64(types.int64, types.int64), generate


def load_attribute(builder, frame, index):
    """In LLVM's code: an attribute, as `get_attribute` has it."""
    scalar = load_word(builder, load_word(builder, frame, _FRAME_ATTRIBUTES), index)
    return load_word(builder, load_word(builder, scalar, _SCALAR_VALUE), 0)


def list_buffers(builder, frame):
    """In LLVM's code: an array of the addresses where the frame keeps those of all operands and results, in order."""
    counts = load_word(builder, frame, _FRAME_OPERANDS - 2), load_word(builder, frame, _FRAME_RESULTS - 2)
    made = builder.alloca(_WORD, size=builder.add(*counts))
    first = _WORD(0)
    for count, place in zip(counts, (_FRAME_OPERANDS, _FRAME_RESULTS)):
        buffers = load_word(builder, frame, place)
        with cgutils.for_range(builder, count) as loop:
            data = find_word(builder, load_word(builder, buffers, loop.index), _BUFFER_DATA)
            builder.store(builder.ptrtoint(data, _WORD), builder.gep(made, [builder.add(first, loop.index)]))
        first = count
    return made


def call_api(builder, api, index: int, words: list):
    """In LLVM's code: what a function of XLA_FFI_Api gives for a structure of these words, and the structure."""
    structure = cgutils.alloca_once(builder, _WORD, size=len(words))
    for place, word in enumerate(words):
        builder.store(word, builder.gep(structure, [_WORD(place)]))
    kind = ir.FunctionType(_WORD, [_WORD.as_pointer()])
    function = builder.inttoptr(load_word(builder, api, index), kind.as_pointer())
    return builder.call(function, [structure]), structure


def _multiply_words(builder, address, count):
    """Of ``count`` words from ``address`` on."""
    total = cgutils.alloca_once_value(builder, _WORD(1))
    with cgutils.for_range(builder, count) as loop:
        builder.store(builder.mul(builder.load(total), load_word(builder, address, loop.index)), total)
    return builder.load(total)


@intrinsic
def read_word(typing, address, index):
    """The ``index``-th word from ``address`` on."""

    def generate(context, builder, signature, arguments):
        return load_word(builder, *arguments)

    return types.int64(types.int64, types.int64), generate


@intrinsic
def write_word(typing, address, index, value):
    """Write the ``index``-th word from ``address`` on."""

    def generate(context, builder, signature, arguments):
        builder.store(arguments[2], find_word(builder, *arguments[:2]))
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.int64), generate


def load_word(builder, address, index):
    """In LLVM's code: the ``index``-th word from ``address`` on."""
    return builder.load(find_word(builder, address, index))


def find_word(builder, address, index):
    """In LLVM's code: a pointer to it."""
    index = _WORD(index) if isinstance(index, int) else index
    return builder.gep(builder.inttoptr(address, _WORD.as_pointer()), [index])


@njit(**NO_WRAPPERS)
def answer_query(frame):
    """Return whether the call only asked for the handler's API version, which it then has got."""
    extension = read_word(frame, _FRAME_EXTENSION)
    if extension == 0 or (read_word(extension, _EXTENSION_TYPE) & 0xFFFFFFFF) != _METADATA:
        return False
    write_word(read_word(extension, _EXTENSION_METADATA), _VERSION_WORD, _VERSION)
    return True


@njit(**NO_WRAPPERS)
def allow_recording(frame):
    """Answer such a query further: each call launches the same, which a CUDA graph may record."""
    write_word(read_word(read_word(frame, _FRAME_EXTENSION), _EXTENSION_METADATA), _TRAITS_WORD, 1)
