"""The last few results of a measurement that takes longer than to ask for it again."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar

_Out = TypeVar("_Out")


class Recent(Generic[_Out]):
    """Results by the object that was measured and the settings of it; threads may share one.

    Two threads that ask at the same time both measure, and each gets its own result.

    Args:
        most: Results that are kept.
    """

    def __init__(self, most: int):
        self._most = most
        self._kept: tuple[tuple[object, Any, _Out], ...] = ()

    def find(self, thing: object, settings: Any, measure: Callable[[], _Out]) -> _Out:
        """The result of ``measure`` for this very ``thing`` and equal ``settings``, remembered or measured now."""
        for its_thing, its_settings, result in self._kept:
            if its_thing is thing and its_settings == settings:
                return result
        result = measure()
        self._kept = (*self._kept, (thing, settings, result))[-self._most :]
        return result
