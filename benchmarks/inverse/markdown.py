"""Tables of docs/inverse.md."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.harness import Page, Result, Tables, drop_fields, number, provenance, table
from benchmarks.inverse.unknowns import UNKNOWNS

PARTS = ("exact", "noise", "finer", "unidentifiable", "landscape")


def write_tables(result: Result) -> Tables:
    """The tables of docs/inverse.md."""
    shows = {"unidentifiable": _write_hidden, "landscape": _write_slices}
    tables = {
        part: shows.get(part, lambda rows: _write_summary(rows) + _write_fits(rows))(result[part]["rows"])
        for part in PARTS
        if part in result
    }
    return tables | {"bars": _list_bars(result), "runs": provenance(result, PARTS)}


def condense(result: Result) -> Result:
    """The rows with the histories that the figure shows, to four digits, and without all others."""
    kept = drop_fields({part: result[part] for part in result if part != "exact"}, ("history",))
    if "exact" in result:
        rows = [
            row | {"history": [[float(f"{x:.4g}") for x in each] for each in row.get("history") or []]}
            for row in result["exact"]["rows"]
        ]
        kept["exact"] = result["exact"] | {"rows": rows}
    return {part: kept[part] for part in result}


def _write_summary(rows: list[dict]) -> str:
    lines = []
    for optimiser in dict.fromkeys(row["optimiser"] for row in rows):
        mine = [row for row in rows if row["optimiser"] == optimiser and row["fitted"]]
        met = sum(row["met"] for row in mine)
        lines.append(f"{optimiser}: {met} of {len(mine)} within their bars")
    return "\n" + "; ".join(lines) + ".\n" if lines else ""


def _write_fits(rows: list[dict]) -> str:
    noisy = any(row["noise"] for row in rows)
    head = ["sought", "start", "by", *["noise"] * noisy, "found", "error", "met", "steps", "cost", "seconds"]
    fitted = [row for row in rows if row["fitted"]]
    worst = max((row["gradient_error"] for row in fitted), default=0.0)
    text = table([*head, "condition", "bound", "left"], [_show_fit(row, noisy) for row in rows])
    return text + f"\nGradients are at worst {worst:.1e} from central differences.\n"


def _show_fit(row: dict, noisy: bool) -> list[Any]:
    start = [row["problem"], row["start"], row["optimiser"], *[f"{row['noise']:.1%}"] * noisy]
    if not row["fitted"]:
        return [*start, "not sought", *[""] * 8]
    reached = "never" if row["steps_to_tolerance"] is None else row["steps_to_tolerance"]
    return [
        *start,
        _join(row, lambda name: _show_value(row["found"][name])),
        _join(row, lambda name: _show_error(name, row["errors"][name])),
        "yes" if row["met"] else "**no**",
        f"{reached} of {row['steps']}",
        number(row["forward_equivalents"]),
        number(row["seconds"]),
        "not finite" if row["condition"] is None else number(row["condition"]),
        _join(row, lambda name: _show_error(name, row["standard_errors"][name]))
        if row["standard_errors"]
        else "",
        number(row["residual"]),
    ]


def _list_bars(result: Result) -> str:
    """The bar of each unknown that is sought."""
    sought = dict.fromkeys(
        name for section in result.values() for row in section["rows"] for name in row.get("unknowns", ())
    )
    bars = [
        f"{name.replace('_', ' ')} {_show_error(name, UNKNOWNS[name].tolerance)}"
        + "*" * UNKNOWNS[name].own_bar
        for name in sought
    ]
    return f"Bars: {'; '.join(bars)}.\n"


def _write_hidden(rows: list[dict]) -> str:
    head = ["sought", "start", "singular values", "least", "told", "not told", "along", "gradient", "done"]
    lines = []
    for row in rows:
        values = ", ".join(number(float(np.sqrt(value))) for value in row["eigenvalues"])
        weak = row["directions"][row["identified"] :]
        along = "; ".join(
            " ".join(
                f"{share:+.2f} {label}" for share, label in zip(each, row["labels"]) if abs(share) > 0.05
            )
            for each in weak
        )
        told = f"{row['identified']} of {len(row['labels'])}"
        done = "**searched**" if row["fitted"] else "not sought"
        lines.append(
            [row["problem"], row["start"], values, number(row["least"]), told, ", ".join(row["unidentified"]), along,
             f"{row['gradient_error']:.1e}", done]
        )  # fmt: skip
    return table(head, lines)


def _write_slices(rows: list[dict]) -> str:
    head = ["slice", "kind", "coordinate", "roughness", "towards the truth"]
    return table(
        head,
        [
            [
                row["slice"],
                row["kind"],
                row["label"],
                f"{row['roughness']:.1e}",
                f"{row['towards_truth']:.0%}",
            ]
            for row in rows
        ],
    )


def _join(row: dict, show: Any) -> str:
    return ", ".join(show(name) for name in row["unknowns"])


def _show_value(value: Any) -> str:
    values = np.atleast_1d(value)
    shown = [f"{each:.4g}" for each in values]
    return shown[0] if len(shown) == 1 else f"({', '.join(shown)})"


def _show_error(name: str, value: float) -> str:
    measure = UNKNOWNS[name].measure
    if measure == "relative":
        return f"{100 * value:.2g}%"
    return f"{value:.2g}°" if measure == "angle" or UNKNOWNS[name].unit == "degrees" else f"{value:.2g}"


PAGE = Page(
    "inverse",
    "python -m benchmarks.inverse --images docs/images",
    write_tables,
    ("physagent_jax/mpm", "physagent_jax/kernels"),
    condense,
)
