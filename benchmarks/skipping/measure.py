"""A row of the table: both ways run in turns, their times and their answers compared."""

from __future__ import annotations

import math
import statistics
import time
from typing import Any

from scipy.stats import binomtest

from benchmarks.skipping.base import Pair, Sizes, Skip, Way, disagreement, finished

FEWEST = 6  # rounds: with fewer, none could be called sure
CHANCE = 0.02  # that the verdict "saves" is noise: of as many rounds going one way by accident
LEAST = 0.01  # a saving or cost below this share is none, however sure

WAYS = ("lean", "full")
NOT_MEASURABLE = "no measurable saving"


def row(skip: Skip, sizes: Sizes) -> dict[str, Any]:
    """Measures ``skip``. A way that cannot be run makes a failing row with its reason, not an exception."""
    blank = {
        "name": skip.name,
        "state": skip.state.value,
        "left_out": skip.left_out,
        "forced": skip.forced,
        "tolerance": skip.tolerance,
        "reason": skip.reason,
        "message": "",
    }
    try:
        pair = skip.pair(sizes)
        measured, found = timed(pair, sizes)
        judged = judge(skip, *found)
        note = pair.note(found[0]) if callable(pair.note) else pair.note
    except Exception as error:  # whatever it is, the other rows are not to be lost
        message = f"{type(error).__name__}: {' '.join(str(error).split())}"
        return blank | {"good": False, "message": message}
    about = dict(particles=pair.particles, unit=pair.unit, share=pair.share, note=note)
    return blank | about | measured | judged


def judge(skip: Skip, lean: Any, full: Any) -> dict[str, Any]:
    """Return whether two answers agree; the row's columns of it. Infinite differences are None."""
    if skip.errors:
        errors = {f"{name}_error": float(answer["error"]) for name, answer in zip(WAYS, (lean, full))}
        good = abs(errors["lean_error"]) <= skip.tolerance
        message = "" if good else f"the error {errors['lean_error']:.2g} exceeds {skip.tolerance:g}"
        return errors | {"disagreement": None, "good": good, "message": message}
    largest, where = disagreement(lean, full)
    good = largest <= skip.tolerance
    message = "" if good else f"`{where}` differs by {largest:.2g}, more than {skip.tolerance:g}"
    return {
        "disagreement": largest if math.isfinite(largest) else None,
        "where": where,
        "good": good,
        "message": message,
    }


def answers(pair: Pair) -> tuple[Any, Any]:
    """Both answers, from one run each."""
    return pair.lean.read(finished(pair.lean)), pair.full.read(finished(pair.full))


def timed(pair: Pair, sizes: Sizes) -> tuple[dict[str, Any], tuple[Any, Any]]:
    """The row's columns of time, and both answers.

    The first run of each way compiles, and gives its answer; what it took beyond a warm one is called compilation.
    Then the ways take turns, each round beginning with the other one.
    """
    ways: dict[str, Way] = dict(zip(WAYS, (pair.lean, pair.full)))
    first, found, runs, turn = {}, {}, {}, 0.0
    for name, way in ways.items():
        begun = time.perf_counter()
        result = finished(way)
        first[name] = time.perf_counter() - begun
        found[name] = way.read(result)
        once = _average_time(way, 1)
        runs[name] = max(1, math.ceil(sizes.sample / once))
        turn += runs[name] * once
    rounds = max(min(sizes.rounds, FEWEST), min(sizes.rounds, int(sizes.seconds / turn)))
    seconds: dict[str, list[float]] = {name: [] for name in ways}
    for index in range(rounds):
        for name in WAYS if index % 2 == 0 else reversed(WAYS):
            seconds[name].append(_average_time(ways[name], runs[name]))
    columns: dict[str, Any] = {"rounds": rounds}
    for name, samples in seconds.items():
        each = [1e3 * sample / pair.share for sample in samples]
        compiled = max(0.0, first[name] - statistics.median(samples))
        columns[f"{name}_ms"] = _round(statistics.median(each))
        columns[f"{name}_range_ms"] = [_round(min(each)), _round(max(each))]
        columns[f"{name}_runs_a_round"] = runs[name]
        columns[f"{name}_compile_seconds"] = round(compiled, 2)
    ratios = [full / lean for lean, full in zip(seconds["lean"], seconds["full"])]
    columns |= {"saving": _round(statistics.median(ratios)), "verdict": verdict(ratios)}
    return columns, (found["lean"], found["full"])


def verdict(ratios: list[float]) -> str:
    """Verdict on the rounds' times without the skip over those with it: "saves", "costs", or nothing.

    By the sign test: if there were no difference, each round would go either way with equal chance. It asks nothing of
    the distribution, so that a few rounds disturbed by other work on the machine do not decide.
    """
    saving = statistics.median(ratios)
    for word, against in (("saves", 1 + LEAST), ("costs", 1 - LEAST)):
        sign = 1 if word == "saves" else -1
        wins = sum(sign * (ratio - 1) > 0 for ratio in ratios)
        sure = binomtest(wins, len(ratios), 0.5, alternative="greater").pvalue <= CHANCE
        if sure and sign * (saving - against) > 0:
            return word
    return NOT_MEASURABLE


def _average_time(way: Way, runs: int) -> float:
    """Seconds per run, of so many in a row."""
    begun = time.perf_counter()
    for _ in range(runs):
        finished(way)
    return (time.perf_counter() - begun) / runs


def _round(value: float) -> float:
    return float(f"{value:.4g}")
