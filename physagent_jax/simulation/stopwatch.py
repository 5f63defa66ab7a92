"""Wall time per stage, with JAX's compilation told apart from running."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import jax

from physagent_jax.core.once import make_lock

_COMPILE_EVENTS = "/jax/core/compile/"
_compile_seconds = 0.0
_lock = make_lock()  # programs are compiled in several threads
_aside = threading.local()  # `on`: whether this thread works beside what is timed


def _listen(event: str, duration_secs: float, **_: str | int) -> None:
    global _compile_seconds
    if event.startswith(_COMPILE_EVENTS) and not getattr(_aside, "on", False):
        with _lock:
            _compile_seconds += duration_secs


jax.monitoring.register_event_duration_secs_listener(_listen)


@contextmanager
def stay_aside() -> Iterator[None]:
    """Keep what this thread compiles in the ``with`` block out of all stages: they are timed in another thread."""
    _aside.on = True
    try:
        yield
    finally:
        _aside.on = False


class Stopwatch:
    """Charges time to named stages; what JAX spends on tracing and compiling goes to "compile" instead.

    Args:
        earlier: Seconds by stage to count on from, when a stopped run is taken up.
    """

    def __init__(self, earlier: Mapping[str, float] | None = None):
        self._seconds: dict[str, float] = dict(earlier or {})
        self._instead: str | None = None

    @contextmanager
    def all_to(self, stage: str):
        """Charge whatever is timed in the ``with`` block to ``stage``; compilation stays apart."""
        self._instead = stage
        try:
            yield
        finally:
            self._instead = None

    @contextmanager
    def __call__(self, stage: str):
        """Charge the time of the ``with`` block to ``stage``."""
        begun, compiled = time.perf_counter(), _compile_seconds
        try:
            yield
        finally:
            seconds = time.perf_counter() - begun
            compiling = min(_compile_seconds - compiled, seconds)
            self._charge(self._instead or stage, seconds - compiling)
            self._charge("compile", compiling)

    def timed(self, stage: str, items: Iterator) -> Iterator:
        """Yield ``items``, charging the time that making each takes to ``stage``."""
        sentinel = object()
        while True:
            with self(stage):
                item = next(items, sentinel)
            if item is sentinel:
                return
            yield item

    def seconds(self) -> dict[str, float]:
        """The seconds so far, by stage."""
        return {name: round(seconds, 4) for name, seconds in self._seconds.items()}

    def _charge(self, stage: str, seconds: float) -> None:
        self._seconds[stage] = self._seconds.get(stage, 0.0) + seconds
