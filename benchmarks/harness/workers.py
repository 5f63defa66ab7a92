"""Jobs one after another, or several side by side."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import TypeVar

T = TypeVar("T")


def call_all(
    calls: Sequence[Callable[[], Iterable[T]]], workers: int = 1, prepare: Callable[[], object] | None = None
) -> Iterator[tuple[int, list[T]]]:
    """Calls each, and yields its place and what it returned as soon as it has.

    Args:
        calls: Without arguments; with several workers, what can be pickled.
        workers: Processes. One is this one. Each of several has its share of the cores to itself, so that
            multithreaded code does not fight over them; seconds are then those of a share.
        prepare: Called first in each of several.
    """
    if workers == 1:
        yield from ((place, list(call())) for place, call in enumerate(calls))
        return
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, context, _begin, (context.Value("i", 0), workers, prepare))
    try:
        places = {pool.submit(_make_list, call): place for place, call in enumerate(calls)}
        for done in as_completed(places):
            yield places[done], done.result()
    finally:
        pool.shutdown(cancel_futures=True)


def _make_list(call: Callable[[], Iterable[T]]) -> list[T]:
    return list(call())


def _begin(counter, workers: int, prepare: Callable[[], object] | None) -> None:
    """Takes this worker's share of the cores, before anything starts threads."""
    with counter.get_lock():
        index, counter.value = counter.value, counter.value + 1
    if hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, cores[index::workers] or cores)
    if prepare is not None:
        prepare()
