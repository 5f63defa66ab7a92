"""Tables of docs/accuracy.md."""

from __future__ import annotations

import numpy as np

from benchmarks.accuracy.study import NEAR_BOUND, QUADRATURE_ERROR, SHARPENED, rule_words
from benchmarks.cases.catalogue import CASES, STUDIED
from benchmarks.harness import Page, Result, Tables, drop_fields, number, provenance, table

PARTS = ("verification", "work_precision", "quadrature", "price", "strength", "aggregation")

_DENSITIES = (
    "cells through the height",
    "stress form",
    "light nodes",
    "step",
    "2 per axis",
    "3 per axis",
    "4 per axis",
)
_CASES = (
    "case",
    "what moves, what is measured",
    "cells",
    "particles",
    "error",
    "bar",
    "wall [s]",
    "compile [s]",
)
_PRICES = (
    "particles",
    "threads",
    "inertia",
    "substep: lumped [ms]",
    "with it [ms]",
    "times lumped",
    "value and gradient: lumped [ms]",
    "with it [ms]",
    "times lumped",
)
_EQUAL = (
    "case",
    "cells",
    "lumped: error",
    "seconds",
    "sharpened, as many cells: error",
    "seconds",
    "sharpened, as many seconds: error",
)
_UNSHOWN = frozenset(
    ("job", "code", "particles", "steps", "dt", "dt_over_bound", "wall", "wall_range", "compile")
)
_UNSHOWN |= {"reference", "within", "good"}
_RUNS = ("case", "code", "numerics", "cells", "steps", "dt / bound", "error", "wall [s]")


def write_tables(result: Result) -> Tables:
    """The tables of docs/accuracy.md."""
    primary = {studied.case.name: studied.error for studied in STUDIED}
    tables = {"runs": provenance(result, PARTS)}
    if "verification" in result:
        tables["cases"] = _write_cases(result["verification"]["rows"])
    if work := result.get("work_precision"):
        known = {name: words for run in work["runs"] for name, words in run["peers"].items()}
        peers = "; ".join(f"{name}: {words}" for name, words in known.items())
        tables["peers"] = (
            f"Peers run the same particles on the same grid in the same process tree: {peers}.\n"
        )
        tables["work"] = _write_studies(work["rows"], primary)
        tables["gains"] = _summarise(work["rows"], primary)
        tables["equal"] = _compare_at_equal_seconds(work["rows"], primary)
    if densities := result.get("quadrature"):
        tables["quadrature"] = table(_DENSITIES, _make_density_lines(densities["rows"]))
    if tried := result.get("strength"):
        tables["strength"] = _write_strengths(tried["rows"], primary)
    if tried := result.get("aggregation"):
        tables["aggregation"] = _write_aggregations(tried["rows"])
    if prices := result.get("price"):
        tables["price"] = table(_PRICES, [_make_price_line(row) for row in prices["rows"]])
    return tables


def _write_cases(rows: list[dict]) -> str:
    titles = {(verified.case.name, verified.note): verified.case.title for verified in CASES}
    lines = [_make_verified_line(row, titles.get((row["case"], row["label"]), "")) for row in rows]
    outside = [row for row in rows if not row["within"]]
    return table(_CASES, lines) + (
        _list_outside(outside) if outside else "\nEvery case is within its bars.\n"
    )


def _make_density_lines(rows: list[dict]) -> list[list]:
    """One line per grid, stress form, kind of nodes and step, one column per density; rows come in this order."""
    lines: dict[tuple, list[str]] = {}
    for row in rows:
        *key, _ = row["label"].split(", ")
        error = f"{100 * row['errors'][QUADRATURE_ERROR]:.2g}%"
        lines.setdefault((row["resolution"], *key), []).append(error)
    return [[*key, *errors] for key, errors in lines.items()]


def _make_verified_line(row: dict, title: str) -> list:
    name = f"{row['case']}, {row['label']}" if row["label"] else row["case"]
    names = list(row["bars"]) or list(row["errors"])
    errors = "<br>".join(f"{name}: {row['errors'][name]:.3g}" for name in names if name in row["errors"])
    bars = "<br>".join(f"{row['bars'][name]:.3g}" for name in names if name in row["bars"])
    start = [name, title, row["resolution"], row["particles"], row["failed"] or errors, bars]
    return [*start, number(row["wall"]), number(row["compile"])]


def _list_outside(rows: list[dict]) -> str:
    lines = [f"- **{row['case']}**: {row['failed'] or 'outside its bar'}" for row in rows]
    return "\nOutside their bars:\n\n" + "\n".join(lines) + "\n"


def _write_studies(rows: list[dict], primary: dict[str, str]) -> str:
    """The rows that have an error, and why others have none."""
    done = [row for row in rows if primary[row["case"]] in row["errors"]]
    text = table(_RUNS, [_make_study_line(row, primary[row["case"]]) for row in done])
    failed: dict[str, dict[str, None]] = {}
    for row in (row for row in rows if row not in done):
        failed.setdefault(f"{row['case']}: {row['failed']}", {})[row["code"]] = None
    return text + "".join(f"\nNo row by {', '.join(codes)} for {why}.\n" for why, codes in failed.items())


def _make_study_line(row: dict, primary: str) -> list:
    error = f"{row['errors'][primary]:.3g}"
    label = f"**{row['label']}** (reference)" if row["reference"] else row["label"]
    start = [row["case"], row["code"], label, row["resolution"], row["steps"], number(row["dt_over_bound"])]
    return [*start, error, _format_wall_time(row)]


def _format_wall_time(row: dict) -> str:
    shown = " to ".join(number(value) for value in dict.fromkeys(row["wall_range"]))
    return f"{number(row['wall'])} ({shown})" if " to " in shown else number(row["wall"])


def _write_strengths(rows: list[dict], primary: dict[str, str]) -> str:
    """A line per case, grid and step, a column per strength."""
    found: dict[tuple, dict[str, str]] = {}
    for row in rows:
        rule, strength = row["label"].split(": ")
        key = row["case"], row["resolution"], rule
        found.setdefault(key, {})[strength] = _percent(abs(row["errors"][primary[row["case"]]]))
    columns = list(dict.fromkeys(strength for line in found.values() for strength in line))
    return table(("case", "cells", "step", *columns), [[*key, *line.values()] for key, line in found.items()])


def _write_aggregations(rows: list[dict]) -> str:
    """A line per case with the error that changes most for its bar, a column per aggregation."""
    found: dict[str, dict[str, dict]] = {}
    for row in rows:
        name, aggregation = row["label"].split(": ")
        found.setdefault(name, {})[aggregation] = row
    lines, columns = [], list(next(iter(found.values())))
    for name, tried in found.items():
        first = next(iter(tried.values()))
        if any(row["failed"] for row in tried.values()):
            lines.append([name, "", *(row["failed"] for row in tried.values()), ""])
            continue
        spread = {
            error: np.ptp([row["errors"][error] for row in tried.values()]) / bar
            for error, bar in first["bars"].items()
            if bar > 0
        }
        error = max(spread, key=lambda each: spread[each])
        shown = [number(row["errors"][error]) for row in tried.values()]
        lines.append([name, error, *shown, number(first["bars"][error])])
    return table(("case", "error", *columns, "bar"), lines)


def _make_price_line(row: dict) -> list:
    line = [row["particles"], row["threads"], row["inertia"]]
    for kind in ("forward", "gradient"):
        (lumped, other), (ratio, least, most) = row[f"{kind}_ms"], row[f"{kind}_ratio"]
        line += [number(lumped), number(other), f"{ratio:.2f} ({least:.2f} to {most:.2f})"]
    return line


def _compare_at_equal_seconds(rows: list[dict], primary: dict[str, str]) -> str:
    """Sharpened errors at the seconds of lumped runs, from the line through the two nearest, both in logarithms."""
    lines, near = [], rule_words(NEAR_BOUND)
    for case, name in primary.items():
        done = [
            row for row in rows if row["case"] == case and row["code"] == "ours" and name in row["errors"]
        ]
        plain, sharp = (
            sorted(
                (row["resolution"], row["wall"], abs(row["errors"][name]))
                for row in done
                if row["label"] == label
            )
            for label in (near, near + SHARPENED)
        )
        if len(sharp) < 2:
            continue
        walls, errors = np.log([[each[1], each[2]] for each in sharp]).T
        for (cells, wall, error), (_, other_wall, other_error) in zip(plain, sharp):
            k = int(np.clip(np.searchsorted(walls, np.log(wall)), 1, len(walls) - 1))
            slope = (errors[k] - errors[k - 1]) / (walls[k] - walls[k - 1])
            equal = float(np.exp(errors[k] + slope * (np.log(wall) - walls[k])))
            lines.append(
                [
                    case,
                    cells,
                    _percent(error),
                    number(wall),
                    _percent(other_error),
                    number(other_wall),
                    _percent(equal),
                ]
            )
    return table(_EQUAL, lines)


def _percent(error: float) -> str:
    return f"{100 * error:.3g} %"


def _summarise(rows: list[dict], primary: dict[str, str]) -> str:
    """Gains of the near-bound step over the fixed one and over each peer, case by case."""
    lines = []
    for case in dict.fromkeys(row["case"] for row in rows):
        mine = [row for row in rows if row["case"] == case and primary[case] in row["errors"]]
        best = [row for row in mine if row["code"] == "ours" and row["label"] == "0.9 x bound"]
        if not best:
            continue
        base = max(best, key=lambda row: row["resolution"])
        for row in mine:
            if row["resolution"] != base["resolution"] or row is base:
                continue
            if row["code"] == "ours" and not row["reference"]:
                continue
            time = row["wall"] / base["wall"]
            error = abs(row["errors"][primary[case]] / base["errors"][primary[case]])
            lines.append([case, f"{row['code']}, {row['label']}", f"{time:.3g}", f"{error:.3g}"])
    return table(("case", "against", "time ratio", "error ratio"), lines)


def condense(result: Result) -> Result:
    """The sections without what no table shows of runs whose errors alone are compared."""
    compared = {part: result[part] for part in ("quadrature", "strength", "aggregation") if part in result}
    return result | drop_fields(compared, _UNSHOWN)


PAGE = Page(
    "accuracy",
    "python -m benchmarks.accuracy",
    write_tables,
    ("physagent_jax/mpm", "physagent_jax/kernels", "benchmarks/cases", "benchmarks/peers"),
    condense,
)
