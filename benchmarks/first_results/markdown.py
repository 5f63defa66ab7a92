"""Tables of docs/first-results.md."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

from benchmarks.first_results import held_back
from benchmarks.first_results.catalogue import SETS
from benchmarks.first_results.sheets import name_sheet
from benchmarks.first_results.totals import count_totals
from benchmarks.first_results.viewing import (
    UNSEEN,
    VIEWS,
    Remark,
    Remarks,
    find_remark,
    find_view,
    rank,
    read_remarks,
)
from benchmarks.harness import Page, Result, Row, Tables, drop_fields, one_line, provenance, table

_SENTENCES = ("#", "object", "preset", "sentence", "viewer", "what a viewer sees")
_SENTENCES += ("verdict", "from the truth", "rounds", "seconds", "frames")

_PAIRS = (
    "#",
    "object",
    "sentence",
    "shows it",
    "would show",
    "what a viewer sees",
    "verdict",
    "rounds",
    "seconds",
)
_PAIRS += ("frames",)

# Raw rows have them, and no table.
_NOWHERE = frozenset(
    ("force_field", "frame_dt", "substeps", "particle_count", "assumptions", "not_understood")
)
_NOWHERE |= {"unsure", "failed_checks", "true_failed_checks", "job", "errors"}
_UNSHOWN = _NOWHERE | {"run", "preset", "options", "wall_s", "true_score"}


def write_tables(result: Result, remarks: Remarks | None = None) -> Tables:
    """The tables of docs/first-results.md.

    Args:
        result: The sections.
        remarks: What viewers have seen; None = what `seen.json` says.
    """
    remarks = read_remarks() if remarks is None else remarks
    tables = {"runs": provenance(result, tuple(SETS)), "totals": count_totals(result, remarks)}
    tables["runs"] += _name_left_out(result)
    if "sentences" in result:
        tables |= _detail(result["sentences"]["rows"], remarks)
    for group in held_back.SETS:
        if group in result:
            tables |= _list_pairs(group, result[group]["rows"], remarks)
    return tables


def _name_left_out(result: Result) -> str:
    """A line about objects without files, of which there is no row from another run."""
    left_out = {name for section in result.values() for run in section["runs"] for name in run["left_out"]}
    known = {row["object"] for section in result.values() for row in section["rows"]}
    missing = sorted(left_out - known)
    return f"\nLeft out, because there was no file: {', '.join(missing)}.\n" if missing else ""


def _detail(rows: list[Row], remarks: Remarks) -> Tables:
    """The tables of the first set, with the verdict from the truth."""
    views = {row["case"]: find_view(row, remarks) for row in rows}
    sheets = {row["case"]: name_sheet(index) for index, row in enumerate(rows)}
    ordered = sorted(rows, key=lambda row: (rank(row["verdict"], views[row["case"]][0]), row["case"]))
    return {
        "verdicts": _count_verdicts(rows, views),
        "sentences": table(_SENTENCES, [_sentence(row, views, sheets) for row in ordered]),
        "sheets": _show_sheets(sheets.values()),
    }


def _list_pairs(group: str, rows: list[Row], remarks: Remarks) -> Tables:
    """The pairs of a set that was held back, as they were written, and their sheets."""
    sheets = [name_sheet(index, group) for index in range(len(rows))]
    lines = [_pair(row, find_remark(row, remarks), sheet) for row, sheet in zip(rows, sheets)]
    return {group: table(_PAIRS, lines), f"{group} sheets": _show_sheets(sheets)}


def _pair(row: Row, remark: Remark | None, sheet: str) -> list:
    seen = [remark.viewer, remark.would_show or "", one_line(remark.remark)] if remark else [UNSEEN, "", ""]
    verdict = row["verdict"] if row["video"] is None else f"{row['verdict']} ({row['score']:.2f})"
    said = f"{row['verdict'].lower()}: {_find_message(row)}" if row["video"] is None else ""
    number = row["case"].split("-")[1]
    head = [number, row["object"], row["sentence"], *seen[:2], "; ".join(filter(None, (seen[2], said)))]
    frames = "" if row["video"] is None else f"[sheet](images/{sheet})"
    return [*head, verdict, row.get("iterations", ""), f"{row['seconds']:.0f}", frames]


_LONGEST = 120  # characters of a message that are kept


def _find_message(row: Row) -> str:
    return one_line(row["message"].rpartition("physagent: ")[2])


def _show_sheets(names: Iterable[str]) -> str:
    return "\n\n".join(f"![Frames of the videos](images/{name})" for name in dict.fromkeys(names))


def _count_verdicts(rows: list[Row], views: dict[str, tuple[str, str]]) -> str:
    """Counts of each verdict with each view."""
    lines = []
    for judge, key in (("from the pictures", "verdict"), ("from the truth", "true_verdict")):
        counts = Counter((row[key], views[row["case"]][0]) for row in rows if row.get(key))
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
        f"{row['true_verdict']} ({row['true_score']:.2f})" if row["true_verdict"] else "",
        row["iterations"],
        f"{row['wall_s']['total']:.0f}",
        f"[sheet](images/{sheets[row['case']]})",
    ]


def condense(result: Result) -> Result:
    """The sections without what no table shows; those of the sets that were held back are shown less of."""
    pairs = {part: section for part, section in result.items() if part in held_back.SETS}
    kept = drop_fields(result | drop_fields(pairs, _UNSHOWN), _NOWHERE)
    for row in (row for section in kept.values() for row in section["rows"] if row.get("message")):
        said = row["message"].rpartition("physagent: ")[2]
        row["message"] = said if len(said) <= _LONGEST else said[: _LONGEST - 1].rstrip() + "…"
    return _round(kept)


def _round(value: Any) -> Any:
    """The value with its numbers to four digits: the tables show three."""
    if isinstance(value, dict):
        return {key: _round(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_round(each) for each in value]
    return float(f"{value:.4g}") if isinstance(value, float) else value


PAGE = Page(
    "first-results",
    f"python -m benchmarks.first_results --parts sentences {' '.join(held_back.SETS)} --data DIR --sheets docs/images",
    write_tables,
    ("physagent_jax",),
    condense,
)
