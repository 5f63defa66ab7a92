"""Tables of docs/stability.md."""

from __future__ import annotations

from collections import defaultdict
from functools import partial

from benchmarks.harness import Page, Result, Row, Tables, one_line, provenance, table
from benchmarks.stability.dt_crit import CONFIGURATIONS

VERDICTS = ("pass", "refused", "FAIL")
KINDS = ("critical", "matrix", "pairwise", "stiffness", "degenerate")
SHARPENED = "sharpened-"
PARTS = KINDS + tuple(SHARPENED + kind for kind in KINDS)
_LEFT_OUT = ("name", "failed", "good", "bound", "subject", "form", "configuration")  # the job tells most
_EXAMPLES = 3  # of refused runs, where not all are shown
_FIGURES = ("substeps", "lowest_loss", "momentum", "retries")


def write_tables(result: Result) -> Tables:
    """The tables of docs/stability.md."""
    counts = {verdict.lower(): partial(_count, verdict) for verdict in VERDICTS}
    tables = {"runs": provenance(result, PARTS, counts)}
    for part in (part for part in PARTS if part in result):
        rows = result[part]["rows"]
        critical = part.endswith("critical")
        tables[part] = _write_critical(rows) if critical else _write_part(rows, whole=part == "degenerate")
    return tables


def condense(result: Result) -> Result:
    """The rows with the figures that the page compares."""
    return {
        part: section | {"rows": [_condense_row(row) for row in _shorten(section["rows"], part)]}
        for part, section in result.items()
    }


def _shorten(rows: list[Row], part: str) -> list[Row]:
    """The rows without the messages that the page does not show."""
    refused = [row for row in rows if row["verdict"] == "refused"]
    quiet = [] if part == "degenerate" else refused[_EXAMPLES:]
    return [row | {"message": ""} if row in quiet else row for row in rows]


def _condense_row(row: Row) -> Row:
    kept = {
        key: _round(value)
        for key, value in row.items()
        if key not in _LEFT_OUT and value != "" and value is not False
    }
    if "figures" in row:
        figures = {name: _round(value) for name, value in row["figures"].items() if name in _FIGURES}
        kept["figures"] = {name: value for name, value in figures.items() if value != 0}
    return kept


def _round(value):
    return float(f"{value:.6g}") if isinstance(value, float) else value


def _count(verdict: str, rows: list[dict]) -> int:
    return sum(row["verdict"] == verdict for row in rows)


def _write_critical(rows: list[dict]) -> str:
    found: dict[str, dict] = defaultdict(dict)
    for row in rows:
        ratio = f"{row['ratio']:.0f}+" if row.get("unlimited") else f"{row['ratio']:.3f}"
        subject, form, place = row["job"].rsplit(", ", 2)
        found[subject][place, form] = ratio
    lines = [
        [
            subject,
            *(f"{ratios.get((p, 'mls'), '')} / {ratios.get((p, 'gradient'), '')}" for p in CONFIGURATIONS),
        ]
        for subject, ratios in found.items()
    ]
    text = table(("material", *CONFIGURATIONS), lines)
    least = min(rows, key=lambda row: row["ratio"])
    subject, form, place = least["job"].rsplit(", ", 2)
    return text + f"\nLeast: {least['ratio']:.3f} ({subject}, {place}, {form}).\n"


def _write_part(rows: list[dict], whole: bool) -> str:
    """Rows in full where they are few and telling; else what was refused or failed, and the extremes."""
    text = ""
    shown = rows if whole else [row for row in rows if row["verdict"] == "FAIL"]
    if not whole:
        text += f"{len(rows)} runs{'' if shown else ', none fails'}. {_describe_extremes(rows)}\n"
        refused = [row for row in rows if row["verdict"] == "refused"]
        if refused:
            text += f"\nRefused ({len(refused)}), for example:\n\n"
            text += "".join(f"- {row['job']}: {one_line(row['message'])}\n" for row in refused[:_EXAMPLES])
    if shown:
        text += table(("run", "of", "verdict", "what happened"), _gather(shown))
    return text


def _gather(rows: list[dict]) -> list[tuple[str, str, str, str]]:
    """A line for the runs that differ by what their names end with, after a colon, alone."""
    gathered: dict[tuple[str, str, str], list[str]] = {}
    for row in rows:
        name, _, of = row["job"].rpartition(": ")
        key = name or row["job"], row["verdict"], one_line(row.get("message", ""))
        gathered.setdefault(key, []).append(of if name else "")
    return [(name, ", ".join(filter(None, of)), *said) for (name, *said), of in gathered.items()]


def _describe_extremes(rows: list[dict]) -> str:
    figures = [row["figures"] for row in rows if row["figures"].get("substeps")]
    if not figures:
        return ""
    least = min(f.get("lowest_loss", 0.0) for f in figures)
    momentum = max(f.get("momentum", 0.0) for f in figures)
    redone = sum("retries" in f for f in figures)
    steps = sum(f["substeps"] for f in figures)
    return (
        f"{steps:,} substeps; the worst gain of energy is {max(0.0, -least):.1e} of what was supplied, the worst "
        f"momentum error {momentum:.1e} M v; in {redone} runs the simulator redid frames with a smaller step."
    )


PAGE = Page(
    "stability",
    "python -m benchmarks.stability",
    write_tables,
    ("physagent_jax/mpm", "physagent_jax/kernels"),
    condense,
)
