"""Words of memory that threads share, how a thread waits for one to change, and the clocks that it has meanwhile.

A thread that waits gives way: it looks at the word for some microseconds, as long as waking a sleeper takes, and then
sleeps until whoever changes the word wakes it. On Linux the kernel's futex does that; elsewhere it sleeps by the clock.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportPrivateImportUsage=false, reportAttributeAccessIssue=false

from __future__ import annotations

import platform
import sys

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from physagent_jax.kernels import ffi

_WORD, _INT = ir.IntType(64), ir.IntType(32)
_MACHINE = platform.machine().lower()
_FUTEX_NUMBERS = {
    "x86_64": 202,
    "amd64": 202,
    "aarch64": 98,
    "arm64": 98,
    "riscv64": 98,
}  # of the system call
_FUTEX = _FUTEX_NUMBERS.get(_MACHINE) if sys.platform.startswith("linux") else None
_FUTEX_WAIT, _FUTEX_WAKE = 128, 129  # within one process
_NAP = 50  # [us] of a thread that nobody can wake
_CLOCKS = {"linux": (1, 3), "darwin": (6, 16)}.get(sys.platform)  # CLOCK_MONOTONIC, CLOCK_THREAD_CPUTIME_ID


@intrinsic
def add_word(typing, address, index, value):
    """Add to a word that threads share, and return what it was; what either did before, the next one sees."""

    def generate(context, builder, signature, arguments):
        place = ffi.find_word(builder, *arguments[:2])
        return builder.atomic_rmw("add", place, arguments[2], "seq_cst")

    return types.int64(types.int64, types.int64, types.int64), generate


@intrinsic
def read_shared(typing, address, index):
    """A word that threads share, with what was done before it was written."""

    def generate(context, builder, signature, arguments):
        return builder.load_atomic(ffi.find_word(builder, *arguments), "seq_cst", 8)

    return types.int64(types.int64, types.int64), generate


@intrinsic
def write_shared(typing, address, index, value):
    """Write a word that threads share."""

    def generate(context, builder, signature, arguments):
        builder.store_atomic(arguments[2], ffi.find_word(builder, *arguments[:2]), "seq_cst", 8)
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.int64), generate


@intrinsic
def pause(typing):
    """Let a core know that this thread looks at a word again and again."""

    def generate(context, builder, signature, arguments):
        if _MACHINE in ("x86_64", "amd64"):
            kind = ir.FunctionType(ir.VoidType(), [])
            builder.call(builder.module.declare_intrinsic("llvm.x86.sse2.pause", (), kind), [])
        return context.get_dummy_value()

    return types.void(), generate


@intrinsic
def sleep_while(typing, address, index, value):
    """Sleeps until `wake_all`, unless a word is not ``value`` any more; may return earlier."""

    def generate(context, builder, signature, arguments):
        if _FUTEX is not None:
            _call_futex(builder, ffi.find_word(builder, *arguments[:2]), _FUTEX_WAIT, arguments[2])
        elif sys.platform != "win32":
            _call_c(builder, "usleep", _INT, [_INT(_NAP)])
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.int64), generate


@intrinsic
def wake_all(typing, address, index):
    """Wakes those who sleep because of a word."""

    def generate(context, builder, signature, arguments):
        if _FUTEX is not None:
            place = ffi.find_word(builder, *arguments)
            _call_futex(builder, place, _FUTEX_WAKE, _WORD((1 << 31) - 1))
        return context.get_dummy_value()

    return types.void(types.int64, types.int64), generate


@intrinsic
def read_clock(typing):
    """Time that has passed [ns]; always 0 where it is not known how to ask."""
    return types.int64(), _make_clock(0)


@intrinsic
def read_own_clock(typing):
    """Time for which this thread has had a core [ns]; always 0 where it is not known how to ask."""
    return types.int64(), _make_clock(1)


def _make_clock(which: int):
    def generate(context, builder, signature, arguments):
        if _CLOCKS is None:
            return _WORD(0)
        time = cgutils.alloca_once_value(builder, ir.Constant(ir.ArrayType(_WORD, 2), [0, 0]))
        seconds, rest = (cgutils.gep_inbounds(builder, time, 0, k) for k in range(2))
        _call_c(builder, "clock_gettime", _INT, [_INT(_CLOCKS[which]), seconds])
        return builder.add(builder.mul(builder.load(seconds), _WORD(10**9)), builder.load(rest))

    return generate


def _call_futex(builder, place, operation: int, value):
    """Linux's system call on the lower half of a word."""
    kind = ir.FunctionType(_WORD, [_WORD], var_arg=True)
    function = cgutils.get_or_insert_function(builder.module, kind, "syscall")
    address, nothing = builder.ptrtoint(place, _WORD), _WORD(0)
    builder.call(function, [_WORD(_FUTEX), address, _WORD(operation), value, nothing, nothing, nothing])


def _call_c(builder, name: str, result, arguments: list):
    """Call a function of the C library."""
    kind = ir.FunctionType(result, [each.type for each in arguments])
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), arguments)
