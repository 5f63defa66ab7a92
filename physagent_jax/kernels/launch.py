"""Parallel loops of Numba that XLA's threads may start.

Around every parallel loop Numba takes Python's global lock and gives it up again, for loops that may call Python.
Ours do not, and must not ask for it: Python ends a thread that does so once the interpreter shuts down. It is one of
XLA's threads, which never answers again, and the process hangs as XLA waits for it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from numba.np.ufunc import parallel


@contextmanager
def without_gil() -> Iterator[None]:
    """Lets parallel loops compiled within be started without Python's lock; hold Numba's compiler lock meanwhile."""
    build = parallel.build_gufunc_kernel

    def lockless(library, context, *arguments):
        return build(library, _Context(context), *arguments)

    parallel.build_gufunc_kernel = lockless
    try:
        yield
    finally:
        parallel.build_gufunc_kernel = build


class _Context:
    """Numba's code generation with a Python interface that has no lock."""

    def __init__(self, context):
        self._context = context

    def __getattr__(self, name: str):
        return getattr(self._context, name)

    def get_python_api(self, builder):
        """What the wrapper of a parallel loop asks of it, all of it for nothing."""
        del builder
        return _NoLock()


class _NoLock:
    def gil_ensure(self):
        return None

    def save_thread(self):
        return None

    def restore_thread(self, state):
        del state

    def gil_release(self, state):
        del state
