"""docs/accuracy.md from the JSON: no figure is typed by hand."""

from __future__ import annotations

from pathlib import Path

from benchmarks.accuracy.study import QUADRATURE_CASE, QUADRATURE_ERROR
from benchmarks.cases.catalogue import CASES
from benchmarks.harness import link, number, provenance, table

PARTS = ("verification", "work_precision", "quadrature")

_INTRODUCTION = """# Accuracy

Every figure is in [{name}]({link}), written by `python -m benchmarks.accuracy`.
{provenance}
## Cases with exact answers

Each case is one object in `benchmarks/cases/` (set-up, exact answer, bar, source), and the same object is a test in
`tests/verification/`. MLS-MPM stress, APIC, float32 (free motion and spin: float64); wall time
warm, compilation apart.
"""

_WORK = """
## Error against wall time

The step is given as a share of the isolated particle's bound (docs of `mpm.timestep`), or as the fixed 2e-4 s that is
customary in PhysGaussian scenes. "signal (rms)" is the deviation of the whole motion from the exact one over two
periods, damping included; "returned" the rms distance of the particles from their exact positions at the end (forces
that hold a motion to a formula have no counterpart in the peers). Wall time is the median of several warm runs of
ours, with the range, and one run of a peer.
Peers run the same particles on the same grid in the same process tree: {peers}.

![Error over wall time]({plot})
"""

_QUADRATURE = """
## Particles per cell

How much too far a beam bends under its own weight ({title}), by the number of particles per cell and axis. The
error is one of quadrature: where particles have moved across cells, the sums over them that stand for integrals are
off, and in the MLS form of the stress that makes matter too soft in bending. It falls with more particles in a cell,
not with smaller cells. Scenes are filled with about two per cell and axis, so expect what bends in them to bend that
much too far; the gradient form (`transfer.stress_form = "gradient"` in a scene) has less of it and takes steps
0.71 times as long.
"""
_DENSITIES = ("cells through the height", "stress form", "2 per axis", "3 per axis", "4 per axis")
_CASES = (
    "case",
    "what moves, what is measured",
    "cells",
    "particles",
    "error",
    "bar",
    "wall [s]",
    "compile [s]",
)
_RUNS = ("case", "code", "numerics", "cells", "steps", "dt / bound", "error", "wall [s]", "compile [s]")

_LIMITS = """
## Known limits

- Soft matter under strong forces is refused: with E = 1e3 Pa and forces fifty times the skills' own, most runs of
  every law end with "matter is crushed to nothing", because no step keeps a cell's matter from being pressed to no
  volume. Weaker forces or stiffer matter are the remedy; of the elastic laws, neo-Hookean resists most.
- Sand at rest at F = I sits on the edge of its yield surface: the derivatives of a push and of a pull differ, and
  automatic differentiation gives a value between the two.
- Friction on a plane oblique to the grid begins with a drift (the row "incline-rests" above), then holds.
- Walls act half to one and a half cells before they are reached.
"""


def document(
    result: dict, json_path: Path, plot_path: Path | None, primary: dict[str, str], target: Path
) -> str:
    """The text of docs/accuracy.md."""
    rows = result.get("verification", {}).get("rows", [])
    text = _INTRODUCTION.format(
        name=json_path.name, link=link(json_path, target), provenance=provenance(result, PARTS)
    )
    titles = {(verified.case.name, verified.note): verified.case.title for verified in CASES}
    text += table(
        _CASES, [_make_verified_line(row, titles.get((row["case"], row["label"]), "")) for row in rows]
    )
    outside = [row for row in rows if not row["within"]]
    text += "\nEvery case is within its bars.\n" if not outside else _list_outside(outside)
    if work := result.get("work_precision"):
        known = {name: words for run in work["runs"] for name, words in run["peers"].items()}
        peers = "; ".join(f"{name}: {words}" for name, words in known.items())
        text += _WORK.format(peers=peers, plot=link(plot_path, target) if plot_path else "")
        text += table(_RUNS, [_make_study_line(row, primary[row["case"]]) for row in work["rows"]])
        text += _summarise(work["rows"], primary)
    if densities := result.get("quadrature"):
        text += _QUADRATURE.format(title=QUADRATURE_CASE.title)
        text += table(_DENSITIES, _make_density_lines(densities["rows"]))
    return text + _LIMITS


def _make_density_lines(rows: list[dict]) -> list[list]:
    """One line per grid and stress form, one column per density; rows come in this order."""
    lines = []
    for first in range(0, len(rows) - len(rows) % 3, 3):
        cells = [f"{100 * row['errors'][QUADRATURE_ERROR]:.2g} %" for row in rows[first : first + 3]]
        lines.append([rows[first]["resolution"], rows[first]["label"].split(",")[0], *cells])
    return lines


def _make_verified_line(row: dict, title: str) -> list:
    name = f"{row['case']}, {row['label']}" if row["label"] else row["case"]
    names = list(row["bars"]) or list(row["errors"])
    errors = "<br>".join(f"{name}: {row['errors'][name]:.3g}" for name in names if name in row["errors"])
    bars = "<br>".join(f"{row['bars'][name]:.3g}" for name in names if name in row["bars"])
    start = [name, title, row["resolution"], row["particles"], row["failed"] or errors, bars]
    return [*start, number(row["wall"]), number(row["compile"])]


def _list_outside(rows: list[dict]) -> str:
    lines = [f"- **{row['case']}**: {row['failed'] or 'outside its bar'}" for row in rows]
    return "\nOutside their bars:\n\n" + "\n".join(lines) + "\n"


def _make_study_line(row: dict, primary: str) -> list:
    error = f"{row['errors'][primary]:.3g}" if primary in row["errors"] else row["failed"]
    label = f"**{row['label']}** (reference)" if row["reference"] else row["label"]
    start = [row["case"], row["code"], label, row["resolution"], row["steps"], number(row["dt_over_bound"])]
    return [*start, error, _format_wall_time(row), number(row["compile"])]


def _format_wall_time(row: dict) -> str:
    shown = " to ".join(number(value) for value in dict.fromkeys(row["wall_range"]))
    return f"{number(row['wall'])} ({shown})" if " to " in shown else number(row["wall"])


def _summarise(rows: list[dict], primary: dict[str, str]) -> str:
    """What the near-bound step gains over the fixed one, and over each peer, case by case."""
    text = "\nAt the finest grid of each case, relative to our own step at 0.9 of the bound:\n"
    lines = []
    for case in dict.fromkeys(row["case"] for row in rows):
        mine = [row for row in rows if row["case"] == case and primary[case] in row["errors"]]
        best = [row for row in mine if row["code"] == "ours" and row["label"] == "0.9 x bound"]
        if not best:
            continue
        base = max(best, key=lambda row: row["resolution"])
        for row in mine:
            if row["resolution"] != base["resolution"] or row is base:
                continue
            if row["code"] == "ours" and not row["reference"]:
                continue
            time = row["wall"] / base["wall"]
            error = abs(row["errors"][primary[case]] / base["errors"][primary[case]])
            lines.append([case, f"{row['code']}, {row['label']}", f"{time:.3g}", f"{error:.3g}"])
    return text + table(("case", "against", "time ratio", "error ratio"), lines)
