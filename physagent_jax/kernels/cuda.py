"""CUDA C++ kernels as XLA custom calls, compiled at run time by NVIDIA's NVRTC, which comes with JAX for CUDA.

One handler serves all kernels: it hands the addresses of all operands and results, in this order, to the kernel that
an attribute names by number. XLA may record it in a CUDA graph.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportPrivateImportUsage=false, reportAttributeAccessIssue=false

from __future__ import annotations

import ctypes
import hashlib
import logging
import os
import sysconfig
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import jax
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils, sigutils
from numba.core.ccallback import CFunc
from numba.extending import intrinsic

from physagent_jax.core.once import once
from physagent_jax.kernels import ffi, store

log = logging.getLogger(__name__)
THREADS = 128  # of a block
_TARGET = "physagent_cuda"
_MOST_KERNELS = 256
_functions = (ctypes.c_int64 * _MOST_KERNELS)()  # where the handler looks for a kernel by its number
_MAJOR, _MINOR = 75, 76  # CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR and _MINOR
_MESSAGE = ctypes.create_string_buffer(b"a CUDA kernel of physagent_jax could not be launched")
_GET_STREAM, _MAKE_ERROR = 10, 6  # XLA_FFI_Stream_Get and XLA_FFI_Error_Create, within XLA_FFI_Api
_INTERNAL = 13  # XLA_FFI_Error_Code_INTERNAL
_WORD, _INT = ir.IntType(64), ir.IntType(32)


@once
def explain_missing() -> str:
    """The reason why kernels cannot be compiled or launched here; "" if they can."""
    try:
        _load_driver()
        _load_compiler()
    except OSError as error:
        log.warning("the CUDA kernels are not available (%s): pure JAX serves, several times slower", error)
        return str(error)
    return ""


def launch(
    number: int,
    source: Path,
    function: str,
    macros: Mapping[str, object],
    results: Sequence[jax.ShapeDtypeStruct],
    operands: Sequence[Any],
    threads: int,
    **options: Any,
) -> Any:
    """Launch a kernel on ``operands``, and return its results.

    Args:
        number: The kernel's own, the same in every process: compiled programs that JAX keeps on the disk name it.
        source: File of CUDA C++.
        function: Name of an ``extern "C" __global__`` function in it, which takes a pointer to each operand and result.
        macros: Definitions for the compiler; THREADS, the threads of a block, is added.
        results: Shapes and types.
        operands: Arrays.
        threads: Threads in all; the last block may have more.
        options: Further options of `jax.ffi.ffi_call`.
    """
    if not _functions[number]:
        defined = tuple(sorted({**macros, "THREADS": THREADS}.items()))
        _functions[number] = _load_function(source, function, defined)
    call = jax.ffi.ffi_call(_register(), results, vmap_method="sequential", **options)
    return call(*operands, blocks=np.int64(-(-threads // THREADS)), kernel=np.int64(number))


# Compiler and driver


def _load_function(source: Path, function: str, macros: tuple[tuple[str, object], ...]) -> int:
    """A CUkernel, which serves every device of this kind."""
    driver = _load_driver()
    code = _compile(source, function, macros, _find_architecture(driver))
    library, kernel = ctypes.c_void_p(), ctypes.c_void_p()
    none = (ctypes.c_void_p(), ctypes.c_void_p(), 0)
    _check(driver.cuLibraryLoadData(ctypes.byref(library), code, *none, *none), "cuLibraryLoadData")
    _check(driver.cuLibraryGetKernel(ctypes.byref(kernel), library, function.encode()), "cuLibraryGetKernel")
    assert kernel.value is not None
    return kernel.value


def _find_architecture(driver: Any) -> str:
    """Architecture of the first device, like "sm_90"."""
    found = []
    for attribute in (_MAJOR, _MINOR):
        value = ctypes.c_int()
        _check(driver.cuDeviceGetAttribute(ctypes.byref(value), attribute, 0), "cuDeviceGetAttribute")
        found.append(value.value)
    return "sm_{}{}".format(*found)


def _compile(source: Path, function: str, macros: tuple[tuple[str, object], ...], architecture: str) -> bytes:
    """Machine code of a source file: from the disk, or compiled and kept."""
    options = [f"--gpu-architecture={architecture}", "--std=c++17"]
    options += [f"--define-macro={name}={value}" for name, value in macros]
    text, compiler = source.read_bytes(), _load_compiler()
    digest = hashlib.sha256(b"\0".join([text, *(option.encode() for option in options)]))
    kept = store.find_folder() / f"{function}-{digest.hexdigest()[:16]}.cubin"
    if kept.is_file():
        return kept.read_bytes()
    program, size = ctypes.c_void_p(), ctypes.c_size_t()
    given = (ctypes.c_char_p * len(options))(*(option.encode() for option in options))
    compiler.nvrtcCreateProgram(ctypes.byref(program), text, source.name.encode(), 0, None, None)
    try:
        if compiler.nvrtcCompileProgram(program, len(options), given):
            compiler.nvrtcGetProgramLogSize(program, ctypes.byref(size))
            said = ctypes.create_string_buffer(size.value)
            compiler.nvrtcGetProgramLog(program, said)
            raise RuntimeError(f"NVRTC refuses {source.name}: {said.value.decode(errors='replace')}")
        compiler.nvrtcGetCUBINSize(program, ctypes.byref(size))
        code = ctypes.create_string_buffer(size.value)
        compiler.nvrtcGetCUBIN(program, code)
    finally:
        compiler.nvrtcDestroyProgram(ctypes.byref(program))
    try:
        with tempfile.NamedTemporaryFile(dir=kept.parent, delete=False) as file:
            file.write(code.raw)
        os.replace(file.name, kept)
    except OSError as error:  # a full disk costs a compilation each time, nothing else
        log.warning("%s cannot be kept: %s", kept, error)
    return code.raw


@once
def _load_driver() -> Any:
    driver = ctypes.CDLL("libcuda.so.1")
    _check(driver.cuInit(0), "cuInit")
    return driver


@once
def _load_compiler() -> Any:
    """NVRTC: of the packages that JAX for CUDA needs, else the system's."""
    folder = Path(sysconfig.get_paths()["purelib"])
    for place in [*sorted(folder.glob("nvidia/*/lib/libnvrtc.so.*"), reverse=True), Path("libnvrtc.so")]:
        try:
            for part in place.parent.glob("libnvrtc-builtins.so.*"):  # else it is looked for on the system
                ctypes.CDLL(str(part))
            return ctypes.CDLL(str(place))
        except OSError:
            continue
    raise OSError("NVIDIA's NVRTC is not installed: it comes with `jax[cuda13]`")


def _check(status: int, name: str) -> None:
    if status:
        raise OSError(f"{name} failed with CUDA error {status}")


# Handler


@once
def _register() -> str:
    """Name of the handler, which is compiled for this process: it holds addresses."""
    address = ctypes.cast(_load_driver().cuLaunchKernel, ctypes.c_void_p).value
    assert address is not None
    handler = make_handler(address)
    new_capsule = ctypes.pythonapi.PyCapsule_New
    new_capsule.restype, new_capsule.argtypes = ctypes.py_object, (ctypes.c_void_p,) + (ctypes.c_char_p,) * 2
    jax.ffi.register_ffi_target(_TARGET, new_capsule(handler.address, None, None), platform="CUDA")
    _kept.append(handler)
    return _TARGET


_kept: list[CFunc] = []


def make_handler(address: int) -> CFunc:
    """The handler, which launches with the function at ``address`` (`cuLaunchKernel`)."""
    launch_kernel = _make_launch(address, ctypes.addressof(_functions), ctypes.addressof(_MESSAGE))

    def handle(frame):
        if ffi.answer_query(frame):
            ffi.allow_recording(frame)
            return 0
        return launch_kernel(frame)

    made = CFunc(handle, sigutils.normalize_signature(ffi.HANDLER), locals={}, options={})
    made.compile()
    return made


def _make_launch(address: int, functions: int, message: int) -> Callable:
    @intrinsic
    def launch_kernel(typing, frame):
        """Launch; 0, or XLA's error."""

        def generate(context, builder, signature, arguments):
            (frame,) = arguments
            api = ffi.load_word(builder, frame, ffi.FRAME_API)
            words = [_WORD(32), _WORD(0), ffi.load_word(builder, frame, ffi.FRAME_CONTEXT), _WORD(0)]
            error, asked = ffi.call_api(builder, api, _GET_STREAM, words)
            answer = cgutils.alloca_once_value(builder, error)
            with builder.if_then(builder.icmp_unsigned("==", error, _WORD(0))):
                stream = builder.load(builder.gep(asked, [_WORD(3)]))
                status = start(builder, frame, stream)
                with builder.if_then(builder.icmp_unsigned("!=", status, _INT(0)), likely=False):
                    words = [_WORD(32), _WORD(0), _WORD(message), _WORD(_INTERNAL)]
                    builder.store(ffi.call_api(builder, api, _MAKE_ERROR, words)[0], answer)
            return builder.load(answer)

        def start(builder, frame, stream):
            blocks, number = (ffi.load_attribute(builder, frame, _WORD(index)) for index in (0, 1))
            parameters = ffi.list_buffers(builder, frame)
            function = ffi.load_word(builder, _WORD(functions), number)
            kind = ir.FunctionType(_INT, [_WORD, *[_INT] * 7, _WORD, _WORD.as_pointer(), _WORD])
            call = builder.inttoptr(_WORD(address), kind.as_pointer())
            blocks = builder.trunc(blocks, _INT)
            shape = [blocks, _INT(1), _INT(1), _INT(THREADS), _INT(1), _INT(1), _INT(0)]
            return builder.call(call, [function, *shape, stream, parameters, _WORD(0)])

        return types.int64(types.int64), generate

    return launch_kernel
