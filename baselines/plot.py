"""Success against simulations and against seconds, and error profiles: a line per method."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from baselines.fits import (
    CAP,
    Rows,
    arrange,
    count_within,
    find_last_mark,
    group,
    is_measured,
    list_marks,
    list_successes,
)
from physagent_jax.core.errors import MissingPackageError
from physagent_jax.metrics.statistics import find_profile


def plot(rows: Rows, path: Path) -> None:
    """Draw the rows of fits; the suffix of ``path`` is the format (.svg and .pdf are made of lines, .png of pixels).

    Raises:
        MissingPackageError: matplotlib is not installed.
    """
    try:
        from matplotlib import colormaps, rc_context  # pyright: ignore[reportMissingImports]
        from matplotlib.figure import Figure  # pyright: ignore[reportMissingImports]
    except ModuleNotFoundError:
        raise MissingPackageError("plots need matplotlib", "benchmarks") from None
    marks, seconds, levels = list_marks(rows), np.geomspace(1, 300, 60), np.geomspace(0.1, CAP, 80)
    figure = Figure(figsize=(15, 5))
    axes = figure.subplots(1, 3, sharey=True)
    for index, (label, mine) in enumerate(group(rows).items()):
        last = find_last_mark(mine)
        if not last:
            continue
        tasks, _, errors = arrange(mine, last)
        solved = [(m, 100 * np.mean(list_successes(mine, m))) for m in marks if is_measured(mine, m)]
        within = [100 * count / len(tasks) for count in count_within(mine, seconds.tolist())]
        look: dict[str, Any] = dict(
            linestyle="--" if mine[0]["oracle"] else "-",
            linewidth=1.2 if mine[0]["oracle"] else 2.2,
            color=colormaps["tab20"](index % 20 / 20),
        )
        axes[0].plot(*zip(*solved), marker="o", markersize=3, **look)
        axes[1].plot(seconds, within, **look)
        profile = [100 * share for share in find_profile(-errors, (-levels).tolist())]
        axes[2].plot(levels, profile, label=f"{label} ({len(tasks)} tasks)", **look)
    axes[0].set(xlabel="simulations [forward-equivalents]", ylabel="tasks solved, of those done [%]")
    axes[1].set(xlabel="seconds, on the machines that measured")
    axes[2].set(xlabel="error at the last budget [tolerances]")
    axes[2].axvline(1.0, color="grey", linewidth=0.5)
    for axis in axes:
        axis.set(xscale="log", ylim=(-2, 102))
    figure.suptitle("Dashed: oracles. A task that a method refuses is left out of its line.", fontsize=9)
    axes[2].legend(fontsize=7, loc="center left", bbox_to_anchor=(1.01, 0.5))
    path.parent.mkdir(parents=True, exist_ok=True)
    with rc_context(
        {"svg.fonttype": "none", "svg.hashsalt": "fits"}
    ):  # letters stay letters; no chance in names
        figure.savefig(
            path, dpi=80, bbox_inches="tight", metadata={"Date": None} if path.suffix == ".svg" else None
        )
