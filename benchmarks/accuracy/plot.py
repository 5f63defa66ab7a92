"""Error against wall time, one panel per case."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of the backend)

# Colour-blind-safe (Okabe & Ito); one fixed place per kind of run, so that panels compare.
_STYLES = {
    "0.9 x bound": ("#0072B2", "o"),
    "0.9 x bound, sharpened": ("#B2182B", "o"),
    "0.45 x bound, sharpened": ("#F4A582", "s"),
    "0.45 x bound": ("#56B4E9", "s"),
    "fixed 0.0002 s": ("#D55E00", "X"),
    "classical stress form": ("#009E73", "^"),
    "RPIC 0.5": ("#CC79A7", "v"),
    "PIC": ("#999999", "D"),
    "float64": ("#000000", "P"),
}
_PEERS = {"warp_classical": ("#E69F00", "*"), "genesis": ("#7F3C8D", "h")}


def plot(rows: list[dict], primary: dict[str, str], path: Path) -> None:
    """Draw ``rows`` (as in the JSON); ``primary`` names the error that each case's panel shows."""
    cases = [case for case in primary if any(row["case"] == case and row["errors"] for row in rows)]
    columns = min(3, len(cases))
    lines = -(-len(cases) // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(5.2 * columns, 4.2 * lines), squeeze=False)
    handles = {}
    for axis, case in zip(axes.flat, cases):
        mine = [row for row in rows if row["case"] == case and row["errors"]]
        for label in dict.fromkeys((row["code"], row["label"]) for row in mine):
            points = sorted(
                (row["wall"], abs(row["errors"][primary[case]]), row["resolution"])
                for row in mine
                if (row["code"], row["label"]) == label
            )
            color, marker = _STYLES[label[1]] if label[0] == "ours" else _PEERS[label[0]]
            name = label[1] if label[0] == "ours" else f"{label[0]}, {label[1]}"
            style = "-" if label[0] == "ours" else ("--" if "fixed" in label[1] else ":")
            (line,) = axis.loglog(
                [p[0] for p in points], [p[1] for p in points], style, color=color, marker=marker, ms=7
            )
            handles.setdefault(name, line)
            for wall, error, resolution in points:
                axis.annotate(
                    str(resolution), (wall, error), textcoords="offset points", xytext=(5, 4), size=7
                )
        bars = [row["bars"][primary[case]] for row in mine if primary[case] in row["bars"]]
        for bar in dict.fromkeys(bars):
            axis.axhline(bar, color="#bbbbbb", lw=0.8, zorder=0)
        axis.set_title(f"{case}: {primary[case]}", fontsize=10)
        axis.set_xlabel("wall time, warm [s]")
        axis.set_ylabel("|error|")
        axis.grid(True, which="major", color="#eeeeee")
    for axis in list(axes.flat)[len(cases) :]:
        axis.axis("off")
    figure.legend(handles.values(), handles.keys(), loc="lower center", ncols=4, frameon=False, fontsize=9)
    legend_lines = -(-len(handles) // 4)
    figure.tight_layout(rect=(0, 0.07 * legend_lines, 1, 1))
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=130)
