"""docs/stability.md from the JSON: no figure is typed by hand."""

from __future__ import annotations

from collections import defaultdict
from functools import partial
from pathlib import Path

from benchmarks.harness import link, one_line, provenance, table
from benchmarks.stability.dt_crit import CONFIGURATIONS, REQUIRED

VERDICTS = ("pass", "refused", "FAIL")
PARTS = ("critical", "matrix", "pairwise", "stiffness", "degenerate")

_HEAD = """# Stability

What was tried to break the simulator, as measured; every row is in [{name}]({link}), written by `python -m
benchmarks.stability`. A run *passes* if it meets the criteria below in every frame, is *refused* if it ends with an
error in words, and *fails* otherwise: a wrong result without a word is a failure.
"""

_CRITERIA = """
Criteria: P1 everything is finite; P2 particles stay inside, and almost none is stopped at the last line of defence;
P3 det F in range; P4 no energy from nowhere (by the ledger); P5 linear and angular momentum balance, and pushes,
blows and torques give what was asked for; P6 the grid has the particles' mass; P7 damped matter comes to rest; P8 a
step above the bound is refused, or, if forced, healthy or ended in words; P9 features that are not used change
nothing; P10 neither does the order of particles or a shift by whole cells. `benchmarks/stability/criteria.py` has the
bars and their reasons.
"""

_CRITICAL = """
## Critical step over the closed-form bound

Lone particles, a drifting spray of them, a plate one cell thick and a block, float64; "MLS / classical form". The
step is bisected until a strain of one in a million no longer grows a thousandfold. Required: at least {required}.
"2+" is stable at twice the bound.
"""


def document(result: dict, json_path: Path, target: Path) -> str:
    """The text of docs/stability.md."""
    text = _HEAD.format(name=json_path.name, link=link(json_path, target))
    text += provenance(result, PARTS, {verdict.lower(): partial(_count, verdict) for verdict in VERDICTS})
    text += _CRITERIA
    if "critical" in result:
        text += _write_critical(result["critical"]["rows"])
    for part, title in (
        ("matrix", "Materials x forces x magnitudes, automatic step"),
        ("stiffness", "E from 1e3 to 1e9 Pa, automatic step"),
        ("pairwise", "Pairs of everything else"),
        ("degenerate", "Degenerate inputs, and runs that must agree"),
    ):
        if part in result:
            text += _write_part(title, result[part]["rows"], whole=part == "degenerate")
    return text


def _count(verdict: str, rows: list[dict]) -> int:
    return sum(row["verdict"] == verdict for row in rows)


def _write_critical(rows: list[dict]) -> str:
    text = _CRITICAL.format(required=REQUIRED)
    found: dict[str, dict] = defaultdict(dict)
    for row in rows:
        ratio = f"{row['ratio']:.0f}+" if row["unlimited"] else f"{row['ratio']:.3f}"
        found[row["subject"]][row["configuration"], row["form"]] = ratio
    lines = [
        [
            subject,
            *(f"{ratios.get((p, 'mls'), '')} / {ratios.get((p, 'gradient'), '')}" for p in CONFIGURATIONS),
        ]
        for subject, ratios in found.items()
    ]
    text += table(("material", *CONFIGURATIONS), lines)
    least = min(rows, key=lambda row: row["ratio"])
    return text + (
        f"\nLeast: {least['ratio']:.3f} ({least['subject']}, {least['configuration']}, {least['form']}).\n"
    )


def _write_part(title: str, rows: list[dict], whole: bool) -> str:
    """Rows in full where they are few and telling; else what was refused or failed, and the extremes."""
    text = f"\n## {title}\n\n"
    shown = rows if whole else [row for row in rows if row["verdict"] == "FAIL"]
    if not whole:
        text += f"{len(rows)} runs{'' if shown else ', none fails'}. {_describe_extremes(rows)}\n"
        refused = [row for row in rows if row["verdict"] == "refused"]
        if refused:
            text += f"\nRefused ({len(refused)}), for example:\n\n"
            text += "".join(f"- {row['name']}: {one_line(row['message'])}\n" for row in refused[:6])
    if shown:
        lines = [[row["name"], row["verdict"], one_line(row["message"])] for row in shown]
        text += table(("run", "verdict", "what happened"), lines)
    return text


def _describe_extremes(rows: list[dict]) -> str:
    figures = [row["figures"] for row in rows if row["figures"].get("substeps")]
    if not figures:
        return ""
    least = min(f["lowest_loss"] for f in figures)
    momentum = max(f["momentum"] for f in figures)
    redone = sum(f["retries"] > 0 for f in figures)
    steps = sum(f["substeps"] for f in figures)
    return (
        f"{steps:,} substeps; the worst gain of energy is {max(0.0, -least):.1e} of what was supplied, the worst "
        f"momentum error {momentum:.1e} M v; in {redone} runs the simulator redid frames with a smaller step."
    )
