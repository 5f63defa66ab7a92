"""How many threads the CPU kernels use."""

from __future__ import annotations

import os
from functools import cache

import numpy as np


@cache
def thread_count() -> int:
    """Threads of a kernel: ``NUMBA_NUM_THREADS`` if set, else the cores that this process may use."""
    asked = os.environ.get("NUMBA_NUM_THREADS")
    return min(int(asked), core_count()) if asked else core_count()


def choose_team() -> dict[str, np.int64]:
    """The attribute by which a call tells `kernels.team` how many threads are to run it."""
    return {"threads": np.int64(thread_count())}


def core_count() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
