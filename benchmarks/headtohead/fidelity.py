"""Tables of physical fidelity: its terms on clips of the tasks, and how many clips of each method are clean."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from baselines.fits import Rows, group
from benchmarks.harness import number, table
from physagent_jax.metrics.fidelity import BARS, UNITS


def count_clean(rows: Rows) -> dict[str, str]:
    """Clips of the test split without a fault, of those that could be simulated, by method."""
    test = [row for row in rows if row["split"] == "test" and "terms" in row]
    return {
        label: f"{sum(not row['faults'] for row in mine)}/{len(mine)}" for label, mine in group(test).items()
    }


def write_terms(rows: Sequence[dict[str, Any]]) -> str:
    """The distribution of each term over all clips, and the clips that are beyond its bar."""
    clips = [row for row in rows if "terms" in row]
    lines = []
    for name, bar in BARS.items():
        rated = [row for row in clips if row["terms"][name] is not None]
        if not rated:
            continue
        values = [row["terms"][name] for row in rated]
        beyond = [row["task"] for row in rated if name in row["faults"]]
        figures = [number(float(figure)) for figure in np.quantile(values, (0.5, 0.9, 0.99, 1.0))]
        lines.append([name, UNITS[name], len(rated), *figures, f"{bar:g}", len(beyond), len(set(beyond))])
    head = [
        "term",
        "unit",
        "clips",
        "median",
        "nine of ten",
        "99 of 100",
        "largest",
        "bar",
        "beyond",
        "tasks",
    ]
    return f"{len(clips)} clips of {len({row['task'] for row in clips})} tasks.\n\n" + table(head, lines)
