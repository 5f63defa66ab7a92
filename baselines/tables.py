"""Tables of fits as Markdown, CSV and LaTeX (booktabs)."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from baselines.fits import (
    Rows,
    arrange,
    average_tasks,
    choose_fits,
    find_last_mark,
    find_refused,
    group,
    list_successes,
    read_cost,
)
from physagent_jax.core.files import make_folders, write_text
from physagent_jax.metrics.statistics import draw_again, estimate_share, find_interquartile_mean

Cells = Sequence[Sequence[Any]]

_LATEX = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
_LATEX |= {letter: f"\\{letter}" for letter in "&%$#_{}"} | {"–": "--"}


def summarise_methods(rows: Rows) -> list[list[Any]]:
    """Head and a line per method: tasks solved by family and in all, error, and medians of cost.

    Each method stands at its own last mark. Shares have Wilson's interval; the error is the interquartile mean of the
    tasks' errors [tolerances] with the bootstrap of Agarwal et al. 2021.
    """
    families = list(dict.fromkeys(row["family"] for row in rows))
    head = ["method", "given", *families, "solved", "share [%]", "refused", "error [tolerances]"]
    lines: list[list[Any]] = [[*head, "spent", "seconds", "model calls"]]
    for label, mine in group(rows).items():
        name = f"{label} (oracle)" if mine[0]["oracle"] else label
        last, refused = find_last_mark(mine), len(find_refused(mine))
        if not last:
            lines.append([name, "", *[""] * len(families), "", "", refused, "", "", "", ""])
            continue
        tasks = average_tasks(mine, last).values()
        by_family = [[success for of, success, _ in tasks if of == family] for family in families]
        solved = list_successes(mine, last)
        share = estimate_share(solved)
        error = draw_again(find_interquartile_mean, arrange(mine, last)[2])
        fits = choose_fits(mine, last)
        costs = [read_cost(row, last) for row in fits]
        lines.append(
            [
                name,
                f"{last:g}",
                *(_count(each) for each in by_family),
                _count(solved),
                f"{100 * share.value:.0f} ({100 * share.low:.0f}–{100 * share.high:.0f})",
                refused,
                f"{error.value:.2f} ({error.low:.2f}–{error.high:.2f})",
                _find_median([cost["spent"] for cost in costs]),
                _find_median([cost["seconds"] for cost in costs]),
                _find_median([row["model_calls"] for row in fits]),
            ]
        )
    return lines


def list_marks_of_fits(rows: Rows) -> list[list[Any]]:
    """Head and a line per fit and mark, for statistics of one's own."""
    named = ("label", "task", "family", "split", "oracle", "seed", "task_hash")
    lines: list[list[Any]] = [[*named, "mark", "success", "error", "spent", "seconds", "refused"]]
    for row in rows:
        told = [row[name] for name in named]
        if not row["marks"]:
            lines.append([*told, "", "", "", "", "", row.get("refused", "")])
        for mark in row["marks"]:
            cost = read_cost(row, mark["mark"])
            figures = [mark["mark"], int(mark["success"]), mark["error"], cost["spent"], cost["seconds"]]
            lines.append([*told, *figures, mark.get("refused", "")])
    return lines


def write_tables(rows: Rows, folder: Path) -> list[Path]:
    """Write ``methods.md``, ``methods.csv``, ``methods.tex`` and ``fits.csv``; return their paths."""
    methods = summarise_methods(rows)
    make_folders(folder)
    texts = {
        "methods.md": format_markdown(methods),
        "methods.csv": format_csv(methods),
        "methods.tex": format_latex(methods),
        "fits.csv": format_csv(list_marks_of_fits(rows)),
    }
    for name, text in texts.items():
        write_text(folder / name, text)
    return [folder / name for name in texts]


def format_markdown(cells: Cells) -> str:
    """A Markdown table; the first line is the head."""
    head, *lines = (f"| {' | '.join(str(cell).replace('|', '/') for cell in line)} |" for line in cells)
    return "\n".join([head, f"|{'---|' * len(cells[0])}", *lines, ""])


def format_csv(cells: Cells) -> str:
    """Comma-separated values (RFC 4180)."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(cells)
    return text.getvalue()


def format_latex(cells: Cells) -> str:
    r"""A ``tabular`` with the rules of booktabs; needs ``\usepackage{booktabs}``."""
    head, *lines = (" & ".join(_escape(cell) for cell in line) + r" \\" for line in cells)
    begin = rf"\begin{{tabular}}{{l{'r' * (len(cells[0]) - 1)}}}"
    inner = [r"\toprule", head, r"\midrule", *lines, r"\bottomrule"]
    return "\n".join([begin, *inner, r"\end{tabular}", ""])


def read_rows(path: Path) -> list[dict[str, Any]]:
    """Rows of a file of JSON lines; a last line that was cut off is left out."""
    rows = []
    for line in path.read_text(encoding="utf-8").splitlines() if path.is_file() else ():
        try:
            rows.append(json.loads(line))
        except json.JSONDecodeError:
            continue
    return rows


def _escape(cell: Any) -> str:
    return "".join(_LATEX.get(letter, letter) for letter in str(cell))


def _count(successes: Sequence[float]) -> str:
    return f"{sum(successes):.3g}/{len(successes)}" if successes else ""


def _find_median(values: Sequence[float]) -> str:
    return f"{sorted(values)[len(values) // 2]:.3g}" if values else ""
