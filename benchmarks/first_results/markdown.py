"""The measured part of docs/first-results.md; what people wrote around it stays."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from benchmarks.first_results.sheets import name_sheet
from benchmarks.first_results.viewing import UNSEEN, VIEWS, Remarks, find_view, rank
from benchmarks.harness import Row, link, number, one_line, provenance, table

BEGIN, END = "<!-- measured: begin -->\n", "<!-- measured: end -->\n"

_CONFUSION = """
## Verdicts against what a viewer sees

The verdict of the run, from the pictures, and what the same planner says of the particles' true motion, which no agent
is shown: each against whether the video shows what the sentence says.
"""
_SENTENCES_HEAD = """
## The sentences

Those first in which verdict and viewer disagree: a success that is none, or a failure that is one; then successes that
are so in part.
"""
_SENTENCES = ("#", "object", "preset", "sentence", "viewer", "what a viewer sees")
_SENTENCES += ("verdict", "from the truth", "rounds", "seconds", "frames")

_SHEETS = """
## Contact sheets

"""

_MOTION = """
## Force fields and motion
"""
_FIELDS = ("#", "force field", "perceived: farthest, last turn", "truth", "particles", "substeps")

_PERCEPTION = """
## Perceived against true

At the last frame: shift of the centroid [L], turn [degrees], and stretch along world x, y, z (perceived: the affine
fit's; true: standard deviations over those at the start). Errors of shift and turn are the largest over the clip; a
stretch is compared only where the object has hardly turned and all of it can be seen. *Seen* are the frames in which
the shift was observable.
"""
_PERCEIVED = ("#", "shift: perceived", "true", "largest error", "turn: perceived", "true", "largest error")
_PERCEIVED += ("stretch: perceived", "true", "error", "size, perceived over true", "seen")

_ODDITIES = """
## Oddities

Found in the truth and in the runs' own files, by `benchmarks/first_results/oddities.py`; "not passed" are the planner's
checks, of the pictures and of the truth.

"""


def document(result: dict, json_path: Path, target: Path, *, remarks: Remarks) -> str:
    """``target``'s text with the measured part put between its two marks; the measured part alone if it has none."""
    text = (
        BEGIN
        + f"\nEvery row is in [{json_path.name}]({link(json_path, target)}).\n"
        + _measured(result, remarks)
        + END
    )
    if not target.is_file() or BEGIN not in (held := target.read_text()):
        return text
    before, rest = held.split(BEGIN, 1)
    return before + text + rest.split(END, 1)[1]


def _measured(result: dict, remarks: Remarks) -> str:
    text = provenance(result, ("sentences",))
    if "sentences" not in result:
        return text
    left_out = sorted({name for run in result["sentences"]["runs"] for name in run["left_out"]})
    rows = result["sentences"]["rows"]
    missing = [name for name in left_out if not any(row["object"] == name for row in rows)]
    if missing:
        text += f"\nLeft out, because there was no file: {', '.join(missing)}.\n"
    views = {row["case"]: find_view(row, remarks) for row in rows}
    text += _CONFUSION + _count_verdicts(rows, views)
    sheets = {row["case"]: name_sheet(index) for index, row in enumerate(rows)}
    ordered = sorted(rows, key=lambda row: (rank(row["verdict"], views[row["case"]][0]), row["case"]))
    text += _SENTENCES_HEAD + table(_SENTENCES, [_sentence(row, views, sheets) for row in ordered])
    text += _SHEETS + "".join(
        f"![Frames of the videos](images/{name})\n\n" for name in dict.fromkeys(sheets.values())
    )
    made = [row for row in rows if row["video"] is not None]
    text += _MOTION + table(_FIELDS, [_field(row) for row in made])
    text += _PERCEPTION + table(_PERCEIVED, [_perception(row) for row in made])
    first = made[0]["oddities"] if len(made) > 1 else []
    common = [words for words in first if all(words in row["oddities"] for row in made)]
    text += _ODDITIES + (f"- **All rows**: {one_line('; '.join(common))}\n" if common else "")
    return text + "".join(_odd(row, common) for row in rows) + "\n"


def _count_verdicts(rows: list[Row], views: dict[str, tuple[str, str]]) -> str:
    """How often each verdict meets each view."""
    lines = []
    for judge, key in (("from the pictures", "verdict"), ("from the truth", "true_verdict")):
        counts = Counter((row[key], views[row["case"]][0]) for row in rows if key in row)
        for verdict in sorted({verdict for verdict, _ in counts}, reverse=True):
            cells = [counts[verdict, view] for view in (*VIEWS, UNSEEN)]
            lines.append([f"{verdict} {judge}", *cells, sum(cells)])
    return table(["", *(f"viewer: {view}" for view in VIEWS), UNSEEN, "all"], lines)


def _number(row: Row) -> str:
    return row["case"].split("-")[0]


def _sentence(row: Row, views: dict[str, tuple[str, str]], sheets: dict[str, str]) -> list:
    view, remark = views[row["case"]]
    head = [_number(row), row["object"], row["preset"], " ".join([row["sentence"], *row["options"]])]
    head += [view, one_line(remark)]
    if row["video"] is None:
        return [*head, row["verdict"], "", "", "", ""]
    return [
        *head,
        f"{row['verdict']} ({row['score']:.2f})",
        f"{row['true_verdict']} ({row['true_score']:.2f})",
        row["iterations"],
        f"{row['wall_s']['total']:.0f}",
        f"[sheet](images/{sheets[row['case']]})",
    ]


def _field(row: Row) -> list:
    return [
        _number(row),
        "<br>".join(_actions(row["force_field"])),
        _motion(row["perceived_farthest"], row["perceived_rotation"]),
        _motion(row["true_farthest"], row["true_rotation"]),
        f"{row['particle_count']:,}",
        f"{row['substeps']:,}",
    ]


def _perception(row: Row) -> list:
    errors = row["errors"]
    turns = [_turn(row["perceived_rotation"]), _turn(row["true_rotation"])]
    cells = [_vector(row["perceived_centroid"]), _vector(row["true_centroid"]), errors["centroid_error_max"]]
    cells += [*turns, errors["rotation_error_max"]]
    cells += [_vector(row["perceived_stretch"], ""), _vector(row["true_stretch"], "")]
    cells += [errors["stretch_error_last"], errors["size_ratio"]]
    shown = [
        "not seen" if cell is None else cell if isinstance(cell, str) else number(cell) for cell in cells
    ]
    return [_number(row), *shown, f"{errors['frames_observed']} of {row['frames']}"]


def _odd(row: Row, common: list[str]) -> str:
    start = f'- **{_number(row)}, {row["object"]}, "{row["sentence"]}"**: '
    if row["video"] is None:
        return f"{start}{row['verdict'].lower()}: {one_line(row['message'])}\n"
    lines = [*(words for words in row["oddities"] if words not in common)]
    lines += [*(f"unsure: {words}" for words in row["unsure"])]
    if row["not_understood"]:
        lines.append(f"not understood: {', '.join(row['not_understood'])}")
    lines += [*(f"not passed: {check}" for check in row["failed_checks"])]
    unpassed = [check for check in row["true_failed_checks"] if check not in row["failed_checks"]]
    lines += [*(f"not passed, from the truth: {check}" for check in unpassed)]
    return start + (one_line("; ".join(line.rstrip(".") for line in lines)) if lines else "nothing") + ".\n"


def _actions(field: dict) -> list[str]:
    lines = ["gravity"] if field["default_drop"] else []
    for action in (*field["actions"], *field["constraints"]):
        kind = action.get("action_type") or action["constraint_type"]
        vector = " ".join(f"{c:.2g}" for c in action["vector"])
        window = (
            "whole clip"
            if "active_time" not in action
            else "frames {:.3g}-{:.3g}".format(*action["active_time"])
        )
        region = ", a region" if "region" in action else ""
        lines.append(f"{kind} ({vector}) M = {action['magnitude']:.2f}, {window}{region}")
    return lines


def _vector(values, sign: str = "+") -> str | None:
    return None if values is None else f"({' '.join(f'{value:{sign}.2f}' for value in values)})"


def _turn(degrees: float | None) -> str | None:
    return None if degrees is None else f"{degrees:.0f}"


def _motion(centroid, rotation) -> str:
    moved = "not observable" if centroid is None else "({:+.2f} {:+.2f} {:+.2f}) L".format(*centroid)
    turned = "turn not observable" if rotation is None else f"{rotation:.0f} deg"
    return f"{moved}, {turned}"
