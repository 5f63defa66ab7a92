"""Figures: error over cost, and slices of the loss."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness import import_pyplot
from benchmarks.inverse.measuring import ADAM


def plot_convergence(result: dict[str, Any], folder: Path) -> None:
    """Write ``inverse.png`` to ``folder``: a panel for each problem with exact tracks.

    Raises:
        UserError: matplotlib is not installed.
    """
    rows = [row for row in result.get("exact", {}).get("rows", []) if row["fitted"]]
    if not rows:
        return
    plt = import_pyplot()
    names = list(dict.fromkeys(row["problem"] for row in rows))
    columns = min(4, len(names))
    lines = -(-len(names) // columns)
    worst = max(ratio for row in rows for _, ratio, _ in row["history"])
    figure, axes = plt.subplots(
        lines, columns, figsize=(3.2 * columns, 2.6 * lines), sharex=True, sharey=True, squeeze=False
    )
    for axis, name in zip(axes.flat, names):
        for row in (row for row in rows if row["problem"] == name):
            spent, ratio, _ = np.array(row["history"]).T
            style = (
                dict(color="tab:orange") if row["optimiser"] == ADAM else dict(color="tab:blue", marker=".")
            )
            axis.plot(spent, np.maximum(ratio, 1e-4), linewidth=1, **style)
        axis.axhline(1.0, color="grey", linewidth=0.8, linestyle="--")
        axis.set(xscale="log", yscale="log", ylim=(5e-4, 2 * worst))
        axis.set_title(name, fontsize=9)
    for axis in list(axes.flat)[len(names) :]:
        axis.set_visible(False)
    figure.supxlabel("forward-equivalents (a gradient is 4.3)", fontsize=9)
    figure.supylabel("error in tolerances", fontsize=9)
    figure.suptitle(
        "Blue: Levenberg-Marquardt, from each start. Orange: Adam. Dashed: the tolerance.", fontsize=9
    )
    _save(plt, figure, folder / "inverse.png")


def plot_landscape(result: dict[str, Any], folder: Path) -> None:
    """Write ``landscape.png`` to ``folder``: losses, with arrows downhill as our gradients have them.

    Raises:
        UserError: matplotlib is not installed.
    """
    rows = result.get("landscape", {}).get("rows", [])
    if not rows:
        return
    plt = import_pyplot()
    figure, axes = plt.subplots(1, len(rows), figsize=(3.6 * len(rows), 3.0), squeeze=False)
    for axis, row in zip(axes.flat, rows):
        x, losses, slopes = (np.array(row[name]) for name in ("offsets", "losses", "slopes"))
        axis.plot(x, losses / losses.max(), color="tab:blue", linewidth=1, marker=".", markersize=3)
        reach = 0.9 * (x[1] - x[0])  # of an arrow: along the tangent, towards where the loss falls
        for at, loss, slope in zip(x, losses / losses.max(), slopes / losses.max()):
            step = -np.sign(slope) * reach
            axis.annotate(
                "",
                (at + step, loss + slope * step),
                (at, loss),
                arrowprops=dict(arrowstyle="->", color="tab:red"),
            )
        axis.axvline(0.0, color="grey", linewidth=0.8, linestyle="--")
        axis.set_title(f"{row['slice']} ({row['kind']})", fontsize=9)
        axis.set_xlabel(f"u of {row['label'].replace('_', ' ')} from the truth", fontsize=8)
    axes[0, 0].set_ylabel("loss over its largest value", fontsize=8)
    _save(plt, figure, folder / "landscape.png")


def _save(plt: Any, figure: Any, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.tight_layout()
    figure.savefig(path, dpi=110, bbox_inches="tight")
    plt.close(figure)
