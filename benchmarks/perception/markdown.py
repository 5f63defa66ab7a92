"""Tables of docs/perception.md."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from benchmarks.harness import Page, Result, Row, Rows, Tables, condense_section, provenance, table

KEYS = ("background", "noise", "distance", "object", "motion")
LEFT_OUT = ("job", "run", "frames", "size_ratio", "notes", "text")
"""Fields of rows that no table needs."""
Figure = tuple[str, str, float, str, str, Callable[[Row], bool]]
FIGURES: tuple[Figure, ...] = (
    ("displacement", "3%", 0.03, "displacement", "displacement_stated", lambda row: True),
    ("displacement across the sight", "3%", 0.03, "across", "across_stated", lambda row: "across" in row),
    ("displacement along it", "10%", 0.10, "along", "along_stated", lambda row: "along" in row),
    ("direction", "5 deg", 5.0, "direction", "", lambda row: row["has_direction"]),
    ("rotation in the plane", "4 deg", 4.0, "rotation", "", lambda row: row["in_plane"]),
    ("rotation out of it", "8 deg", 8.0, "rotation", "", lambda row: not row["in_plane"]),
    ("rotation's angle", "8 deg", 8.0, "angle", "rotation_stated", lambda row: True),
    ("rotation's axis", "", np.inf, "axis", "axis_stated", lambda row: row["turns"]),
    ("stretch", "8%", 0.08, "stretch", "stretch_stated", lambda row: True),
    ("outline's stretch, unturned", "8%", 0.08, "outline", "outline_stated", lambda row: not row["turns"]),
    ("frequency", "5%", 0.05, "frequency", "frequency_stated", lambda row: row["swings"]),
    ("depth of 95% of pixels [half widths]", "1", 1.0, "depth", "depth_stated", lambda row: "depth" in row),
)


def write_tables(result: Result) -> Tables:
    """The tables of docs/perception.md; a part of the rows is a choice of backends.

    Choices that saw a sample of the clips are compared over all and by background, where a sample says something.
    """
    seen = {name: rows for name, section in result.items() if (rows := _read_columns(section["rows"]))}
    tables = {"runs": provenance(result, tuple(result))}
    whole = {name: rows for name, rows in seen.items() if len(rows) == max(map(len, seen.values()))}
    if seen:
        tables["all"] = _summarise(seen)
        tables |= {f"by {key}": _compare_by(seen if key == "background" else whole, key) for key in KEYS}
        tables["worst"] = _list_wrong(seen)
    return tables


def condense(result: Result) -> Result:
    """The rows as columns, with numbers to four digits."""
    return {
        part: condense_section(section, _make_columns(section["rows"])) for part, section in result.items()
    }


def _make_columns(rows: Rows) -> Rows:
    """One row for each field that tables need, with the values of all clips; None where a clip has no such field."""
    fields = [field for field in dict.fromkeys(f for row in rows for f in row) if field not in LEFT_OUT]
    return [{"field": field, "values": [_round(row.get(field)) for row in rows]} for field in fields]


def _read_columns(columns: Rows) -> Rows:
    names = [column["field"] for column in columns]
    return [dict(zip(names, values)) for values in zip(*(column["values"] for column in columns))]


def _round(value: object) -> object:
    return float(f"{value:.4g}") if isinstance(value, float) else value


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


def _summarise(seen: Mapping[str, Rows]) -> str:
    columns = ("perception", "figure", "limit", "clips", "within", "not observable", "covered")
    columns += ("median error", "nine of ten below", "median half width")
    lines, text = [], ""
    for name, rows in seen.items():
        for figure in FIGURES:
            s = summarize(rows, figure)
            if not s["clips"]:
                continue
            within = _to_percent(s["within"]) if np.isfinite(figure[2]) else ""
            shares = [_to_percent(s[key]) for key in ("unobservable", "covered")]
            values = [_to_text(s[key]) for key in ("median", "ninth", "stated")]
            lines.append([name, figure[0], figure[1], s["clips"], within, *shares, *values])
        still = [row for row in rows if row["motion"] == "nothing"]
        swings = [row for row in rows if not row["swings"]]
        text += f"\n{name}: read as still where nothing moves: {sum(row['still'] for row in still)} of {len(still)}. "
        text += f"A swing where there is none: {sum(row['false_swing'] for row in swings)} of {len(swings)}. "
        text += f"More than one piece: {sum((row['pieces'] or 1) > 1 for row in rows)} of {len(rows)}.\n"
    return table(columns, lines) + text


def _compare_by(seen: Mapping[str, Rows], key: str) -> str:
    figures = [figure for figure in FIGURES if np.isfinite(figure[2])]
    columns = (key, "perception", "clips", *(figure[0] for figure in figures))
    lines = []
    for value in dict.fromkeys(row[key] for rows in seen.values() for row in rows):
        for name, rows in seen.items():
            own = [row for row in rows if row[key] == value]
            cells = [value, name, len(own)]
            for figure in figures:
                s = summarize(own, figure)
                missing = f" ({_to_percent(s['unobservable'])} n. o.)" if s["unobservable"] else ""
                cells.append(_to_percent(s["within"]) + missing)
            if own:
                lines.append(cells)
    return table(columns, lines)


def _list_wrong(seen: Mapping[str, Rows]) -> str:
    """The twenty clips whose displacement or rotation is farthest off."""

    def badness(row: Row) -> float:
        return max((row["displacement"] or 0) / 0.03, (row["rotation"] or 0) / (4 if row["in_plane"] else 8))

    every = [(name, row) for name, rows in seen.items() for row in rows]
    worst = sorted(every, key=lambda each: badness(each[1]), reverse=True)[:20]
    columns = ("clip", "perception", "displacement", "rotation", "stretch")
    lines = []
    for name, row in worst:
        clip = (
            f"{row['motion']}: {row['object']}, {row['distance']}, {row['background']}, noise {row['noise']}"
        )
        if badness(row) > 1:
            lines.append([clip, name, *(_to_text(row[key]) for key in columns[2:])])
    return table(columns, lines)


PAGE = Page(
    "perception",
    "python -m benchmarks.perception",
    write_tables,
    ("physagent_jax/perception", "physagent_jax/render"),
    condense,
)
