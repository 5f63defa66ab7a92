"""The account of what helpers bring and cost: whether kernels of this process ask for any.

A call by one thread takes the time of all the work. With helpers it takes that less what they work, plus what the
thread that the call was given to waits for them. Where cores are free they bring much and cost little. Where other
programs run, the system takes a helper's core away for milliseconds in the middle of an iteration, and all wait: if
that costs more than helpers bring, kernels do without them for a while, and then try again.

One account for all kernels of a process, as it depends on the machine and not on the kernel.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportPrivateImportUsage=false, reportAttributeAccessIssue=false

from __future__ import annotations

import llvmlite.binding as llvm
import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

from physagent_jax.kernels.numbers import INLINE, OPTIONS
from physagent_jax.kernels.words import add_word, read_clock, read_shared, write_shared

BALANCE, UNTIL, REST = (
    0,
    8,
    9,
)  # [ns]: brought less cost; the clock until which nobody is asked; how long that lasts
MOST = 8_000_000  # [ns] of balance that is remembered: what was brought long ago says little
LEAST = (
    -4_000_000
)  # [ns] of balance at which helpers are not asked any more: about the time for which a core is taken
SHORTEST_REST, LONGEST_REST = 50_000_000, 400_000_000  # [ns]; twice as long each time
_NAME = "physagent_account"

words = np.zeros(16, np.int64)
llvm.add_symbol(_NAME, words.ctypes.data)


@intrinsic
def _find_account(typing):
    """The address of `words`: by a name, since code that is kept on disk holds no addresses."""

    def generate(context, builder, signature, arguments):
        module = builder.module
        place = module.globals.get(_NAME) or ir.GlobalVariable(module, ir.IntType(64), _NAME)
        return builder.ptrtoint(place, ir.IntType(64))

    return types.int64(), generate


@njit(**OPTIONS)
def is_resting():
    """Return whether no helpers are asked at present."""
    until = read_shared(_find_account(), UNTIL)
    return until != 0 and read_clock() < until


@njit(**INLINE)
def note_work(nanoseconds):
    """Add a helper's work to the account."""
    add_word(_find_account(), BALANCE, nanoseconds)


@njit(**OPTIONS)
def note_wait(nanoseconds):
    """Subtract a call's wait for its helpers, as the last step of the call."""
    account = _find_account()
    balance = add_word(account, BALANCE, -nanoseconds) - nanoseconds
    if balance > MOST:
        write_shared(account, BALANCE, MOST)
        write_shared(account, REST, 0)
    elif balance < LEAST:
        rest = min(max(2 * read_shared(account, REST), SHORTEST_REST), LONGEST_REST)
        write_shared(account, BALANCE, 0)
        write_shared(account, REST, rest)
        write_shared(account, UNTIL, read_clock() + rest)
