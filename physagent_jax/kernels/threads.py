"""How many threads the CPU kernels use, and on what."""

from __future__ import annotations

import os
from functools import cache

from physagent_jax.core.errors import UserError

# Waiting threads must not spin: between two kernels XLA needs the cores. Read when the OpenMP runtime is loaded.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")


@cache
def thread_count() -> int:
    """Threads of a kernel: ``NUMBA_NUM_THREADS`` if set, else the cores that this process may use.

    Also starts Numba's threading layer, which compiled code from the cache needs to be there.

    Raises:
        UserError: The threading layer that was asked for is not to be had.
    """
    import numba

    try:
        return min(numba.get_num_threads(), core_count())
    except ValueError as error:
        raise UserError(
            "Numba cannot start its threads",
            got=str(error).splitlines()[0],
            do="Unset `NUMBA_THREADING_LAYER`, or set it to omp or workqueue",
        ) from error


def caller_count() -> int:
    """Threads that may run kernels at the same time: one per core, but one alone where Numba's layer forbids more."""
    import numba

    return thread_count() if thread_count() > 1 and numba.threading_layer() != "workqueue" else 1  # type: ignore[attr-defined]


def core_count() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
