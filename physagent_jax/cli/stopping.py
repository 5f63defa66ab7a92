"""Stopping on request: Ctrl-C or SIGTERM asks the work to stop at its next frame, and a second one ends it at once.

Python's own way, an exception at an arbitrary place, is lost when it comes while JAX's callback on garbage collection
runs: the run then goes on.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_asked: signal.Signals | None = None


class Stopped(KeyboardInterrupt):
    """The work has stopped because it was asked to.

    Attributes:
        exit_code: What a shell expects of a process that a signal has ended.
    """

    def __init__(self, by: signal.Signals):
        super().__init__()
        self.exit_code = 128 + by


@contextmanager
def allow_stopping() -> Iterator[None]:
    """Let `check` answer to signals within the ``with`` block; in threads other than the main one, nothing changes."""
    global _asked
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    _asked = None
    before = {number: signal.signal(number, _ask) for number in _SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def check() -> None:
    """Raise `Stopped` if the process has been asked to stop; called where nothing is half done."""
    if _asked is not None:
        raise Stopped(_asked)


def _ask(number: int, _) -> None:
    global _asked
    if _asked is None:
        _asked = signal.Signals(number)
        os.write(2, b"stopping at the next frame; once more to stop at once\n")
    else:
        signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)
