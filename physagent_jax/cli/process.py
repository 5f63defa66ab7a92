"""The `physagent` command as a process of its own, which begins and ends without needless work."""

from __future__ import annotations

import gc
import sys
from typing import NoReturn

THRESHOLDS = (100_000, 20, 50)
"""Thresholds of Python's cyclic garbage collector.

JAX and what it traces make hundreds of thousands of objects that stay. By default the collector looks at all of them
many times.
"""


def run_process() -> NoReturn:
    """Run the command line of this process and end it.

    A process that ends frees its memory at once. Objects that are frozen are not searched for cycles before that,
    which takes half a second; all else that Python does at its end is done.
    """
    gc.set_threshold(*THRESHOLDS)
    from physagent_jax.cli import main

    try:
        sys.exit(main())
    finally:
        gc.freeze()
