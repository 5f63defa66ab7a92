"""docs/perception.md, of the rows alone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.harness import Row, Rows, link, one_line, provenance, table

_MEANING = """Known motions of three objects, moved Gaussian by Gaussian without a simulation and drawn by the product's
renderer at three distances (2.4, 3.2 and 4.4 body lengths; 400 x 300 pixels, 24 frames), before three backgrounds:
*plain*, white without a surface; *picture*, a slanted wall with a busy picture; *room*, a floor that the object touches
and a wall, depth everywhere. Noise *camera*: depth with a deviation of 0.12 % of z^2, 2 % of the pixels dropped and
half of those at jumps in depth, colours with a deviation of 2 of 255. Every motion and object is seen before each
background, with distances and noise taking turns.

*Displacement* is the largest error of the centroid over the clip in true body lengths, *direction* the angle between
perceived and true at the farthest, *rotation* the angle of the rotation that leads from perceived to true at the end
(axis and angle together), *stretch* the larger error along two directions across the line of sight, *outline's stretch*
that of the outline's lengths to the right and up, *frequency* that of a swing. *Within* is the share of clips within
the limit, of those where the figure is given; *not observable*, of all where it should be; *covered*, the share whose
error is within the half width that the report states.
"""

Figure = tuple[str, str, float, str, str, Callable[[Row], bool]]
FIGURES: tuple[Figure, ...] = (
    ("displacement", "3 %", 0.03, "displacement", "displacement_stated", lambda row: True),
    ("direction", "5 deg", 5.0, "direction", "", lambda row: row["has_direction"]),
    ("rotation in the plane", "4 deg", 4.0, "rotation", "", lambda row: row["in_plane"]),
    ("rotation out of it", "8 deg", 8.0, "rotation", "", lambda row: not row["in_plane"]),
    ("rotation's angle", "8 deg", 8.0, "angle", "rotation_stated", lambda row: True),
    ("rotation's axis", "", np.inf, "axis", "axis_stated", lambda row: row["turns"]),
    ("stretch", "8 %", 0.08, "stretch", "stretch_stated", lambda row: True),
    ("outline's stretch, unturned", "8 %", 0.08, "outline", "outline_stated", lambda row: not row["turns"]),
    ("frequency", "5 %", 0.05, "frequency", "frequency_stated", lambda row: row["swings"]),
)


def document(result: dict, json_path: Path, target: Path) -> str:
    """The tables as Markdown."""
    text = f"# Perception\n\n{_MEANING}\nEvery row is in [{json_path.name}]({link(json_path, target)}).\n"
    text += provenance(result, ("clips",))
    rows = result["clips"]["rows"] if "clips" in result else []
    if not rows:
        return text
    text += "\n## All clips\n" + _summarise(rows)
    for key in ("background", "noise", "distance", "object"):
        text += f"\n## By {key}\n" + _compare_by(rows, key)
    return (
        text + "\n## By motion\n" + _compare_by(rows, "motion") + "\n## What is wrong\n" + _list_wrong(rows)
    )


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
    return "" if value is None else f"{100 * value:.0f} %"


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
