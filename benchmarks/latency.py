"""The latency of a word between two cores: it tells whether they share a cache.

A virtual machine's cores may lie in one part of a processor at one moment and in two the next. What threads hand to
each other then goes through memory, and a code that does so much is slower, at the same number of cores.
"""

from __future__ import annotations

import os
import threading
import time

import numpy as np
from numba import njit

from physagent_jax.kernels.words import add_word, read_shared

SHARED = 100e-9
"""[s] below which two cores have a cache in common: some 50 ns on server processors, and 150 or more where not."""
_TURNS = 10_000


def measure_latency() -> float | None:
    """One way between the first two cores of this process [s]; None where there is one, or they cannot be chosen."""
    cores = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []
    if len(cores) < 2:
        return None
    word = np.zeros(8, np.int64)
    _take_turns(word.ctypes.data, 0, 0)  # compiles

    def play(player: int) -> None:
        os.sched_setaffinity(0, {cores[player]})  # of this thread alone
        _take_turns(word.ctypes.data, player, _TURNS)

    other = threading.Thread(target=play, args=(1,))
    begun = time.perf_counter()
    other.start()
    try:
        play(0)
        other.join()
    finally:
        os.sched_setaffinity(0, cores)
    return (time.perf_counter() - begun) / (2 * _TURNS)


@njit(nogil=True)
def _take_turns(address, player, turns):
    """Count a word up whenever it is this player's turn."""
    for turn in range(turns):
        while read_shared(address, 0) != 2 * turn + player:
            pass
        add_word(address, 0, 1)
