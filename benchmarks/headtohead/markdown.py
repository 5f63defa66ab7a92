"""Tables of docs/head-to-head.md: success, error and cost per method, with intervals."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from typing import Any

import numpy as np

from benchmarks.harness import (
    Page,
    Result,
    Rows,
    Tables,
    condense_section,
    make_lines,
    number,
    provenance,
    read_lines,
    table,
)
from benchmarks.headtohead.entrants import ABLATION_ROWS, LOCAL, METHODS
from benchmarks.headtohead.statistics import (
    average_tasks,
    choose_fits,
    compare,
    correct,
    count_by_seed,
    estimate,
    find_solved,
    is_measured,
    read_budget,
    read_cost,
)

PARTS = (
    "methods",
    "ablation",
    "iterations",
    "distillation",
    "materials",
    "neighbourhood",
    "gradients",
    "clipsim",
    "verify",
)
REFERENCE = "physagent"


def write_tables(summary: Result) -> Tables:
    """The tables of docs/head-to-head.md, of a summary."""
    return {**read_lines(summary), "runs": provenance(summary, PARTS)}


def condense(result: Result) -> Result:
    """The lines of the tables: all rows are 200 times as much. Some are made of the rows of several parts."""
    return {
        part: condense_section(section, make_lines(_list_tables(part, result)))
        for part, section in result.items()
    }


def _list_tables(part: str, result: Result) -> Tables:
    """The tables that stand with a part."""
    rows = result[part]["rows"]
    if part == "methods":
        return _list_comparison(rows)
    if part == "ablation":
        chosen = choose_ablation(result)
        return {part: _tell_splits(chosen) + _write_marks(chosen)}
    if part == "iterations":
        return {part: _tell_splits(rows) + _write_marks(rows)}
    if part == "distillation":
        return {part: _write_families(rows), "distillation, costs": _write_costs(rows)}
    if part == "materials":
        return {part: _write_materials(rows, result)}
    if part == "neighbourhood":
        return {part: _write_neighbours(choose_neighbours(result))}
    shows = {"gradients": _write_gradients, "clipsim": _write_similarities, "verify": _write_checks}
    return {part: shows[part](rows)}


def _list_comparison(rows: Rows) -> Tables:
    chosen = choose_split(rows)
    tables = {
        "methods": _tell_splits(chosen) + _write_families(chosen),
        "costs": _write_costs(chosen),
        "marks": _write_marks(chosen),
        "seeds": _write_seeds(chosen),
        "pairs": _write_pairs(chosen),
        "findings": _state_findings(chosen),
    }
    if mended := [row for row in rows if row["split"] != chosen[0]["split"]]:
        tables["development"] = _write_marks(mended)
    return tables


def choose_ablation(result: dict[str, Any]) -> list[dict]:
    """The rows of table 2, of the parts that have them, on the tasks that all of these were done on."""
    chosen: dict[str, list[dict]] = {}
    for label, (part, name) in ABLATION_ROWS.items():
        rows = [row for row in result.get(part, {}).get("rows", []) if row["label"] == name]
        if rows:
            chosen[label] = [row | {"label": label} for row in rows]
    tasks = set.intersection(*({row["task"] for row in rows} for rows in chosen.values()))
    return [row for rows in chosen.values() for row in rows if row["task"] in tasks]


def choose_split(rows: list[dict]) -> list[dict]:
    """The rows of the test split, on which nothing was mended; all where there are none. Methods as in table 1."""
    places = {entrant.label: place for place, entrant in enumerate(METHODS)}
    rows = [row for row in rows if row["split"] == "test"] or rows
    return sorted(rows, key=lambda row: places.get(row["label"], len(places)))


def choose_neighbours(result: dict[str, Any]) -> list[dict]:
    """The fits of local methods, from near and from afar: of the parts that have them."""
    near, far = (result.get(part, {}).get("rows", []) for part in ("neighbourhood", "methods"))
    labels = {f"{method}, {start}" for method in LOCAL for start in ("responses", "all types")}
    return [*near, *(row for row in far if row["label"] in labels)]


def _tell_splits(rows: list[dict]) -> str:
    """Number of tasks that methods were developed on: these flatter."""
    tasks = {row["task"]: row["split"] for row in rows}
    seen = sum(split == "development" for split in tasks.values())
    if not seen:
        return f"{len(tasks)} tasks, all of the test split: methods were mended on others.\n"
    return (
        f"{len(tasks)} tasks, of which {seen} are of the development split, on which methods were mended.\n"
    )


def group(rows: list[dict]) -> dict[str, list[dict]]:
    """Rows by their label, in the order in which they first appear."""
    groups: dict[str, list[dict]] = {}
    for row in rows:
        groups.setdefault(row["label"], []).append(row)
    return groups


def find_last_mark(rows: list[dict]) -> float:
    """The largest mark up to which every method has been given budget on every task of the rows."""
    given: dict[tuple[str, str], float] = {}
    for row in rows:
        key = row["label"], row["task"]
        given[key] = max(given.get(key, 0.0), read_budget(row))
    least = min(given.values(), default=0.0)
    return least if math.isfinite(least) else 0.0


def format_share(values: tuple[float, float, float]) -> str:
    """A share with its interval in per cent."""
    value, low, high = (100 * each for each in values)
    return f"{value:.0f}% ({low:.0f}–{high:.0f})"


def _write_checks(rows: list[dict]) -> str:
    """Number of stored force fields that were found again, and the differences of the others."""
    others = [row for row in rows if not row["good"]]
    good = len(rows) - len(others)
    text = f"{good} of {len(rows)} stored force fields, simulated again, have the error that they had.\n"
    if others:
        turned = sum((row["again"] <= 1) != (row["stored"] <= 1) for row in others) or "none"
        most = max(abs(row["again"] - row["stored"]) for row in others)
        text += f"The other {len(others)} differ by up to {most:.2g}; {turned} is a success in one only.\n"
        text += "Sums in single precision depend on how many threads there are, and on the processor.\n"
    return text


def _name(label: str, rows: list[dict]) -> str:
    return f"{label} (oracle)" if rows[0]["oracle"] else label


def _state_findings(rows: list[dict]) -> str:
    """Findings of the comparison in words; empty where a method that they name has not been measured."""
    groups, last = group(rows), find_last_mark(rows)
    blind = [f"{name}, all types" for name in ("adam", "lbfgs", "levenberg_marquardt", "smoothed_adam")]
    told = [f"{name}, responses" for name in ("adam", "lbfgs", "levenberg_marquardt")]
    if not {REFERENCE, "hybrid", "random", "catcma", *blind, *told} <= groups.keys():
        return ""

    def share(labels, mark=last):
        values = [100 * estimate(groups[label], mark, 1)[0] for label in labels]
        low, high = f"{min(values):.0f}", f"{max(values):.0f}"
        return f"{low} %" if low == high else f"{low} to {high} %"

    every = sorted({mark["mark"] for row in rows for mark in row["marks"]})
    marks = [mark for mark in every if mark > last]
    before = max((mark for mark in every if mark < last), default=last)
    early = 30.0 if 30.0 in every else before

    def tell_longer(labels):
        known = [label for label in labels if label in groups]
        reached = {mark: [label for label in known if is_measured(groups[label], mark)] for mark in marks}
        return "".join(
            f"\n  With {mark:g} simulations: "
            + ", ".join(f"`{label}` {share([label], mark)}" for label in mine)
            + "."
            for mark, mine in reached.items()
            if mine
        )

    longer = [
        tell_longer(labels) for labels in ([REFERENCE, "random"], told, [*blind, "catcma", "cma"], ["hybrid"])
    ]
    tasks = {row["task"] for row in rows}
    missed = len(tasks - set().union(*(find_solved(mine, last) for mine in groups.values())))
    ours = find_solved(groups[REFERENCE], last)
    theirs = set().union(*(find_solved(groups[label], last) for label in told))
    return f"""- After one simulation `{REFERENCE}` solves {share([REFERENCE], 1.0)} of the tasks,
  chance {share(["random"], 1.0)};
  after {before:g}, {share([REFERENCE], before)} and {share(["random"], before)};
  after {last:g}, {share([REFERENCE])} and {share(["random"])}.{longer[0]}
- With {last:g} simulations, optimisers that are told by the target and by the object's responses what acts, when and
  where solve {share(told)}. Of the tasks that all of these miss, `{REFERENCE}` solves {len(ours - theirs) or "none"}.
  They know the answer that they are measured by: it is what the simulator allows, and what agents could
  reach.{longer[1]}
- Gradients begun at random with every skill in turn solve {share(blind, before)} with {before:g} simulations and
  {share(blind)} with {last:g}, evolution over skills (`catcma`)
  {share(["catcma"], before)} and {share(["catcma"])}.
  Told what acts, when and where, as above, gradients solve {share(told, early)} with {early:g}: to find that out is
  most of the work.{longer[2]}
- Least squares on the agents' first guess (`hybrid`) solves {share(["hybrid"])}: of what the agents miss, a part is
  numbers, which gradients mend, and the rest is what acts and when, which they do not.{longer[3]}
- {f"{missed} of {len(tasks)} tasks are solved by nobody." if missed else "Every task is solved by some method."}
"""


def _write_seeds(rows: list[dict]) -> str:
    """Of what draws, how far the seeds are apart; empty where nothing was done with several on every task."""
    groups, lines = group(rows), []
    budgets = sorted({given for row in rows if math.isfinite(given := read_budget(row))})
    many = [mark for mark in budgets if any(len(count_by_seed(mine, mark)) > 1 for mine in groups.values())]
    for label, mine in groups.items():
        if many and len(counts := count_by_seed(mine, many[-1])) > 1:
            counted = [row for row in mine if row["seed"] in counts]
            shares = [success for _, success, _ in average_tasks(counted, many[-1]).values()]
            always, never = sum(s == 1 for s in shares), sum(s == 0 for s in shares)
            lines.append(
                [
                    _name(label, mine),
                    len(counts),
                    f"{np.mean(list(counts.values())):.1f}",
                    f"{min(counts.values())} to {max(counts.values())}",
                    always,
                    len(shares) - always - never,
                ]
            )  # fmt: skip
    if not lines:
        return ""
    head = ["method", "seeds", "tasks solved", "by seed", "by every seed", "by some"]
    tasks = len({row["task"] for row in rows})
    return f"With {many[-1]:g} simulations, of {tasks} tasks:\n" + table(head, lines)


def _write_families(rows: list[dict]) -> str:
    last = find_last_mark(rows)
    families = list(dict.fromkeys(row["family"] for row in rows))
    lines = []
    for label, mine in group(rows).items():
        cells = []
        for family in families:
            solved = [success for of, success, _ in average_tasks(mine, last).values() if of == family]
            cells.append(f"{np.mean(solved):.0%}" if solved else "")
        error = estimate(mine, last, 2, lambda values: float(np.median(values)))
        lines.append(
            [
                _name(label, mine),
                *cells,
                format_share(estimate(mine, last, 1)),
                f"{error[0]:.2f} ({error[1]:.2f}–{error[2]:.2f})",
            ]
        )
    counts = {family: len({row["task"] for row in rows if row["family"] == family}) for family in families}
    return table(["method", *(f"{name} ({count})" for name, count in counts.items()), "all", "error"], lines)


def _write_costs(rows: list[dict]) -> str:
    last, lines = find_last_mark(rows), []
    for label, mine in group(rows).items():
        done = [row for row in choose_fits(mine, last) if "seconds" in row]
        costs = [read_cost(row, last) for row in done]
        efforts = [
            mark["effort"]
            for row in done
            for mark in row["marks"]
            if mark["mark"] == last and mark.get("effort") is not None
        ]
        lines.append(
            [
                _name(label, mine),
                _count_seeds(choose_fits(mine, last)),
                *(_find_median(costs, name) for name in ("spent", "seconds", "evaluations")),
                _find_median(done, "memory_gb"),
                number(float(np.median(efforts))) if efforts else "",
                sum("refused" in row for row in choose_fits(mine, last)),
            ]
        )  # fmt: skip
    head = [
        "method",
        "seeds",
        "forward-equivalents",
        "seconds",
        "evaluations",
        "memory [GB]",
        "effort [m/s]",
        "refused",
    ]
    return f"Medians over tasks, up to {last:g} forward-equivalents:\n" + table(head, lines)


def _write_materials(rows: list[dict], result: dict[str, Any]) -> str:
    """Success with the own material, found with each other one, and brought to it."""
    settings = list(dict.fromkeys(row["material"] for row in rows))
    mark = max(read_budget(row) for row in rows if row["marks"])
    fits, lines = result.get("methods", {}).get("rows", []), []
    own = group(choose_split([row for row in fits if row["seed"] == 0]))  # the seed that is brought
    for label, mine in group(rows).items():
        with_own = own.get(label, [])
        cells = [format_share(estimate(with_own, mark, 1)) if with_own else ""]
        for setting, brought in itertools.product(settings, (False, True)):
            some = [row for row in mine if (row["material"], row["brought"]) == (setting, brought)]
            cells.append(format_share(estimate(some, mark, 1)) if some else "")
        lines.append([_name(label, mine), *cells])
    heads = [f"{setting}, {how} there" for setting in settings for how in ("found", "brought")]
    return table(["method", "own", *heads], lines)


def _count_seeds(rows: list[dict]) -> str:
    """Of each task, the fewest and the most."""
    counts = Counter(row["task"] for row in rows).values()
    few, many = min(counts, default=0), max(counts, default=0)
    return f"{few}" if few == many else f"{few} to {many}"


def _write_neighbours(rows: list[dict]) -> str:
    """Tasks solved by budget, smooth ones and others, and the names of the missed ones where these may be known."""
    budgets = sorted({given for row in rows if math.isfinite(given := read_budget(row))})
    kinds = {"smooth": True, "others": False}
    lines = []
    for label, mine in group(rows).items():
        for split in sorted({row["split"] for row in mine}):
            here = [row for row in mine if row["split"] == split]
            last = max(read_budget(row) for row in here)
            cells = []
            for smooth, budget in itertools.product(kinds.values(), budgets):
                alike = [row for row in here if row["smooth"] == smooth]
                count = len(average_tasks(alike, budget))
                cells.append(f"{len(find_solved(alike, budget))}/{count}" if count else "")
            missed = sorted(average_tasks(here, last).keys() - find_solved(here, last))
            names = ", ".join(missed) if split == "development" else "not told"
            lines.append([label, split, *cells, names if missed else "none"])
    counted = [f"{kind}, {budget:g}" for kind, budget in itertools.product(kinds, budgets)]
    return table(["method, start", "split", *counted, "missed"], lines)


def _write_gradients(rows: list[dict]) -> str:
    """Seconds of a simulation and of a gradient by family, and how many of the first are one of the second."""
    families, lines = list(dict.fromkeys(row["family"] for row in rows)), []
    for family in (*families, "all"):
        mine = [row for row in rows if family in (row["family"], "all")]
        plain, gradient, ratios = (
            np.array([row[name] for row in mine]) for name in ("plain_seconds", "gradient_seconds", "ratio")
        )
        lines.append(
            [
                family,
                len(mine),
                number(float(np.median(plain))),
                number(float(np.median(gradient))),
                f"{np.median(ratios):.2f} ({ratios.min():.2f} to {ratios.max():.2f})",
                f"{gradient.sum() / plain.sum():.2f}",
            ]
        )
    head = ["family", "tasks", "simulation [s]", "value and gradient [s]", "ratio", "of the sums"]
    return table(head, lines)


def _write_similarities(rows: list[dict]) -> str:
    lines = []
    for label, mine in group(rows).items():
        done = [row for row in mine if "mean" in row]
        means, stills = (np.array([row[name] for row in done]) for name in ("mean", "still"))
        models = ", ".join(dict.fromkeys(row["model"] for row in done))
        figures = [f"{x.mean():.4f}" for x in (means, stills)] if done else ["", ""]
        gain = f"{(means - stills).mean():+.4f} ± {(means - stills).std():.4f}" if done else ""
        lines.append([_name(label, mine), len(done), *figures, gain, models])
    return table(["method", "clips", "CLIPsim", "still", "difference ± spread over clips", "model"], lines)


def _find_median(rows: list[dict], name: str) -> str:
    return number(float(np.median([row[name] or 0 for row in rows]))) if rows else ""


def _write_marks(rows: list[dict]) -> str:
    marks = sorted({mark["mark"] for row in rows for mark in row["marks"]})
    lines = [
        [
            _name(label, mine),
            *(format_share(estimate(mine, mark, 1)) if is_measured(mine, mark) else "" for mark in marks),
        ]
        for label, mine in group(rows).items()
    ]
    return table(["method", *(f"{mark:g}" for mark in marks)], lines)


def _write_pairs(rows: list[dict]) -> str:
    """Every method against ours."""
    groups, last = group(rows), find_last_mark(rows)
    if REFERENCE not in groups:
        return ""
    others = [label for label in groups if label != REFERENCE]
    found = [compare(groups[label], groups[REFERENCE], last) for label in others]
    success, error = (correct([each[i] for each in found]) for i in (2, 3))
    lines = [
        [_name(label, groups[label]), first, second, f"{p:.2g}", f"{q:.2g}"]
        for label, (first, second, _, _), p, q in zip(others, found, success, error)
    ]
    head = [
        "method",
        "tasks that it alone solves",
        f"that {REFERENCE} alone solves",
        "p (McNemar, Holm)",
        "p of the error (Wilcoxon, Holm)",
    ]
    return table(head, lines)


PAGE = Page(
    "head-to-head",
    "python -m benchmarks.headtohead --data DIR --parts methods ablation iterations",
    write_tables,
    (
        "baselines",
        "benchmarks/tasks",
        *(
            f"physagent_jax/{part}"
            for part in ("agents", "forces", "kernels", "mpm", "perception", "simulation")
        ),
    ),
    condense,
)
