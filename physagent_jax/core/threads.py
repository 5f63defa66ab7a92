"""Work done ahead of whoever waits for it."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

_In = TypeVar("_In")
_Out = TypeVar("_Out")


def map_ahead(function: Callable[[_In], _Out], items: Iterable[_In], at_once: int) -> Iterator[_Out]:
    """`map`, with the next ``at_once`` results made in threads while the caller is busy with the one before.

    The first is made alone: what all have in common, compiled programs among it, is then there.
    """
    waiting = iter(items)
    for first in waiting:
        yield function(first)
        break
    with ThreadPoolExecutor(at_once) as pool:
        coming: deque = deque()
        for item in waiting:
            coming.append(pool.submit(function, item))
            if len(coming) > at_once:
                yield coming.popleft().result()
        while coming:
            yield coming.popleft().result()
