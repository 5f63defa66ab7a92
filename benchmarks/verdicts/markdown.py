"""Tables of docs/verdicts.md."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchmarks.harness import (
    Page,
    Result,
    Row,
    Rows,
    Tables,
    condense_section,
    make_lines,
    one_line,
    provenance,
    read_lines,
    table,
)
from benchmarks.verdicts.catalogue import list_clips
from benchmarks.verdicts.figures import ALLOWED, HALVES, SIGHTS, count_false

_RATES = ("sight", "half", "clips", "false SUCCESS", "allowed", "false FAIL", "allowed")


def write_tables(summary: Result) -> Tables:
    """The tables of docs/verdicts.md, of a summary."""
    return {**read_lines(summary), "runs": provenance(summary, ("clips", *SIGHTS))}


def condense(result: Result) -> Result:
    """The lines of the tables, and what is said of the clips that are misjudged or not as labelled."""
    return {
        part: condense_section(section, make_lines(_list_tables(part, section)))
        for part, section in result.items()
    }


def _list_tables(part: str, section: dict[str, Any]) -> Tables:
    """The tables that stand with a part."""
    rows = section["rows"]
    if part == "clips":
        return {"untrue": _list_untrue(rows)}
    missing = sorted({name for run in section["runs"] for name in run["left_out"]})
    left_out = (
        f"\nLeft out in some run, because there was no file: {', '.join(missing)}.\n" if missing else ""
    )
    return {
        f"{part}, rates": left_out + _coverage(rows) + table(_RATES, _rates(part, rows)),
        part: _section(part, rows),
        f"{part}, misjudged": _list_misjudged(rows),
    }


def _list_untrue(rows: Rows) -> str:
    """The clips that are not judged, with what is not as it is said."""
    untrue = [row for row in rows if row["untrue"]]
    lines = [
        f"- `{row['clip']}`: {row['motion']}: {'; '.join(row['untrue']).replace(', which nobody says', '')}\n"
        for row in untrue
    ]
    return f"Of {len(rows)} clips, {len(untrue)} do not move as they are said to.\n\n" + "".join(lines)


def _coverage(rows: Rows) -> str:
    """Share of the catalogue that has been judged: a run may be stopped, or judge only what has been made."""
    whole = {clip.name for clip in list_clips(None)}
    judged = len(whole & {row["clip"] for row in rows})
    return f"\nOf the {len(whole)} clips that need no folder of data, {judged} have been judged.\n"


def _rates(sight: str, rows: Rows) -> list[list[Any]]:
    success, fail = ALLOWED[sight]
    lines = []
    for name in ("all", *HALVES):
        mine = [row for row in rows if name in ("all", row["half"])]
        if mine:
            cells = [sight, name, len(mine), _share(mine, "FAIL"), f"{100 * success:.0f}%"]
            lines.append([*cells, _share(mine, "SUCCESS"), f"{100 * fail:.0f}%"])
    return lines


def _share(rows: Sequence[Row], label: str) -> str:
    false, of = count_false(rows, label)
    return f"{100 * false / of:.1f}% ({false} of {of})" if of else ""


def _section(sight: str, rows: Rows) -> str:
    text = _confusion("motion", rows, lambda row: row["wrong"] or "right")
    if sight == "pictures":
        text += _confusion("background", rows, lambda row: row["background"])
    text += _confusion("object", rows, lambda row: row["object"])
    text += _confusion("world", rows, lambda row: row["world"])
    return text + _confusion("sentence", rows, lambda row: row["clip"].split("/")[1])


def _list_misjudged(rows: Rows) -> str:
    return "".join(_misjudged(row) for row in rows if not row["right"]) or "None.\n"


def _confusion(what: str, rows: Rows, key) -> str:
    """Labels against verdicts, per value of ``key``."""
    columns = (what, "right: SUCCESS", "right: FAIL", "wrong: SUCCESS", "wrong: FAIL")
    lines = []
    for name in sorted({key(row) for row in rows}):
        mine = [row for row in rows if key(row) == name]
        cells = [
            sum((row["label"], row["verdict"]) == (label, verdict) for row in mine)
            for label in ("SUCCESS", "FAIL")
            for verdict in ("SUCCESS", "FAIL")
        ]
        lines.append([name, *cells])
    return table(columns, lines)


def _misjudged(row: Row) -> str:
    why = "; ".join(row.get("failed", [])) or row.get("refused", "no check failed")
    label = f"wrong: {row['wrong']}" if row["wrong"] else "right"
    return one_line(f'- `{row["clip"]}` "{row["sentence"]}": {row["motion"]} ({label}): {why}') + "\n"


PAGE = Page(
    "verdicts",
    "python -m benchmarks.verdicts",
    write_tables,
    (
        *(f"physagent_jax/{part}" for part in ("agents", "mpm", "perception", "render")),
        *(
            f"benchmarks/verdicts/{name}.py"
            for name in ("catalogue", "claims", "motions", "scenes", "things")
        ),
    ),
    condense,
)
