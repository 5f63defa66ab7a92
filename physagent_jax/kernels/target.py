"""Handlers as names that XLA can call."""

from __future__ import annotations

from functools import cache

from physagent_jax.kernels import ahead, ffi, store
from physagent_jax.kernels.threads import thread_count


@cache
def register_target(name: str, function) -> str:
    """Compiles ``function``, a handler of `ffi`, unless the disk has it, and registers it under ``name``."""
    thread_count()  # starts the threads: compiled code from the disk asks for them as it is loaded
    ahead.wait_for(name)
    ffi.register(name, store.load_or_compile(name, ffi.HANDLER, function))
    return name
