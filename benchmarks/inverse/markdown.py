"""The tables of the inverse problems."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness import link, number, provenance, table
from benchmarks.inverse.fitting import ADAM_STEPS, LM_STEPS
from benchmarks.inverse.unknowns import UNKNOWNS

PARTS = ("exact", "noise", "finer", "unidentifiable", "landscape")
_MEANING = f"""Numbers of a scene found again from the motion that they made, by gradients through the simulator, by
`python -m benchmarks.inverse`. A block of 2,304 to 2,744 particles is dropped, thrown, kicked, slid, smashed, spilt or
left to collapse, in single precision with the kernels that the product runs (`mpm.simulate`; derivatives by
`trajectory` along its schedule); 64 points of its surface are followed over ten frames. Residuals are in 0.1 % of its
longest side. Searches begin at wrong numbers: a factor of 3 for moduli, strengths, viscosity and friction (Poisson's
ratio: a third, and 1.5 times, near the limit), 12 and 50 degrees for a friction angle of 35, 45 and 60 degrees with
a factor of 2 for vectors, a factor of 2 for the density. Unknowns are in the coordinates of PAC-NeRF and GIC (GIC's
`simulator/estimator.py`): logarithms of moduli, strengths and viscosity, a bounded map for Poisson's ratio, degrees for
the friction angle, plain components of vectors; density and Coulomb's coefficient by their logarithms too.
*Levenberg-Marquardt*: at most {LM_STEPS} trial steps, J^T J by differences, its slope by the adjoint. *Adam*: at most
{ADAM_STEPS} gradients at a rate of 0.1 that falls by a cosine (200 are allowed). The six numbers of a throw are sought
in two stages, the velocity alone first, as GIC does it (Levenberg-Marquardt: half the steps in each; Adam:
{ADAM_STEPS} in each): all at once, with a velocity that is far off, E is driven to where the step is no longer stable.

*Error* is the distance to the truth, *bar* what it should be within: 1 % for E, 0.02 for Poisson's ratio, 0.1 % for
the initial velocity, 1 % for an impulse, 1 degree for the friction angle, 3 % for the yield stress. Bars with a star
are ours, for numbers that the reference values do not name. *Steps*: until the error was within the bar, of those that
were made; the search knows nothing of the truth and ends by itself. *Cost*: forward-equivalents of the search (a
gradient is 4.3). *Condition*: largest over smallest singular value of J at what was found, in the scales of the starts.
*Bound*: the standard error that no unbiased estimate from such tracks can beat (Cramér-Rao), at the row's noise; for
tracks without noise at 0.1 %. *Left*: root mean square of the residuals where it ended. *Gradient*: the adjoint at the
start against central differences of the loss, relative (the best of four steps, single precision; above 1 % the row
fails). Seconds are wall time with what had to be compiled; where the load at the start is above the machine's cores,
other programs kept them busy.
"""
_INTRO = {
    "exact": "Tracks of the same simulator at the same resolution, without noise.",
    "noise": "The same with independent normal noise on every coordinate of the tracks. An error of one to two times "
    "*bound* is what the tracks allow.",
    "finer": "Tracks of a simulation with half the cell size and half the step, eight times the particles: a track is "
    "the mean of the eight that its particle was divided into. The error is what the resolution does to the number, "
    "not what the search does: it ends where the loss is least. The bars are for the same resolution; where a row "
    "misses one, the simulator at this resolution does. Blocks are six to eight cells across, a floor is felt from "
    "half a cell to a cell away, and transfers damp by the step; the last row touches nothing.",
    "unidentifiable": "The singular values of J are looked at before a search: a direction along which a change by the "
    "whole scale (a factor of 3) does not move all residuals together by 0.1 % of the object's size, or by what J "
    "itself is in doubt (*least*: from two step lengths), is not sought.",
    "landscape": "The loss along one coordinate, the others at the truth, at 31 points, with our gradient at each. "
    "*Roughness*: what the loss is off, at the worst, by the cubic through its neighbours' values and gradients, over "
    "the largest loss. *Towards the truth*: at how many points the downhill side is.",
}


def document(result: dict[str, Any], json_path: Path, target: Path) -> str:
    """The tables as Markdown."""
    text = (
        f"# Inverse problems\n\n{_MEANING}\nEvery row is in [{json_path.name}]({link(json_path, target)}).\n"
    )
    text += provenance(result, PARTS)
    for part in PARTS:
        if part not in result:
            continue
        rows = result[part]["rows"]
        text += f"\n## {part.capitalize()}\n\n{_INTRO[part]}\n"
        if part == "landscape":
            text += _write_slices(rows) + "\n![Slices of the loss](images/landscape.png)\n"
        elif part == "unidentifiable":
            text += _write_hidden(rows)
        else:
            text += _write_summary(rows) + _write_fits(rows)
        if part == "exact":
            text += "\n![Error over cost](images/inverse.png)\n"
    return text


def _write_summary(rows: list[dict]) -> str:
    lines = []
    for optimiser in dict.fromkeys(row["optimiser"] for row in rows):
        mine = [row for row in rows if row["optimiser"] == optimiser and row["fitted"]]
        met = sum(row["met"] for row in mine)
        lines.append(f"{optimiser}: {met} of {len(mine)} within their bars")
    return "\n" + "; ".join(lines) + ".\n" if lines else ""


def _write_fits(rows: list[dict]) -> str:
    head = [
        "sought",
        "start",
        "by",
        "noise",
        "found",
        "error",
        "bar",
        "met",
        "steps",
        "cost",
        "seconds",
        "condition",
    ]
    return table([*head, "bound", "left", "gradient"], [_show_fit(row) for row in rows])


def _show_fit(row: dict) -> list[Any]:
    start = [row["problem"], row["start"]]
    if not row["fitted"]:
        return [*start, row["optimiser"], row["noise"], "not sought", *[""] * 10]
    reached = "never" if row["steps_to_tolerance"] is None else row["steps_to_tolerance"]
    noise = f"{row['noise']:.1%}" if row["noise"] else "0"
    return [
        *start,
        row["optimiser"],
        noise,
        _join(row, lambda name: _show_value(row["found"][name])),
        _join(row, lambda name: _show_error(name, row["errors"][name])),
        _join(row, lambda name: _show_error(name, UNKNOWNS[name].tolerance) + "*" * UNKNOWNS[name].own_bar),
        "yes" if row["met"] else "**no**",
        f"{reached} of {row['steps']}",
        number(row["forward_equivalents"]),
        number(row["seconds"]),
        "not finite" if row["condition"] is None else number(row["condition"]),
        _join(row, lambda name: _show_error(name, row["standard_errors"][name]))
        if row["standard_errors"]
        else "",
        number(row["residual"]),
        f"{row['gradient_error']:.1e}",
    ]


def _write_hidden(rows: list[dict]) -> str:
    head = ["sought", "start", "singular values", "least", "told", "not told", "along", "gradient", "done"]
    lines = []
    for row in rows:
        values = ", ".join(number(float(np.sqrt(value))) for value in row["eigenvalues"])
        weak = row["directions"][row["identified"] :]
        along = "; ".join(
            " ".join(
                f"{share:+.2f} {label}" for share, label in zip(each, row["labels"]) if abs(share) > 0.05
            )
            for each in weak
        )
        told = f"{row['identified']} of {len(row['labels'])}"
        done = "**searched**" if row["fitted"] else "not sought"
        lines.append(
            [row["problem"], row["start"], values, number(row["least"]), told, ", ".join(row["unidentified"]), along,
             f"{row['gradient_error']:.1e}", done]
        )  # fmt: skip
    return table(head, lines)


def _write_slices(rows: list[dict]) -> str:
    head = ["slice", "kind", "coordinate", "roughness", "towards the truth"]
    return table(
        head,
        [
            [
                row["slice"],
                row["kind"],
                row["label"],
                f"{row['roughness']:.1e}",
                f"{row['towards_truth']:.0%}",
            ]
            for row in rows
        ],
    )


def _join(row: dict, show: Any) -> str:
    return ", ".join(show(name) for name in row["unknowns"])


def _show_value(value: Any) -> str:
    values = np.atleast_1d(value)
    shown = [f"{each:.4g}" for each in values]
    return shown[0] if len(shown) == 1 else f"({', '.join(shown)})"


def _show_error(name: str, value: float) -> str:
    measure = UNKNOWNS[name].measure
    if measure == "relative":
        return f"{100 * value:.2g} %"
    return f"{value:.2g}°" if measure == "angle" or UNKNOWNS[name].unit == "degrees" else f"{value:.2g}"
