"""The measured part of docs/first-results.md; what people wrote around it stays."""

from __future__ import annotations

from pathlib import Path

from benchmarks.harness import Row, link, number, one_line, provenance, table

BEGIN, END = "<!-- measured: begin -->\n", "<!-- measured: end -->\n"

_SENTENCES = ("#", "object", "sentence", "force field", "perceived: farthest, last turn", "truth")
_SENTENCES += ("verdict", "rounds", "seconds")

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
checks.

"""


def document(result: dict, json_path: Path, target: Path) -> str:
    """``target``'s text with the measured part put between its two marks; the measured part alone if it has none."""
    text = (
        BEGIN
        + f"\nEvery row is in [{json_path.name}]({link(json_path, target)}).\n"
        + _measured(result)
        + END
    )
    if not target.is_file() or BEGIN not in (held := target.read_text()):
        return text
    before, rest = held.split(BEGIN, 1)
    return before + text + rest.split(END, 1)[1]


def _measured(result: dict) -> str:
    text = provenance(result, ("sentences",))
    if "sentences" not in result:
        return text
    left_out = sorted({name for run in result["sentences"]["runs"] for name in run["left_out"]})
    rows = result["sentences"]["rows"]
    missing = [name for name in left_out if not any(row["object"] == name for row in rows)]
    if missing:
        text += f"\nLeft out, because there was no file: {', '.join(missing)}.\n"
    text += table(_SENTENCES, [_sentence(row) for row in rows])
    text += _PERCEPTION + table(_PERCEIVED, [_perception(row) for row in rows])
    first = rows[0]["oddities"] if len(rows) > 1 else []
    common = [words for words in first if all(words in row["oddities"] for row in rows)]
    text += _ODDITIES + (f"- **All rows**: {one_line('; '.join(common))}\n" if common else "")
    return text + "".join(_odd(row, common) for row in rows) + "\n"


def _sentence(row: Row) -> list:
    return [
        row["number"],
        row["object"],
        row["prompt"],
        "<br>".join(_actions(row["force_field"])),
        _motion(row["perceived_farthest"], row["perceived_rotation"]),
        _motion(row["true_farthest"], row["true_rotation"]),
        f"{row['verdict']} ({row['score']:.2f})",
        row["iterations"],
        f"{row['wall_s']['total']:.0f}",
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
    return [row["number"], *shown, f"{errors['frames_observed']} of {row['frames']}"]


def _odd(row: Row, common: list[str]) -> str:
    lines = [*(words for words in row["oddities"] if words not in common)]
    lines += [*(f"not passed: {check}" for check in row["failed_checks"])]
    start = f'- **{row["number"]}, {row["object"]}, "{row["prompt"]}"**: '
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
