"""Tables of docs/perception.md."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from benchmarks.harness import Page, Result, Row, Rows, Tables, drop_fields, one_line, provenance, table

KEYS = ("background", "noise", "distance", "object", "motion")
Figure = tuple[str, str, float, str, str, Callable[[Row], bool]]
FIGURES: tuple[Figure, ...] = (
    ("displacement", "3%", 0.03, "displacement", "displacement_stated", lambda row: True),
    ("direction", "5 deg", 5.0, "direction", "", lambda row: row["has_direction"]),
    ("rotation in the plane", "4 deg", 4.0, "rotation", "", lambda row: row["in_plane"]),
    ("rotation out of it", "8 deg", 8.0, "rotation", "", lambda row: not row["in_plane"]),
    ("rotation's angle", "8 deg", 8.0, "angle", "rotation_stated", lambda row: True),
    ("rotation's axis", "", np.inf, "axis", "axis_stated", lambda row: row["turns"]),
    ("stretch", "8%", 0.08, "stretch", "stretch_stated", lambda row: True),
    ("outline's stretch, unturned", "8%", 0.08, "outline", "outline_stated", lambda row: not row["turns"]),
    ("frequency", "5%", 0.05, "frequency", "frequency_stated", lambda row: row["swings"]),
)


def write_tables(result: Result) -> Tables:
    """The tables of docs/perception.md."""
    rows = result["clips"]["rows"] if "clips" in result else []
    tables = {"runs": provenance(result, ("clips",))}
    if rows:
        tables["all"] = _summarise(rows)
        tables |= {f"by {key}": _compare_by(rows, key) for key in KEYS}
        tables["worst"] = _list_wrong(rows)
    return tables


def summarize(rows: Rows, figure: Figure) -> dict[str, float | int | None]:
    """Counts and shares of one figure; a share of nothing is None."""
    _, _, limit, error, stated, applies = figure
    due = [row for row in rows if applies(row)]
    given = [row for row in due if row.get(error) is not None]
    with_bound = [row for row in given if stated and row.get(stated) is not None]
    return {
        "clips": len(due),
        "given": len(given),
        "unobservable": _compute_share([row.get(error) is None for row in due]),
        "within": _compute_share([row[error] <= limit for row in given]),
        "covered": _compute_share([row[error] <= row[stated] for row in with_bound]),
        "median": float(np.median([row[error] for row in given])) if given else None,
        "ninth": float(np.quantile([row[error] for row in given], 0.9)) if given else None,
        "stated": float(np.median([row[stated] for row in with_bound])) if with_bound else None,
    }


def _compute_share(values: list[bool]) -> float | None:
    return sum(values) / len(values) if values else None


def _to_percent(value: float | None) -> str:
    return "" if value is None else f"{100 * value:.0f}%"


def _to_text(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}"


def _summarise(rows: Rows) -> str:
    columns = ("figure", "limit", "clips", "within", "not observable", "covered")
    columns += ("median error", "nine of ten below", "median half width")
    lines = []
    for figure in FIGURES:
        s = summarize(rows, figure)
        within = _to_percent(s["within"]) if np.isfinite(figure[2]) else ""
        lines.append(
            [
                figure[0],
                figure[1],
                s["clips"],
                within,
                *(_to_percent(s[key]) for key in ("unobservable", "covered")),
            ]
            + [_to_text(s[key]) for key in ("median", "ninth", "stated")]
        )
    still = [row for row in rows if row["motion"] == "nothing"]
    text = f"\nRead as still where nothing moves: {sum(row['still'] for row in still)} of {len(still)}. "
    swings = [row for row in rows if not row["swings"]]
    text += f"A swing where there is none: {sum(row['false_swing'] for row in swings)} of {len(swings)}. "
    text += f"More than one piece: {sum((row['pieces'] or 1) > 1 for row in rows)} of {len(rows)}.\n"
    return table(columns, lines) + text


def _compare_by(rows: Rows, key: str) -> str:
    figures = [figure for figure in FIGURES if np.isfinite(figure[2])]
    columns = (key, "clips", *(figure[0] for figure in figures))
    lines = []
    for name in dict.fromkeys(row[key] for row in rows):
        own = [row for row in rows if row[key] == name]
        cells = [name, len(own)]
        for figure in figures:
            s = summarize(own, figure)
            missing = f" ({_to_percent(s['unobservable'])} n. o.)" if s["unobservable"] else ""
            cells.append(_to_percent(s["within"]) + missing)
        lines.append(cells)
    return table(columns, lines)


def _list_wrong(rows: Rows) -> str:
    """The twenty clips whose displacement or rotation is farthest off, with what the report says."""

    def badness(row: Row) -> float:
        return max((row["displacement"] or 0) / 0.03, (row["rotation"] or 0) / (4 if row["in_plane"] else 8))

    worst = sorted(rows, key=badness, reverse=True)[:20]
    columns = ("clip", "displacement", "rotation", "stretch", "notes")
    return table(
        columns,
        [
            [
                f"{row['motion']}: {row['object']}, {row['distance']}, {row['background']}, noise {row['noise']}"
            ]
            + [_to_text(row[key]) for key in ("displacement", "rotation", "stretch")]
            + [one_line(" ".join(row["notes"]))]
            for row in worst
            if badness(row) > 1
        ],
    )


PAGE = Page(
    "perception",
    "python -m benchmarks.perception",
    write_tables,
    ("physagent_jax/perception", "physagent_jax/render"),
    partial(drop_fields, left_out=("text",)),
)
