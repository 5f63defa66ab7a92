"""Sentences about two methods: each is what a test of the rows supports, or says that none does."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

from baselines.fits import Pair, Rows, compare, is_measured
from physagent_jax.metrics.statistics import CONTRARY, LEVEL, correct, find_smallest_difference


@dataclasses.dataclass(frozen=True)
class Question:
    """Question which of two methods solves more tasks.

    Attributes:
        one, other: Labels of the methods.
        mark: Budget of both [forward-equivalents]; None = the last that both have reached.
    """

    one: str
    other: str
    mark: float | None = None


COMPARISON = (
    Question("rules", "random", 1.0),
    Question("rules", "random"),
    Question("rules", "expert"),
    Question("hybrid", "rules"),
    Question("levenberg_marquardt, all types", "random"),
    Question("levenberg_marquardt, all types", "catcma"),
    Question("levenberg_marquardt, responses", "levenberg_marquardt, all types", 30.0),
    Question("levenberg_marquardt, responses", "levenberg_marquardt, all types"),
)
ABLATION = (
    Question("full", "without refinement"),
    Question("full", "direction_only, feedback"),
    Question("privileged", "full"),
    Question("types: agent, numbers: least squares", "types: agent, numbers: agent"),
)


def answer(questions: Sequence[Question], groups: Mapping[str, Rows]) -> str:
    """A line for each question whose methods were measured, as Markdown; p values are corrected over all of them.

    The last mark that both have may be one that another question names: that is one question.
    """
    asked = [each for each in questions if each.one in groups and each.other in groups]
    asked = [
        each
        for each in asked
        if each.mark is None or all(is_measured(groups[label], each.mark) for label in (each.one, each.other))
    ]
    pairs = [(each, compare(groups[each.one], groups[each.other], each.mark)) for each in asked]
    known = {(each.one, each.other, pair.mark): pair for each, pair in pairs if pair is not None}
    corrected = correct([pair.successes for pair in known.values()])
    lines = [state(one, other, pair, p) for ((one, other, _), pair), p in zip(known.items(), corrected)]
    return "".join(f"- {line}\n" for line in lines)


def state(one: str, other: str, pair: Pair, p_value: float) -> str:
    """One sentence: which method solves more tasks, if the test says so."""
    at = f"{pair.mark:g} simulation{'s' if pair.mark != 1 else ''}"
    counts = f"{pair.first + pair.both} and {pair.second + pair.both} of {pair.tasks}"
    told = f"{counts}; alone {pair.first} and {pair.second}; p = {p_value:.2g}"
    if p_value >= 1 - LEVEL or pair.first == pair.second:
        least = find_smallest_difference(pair.tasks)
        power = "no difference could be" if least is None else f"{100 * least:.0f} points would be"
        return f"{at}: no difference between `{one}` and `{other}` is shown ({told}; {power})."
    better, worse = (one, other) if pair.first > pair.second else (other, one)
    return f"{at}: `{better}` solves more tasks than `{worse}` ({told})."


def explain_power(count: int) -> str:
    """The power of a number of tasks, which sentences that show nothing repeat."""
    least = find_smallest_difference(count)
    shown = "no difference at all" if least is None else f"a difference of {100 * least:.0f} points"
    return (
        f"{count} tasks show {shown} in four of five cases. That is of exact McNemar at {1 - LEVEL:.2g} before Holm's "
        f"correction, where the worse method alone solves {CONTRARY:.0%} of the tasks."
    )
