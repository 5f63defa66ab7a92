"""Sheets of a study: which clips each participant is shown, beside which others, and in which place."""

from __future__ import annotations

import collections
import dataclasses
import itertools
import random
from collections.abc import Sequence


@dataclasses.dataclass(frozen=True)
class Balance:
    """Least and most times that the design shows a method, two methods beside each other, and a method in one place."""

    shown: tuple[int, int]
    pairs: tuple[int, int]
    places: tuple[int, int]


Set = tuple[int, tuple[str, ...]]
"""Index of an item and the methods that are shown, from left to right."""


def make_sheets(
    items: Sequence[Sequence[str]], alternatives: int, *, sheets: int, sets: int, seed: int
) -> tuple[list[list[Set]], Balance]:
    """Deal sets to sheets so that methods, pairs and places come up as equally often as they can.

    Each set goes to the methods, pairs and places that had the fewest so far: first on its item, then over all, and
    for places first on the sheet. Ties are drawn. Where all items have as many methods as a set has alternatives,
    every set is complete; else the design is an incomplete block design, balanced up to what is missing.

    Args:
        items: Methods that have a clip, of each item.
        alternatives: Number of clips side by side.
        sheets: Number of sheets.
        sets: Number of sets on a sheet, at most that of the items.
        seed: Seed of the draws.
    """
    draw = random.Random(seed)
    count: collections.Counter = collections.Counter()
    made = []
    for sheet in range(sheets):
        order = sorted(range(len(items)), key=lambda item: (count["item", item], draw.random()))[:sets]
        draw.shuffle(order)
        page = []
        for item in order:
            chosen: list[str] = []
            while len(chosen) < alternatives:
                rest = [method for method in items[item] if method not in chosen]
                chosen.append(min(rest, key=lambda method: _rate(count, item, method, chosen, draw)))
            places = list(itertools.permutations(chosen))
            draw.shuffle(places)
            shown = min(places, key=lambda row: _rate_places(count, sheet, item, row))
            _note(count, sheet, item, shown)
            page.append((item, shown))
        made.append(page)
    return made, _measure(count, items, alternatives)


def _rate(
    count: collections.Counter, item: int, method: str, chosen: list[str], draw: random.Random
) -> tuple:
    pairs = [frozenset((method, other)) for other in chosen]
    return (
        sum(count[item, pair] for pair in pairs),
        count[item, method],
        sum(count["pair", pair] for pair in pairs),
        count["method", method],
        draw.random(),
    )


def _rate_places(count: collections.Counter, sheet: int, item: int, row: tuple[str, ...]) -> tuple[int, int]:
    """Sums of squares grow least where the rarest place is taken."""
    mine = sum(count["sheet", sheet, method, place] for place, method in enumerate(row))
    whole = sum(
        count["place", method, place] + count[item, method, place] for place, method in enumerate(row)
    )
    return mine, whole


def _note(count: collections.Counter, sheet: int, item: int, row: tuple[str, ...]) -> None:
    count["item", item] += 1
    for place, method in enumerate(row):
        for key in (("method", method), (item, method), ("place", method, place), (item, method, place)):
            count[key] += 1
        count["sheet", sheet, method, place] += 1
    for pair in map(frozenset, itertools.combinations(row, 2)):
        count["pair", pair] += 1
        count[item, pair] += 1


def _measure(count: collections.Counter, items: Sequence[Sequence[str]], alternatives: int) -> Balance:
    methods = sorted({method for item in items for method in item})
    pairs = {frozenset(pair) for item in items for pair in itertools.combinations(item, 2)}
    shown = [count["method", method] for method in methods]
    together = [count["pair", pair] for pair in pairs]
    places = [count["place", method, place] for method in methods for place in range(alternatives)]
    return Balance(*((min(each), max(each)) for each in (shown, together, places)))
