"""Jobs one after another, or several side by side."""

from __future__ import annotations

import multiprocessing
import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from typing import TypeVar

T = TypeVar("T")


def call_all(
    calls: Sequence[Callable[[], Iterable[T]]],
    workers: int = 1,
    prepare: Callable[[], object] | None = None,
    groups: Sequence[str] | None = None,
) -> Iterator[tuple[int, list[T]]]:
    """Call each, and yield its place and what it returned as soon as it has.

    Args:
        calls: Without arguments; with several workers, what can be pickled.
        workers: Processes. One is this one. Each of several has its share of the cores to itself, so that
            multithreaded code does not fight over them; seconds are then those of a share.
        prepare: Called first in each of several.
        groups: Name per call. One worker does those of a name, in their order, with what it has compiled for
            the first of them, until there is nothing else left for another; None = each is on its own.
    """
    if workers == 1:
        yield from ((place, list(call())) for place, call in enumerate(calls))
        return
    waiting = _gather(groups or [str(place) for place in range(len(calls))])
    context = multiprocessing.get_context("spawn")
    pools = [ProcessPoolExecutor(1, context, _begin, (index, workers, prepare)) for index in range(workers)]
    lines = [deque[int]() for _ in pools]
    running: dict[Future[list[T]], tuple[int, int]] = {}

    def start(worker: int) -> None:
        line = lines[worker] = lines[worker] or (waiting.popleft() if waiting else _share(lines))
        if line:
            place = line.popleft()
            running[pools[worker].submit(_make_list, calls[place])] = worker, place

    try:
        for worker in range(workers):
            start(worker)
        while running:
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                worker, place = running.pop(future)
                yield place, future.result()
                start(worker)
    finally:
        for pool in pools:  # once each: a second call may find its pipe closed
            pool.shutdown(cancel_futures=True)


def _gather(groups: Sequence[str]) -> deque[deque[int]]:
    """The places of each name, in the order in which names first appear."""
    places: dict[str, deque[int]] = {}
    for place, name in enumerate(groups):
        places.setdefault(name, deque()).append(place)
    return deque(places.values())


def _share(lines: Sequence[deque[int]]) -> deque[int]:
    """The last of the longest line, for who has nothing to do."""
    longest = max(lines, key=len)
    return deque([longest.pop()] if longest else [])


def _make_list(call: Callable[[], Iterable[T]]) -> list[T]:
    return list(call())


def _begin(index: int, workers: int, prepare: Callable[[], object] | None) -> None:
    """Take this worker's share of the cores, before anything starts threads."""
    if hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, cores[index::workers] or cores)
    if prepare is not None:
        prepare()
