"""Success against budget, a line per method."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from benchmarks.harness import import_pyplot
from benchmarks.headtohead.markdown import choose_split, group
from benchmarks.headtohead.statistics import estimate, is_measured


def plot(result: dict[str, Any], folder: Path) -> None:
    """Write ``headtohead-success.png`` to ``folder``.

    Raises:
        UserError: matplotlib is not installed.
    """
    plt = import_pyplot()

    rows = choose_split(result["methods"]["rows"])
    marks = sorted({mark["mark"] for row in rows for mark in row["marks"]})
    figure, axis = plt.subplots(figsize=(8, 5))
    for index, (label, mine) in enumerate(group(rows).items()):
        values = [(mark, 100 * estimate(mine, mark, 1)[0]) for mark in marks if is_measured(mine, mark)]
        style = "--" if mine[0]["oracle"] else "-"
        color = plt.get_cmap("tab20")(index / 20)
        axis.plot(
            *zip(*values),
            style,
            color=color,
            marker="o",
            markersize=3,
            label=label,
        )
    axis.set(xscale="log", xlabel="budget [forward-equivalents]", ylabel="tasks solved [%]", ylim=(-2, 102))
    axis.set_title(
        "Dashed: oracles. Intervals are in the table: of so many methods they hide each other.", fontsize=9
    )
    axis.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.01, 0.5))
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "headtohead-success.png", dpi=110, bbox_inches="tight")
    plt.close(figure)
