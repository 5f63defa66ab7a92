"""The number of threads of the CPU kernels."""

from __future__ import annotations

import os
from functools import cache

import numpy as np

from physagent_jax.core.errors import UserError


@cache
def thread_count() -> int:
    """Threads of a kernel: the cores that this process may use, or ``NUMBA_NUM_THREADS`` of them.

    Raises:
        UserError: That is no whole number from 1.
    """
    return min(read_limit(), core_count())


def read_limit() -> int:
    """``NUMBA_NUM_THREADS``; the cores that this process may use if it is not set.

    Raises:
        UserError: It is no whole number from 1: no thread would do a kernel's work.
    """
    asked = os.environ.get("NUMBA_NUM_THREADS")
    if asked is None:
        return core_count()
    if not (asked.isascii() and asked.isdigit() and 0 < int(asked[:5]) < 10_000):
        raise UserError(
            "`NUMBA_NUM_THREADS` must be a whole number from 1", got=asked, do="Unset it to use all cores"
        )
    return int(asked)


def choose_team() -> dict[str, np.int64]:
    """The attribute by which a call tells `kernels.team` how many threads are to run it."""
    return {"threads": np.int64(thread_count())}


def core_count() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
