"""Tables of docs/head-to-head.md, made of the rows of every part."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from baselines.fits import (
    arrange,
    average_tasks,
    choose_fits,
    find_last_mark,
    find_refused,
    find_solved,
    group,
    is_refused,
    list_budgets,
    list_marks,
    list_successes,
    read_budget,
    read_cost,
)
from benchmarks.harness import (
    Page,
    Result,
    Tables,
    condense_section,
    make_lines,
    number,
    provenance,
    read_lines,
    table,
)
from benchmarks.headtohead import claims
from benchmarks.headtohead.comparison import (
    choose_split,
    format_count,
    format_figure,
    list_comparison,
    name_row,
    tell_published,
    tell_splits,
    write_families,
    write_marks,
)
from benchmarks.headtohead.entrants import ABLATION_ROWS, LOCAL, list_distillers, rename
from benchmarks.headtohead.fidelity import count_clean, write_terms
from benchmarks.headtohead.leaderboard import PARTS as FITS
from physagent_jax.metrics.statistics import draw_again, find_interquartile_mean

SUITE = "suite"
"""Part of the tasks that are drawn (`benchmarks.headtohead.reproduce`)."""
PARTS = (
    "methods",
    SUITE,
    "ablation",
    "iterations",
    "models",
    "distillation",
    "materials",
    "neighbourhood",
    "gradients",
    "clipsim",
    "fidelity",
    "verify",
)


_CHARGED = {"model_calls": "calls", "tokens": "tokens"}


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
        return list_comparison(result[part], count_clean(result.get("fidelity", {}).get("rows", [])))
    if part == SUITE:
        found = f"{write_families(rows, {})}\n{claims.answer(claims.COMPARISON, group(rows))}"
        return {part: found, "suite marks": write_marks(rows)}
    if part == "ablation":
        chosen = choose_ablation(result)
        found = claims.answer(claims.ABLATION, group(chosen))
        return {part: tell_splits(chosen) + write_marks(chosen) + (f"\n{found}" if found else "")}
    if part == "iterations":
        return {part: tell_splits(rows) + write_marks(rows)}
    if part == "models":
        return {part: tell_splits(rows) + _write_models(rows)}
    if part == "distillation":
        return {part: _write_distillation(rows)}
    if part == "materials":
        return {part: _write_materials(rows, result)}
    if part == "neighbourhood":
        return {part: _write_neighbours(choose_neighbours(result))}
    if part == "verify":
        return {part: _write_checks(rows, result)}
    return {part: _WRITERS[part](rows)}


def choose_ablation(result: dict[str, Any]) -> list[dict]:
    """The rows of table 2, of the parts that have them, on the tasks that all of these were done on."""
    chosen: dict[str, list[dict]] = {}
    for label, (part, name) in ABLATION_ROWS.items():
        rows = [row for row in result.get(part, {}).get("rows", []) if row["label"] == name]
        if rows:
            chosen[label] = [row | {"label": label} for row in rows]
    tasks = set.intersection(*({row["task"] for row in rows} for rows in chosen.values()))
    return [row for rows in chosen.values() for row in rows if row["task"] in tasks]


def choose_neighbours(result: dict[str, Any]) -> list[dict]:
    """The fits of local methods, from near and from afar: of the parts that have them."""
    near, far = (result.get(part, {}).get("rows", []) for part in ("neighbourhood", "methods"))
    labels = {f"{method}, {start}" for method in LOCAL for start in ("responses", "all types")}
    return [*near, *(row for row in far if row["label"] in labels)]


def _write_checks(rows: list[dict], result: dict[str, Any]) -> str:
    """Share of the stored force fields that were simulated again, and the differences that were found."""
    fits = [row for part in FITS for row in result.get(part, {}).get("rows", []) if not is_refused(row)]
    jobs = {row["job"] for row in rows}
    checked = [row for row in fits if row["job"] in jobs]
    others = [row for row in rows if not row["good"]]
    good = len(rows) - len(others)
    text = f"{good} of {len(rows)} force fields, simulated again, have the error that they had.\n"
    if fits:
        tasks, every = ({row["task"] for row in some if row["split"] == "test"} for some in (checked, fits))
        text += (
            f"They are {len(checked) / len(fits):.0%} of the {len(fits)} stored fits, of {len(tasks)} of "
            f"{len(every)} test tasks; of each fit the last mark is checked, and no earlier one.\n"
        )
    if others:
        turned = sum((row["again"] <= 1) != (row["stored"] <= 1) for row in others) or "none"
        most = max(abs(row["again"] - row["stored"]) for row in others)
        text += f"The other {len(others)} differ by up to {most:.2g}; {turned} is a success in one only.\n"
        text += "Sums in single precision depend on how many threads there are, and on the processor.\n"
    return text


def _write_models(rows: list[dict]) -> str:
    """Tasks solved after each round, refused ones apart, with the calls and tokens of a task."""
    marks, lines = list_marks(rows), []
    for label, mine in group(rows).items():
        done = [row for row in mine if not is_refused(row)]
        solved = [len(find_solved(mine, mark)) for mark in marks]
        costs = [number(float(np.mean([row[key] for row in done]))) if done else "" for key in _CHARGED]
        lines.append([label, len(done), len(mine) - len(done), *solved, *costs])
    return table(["agents", "of", "refused", *(f"{mark:g}" for mark in marks), *_CHARGED.values()], lines)


def _write_distillation(rows: list[dict]) -> str:
    """Score distillation with what it was given: budget, steps and stages of the published ones, and model calls."""
    steps = {entrant.label: entrant.published_steps for entrant in list_distillers("toy", "")}
    lines = []
    for label, mine in group(rows).items():
        last = find_last_mark(mine)
        done = choose_fits(mine, last)
        if not done:
            continue
        taken = round(float(np.median([read_cost(row, last)["evaluations"] - 1 for row in done])))
        inner, stages = (done[0]["options"].get(key, 0) for key in ("inner", "stages"))
        reached = f"{min(stages, -(-taken // inner))} of {stages}" if inner else ""
        calls, spent = (
            number(float(np.median([row[key] for row in done]))) for key in ("model_calls", "spent")
        )
        error = format_figure(draw_again(find_interquartile_mean, arrange(mine, last)[2]))
        solved = format_count(list_successes(mine, last))
        published = f"{taken} of {steps[label]}" if steps.get(label) else f"{taken}"
        told = [solved, len(find_refused(mine)), error, spent, published, reached, calls]
        lines.append([label, tell_published(label), *told])
    head = ["method", "published as", "solved", "refused", "error", "simulations", "steps", "stages"]
    return table([*head, "model calls"], lines)


def _write_materials(rows: list[dict], result: dict[str, Any]) -> str:
    """Tasks solved with the own material, found with each other one, and brought to it."""
    settings = list(dict.fromkeys(row["material"] for row in rows))
    mark = max(read_budget(row) for row in rows if not is_refused(row))
    fits, lines = result.get("methods", {}).get("rows", []), []
    own = group(choose_split([row for row in fits if row["seed"] == 0]))  # the seed that is brought
    for label, mine in group(rows).items():
        cells = [format_count(list_successes(own.get(label, []), mark))]
        for setting, brought in itertools.product(settings, (False, True)):
            some = [row for row in mine if (row["material"], row["brought"]) == (setting, brought)]
            cells.append(format_count(list_successes(some, mark)))
        lines.append([label, *cells])
    heads = [f"{setting}, {how} there" for setting in settings for how in ("found", "brought")]
    return table(["method", "own", *heads], lines)


def _write_neighbours(rows: list[dict]) -> str:
    """Tasks solved by budget, smooth ones and others, and the names of the missed ones where these may be known."""
    budgets = list_budgets(rows)
    kinds = {"smooth": True, "others": False}
    lines = []
    for label, mine in group(rows).items():
        for split in sorted({row["split"] for row in mine}):
            here = [row for row in mine if row["split"] == split]
            last = max(list_budgets(here), default=0.0)
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
    """CLIPsim, by family and for every part with clips.

    In brackets its differences to that of the first frame alone, and to that of the same clip with another sentence.
    """
    families = list(dict.fromkeys(row["family"] for row in rows))
    lines = []
    for (part, label), mine in _group_clips(rows).items():
        done = [row for row in mine if "mean" in row]
        cells = []
        for family in (*families, None):
            some = [row for row in done if family in (None, row["family"])]
            told = [
                np.mean([row["mean"] - row[control] for row in known])
                for control in ("still", "shuffled")
                if (known := [row for row in some if row.get(control) is not None])
            ]
            mean = f"{np.mean([row['mean'] for row in some]):.4f}" if some else ""
            cells.append(f"{mean} ({', '.join(f'{gain:+.4f}' for gain in told)})" if some else "")
        models = ", ".join(dict.fromkeys(row["model"] for row in done))
        lines.append([part, name_row(label, mine), len(done), *cells, models])
    return table(["part", "method", "clips", *families, "all", "model"], lines)


def _group_clips(rows: list[dict]) -> dict[tuple[str, str], list[dict]]:
    """Rows by their part and label."""
    groups: dict[tuple[str, str], list[dict]] = {}
    for row in rows:
        groups.setdefault((row["part"], row["label"]), []).append(row)
    return groups


_WRITERS = {"gradients": _write_gradients, "clipsim": _write_similarities, "fidelity": write_terms}
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
    rename,
    "head-to-head-details",
)
