"""Covering arrays: few rows in which every pair of values of every two axes occurs."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

Row = tuple[Any, ...]
_TRIES = 30  # candidates per row


def covering_array(
    axes: Mapping[str, Sequence[Any]], seed: int = 0, keys: Sequence[Row] | None = None
) -> list[dict]:
    """Rows over ``axes`` that cover all pairs, made greedily.

    Args:
        axes: Values by name, in order.
        seed: Same seed, same rows.
        keys: The only combinations allowed of the first axes, each as long as there are such axes; they must
            cover the pairs among these axes. None = any.

    Returns:
        One dictionary per row.
    """
    values = [list(range(len(axis))) for axis in axes.values()]
    allowed = None if keys is None else [_find_indices(axes, key) for key in keys]
    rng = np.random.default_rng(seed)
    missing = set(_list_pairs(values))
    rows = []
    while missing:
        candidates = [_make_candidate(values, allowed, missing, rng) for _ in range(_TRIES)]
        row = max(candidates, key=lambda row: len(missing & set(_list_row_pairs(row))))
        missing -= set(_list_row_pairs(row))
        rows.append(row)
    names = list(axes)
    return [{name: axes[name][index] for name, index in zip(names, row)} for row in rows]


def uncovered(axes: Mapping[str, Sequence[Any]], rows: Iterable[Mapping[str, Any]]) -> int:
    """Number of pairs of values that ``rows`` leave out."""
    missing = set(_list_pairs([list(range(len(axis))) for axis in axes.values()]))
    for row in rows:
        missing -= set(_list_row_pairs([list(axes[name]).index(row[name]) for name in axes]))
    return len(missing)


def _find_indices(axes: Mapping[str, Sequence[Any]], key: Row) -> list[int]:
    return [list(axis).index(value) for axis, value in zip(axes.values(), key)]


def _list_pairs(values: list[list[int]]) -> Iterable[tuple[int, int, int, int]]:
    for a, b in itertools.combinations(range(len(values)), 2):
        for i, j in itertools.product(values[a], values[b]):
            yield a, i, b, j


def _list_row_pairs(row: Sequence[int]) -> Iterable[tuple[int, int, int, int]]:
    for a, b in itertools.combinations(range(len(row)), 2):
        yield a, row[a], b, row[b]


def _make_candidate(values, allowed, missing, rng: np.random.Generator) -> list[int]:
    """A row that starts from a missing pair and is filled with what covers most, axis by axis."""
    ordered = sorted(missing)
    a, i, b, j = ordered[rng.integers(len(ordered))]
    chosen: dict[int, int] = {a: i, b: j}
    if allowed is not None:
        fitting = [
            key for key in allowed if all(key[axis] == v for axis, v in chosen.items() if axis < len(key))
        ]
        chosen.update(enumerate(fitting[rng.integers(len(fitting))]))
    for axis in rng.permutation(len(values)):
        if axis in chosen:
            continue
        scores = [
            sum(_make_pair(axis, v, other, w) in missing for other, w in chosen.items()) for v in values[axis]
        ]
        best = [v for v, score in zip(values[axis], scores) if score == max(scores)]
        chosen[int(axis)] = best[rng.integers(len(best))]
    return [chosen[axis] for axis in range(len(values))]


def _make_pair(a: int, i: int, b: int, j: int) -> tuple[int, int, int, int]:
    return (a, i, b, j) if a < b else (b, j, a, i)
