"""Tables of the comparison: success, error and cost of each method, and each against ours and against chance."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from baselines.fits import (
    Row,
    Rows,
    arrange,
    average_tasks,
    choose_fits,
    compare,
    count_within,
    find_done,
    find_last_mark,
    find_refused,
    find_solved,
    group,
    is_measured,
    is_refused,
    list_budgets,
    list_marks,
    list_successes,
    read_cost,
)
from benchmarks.harness import Tables, number, table
from benchmarks.headtohead import claims
from benchmarks.headtohead.entrants import ABLATION, METHODS, list_distillers
from physagent_jax.metrics.statistics import (
    Estimate,
    correct,
    draw_again,
    estimate_share,
    find_improvement,
    find_interquartile_mean,
    find_profile,
    find_smallest_difference,
)

REFERENCE, CHANCE = "rules", "random"
SECONDS = (5.0, 20.0, 60.0, 300.0)
_LEVELS = (0.5, 1.0, 2.0)  # [tolerances]


def list_comparison(section: dict[str, Any], clean: Mapping[str, str]) -> Tables:
    """The tables of the part `methods`; ``clean`` tells the clips without a fault of fidelity of each method."""
    rows = choose_split(section["rows"])
    tables = {
        "agents": describe_agents(rows),
        "methods": tell_splits(rows) + write_families(rows, clean),
        "progress": write_progress(rows, section["runs"]),
        "seeds": write_seeds(rows),
        "pairs": write_pairs(rows),
        "findings": write_findings(rows),
    }
    if mended := [row for row in section["rows"] if row["split"] != rows[0]["split"]]:
        tables["development"] = write_marks(mended)
    return tables


def choose_split(rows: Rows) -> list[Row]:
    """The rows of the test split, on which nothing was mended; all where there are none. Methods as in table 1."""
    places = {entrant.label: place for place, entrant in enumerate(METHODS)}
    rows = [row for row in rows if row["split"] == "test"] or rows
    return sorted(rows, key=lambda row: places.get(row["label"], len(places)))


def describe_agents(rows: Rows) -> str:
    """The agents behind `REFERENCE`, by the calls of models that its rows counted; empty without rows."""
    mine = [row for row in rows if row["label"] == REFERENCE and not is_refused(row)]
    if not mine:
        return ""
    if calls := sum(row.get("model_calls", 0) for row in mine):
        return f"The agents of `{REFERENCE}` called a language model {calls} times in {len(mine)} fits."
    others = sum(row.get("model_calls", 0) for row in rows)
    told = "others here called models too" if others else "no other method here called a model either"
    return (
        f"The agents here (`{REFERENCE}`) are rules of English: no language model was called in {len(mine)} fits, and "
        f"{told}.\n"
    )


def tell_splits(rows: Rows) -> str:
    """Number of tasks that methods were developed on: these flatter."""
    tasks = {row["task"]: row["split"] for row in rows}
    seen = sum(split == "development" for split in tasks.values())
    if not seen:
        return f"{len(tasks)} tasks, all of the test split.\n"
    return (
        f"{len(tasks)} tasks, of which {seen} are of the development split, on which methods were mended.\n"
    )


def name_row(label: str, rows: Rows) -> str:
    """Label of a row, with a mark for oracles."""
    return f"{label} (oracle)" if rows[0]["oracle"] else label


def tell_published(label: str) -> str:
    """The published method in whose place a row stands."""
    entrants = (*METHODS, *ABLATION, *list_distillers("toy", ""))
    return next((each.published_as for each in entrants if each.label == label), "")


def format_share(share: Estimate) -> str:
    """A share with its interval in per cent."""
    return f"{100 * share.value:.0f}% ({100 * share.low:.0f}–{100 * share.high:.0f})"


def format_figure(figure: Estimate) -> str:
    """A figure with its interval."""
    return f"{figure.value:.2f} ({figure.low:.2f}–{figure.high:.2f})"


def format_count(successes: list[float]) -> str:
    """Tasks that are solved, of those that were done; seeds are averaged."""
    return f"{sum(successes):.3g}/{len(successes)}" if successes else ""


def write_families(rows: Rows, clean: Mapping[str, str]) -> str:
    """Tasks solved by family and in all, each method at its own last mark, its error, and its clean clips."""
    families = list(dict.fromkeys(row["family"] for row in rows))
    lines = []
    for label, mine in group(rows).items():
        last = find_last_mark(mine)
        refused = len(find_refused(mine))
        if not last:
            lines.append(
                [name_row(label, mine), tell_published(label), *[""] * len(families), "", "", refused, "", ""]
            )
            continue
        tasks = average_tasks(mine, last).values()
        cells = [format_count([success for of, success, _ in tasks if of == family]) for family in families]
        solved = list_successes(mine, last)
        _, _, errors = arrange(mine, last)
        error = format_figure(draw_again(find_interquartile_mean, errors))
        published, told = tell_published(label), [*cells, format_count(solved)]
        lines.append(
            [
                name_row(label, mine),
                published,
                *told,
                format_share(estimate_share(solved)),
                refused or "",
                error,
                clean.get(label, ""),
            ]
        )
    return table(["method", "published as", *families, "all", "share", "refused", "error", "clean"], lines)


def write_progress(rows: Rows, runs: list[dict[str, Any]]) -> str:
    """Tasks solved against simulations and against seconds, and medians over tasks of what the fits cost."""
    marks, lines = list_marks(rows), []
    for label, mine in group(rows).items():
        last = find_last_mark(mine)
        done = choose_fits(mine, last)
        by_mark = [_count_solved(mine, mark) for mark in marks]
        by_seconds = [f"{count:.3g}" for count in count_within(mine, SECONDS)]
        costs = [read_cost(row, last) for row in done]
        efforts = [
            {"effort": m["effort"]}
            for row in done
            for m in row["marks"]
            if m["mark"] == last and "effort" in m
        ]
        told = [_find_median(costs, "spent"), _find_median(costs, "seconds"), _find_median(efforts, "effort")]
        machines = dict.fromkeys(name_processor(runs[row["run"]]["machine"]) for row in done)
        tasks = len(average_tasks(mine, last))
        lines.append([label, tasks, *by_mark, *by_seconds, f"{last:g}", *told, ", ".join(machines)])
    head = ["method", "of", *(f"{mark:g}" for mark in marks), *(f"{seconds:g} s" for seconds in SECONDS)]
    return table([*head, "given", "spent", "seconds", "effort", "machine"], lines)


def _count_solved(rows: Rows, mark: float) -> str:
    return f"{sum(list_successes(rows, mark)):.3g}" if is_measured(rows, mark) else ""


def name_processor(machine: str) -> str:
    """The processor of a machine's description."""
    return machine.split(",")[0].replace("(R)", "").removesuffix(" Processor")


def _find_median(rows: Rows | list[dict[str, float]], key: str) -> str:
    return number(float(np.median([row.get(key) or 0 for row in rows]))) if rows else ""


def write_marks(rows: Rows) -> str:
    """Tasks solved against simulations."""
    marks = list_marks(rows)
    lines = [
        [label, len(find_done(mine)), *(_count_solved(mine, mark) for mark in marks)]
        for label, mine in group(rows).items()
    ]
    return table(["method", "of", *(f"{mark:g}" for mark in marks)], lines)


def write_seeds(rows: Rows) -> str:
    """Runs and tasks of what draws, at the largest budget that several seeds were given; empty where there is none."""
    groups, lines = group(rows), []
    many = [mark for mark in list_budgets(rows) if any(_has_seeds(mine, mark) for mine in groups.values())]
    if not many:
        return ""
    chance = arrange(groups[CHANCE], many[-1]) if _has_seeds(groups.get(CHANCE, []), many[-1]) else None
    for label, mine in groups.items():
        if not _has_seeds(mine, many[-1]):
            continue
        tasks, solved, errors = arrange(mine, many[-1])
        each, shares = solved.sum(1), solved.mean(0)
        better = ""
        if chance is not None and label != CHANCE and chance[0] == tasks:
            better = format_figure(draw_again(find_improvement, -errors, -chance[2]))
        profile = [f"{share:.2f}" for share in find_profile(-errors, [-level for level in _LEVELS])]
        some = int(((shares > 0) & (shares < 1)).sum())
        error = format_figure(draw_again(find_interquartile_mean, errors))
        apart = f"{each.min():g} to {each.max():g}"
        lines.append([label, len(solved), error, better, *profile, apart, some])
    head = ["method", "runs", "error", f"better than {CHANCE}", *(f"≤ {level:g}" for level in _LEVELS)]
    told = f"With {many[-1]:g} simulations, {len({row['task'] for row in rows})} tasks:\n"
    return told + table([*head, "tasks by run", "by some runs"], lines)


def _has_seeds(rows: Rows, mark: float) -> bool:
    return bool(choose_fits(rows, mark)) and len(arrange(rows, mark)[1]) > 1


def write_pairs(rows: Rows) -> str:
    """Every method against ours, on the tasks that both have done."""
    groups = group(rows)
    if REFERENCE not in groups:
        return ""
    ours = groups.pop(REFERENCE)
    pairs = {label: pair for label, mine in groups.items() if (pair := compare(mine, ours))}
    successes = correct([pair.successes for pair in pairs.values()])
    errors = correct([pair.errors for pair in pairs.values()])
    lines = []
    for (label, pair), p, q in zip(pairs.items(), successes, errors):
        least = find_smallest_difference(pair.tasks)
        shown = "none" if least is None else f"{100 * least:.0f}"
        told = [pair.tasks, f"{pair.mark:g}", pair.first, pair.second, f"{p:.2g}", f"{q:.2g}", shown]
        lines.append([label, *told])
    head = ["method", "tasks", "simulations", "it alone", f"{REFERENCE} alone", "p", "p of the error"]
    return table([*head, "smallest difference"], lines)


def write_findings(rows: Rows) -> str:
    """Findings of the comparison: only what a test of these rows supports."""
    groups = group(rows)
    solved = set().union(*(find_solved(mine, find_last_mark(mine)) for mine in groups.values()))
    missed = len({row["task"] for row in rows} - solved)
    text = claims.answer(claims.COMPARISON, groups)
    count = len({row["task"] for row in rows})
    told = (
        f"{missed} of {count} tasks are solved by no method." if missed else "Some method solves each task."
    )
    return f"{text}- {told}\n- {claims.explain_power(count)}\n"
