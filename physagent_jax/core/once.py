"""Work that a process does once whichever of its threads asks first, and locks that no forked process finds taken.

`functools.cache` calls a function twice if two threads ask at the same time. That is waste where the function only
computes; where it registers something, makes a folder or starts a process, it is wrong: `once` is for those.
"""

from __future__ import annotations

import functools
import os
import threading
from collections.abc import Callable
from typing import Any, Generic, TypeVar

_Out = TypeVar("_Out")


class Once(Generic[_Out]):
    """A function that is called once for each tuple of arguments; other threads wait for the result.

    What it raises is not kept: the next caller tries again.

    Args:
        function: Function of positional, hashable arguments.
    """

    def __init__(self, function: Callable[..., _Out]):
        functools.update_wrapper(self, function)
        self.__wrapped__ = function
        self._results: dict[tuple, _Out] = {}
        self._locks: dict[tuple, threading.RLock] = {}  # type: ignore[valid-type]
        call_in_forked(self._locks.clear)

    def __call__(self, *arguments: Any) -> _Out:
        """The result of the one call with these arguments."""
        if arguments not in self._results:
            with self._locks.setdefault(arguments, threading.RLock()):
                if arguments not in self._results:
                    self._results[arguments] = self.__wrapped__(*arguments)
        return self._results[arguments]

    def cache_clear(self) -> None:
        """Forget all results, as of `functools.cache`."""
        self._results.clear()


def once(function: Callable[..., _Out]) -> Once[_Out]:
    """Decorates a function that a process must not run twice with the same arguments (`Once`)."""
    return Once(function)


def make_lock(*, awaited: bool = False) -> threading.RLock:  # type: ignore[valid-type]
    """A lock that is free in a forked process.

    Args:
        awaited: Whether forking waits until the thread that has it lets go, so that what it guards is whole in the
            forked process: for work of milliseconds, within which no other awaited lock is taken.
    """
    lock: Any = threading.RLock()
    if not awaited:
        call_in_forked(lock._at_fork_reinit)
    elif hasattr(os, "register_at_fork"):
        os.register_at_fork(before=lock.acquire, after_in_parent=lock.release, after_in_child=lock.release)
    return lock


def call_in_forked(function: Callable[[], object]) -> None:
    """Has ``function`` called in every process that forks from this one, before anything else is done there."""
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(after_in_child=function)
